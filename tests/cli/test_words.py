"""Wrong words are one sentence that says what to write instead, and exit code 2."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from motorspace.cli import main as cli
from motorspace.cli.main import COMMANDS, main
from motorspace.worlds.catalog import SENSORS

ROOT = Path(__file__).parents[2]

WRONG = {
    # commands
    "swep --help": "there is no command 'swep'; perhaps 'sweep'",
    "fly": "there is no command 'fly'; choose one of demo, train, evaluate, topology",
    "--verbose": "the flag --verbose does not exist, or belongs to a command; begin with",
    # flags
    "train forward --rotation 3": "the flag --rotation does not exist; perhaps --max-rotation",
    "train forward --starts 3": "the flag --starts does not exist; perhaps --restarts",
    "train forward --zzz": "the flag --zzz does not exist; see motorspace train --help",
    "train --agent forward": "--agent: AGENT is given without a flag; write: motorspace train",
    "evaluate r --jsn": "the flag --jsn does not exist; perhaps --json",
    "evaluate r --epochs 3": "the flag --epochs applies to motorspace train only",
    "train lattice --max-rotation 1": "--max-rotation applies to the agents forward and holonomic",
    "train lattice --num-rays 3": "--num-rays applies to the sensors range_fan and retina and",
    "train lattice --no-sense-head": "--no-sense-head applies to the sensor range_fan only",
    "train forward --num-blocks 9": "the flag --num-blocks applies to logs (--data) only",
    "train --data t.csv --layout empty": "the flag --layout applies to simulations only",
    "train --data t.csv --max-rotation 1": "--max-rotation applies to the agents forward and",
    "train --data t.csv --num-rays 3": "the flag --num-rays applies to the sensors range_fan and",
    "inspect t.csv --num-rays 3": "the flag --num-rays applies to the sensors range_fan and",
    "inspect t.csv --epochs 3": "the flag --epochs applies to motorspace train only",
    # values
    "train forward --max-rotation": "--max-rotation: its value is missing; see motorspace train",
    "train forward --max-rotation --epochs 3": "--max-rotation: its value is missing",
    "train forward --max-rotation much": "--max-rotation: must be a number, got 'much'",
    "train forward --max_rotation much": "--max-rotation: must be a number, got 'much'",
    "train forward --max-rotation inf": "--max-rotation: must be a number, got 'inf'",
    "train forward --max-rotation 0": "max_rotation must be above 0 (in units of pi), got 0.0",
    "train forward --num-rays 0": "num_rays must be above 0, got 0",
    "train forward --max-range -1": "max_range must be above 0, got -1.0",
    "train forward --epochs 1.5": "--epochs: must be a whole number, got '1.5'",
    "train forward --epochs 0": "epochs must be at least 1, got 0",
    "train forward --batch-size 5000": "batch_size 5000 is above trajectories_per_epoch 2000",
    "train forward --horizon 0": "horizon must be at least 1, got 0",
    "train forward --min-horizon 9": "min_horizon 9 is above horizon 6",
    "train forward --learning-rate -1": "learning_rate must be above 0 and finite, got -1",
    "train forward --ema-decay 1.5": "ema_decay must be from 0 to 0.999999, got 1.5",
    "train forward --curriculum 2": "curriculum must be from 0 to 1, got 2",
    "train forward --code-noise -1": "code_noise must be at least 0 and finite, got -1",
    "train forward --hidden-size 0": "hidden_size must be at least 1, got 0",
    "train forward --seed 99999999999": "seed must be from 0 to 2147483647, got 99999999999",
    "train forward --encoder group": "no encoder named 'group' (perhaps 'gru'); choose one of lstm",
    "train forward --preset bestest": "--preset: 'bestest' is not one of paper, best",
    "train forward --collision bounce": "--collision: 'bounce' is not one of resample, block",
    "train holonomic --head-rule spin": "--head-rule: 'spin' is not one of set, turn",
    "train forward --layout nowhere": "there is no layout 'nowhere'; choose one of corridors",
    "train forward --layout rooms:x": "layout 'rooms:x': the seed of random rooms must be a whole",
    "train forward --sensor nose": "there is no sensor named 'nose'",
    "train forward --seeds 0": "--seeds: must be at least 1, got 0",
    "train forward --seeds 2 --tensorboard": "--tensorboard takes one seed at a time",
    "train forward --jobs 0": "--jobs: must be at least 1, got 0",
    "evaluate r --num 0": "--num: must be at least 1, got 0",
    "topology r --seed -1": "--seed: must be from 0 to 2147483647, got -1",
    "export r --format zarr": "--format: 'zarr' is not one of npy, parquet",
    "completion fish": "SHELL: 'fish' is not one of bash, zsh, tcsh",
    # switches
    "train forward --resume=1": "--resume: the flag takes no value",
    "train forward --sense-head=yes": "--sense-head: the flag takes no value",
    "train forward --sense-head false": "flags that switch take no value: write --FLAG or --no",
    # positional words
    "train crab": "there is no agent named 'crab'",
    "train foward": "there is no agent named 'foward' (perhaps 'forward')",
    "train forward backward": "nothing is expected here: 'backward'",
    "train forward --data t.csv": "a log is not simulated, so no agent applies: 'forward'",
    "train lattice --data t.csv": "a log is not simulated, so no agent applies: 'lattice'",
    "train --reader carmen": "--reader applies to logs only; give a log with --data",
    "evaluate": "RUN is missing; see motorspace evaluate --help",
    "inspect": "LOG is missing",
    "compare r": "one run cannot be compared; give the folders of two or more",
    "export r": "nothing to export was named; give --num N, --onnx or --numpy",
    # files
    "train --data nowhere": "nowhere: there is no such file; check the path",
    "train --data plain.txt": "plain.txt: the columns are hello; a table needs time",
    "train --data .": "this is a folder",
    "evaluate nowhere": "nowhere: there is no run here; give a folder made by motorspace train",
    "evaluate plain.txt": "plain.txt: there is no run here",
    "topology nowhere": "nowhere: there is no run here",
    "topology codes.npy": "codes.npy: codes alone cannot be measured; give their displacements",
    "topology codes.npy d.npy --standard-form": "--standard-form: codes from files are measured as",
    "topology codes.npy d.npy --data t.csv": "--data: codes from files are measured as they are",
    "topology nowhere --motors m.npy": "--motors: a run's motor commands are known; leave it out",
    "inspect nowhere": "nowhere: there is no such file",
    "compare nowhere elsewhere": "nowhere: there is no run here",
    # modules of one's own
    "train --import": "--import: its value is missing",
    "train --import nothing_here": "--import nothing_here: there is no module 'nothing_here'; give",
    "train --import=broken": "the module cannot be imported (SyntaxError: ",
    "train --import failing": "failing.py:1: ZeroDivisionError: division by zero); mend it",
    "train --import lacking": "there is no module 'not_there'; install 'not_there', which it",
    "evaluate r --import nothing_here": "--import nothing_here: there is no module",
}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder with the files that the words name."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr(SENSORS, "_added", dict(SENSORS._added))
    for name, content in {
        "plain.txt": "hello\nworld\n",
        "codes.npy": "none",
        "d.npy": "none",
        "t.csv": "time,motor_a,sensor_a\n0,1,2\n1,1,3\n2,2,1\n",
        "broken.py": "def f(:\n",
        "failing.py": "1 / 0\n",
        "lacking.py": "import not_there\n",
    }.items():
        (tmp_path / name).write_text(content)


def refused(words, capsys):
    """The one sentence that words end with."""
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 2
    (sentence,) = capsys.readouterr().err.strip().splitlines()
    return sentence


@pytest.mark.parametrize("words", WRONG)
def test_wrong_words_are_one_sentence_with_a_remedy(capsys, words):
    sentence = refused(words.split(), capsys)
    assert sentence.startswith("motorspace: ") and sentence.endswith(".")
    assert WRONG[words] in sentence


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_that_names_its_words_and_flags(capsys, name):
    with pytest.raises(SystemExit) as stop:
        main([name, "--help"])
    assert stop.value.code == 0
    shown = capsys.readouterr().out
    assert shown.startswith(f"usage: motorspace {name}") and "--import MODULE" in shown
    main(["--help"])
    assert f"  {name} " in capsys.readouterr().out


def test_the_help_of_train_is_that_of_its_agent_sensor_and_log(capsys):
    shown = {}
    for words in (
        "forward",
        "holonomic",
        "lattice",
        "--data t.csv",
        "--data t.csv --reader carmen",
    ):
        with pytest.raises(SystemExit):
            main(["train", *words.split(), "--help"])
        shown[words] = capsys.readouterr().out
    assert "--head-rule" in shown["holonomic"] and "--head-rule" not in shown["forward"]
    assert "--num-rays" in shown["forward"] and "--num-rays" not in shown["lattice"]
    assert "--layout" in shown["lattice"] and "--layout" not in shown["--data t.csv"]
    assert "--separator" in shown["--data t.csv"]
    assert "--num-rays" in shown["--data t.csv --reader carmen"]
    assert "(default: 0.8)" in shown["forward"] and "In units of pi." in shown["forward"]


def test_flags_of_a_class_of_ones_own_come_with_it(capsys, tmp_path):
    (tmp_path / "my_sensor.py").write_text(
        "import equinox as eqx\n"
        "import motorspace as ms\n"
        '@ms.register("sniffer")\n'
        "class Sniffer(ms.AbstractSensor):\n"
        "    reach: float = eqx.field(static=True, default=2.0)\n"
        '    """How far it smells."""\n'
        "    def space(self, world): ...\n"
        "    def sense(self, world, pose): ...\n"
    )
    flags = ["train", "forward", "--import", "my_sensor", "--sensor", "sniffer"]
    with pytest.raises(SystemExit):
        main([*flags, "--help"])
    shown = capsys.readouterr().out
    assert "--reach X" in shown and "How far it smells. (default: 2.0)" in shown
    assert "--num-rays applies to the sensor" in refused([*flags, "--num-rays", "3"], capsys)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("train", "motorspace: stopped; --resume continues"),
        ("reproduce", "motorspace: stopped; the same command continues"),
        ("evaluate", "motorspace: stopped"),
    ],
)
def test_an_interruption_says_how_to_go_on(monkeypatch, capsys, name, said):
    def interrupt(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "run", interrupt)
    with pytest.raises(SystemExit) as stop:
        main([name])
    assert stop.value.code == 130
    assert capsys.readouterr().err == f"{said}\n"


def test_completion_knows_commands_and_flags(capsys):
    main(["completion", "bash"])
    script = capsys.readouterr().out
    assert all(name in script for name in COMMANDS)
    assert "--max-rotation" in script and "--standard-form" in script


def test_the_output_may_be_cut_off():
    """As by `| head -1`: no traceback, and nothing at exit."""
    command = f"{sys.executable} -m motorspace completion bash | head -1"
    done = subprocess.run(
        command,
        shell=True,
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
