"""The examples run, and classes of one's own work from Python and from the command line."""

import json
import re
import runpy
import subprocess
import sys
from pathlib import Path

import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace._types import Pose
from motorspace.cli.main import main
from motorspace.models.config import ENCODERS
from motorspace.recordings.catalog import READERS
from motorspace.recordings.readers.base import read_log
from motorspace.training.folder import load_config
from motorspace.training.run import load_run
from motorspace.worlds.catalog import AGENTS, SENSORS

EXAMPLES = Path(__file__).parents[1] / "examples"
SCRIPTS = (
    *("first_steps", "own_layout", "own_log", "own_classes"),
    *("reach_a_goal", "find_a_place", "from_images"),
)
SMALL = [
    *("--code-size", "4", "--width-size", "8", "--depth", "1"),
    *("--trajectories-per-epoch", "64", "--batch-size", "32"),
]


@pytest.fixture(scope="module", autouse=True)
def examples():
    """The folder of the examples as the present one; what they register is forgotten after."""
    registries = (AGENTS, SENSORS, ENCODERS, READERS)
    before = [dict(registry._added) for registry in registries]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(EXAMPLES)
        patch.syspath_prepend(EXAMPLES)
        yield
    sys.modules.pop("my_robot", None)
    for registry, added in zip(registries, before, strict=True):
        registry._added = added


@pytest.fixture
def my_robot():
    import my_robot

    return my_robot


@pytest.fixture
def log(tmp_path):
    """A robot that turns on the spot and drives back and forth."""
    rng, path = np.random.default_rng(0), tmp_path / "log.jsonl"
    scans = [
        {"t": t, "wheels": list(rng.uniform(-0.2, 1.0, 2)), "sensors": list(rng.uniform(0, 6, 3))}
        for t in range(120)
    ]
    path.write_text("".join(json.dumps(scan) + "\n" for scan in scans))
    return path


LONG = ("first_steps", "own_classes", "find_a_place", "from_images", "reach_a_goal")
"""Those that train for long; what they show is tested in smaller pieces as well."""


@pytest.mark.parametrize(
    "script",
    [pytest.param(name, marks=pytest.mark.slow if name in LONG else ()) for name in SCRIPTS],
)
def test_an_example_runs(script, capsys, tmp_path):
    source = (EXAMPLES / f"{script}.py").read_text()
    small = re.sub(r"epochs=(\d+)", lambda found: f"epochs={int(found[1]) // 20 or 1}", source)
    (tmp_path / "script.py").write_text(small.replace("num=8000", "num=400"))
    try:
        runpy.run_path(str(tmp_path / "script.py"), run_name="__main__")
    except SystemExit as ended:
        if not str(ended).startswith("no images: "):
            raise
        pytest.skip(str(ended))
    assert len(capsys.readouterr().out.splitlines()) >= 2


def test_there_is_no_other_example():
    assert {path.stem for path in EXAMPLES.glob("*.py")} == {*SCRIPTS, "my_robot"}


def test_two_wheels_turn_and_roll_along_an_arc(my_robot):
    body, here = my_robot.TwoWheels(wheel_base=0.5), Pose(*jnp.zeros(4))
    straight, half_circle = (
        body.move(here, jnp.array(motor))[-1] for motor in ((1.0, 1.0), (0.0, np.pi / 2))
    )
    np.testing.assert_allclose([straight.x, straight.y, straight.heading], [1, 0, 0], atol=1e-6)
    # The left wheel stands still: the body's centre goes half around it.
    np.testing.assert_allclose([half_circle.x, half_circle.y], [0, 0.5], atol=1e-6)
    np.testing.assert_allclose(abs(half_circle.heading), np.pi, atol=1e-6)


@pytest.mark.slow
def test_train_evaluate_and_lengthen_from_the_command_line(tmp_path, capsys):
    run = tmp_path / "run"
    own = ["--import", "my_robot", "--sensor", "compass_and_sonar", "--encoder", "odometer"]
    flags = [*own, *SMALL, "--wheel-base", "0.4", "--num-sonars", "3", "--layout", "empty"]
    # The agent may also stand after the flags that make it known.
    command = ["train", *flags, "two_wheels", "--horizon", "2", "--out", str(run)]
    main([*command, "--epochs", "2"])
    data = load_config(run).data
    assert data.agent.as_json() == {"kind": "two_wheels", "wheel_base": 0.4}
    assert data.sensor.as_json() == {
        "kind": "compass_and_sonar",
        "num_sonars": 3,
        "max_range": 6.0,
    }
    main(["evaluate", str(run), "--import", "my_robot", "--num", "64"])
    assert "prediction.skill" in capsys.readouterr().out
    main([*command, "--epochs", "3", "--resume"])
    assert [record["epoch"] for record in load_run(run).log] == [1, 2, 3]


def test_flags_of_a_class_that_is_not_chosen_are_refused(capsys):
    words = ["train", "forward", "--import", "my_robot", "--wheel-base", "0.4"]
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert "--wheel-base applies to the agent two_wheels only" in capsys.readouterr().err


def test_learn_from_a_log_of_ones_own_from_the_command_line(tmp_path, capsys, log):
    run = tmp_path / "run"
    own = ["--import", "my_robot", "--wheel-scale", "0.5"]
    main(["inspect", *own, str(log)])
    assert capsys.readouterr().out.startswith("name")
    flags = [*own, *SMALL, "--encoder", "odometer", "--horizon", "2", "--num-blocks", "8"]
    main(["train", "--data", str(log), *flags, "--epochs", "2", "--out", str(run)])
    data = load_config(run).data
    assert data.reader.kind == "json_lines" and dict(data.reader.options)["wheel_scale"] == 0.5
    main(["evaluate", "--import", "my_robot", str(run)])
    assert "prediction.error" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("{", "line 3: the line is no scan .*JSONDecodeError"),
        ('{"t": 3}', "line 3: the line is no scan .*'wheels'"),
        ("[1, 2]", "line 3: the line is no scan"),
        ('{"t": 3, "wheels": [1, 2], "sensors": [1]}', "line 3: .* differs from .* the first"),
    ],
)
def test_a_broken_line_of_the_log_is_named(my_robot, tmp_path, line, sentence):
    path = tmp_path / "log.jsonl"
    good = '{"t": 0, "wheels": [0.1, 0.2], "sensors": [1.0, 2.0], "pose": [0, 0, 0]}'
    path.write_text("\n".join([good, good, line]))
    with pytest.raises(UserError, match=sentence):
        read_log(path)


def described(run, **kinds):
    """A run's folder that names classes, written by hand."""
    run.mkdir()
    sensor = {"kind": kinds.get("sensor", "range_fan")}
    data = {"kind": "simulated", "agent": {"kind": kinds.get("agent", "forward")}, "sensor": sensor}
    config = {
        "data": data | {"layout": "empty", "horizon": 2},
        "model": {"encoder": kinds.get("encoder", "lstm")},
        "training": {},
    }
    scaling = {"sensors": [10.0] * 9, "motors": [1.0, 1.0]}
    written = {"format_version": 2, "config": config, "scaling": scaling, "horizon": 2}
    (run / "config.json").write_text(json.dumps(written))
    (run / "weights.safetensors").write_bytes(b"")
    return run


@pytest.mark.parametrize("family", ["agent", "sensor", "encoder"])
@pytest.mark.parametrize("command", ["evaluate", "topology", "export", "compare"])
def test_a_class_that_is_not_imported_is_named_and_never_imported(tmp_path, family, command):
    """A process of its own, in a folder with a module of that name."""
    (tmp_path / "intruder.py").write_text("raise SystemExit('imported')\n")
    run = described(tmp_path / "run", **{family: "intruder"})
    more = {"compare": [str(run)], "export": ["--num", "8"]}
    words = [command, str(run), *more.get(command, [])]
    done = subprocess.run(
        [sys.executable, "-m", "motorspace", *words],
        cwd=tmp_path,
        env={"PYTHONPATH": f"{EXAMPLES.parent}:{tmp_path}", "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2 and "imported" not in done.stdout
    assert f"there is no {family} named 'intruder'" in done.stderr, done.stderr
    assert "import the module that registers it (on the command line: --import MODULE)" in (
        done.stderr
    )
