"""Other things that a network can be given to learn, made from trajectories: reference rows."""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from motorspace._errors import UserError
from motorspace._types import Count, Displacement, Key, Motors, Pose, Scalar
from motorspace.trajectories.transitions import Experience, Trajectories
from motorspace.worlds.agents import AbstractAgent
from motorspace.worlds.simulation import nominal_displacement


def displacement_as_motors(trajectories: Trajectories, reach: float | Scalar) -> Experience:
    """The oracle's experience: one «command» that is the achieved displacement itself.

    Fitted with the identity encoder, it shows what the predictor could reach with a perfect code.

    Args:
        trajectories: N transitions with their displacements.
        reach: What translations are divided by, world units.

    Returns:
        N transitions whose motors [N, 1, 4] are (longitudinal / reach, lateral / reach, cos, sin of
        the orientation change).
    """
    experience = trajectories.experience
    longitudinal, lateral, cos, sin = _features(trajectories.displacements.achieved)
    features = jnp.stack([longitudinal / reach, lateral / reach, cos, sin], axis=-1)
    return Experience(
        sensors=experience.sensors,
        motors=features[:, None, :],
        num_steps=jnp.ones_like(experience.num_steps),
        later_sensors=experience.later_sensors,
    )


def scaled_rotations(
    agent: AbstractAgent, trajectories: Trajectories, *, angle: float | Scalar
) -> Experience:
    """The experience of an oracle that computes displacements with all rotations scaled.

    Args:
        agent: The agent that executed the commands.
        trajectories: N transitions of at most T commands.
        angle: What every rotation of the body is multiplied by; 1 gives the nominal displacement.

    Returns:
        As `displacement_as_motors`, with T as the reach. Walls do not matter.

    Raises:
        UserError: For an agent whose commands do not say which channels turn it.
    """
    commands, experience = agent.commands, trajectories.experience
    if not commands.turning:
        raise UserError(
            f"the commands of a {type(agent).__name__} do not say which channels turn it",
            remedy="give its commands `turning`",
        )
    factors = jnp.ones(commands.size, jnp.float32).at[jnp.array(commands.turning)].set(angle)
    here = Pose(*jnp.zeros((4,), jnp.float32))

    def computed(motors: Motors, num_steps: Count) -> Displacement:
        return nominal_displacement(agent, here, motors * factors[None], num_steps)

    scaled = jax.vmap(computed)(experience.motors, experience.num_steps)
    moved = trajectories.displacements._replace(achieved=scaled)
    return displacement_as_motors(
        Trajectories(experience, moved), float(experience.motors.shape[1])
    )


def shuffled(trajectories: Trajectories, *, key: Key) -> Experience:
    """N transitions in which every sequence leads to what another one led to.

    Motors say nothing about what comes then: an encoder learns nothing from them.
    """
    experience = trajectories.experience
    later = jax.random.permutation(jax.random.fold_in(key, 1), experience.later_sensors)
    return Experience(experience.sensors, experience.motors, experience.num_steps, later)


def supervised(trajectories: Trajectories) -> Experience:
    """N transitions whose «later sensors» [N, 4] are the achieved displacement.

    (longitudinal, lateral, cos, sin of the orientation change), with «sensors» of zeros: the
    network learns displacements from motor sequences directly.
    """
    experience = trajectories.experience
    targets = jnp.stack(_features(trajectories.displacements.achieved), axis=-1)
    return Experience(jnp.zeros_like(targets), experience.motors, experience.num_steps, targets)


def _features(displacements: Float[Array, "N 3"]) -> tuple[Float[Array, " N"], ...]:
    longitudinal, lateral, turn = displacements.T
    return longitudinal, lateral, jnp.cos(turn), jnp.sin(turn)
