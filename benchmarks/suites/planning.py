"""One displacement goal, from the call to the commands: decoded, refined, or searched for."""

import os

import jax
import jax.numpy as jnp
import numpy as np

import motorspace as ms
from benchmarks.harness import Contender, Launch, report, take_turns
from motorspace.control.planning import Effort
from motorspace.control.trials import answers
from motorspace.training.data import simulated

GOAL = ms.DisplacementGoal(longitudinal=1.0, lateral=-1.5, turn=1.0)
SENSORS = np.full(9, 5.0)


def main() -> None:
    """Plans with the controller that comes with the package, and search in the true simulator."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    run, controller, *_ = ms.load_pretrained("forward-0.4pi")
    contenders = [
        planned("motorspace", controller, "hybrid"),
        planned("decoded, not refined", controller, "amortised"),
        searched(run, controller),
    ]
    rates, first, foreign = take_turns(contenders)
    report(Launch("one plan", "plans", threads, rates, first, {}, foreign))


def planned(name: str, controller: ms.Controller, method: str) -> Contender:
    """What a caller waits for who has the readings and wants the commands."""
    return Contender(name, lambda: ms.plan(controller, SENSORS, GOAL, method=method), 1)


def searched(run: ms.Run, controller: ms.Controller) -> Contender:
    """The cross-entropy method, with the true simulator to judge."""
    agent = simulated(run.config.data).scenario().agent
    goals = jnp.array([[GOAL.longitudinal, GOAL.lateral, GOAL.turn]], jnp.float32)
    key = jax.random.key(0)

    def search() -> None:
        found = answers(controller, agent, goals, "cross_entropy", Effort(), True, key)
        jax.block_until_ready(found)

    return Contender("cross-entropy search in the simulator", search, 1)


if __name__ == "__main__":
    main()
