"""`motorspace navigate`, from learning to moving pictures."""

import json

import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.cli.main import main
from motorspace.navigation.folder import config_of, load_policy
from motorspace.training.presets import BEST
from tests.tiny import flags

SMALL = [
    "--level", "1", "--num-layouts", "2", "--max-steps", "6", "--steps", "1", "--num-agents", "8",
    "--num-steps", "4", "--num-minibatches", "2", "--width-size", "8", "--num-epochs", "1",
]  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a run of the preset best, hardly trained."""
    folder = tmp_path_factory.mktemp("runs") / "run"
    words = ["train", "forward", *flags(), "--preset", "best", "--restarts", "1", "--epochs", "2"]
    for name in ("encoder", "code_size"):
        words += [f"--{name.replace('_', '-')}", str(BEST[name])]
    main([*words, "--max-rotation", "0.4", "--out", str(folder)])
    return folder


@pytest.fixture(scope="module")
def policy(run, tmp_path_factory):
    """The folder of a policy that observes the run's codes."""
    folder = tmp_path_factory.mktemp("policies") / "policy"
    words = ["navigate", "train", "displacement_goal", "--run", str(run), *SMALL]
    main([*words, "--observe", "ranges", "code", "--out", str(folder)])
    return folder


def refused(capsys, *words):
    with pytest.raises(SystemExit) as stop:
        main([str(word) for word in words])
    assert stop.value.code == 2
    return capsys.readouterr().err


@pytest.mark.slow
def test_a_policy_is_learned_for_the_body_of_the_run(policy):
    trained = load_policy(policy)
    assert dict(trained.config.agent.options)["max_rotation"] == pytest.approx(0.4 * np.pi)
    assert trained.config.observe == ("ranges", "code") and trained.codes is not None
    assert trained.config.ppo.num_agents == 8 and trained.config.policy.width_size == 8
    assert [record["steps"] for record in trained.log] == [4 * 8 * 4]
    assert trained.config == config_of(policy)


@pytest.mark.slow
def test_it_is_measured_beside_chance_and_the_planner(policy, capsys):
    main(["navigate", "evaluate", str(policy), "--num", "4", "--json"])
    shown = json.loads(capsys.readouterr().out)
    rows = {"seen", "unseen", "chance", "planner"}
    assert {name.partition(".")[0] for name in shown} == rows
    assert shown["planner.success"] >= shown["chance.success"] and shown["seen.num"] == 4
    assert json.loads((policy / "evaluation.json").read_text()) == shown


@pytest.mark.slow
def test_episodes_become_moving_pictures(policy, tmp_path, capsys):
    path = tmp_path / "some.gif"
    main(["navigate", "watch", str(policy), "--num", "1", "--goal", "1.5", "0", "--out", str(path)])
    assert path.read_bytes().startswith(b"GIF8")
    assert f"of 1 goals reached: {path}" in capsys.readouterr().out


def test_goals_that_cannot_be(policy, capsys):
    words = ["navigate", "watch", policy, "--num", "1", "--goal"]
    assert "goal must be 2 numbers (longitudinal, lateral), got 1" in refused(capsys, *words, "1")
    assert "is outside the world" in refused(capsys, *words, "90", "0")


def test_wrong_words_end_with_a_sentence(policy, run, capsys, tmp_path):
    train = ["navigate", "train", "home", *SMALL]
    err = refused(capsys, *train, "--run", run, "--agent", "holonomic")
    assert "the run's body is a forward agent, not a holonomic one; leave out --agent" in err
    assert "already holds a policy" in refused(capsys, *train, "--out", policy)
    assert "give its folder with --run" in refused(capsys, *train, "--observe", "code")
    assert "there is no run here" in refused(capsys, *train, "--run", tmp_path)
    err = refused(capsys, *train, "--observe", "smell")
    assert "'smell' is not one of ranges, bump" in err
    assert "written as GIF" in refused(capsys, "navigate", "watch", policy, "--out", "x.mp4")
    assert "there is no policy here" in refused(capsys, "navigate", "evaluate", tmp_path)
    assert "this is no policy" in refused(capsys, "navigate", "evaluate", run)


def test_a_broken_policy_is_refused(policy, tmp_path):
    for name in ("config.json", "policy.safetensors"):
        (tmp_path / name).write_bytes((policy / name).read_bytes()[:200])
    with pytest.raises(UserError, match="this is no policy, or one of another version"):
        load_policy(tmp_path)
    (tmp_path / "config.json").write_bytes((policy / "config.json").read_bytes())
    with pytest.raises(UserError, match="cut off or damaged"):
        load_policy(tmp_path)
