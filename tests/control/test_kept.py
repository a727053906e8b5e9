"""A controller is kept in the folder of its run, measured, and asked on the command line."""

import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.cli.main import main
from motorspace.control.controller import learn_controller
from motorspace.control.goals import DisplacementGoal
from motorspace.control.learning import ControlConfig
from motorspace.control.planning import plan
from motorspace.control.store import CONFIG, WEIGHTS, load_controller, save_controller
from motorspace.training.run import Run, train
from motorspace.training.settings import changed
from tests.tiny import TINY

SMALL = ControlConfig(
    updates=3, batch_size=8, width_size=8, depth=1, noise_size=2, bank=32, restarts=1
)
CONFIGURED = changed(
    TINY, {"encoder": "matrix_product", "code_size": 6, "epochs": 2, "layout": "empty"}
)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a run with a controller."""
    folder = tmp_path_factory.mktemp("control") / "run"
    save_controller(learn_controller(train(CONFIGURED, folder=folder), SMALL), SMALL, folder)
    return folder


def refused(capsys, *words):
    with pytest.raises(SystemExit) as ended:
        main([str(word) for word in words])
    assert ended.value.code == 2
    return capsys.readouterr().err


def test_a_controller_comes_back_as_it_was(run):
    first, second = load_controller(run), load_controller(run)
    for a, b in zip(jax.tree.leaves(first), jax.tree.leaves(second), strict=True):
        np.testing.assert_array_equal(a, b)
    here, goal = np.full(9, 5.0), DisplacementGoal(0.5, 0.1)
    learned = learn_controller(Run(CONFIGURED, first.model), SMALL)
    np.testing.assert_allclose(
        plan(first, here, goal).motors, plan(learned, here, goal).motors, atol=1e-5
    )


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        (CONFIG, None, "this run has no controller"),
        (CONFIG, b"{", "the controller cannot be read"),
        (CONFIG, b'{"format_version": 9}', "format version 9"),
        (CONFIG, b'{"format_version": 2, "config": {"magic": 1}}', "the controller cannot be read"),
        (WEIGHTS, b"1234", "cut off or damaged"),
    ],
)
def test_a_broken_controller_is_refused(run, name, content, sentence):
    before = (run / name).read_bytes()
    try:
        (run / name).unlink() if content is None else (run / name).write_bytes(content)
        with pytest.raises(UserError, match=sentence):
            load_controller(run)
    finally:
        (run / name).write_bytes(before)


@pytest.mark.slow
def test_codes_that_are_no_products_learn_what_remains(tmp_path):
    config = changed(TINY, {"epochs": 2})
    learned = learn_controller(train(config, folder=tmp_path), SMALL)
    save_controller(learned, SMALL, tmp_path)
    kept = load_controller(tmp_path)
    motors, goal = learned.bank.motors[0], learned.bank.codes[1]
    first, second = (c.remaining(goal, motors, jnp.array([True, False])) for c in (learned, kept))
    np.testing.assert_array_equal(first, second)
    assert first.shape == goal.shape and bool(np.isfinite(first).all())


def test_a_lattice_run_has_no_controller():
    config = changed(TINY, {"layout": "lattice:6"})
    from dataclasses import replace

    from motorspace.training.data import Simulated

    config = replace(config, data=Simulated("lattice", horizon=2))
    from motorspace.training.run import initial_run

    with pytest.raises(UserError, match="a controller needs continuous commands"):
        learn_controller(initial_run(config), SMALL)


def test_a_plan_on_the_command_line(run, capsys):
    main(["control", str(run), "--displacement", "0.5", "-0.2", "30", "--json"])
    shown = json.loads(capsys.readouterr().out)
    assert set(shown) == {"miss", "rotation", "move"} and len(shown["move"]) == 2
    main(["control", str(run), "--sensors", *["5"] * 9, "--now", *["6"] * 9, "--json"])
    assert json.loads(capsys.readouterr().out)["miss"] >= 0


@pytest.mark.slow
def test_a_controller_is_learned_where_there_is_none_and_measured(run, capsys, tmp_path):
    import shutil

    copy = shutil.copytree(run, tmp_path / "copy")
    (copy / CONFIG).unlink()
    main(["control", str(copy), "--updates", "2", "--num", "50", "--json"])
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    assert "learning a controller, 2 updates" in printed.err
    assert 0 <= found["control.success.random"] <= 1 and (copy / CONFIG).exists()
    assert found["control.success.simulated_cross_entropy"] > 0.9
    assert found["control.sensors.simulated"] > found["control.sensors.stay"]
    assert {"control.cost.hybrid", "control.diversity", "control.success.far"} <= set(found)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--displacement", "1", "0", "0", "--code", "1"], "are two goals"),
        (["--sensors", "1"], "from where is not said"),
        (["--displacement", "1", "0"], "expected 3 arguments"),
        (["--code", "1", "2"], "the code must be 6 numbers"),
        (["--displacement", "nan", "0", "0"], "must be a number"),
    ],
)
def test_wrong_goals_are_one_sentence(run, capsys, words, sentence):
    assert sentence in refused(capsys, "control", run, *words)
