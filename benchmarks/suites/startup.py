"""Until motorspace answers, beside a bare interpreter: help, a wrong flag, a wrong file, import."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence

from benchmarks.harness import Contender, Launch, report, take_turns

STARTS = {
    "help": ("motorspace --help", ["-m", "motorspace", "--help"], 0),
    "flag": ("a wrong flag", ["-m", "motorspace", "train", "forward", "--epoch", "5"], 2),
    "file": ("a wrong file", ["-m", "motorspace", "inspect", "missing.log"], 2),
    "import": ("import motorspace", ["-c", "import motorspace"], 0),
}
"""What is started: its name, the interpreter's arguments, and the exit code."""


def main() -> None:
    """Starts in turns, so that whatever slows the machine slows both."""
    threads = int(os.environ["BENCHMARK_THREADS"])
    name, arguments, code = STARTS[os.environ["BENCHMARK_START"]]
    contenders = [
        start("motorspace", arguments, code=code),
        start("a bare interpreter", ["-c", "pass"]),
    ]
    rates, first, foreign = take_turns(contenders, seconds=2.0)
    report(Launch(name, "starts", threads, rates, first, {}, foreign))


def start(name: str, arguments: Sequence[str], *, code: int = 0) -> Contender:
    """A fresh interpreter, until its end, in a folder without files."""
    here = os.getcwd()
    environment = os.environ | {"PYTHONPATH": here}

    def run() -> None:
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [sys.executable, *arguments], cwd=folder, env=environment, capture_output=True
            )
        assert done.returncode == code, done.stderr.decode()

    return Contender(name, run, 1)


if __name__ == "__main__":
    main()
