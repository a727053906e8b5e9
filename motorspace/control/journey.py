"""Far goals of readings: sequence after sequence, planned on a judge's own map."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Bool, Float

from motorspace._types import Key, Pose
from motorspace.control.following import Way, carry_out_compiled
from motorspace.control.guide import BLOCKED, Course, Guide, features
from motorspace.judge.belief import first_belief, updated
from motorspace.judge.judge import Readings
from motorspace.judge.places import OUTLIER
from motorspace.judge.roadmap import MARGIN, Roadmap
from motorspace.se2 import compose, relative
from motorspace.worlds.scenario import Scenario

ALIKE, EXACTLY_ALIKE = 1.5, 0.2
"""Mismatch of readings with the goal's below which an agent stays: at a place that it takes to be
the goal, and anywhere. It is the mean over rays of log(1 + (off / OUTLIER)^2)."""
WITHIN = 0.3
"""World units from the bank's displacements within which a goal is one sequence away."""
CLOSE = 0.15
"""World units from a place that looks like the goal at which it has to be sensed."""
DOUBT = 0.1
"""How likely such a place remains where the goal is not sensed."""
USUAL_WAY = 8.0
"""World units of a way that make a place that looks like the goal less likely by a factor e; of
twice as long a way, by e to the fourth."""
TRIED = 256
"""Sequences of the bank that lead nearest, among which one is sought that no wall blocks."""


class Journey:
    """The way of an agent to where readings are sensed.

    Alternate `plan` and `sensed` until the plan is None: the agent has arrived, and stays.

    Args:
        guide: Of the layout.
        roadmap: Of the same layout.
        sensors: The readings at the start, at rest, [K], raw units.
        goal: The readings wanted, [K], raw units.

    Example:
        >>> journey = Journey(guide, roadmap, sensors, goal)  # doctest: +SKIP
        >>> motors = journey.plan(key=key)  # doctest: +SKIP
        >>> journey.sensed(motors, sensors_after)  # doctest: +SKIP
    """

    def __init__(
        self,
        guide: Guide,
        roadmap: Roadmap,
        sensors: Readings,
        goal: Readings,
    ) -> None:
        self.guide, self.roadmap = guide, roadmap
        self.now, self.goal = np.asarray(sensors, np.float64), np.asarray(goal, np.float64)
        self.belief = first_belief(guide.judge, self.now, np.zeros(guide.motors.shape[-1]))
        there = guide.judge.where(self.goal)
        self.there, self.likely = there.eyes, np.log(np.maximum(there.weight, 1e-300))

    @property
    def arrived(self) -> bool:
        """Whether the readings are those of the goal."""
        off = (self.now - self.goal) / (OUTLIER * self.guide.judge.walls.reach)
        alike = ALIKE if self._at(self.belief.likeliest).any() else EXACTLY_ALIKE
        return bool(np.log1p(off**2).mean() < alike)

    def plan(self, *, key: Key) -> Float[np.ndarray, "T M"] | None:
        """The next motor commands [T, M], or None where the agent stays."""
        if self.arrived:
            return None
        place = self.belief.likeliest
        # An agent that stands where the goal should be but does not sense it looks elsewhere.
        self.likely += np.where(self._at(place), np.log(DOUBT), 0.0)
        ways = self.roadmap.left(self.there[:2], self.roadmap.lengths(place[:2]))
        aim = int(np.argmax(self.likely - (ways / USUAL_WAY) ** 2))
        body = self.guide.judge.calibration.body
        here = body.at_rest(place[:, None], self.belief.motor)[:, 0]
        last_key, key = jax.random.split(key)
        last = Course(here, relative(here, self.there[:, aim]))
        if self.guide.beyond(last.moved[:, None])[0] < WITHIN:
            answer = self.guide.answer(last, key=last_key)
            if answer.miss < BLOCKED:
                return answer.motors
        return self._farther(here, self.there[:2, aim], key=key)

    def sensed(self, motors: Float[np.ndarray, "T M"], sensors: Readings) -> None:
        """Take in the readings [K] after commands [T, M], as they happened.

        Of a command that a wall has forbidden the translation is zero; those after it are left out.
        """
        self.now = np.asarray(sensors, np.float64)
        self.belief = updated(self.guide.judge, self.belief, motors, self.now)

    def _at(self, place: Float[np.ndarray, "3"]) -> Bool[np.ndarray, " G"]:
        """At which of the places that look like the goal this one is."""
        off = features(self.there) - features(place[:, None])
        return np.asarray(np.linalg.norm(off, axis=0) < CLOSE)

    def _farther(
        self, here: Float[np.ndarray, "3"], aim: Float[np.ndarray, "2"], *, key: Key
    ) -> Float[np.ndarray, "T M"]:
        """A sequence that shortens the way most."""
        guide, roadmap = self.guide, self.roadmap
        moved = np.repeat(here[:, None], guide.moved.shape[1], axis=1)
        ends = np.asarray(compose(moved, guide.moved))[:2]
        lengths = roadmap.lengths(aim)
        best = np.argsort(roadmap.roughly_left(ends, lengths))[:TRIED]
        best = best[np.argsort(roadmap.left(ends[:, best], lengths))]
        room = guide.room(here, guide.motors[best])
        free = room > MARGIN * guide.judge.walls.reach
        chosen = best[int(np.argmax(free)) if free.any() else int(np.argmax(room))]
        answer = guide.answer(Course(here, guide.moved[:, chosen]), key=key)
        return answer.motors if answer.miss < BLOCKED else guide.motors[chosen]


def seek(
    guide: Guide,
    roadmap: Roadmap,
    scenario: Scenario,
    start: Pose,
    goal: Readings,
    *,
    rounds: int,
    key: Key,
) -> Way:
    """Returns the way of an agent to where `goal` is sensed, round after round.

    A bump ends a round, and the way ends where the agent takes the goal to be. The agent senses
    readings and what a wall forbids; its pose is what the simulator knows.

    Args:
        guide: Of the scenario's layout.
        roadmap: Of the same layout.
        scenario: Where the agent acts.
        start: Its pose, at rest.
        goal: The readings wanted, [K], raw units.
        rounds: Plans at most.
        key: Source of randomness.

    Returns:
        Every command that was carried out, L in all, and every pose.
    """
    journey = Journey(guide, roadmap, np.asarray(_sensed(scenario, start)), goal)
    motors, bumps, poses = [], [], [start]
    for round_key in jax.random.split(key, rounds):
        planned = journey.plan(key=round_key)
        if planned is None:
            break
        commands = jnp.asarray(planned, jnp.float32)
        after, blocked, done = carry_out_compiled(scenario, poses[-1], commands)
        num = int(done.sum())
        motors.append(planned[:num])
        bumps.append(np.asarray(blocked)[:num])
        poses += [jax.tree.map(lambda field, t=t: field[t], after) for t in range(num)]
        happened = guide.controller.commands.without_translation(
            jnp.asarray(motors[-1].T), jnp.asarray(bumps[-1])
        )
        journey.sensed(np.asarray(happened).T, np.asarray(_sensed(scenario, poses[-1])))
    none = np.zeros((0, guide.motors.shape[-1]))
    return Way(
        jnp.asarray(np.concatenate([none, *motors]), jnp.float32),
        jax.tree.map(lambda *fields: jnp.stack(fields), *poses),
        jnp.asarray(np.concatenate([np.zeros(0, bool), *bumps])),
        jnp.ones(len(poses) - 1, bool),
    )


_sensed = eqx.filter_jit(lambda scenario, pose: scenario.sense(pose))
