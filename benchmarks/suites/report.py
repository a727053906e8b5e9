"""A report on a hundred thousand codes of anybody's: time, and what it takes of memory."""

import time

import numpy as np

import motorspace as ms
from benchmarks.harness import report_once

NUM, HORIZON, CODE_SIZE, GROUP = 100_000, 6, 50, 8


def main() -> None:
    """Every measure of random codes of the paper's size, beside a minute."""
    rng = np.random.default_rng(0)
    translation, turns = rng.normal(size=(NUM, 2)), rng.uniform(-np.pi, np.pi, (NUM, 1))
    points = np.concatenate([translation, np.cos(turns), np.sin(turns)], axis=1)
    codes = np.tanh(points @ rng.normal(size=(4, CODE_SIZE)))
    displacements = np.concatenate([translation, turns], axis=1)
    motors, groups = rng.normal(size=(NUM, HORIZON, 2)), np.arange(NUM) // GROUP

    def measured() -> dict[str, float]:
        begun = time.perf_counter()
        ms.topology(codes, displacements, motors, groups)
        return {"motorspace": time.perf_counter() - begun, "a minute": 60.0}

    report_once("a report on 100,000 codes", "reports", measured)


if __name__ == "__main__":
    main()
