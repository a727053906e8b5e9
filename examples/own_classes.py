"""Train, evaluate, resume and act with the robot of `my_robot.py`, and learn from its log.

The same on the command line, in this folder:

    motorspace train two_wheels --import my_robot --wheel-base 0.4 --sensor compass_and_sonar \\
        --encoder odometer --code-size 8 --epochs 20 --out runs/robot
    motorspace evaluate runs/robot --import my_robot
    motorspace train --data robot.jsonl --import my_robot --encoder odometer --out runs/log
"""

import dataclasses
import json
import tempfile
from pathlib import Path

import gymnasium
import jax
import my_robot
import numpy as np

import motorspace as ms
from motorspace.testing import check_agent, check_encoder, check_reader, check_sensor

body = my_robot.TwoWheels(wheel_base=0.4)
senses = my_robot.CompassAndSonar(num_sonars=3)
check_agent(body)
check_sensor(senses)
check_encoder(my_robot.Odometer)

world = ms.Simulated(body, senses, layout="four_rooms", horizon=3)
network = ms.ModelConfig(encoder="odometer", code_size=8)
training = ms.TrainingConfig(epochs=20)
config = ms.RunConfig(world, network, training)


def lines(walk: ms.Recording) -> str:
    """A walk as the robot writes it."""
    wheels = np.append(walk.increments, [[0, 0]], axis=0)  # nothing follows the last scan
    scans = zip(walk.time, wheels.tolist(), walk.sensors.tolist(), walk.poses.tolist(), strict=True)
    return "\n".join(
        json.dumps({"t": time, "wheels": rolled, "sensors": sensed, "pose": pose[:3]})
        for time, rolled, sensed, pose in scans
    )


with tempfile.TemporaryDirectory() as folder:
    run = ms.train(config, folder=f"{folder}/run")
    print("skill after 20 epochs", ms.evaluate(run, num=8000)["prediction.skill"])

    longer = dataclasses.replace(training, epochs=40)
    run = ms.train(ms.RunConfig(world, network, longer), folder=f"{folder}/run", resume=True)
    print("skill after 40 epochs", ms.evaluate(run, num=8000)["prediction.skill"])

    environment = gymnasium.make("motorspace/Exploration-v0", agent=body, sensor=senses)
    environment.reset(seed=0)
    print("east, north, sonars", environment.step(environment.action_space.sample())[0])

    log = Path(folder) / "robot.jsonl"
    log.write_text(lines(ms.record(world.scenario(), num_steps=3000, key=jax.random.key(0))))
    check_reader(my_robot.JsonLinesReader(), log)
    run = ms.train(ms.RunConfig(ms.Logged(log, horizon=3), network, longer))
    print("skill on the log", ms.evaluate(run)["prediction.skill"])
