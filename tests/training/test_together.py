"""Runs that differ by seeds and by numbers are one program, and each is what it would be alone."""

from dataclasses import replace

import jax
import numpy as np
import pytest

from motorspace._errors import UserError
from motorspace.models.config import ModelConfig
from motorspace.training import program
from motorspace.training.config import RunConfig, TrainingConfig
from motorspace.training.data import Derived, Simulated
from motorspace.training.run import load_run, train, train_together
from motorspace.training.settings import changed

SMALL = TrainingConfig(
    epochs=6,
    trajectories_per_epoch=64,
    batch_size=32,
    isometry_weight=0.5,
    code_noise=0.1,
    ema_decay=0.9,
)
NETWORK = ModelConfig("matrix_product", hidden_size=8, code_size=6, width_size=8, depth=1)
BASE = RunConfig(Simulated(layout="empty", horizon=2), NETWORK, SMALL)
NUMBERS = {
    "max_rotation": 0.7,
    "learning_rate": 1e-3,
    "isometry_weight": 2.0,
    "code_noise": 0.3,
    "ema_decay": 0.5,
    "curriculum": 0.6,
    "seed": 3,
}


@pytest.fixture
def traces(monkeypatch) -> list[int]:
    """Grows by one whenever an epoch is traced, which is when a program is compiled."""
    seen, original = [], program._updated

    def traced(*given):
        seen.append(1)
        return original(*given)

    monkeypatch.setattr(program, "_updated", traced)
    return seen


def test_runs_that_differ_by_numbers_are_one_program_and_each_as_if_alone(tmp_path, traces):
    base = changed(BASE, {"hidden_size": 7})
    configs = [base, *(changed(base, {name: number}) for name, number in NUMBERS.items())]
    assert len({config.program() for config in configs}) == 1
    folders = [tmp_path / str(n) for n in range(len(configs))]
    together = train_together(configs, folders)
    assert len(traces) == 1
    alone = [train(config) for config in configs]
    assert len(traces) == 2, "one by one they share another program"
    motors = np.ones((3, 2, 2), np.float32)
    codes = [np.asarray(run.encode(motors)) for run in alone]
    for ours, expected, folder, code in zip(together, alone, folders, codes, strict=True):
        assert sum(np.allclose(code, other, atol=1e-5) for other in codes) == 1
        np.testing.assert_allclose(ours.encode(motors), code, atol=1e-5)
        for record, wanted in zip(ours.log, expected.log, strict=True):
            assert record == pytest.approx(wanted, rel=1e-4)
        assert load_run(folder).model.scaling == expected.model.scaling


def test_runs_that_differ_otherwise_are_programs_of_their_own(tmp_path, traces):
    others = [{"batch_size": 16}, {"isometry_weight": 0.0}, {"horizon": 3}, {"hidden_size": 6}]
    configs = [BASE, *(changed(BASE, other) for other in others)]
    assert len({config.program() for config in configs}) == len(configs)
    train_together(configs[-2:], [tmp_path / "longer", tmp_path / "smaller"])
    assert len(traces) == 2


def test_oracles_of_different_agents_are_one_program(tmp_path, traces):
    oracle = RunConfig(Derived(BASE.data, "oracle"), ModelConfig("identity"), SMALL)
    configs = [oracle, changed(oracle, {"max_rotation": 0.7})]
    train_together(configs, [tmp_path / "a", tmp_path / "b"])
    assert len(traces) == 1


def test_a_run_that_explodes_does_not_stop_the_others(tmp_path):
    configs = [changed(BASE, {"learning_rate": 1e30}), BASE]
    folders = [tmp_path / "broken", tmp_path / "sound"]
    with pytest.raises(UserError, match="no longer finite after epoch"):
        train_together(configs, folders)
    (sound,) = train_together([BASE], folders[1:], resume=True)
    assert len(sound.log) == SMALL.epochs
    alone = train(BASE)
    assert sound.log[-1] == pytest.approx(alone.log[-1], rel=1e-4)
    assert not (folders[0] / "weights.safetensors").exists()


@pytest.mark.slow
def test_restarts_of_several_runs_are_tried_together(tmp_path):
    several = [changed(BASE, {"restarts": 2, "seed": seed}) for seed in (0, 1)]
    together = train_together(several, [tmp_path / "a", tmp_path / "b"])
    motors = np.ones((3, 2, 2), np.float32)
    for config, run in zip(several, together, strict=True):
        np.testing.assert_allclose(run.encode(motors), train(config).encode(motors), atol=1e-5)


@pytest.mark.parametrize("precision", ["tf32", "bf16"])
def test_a_cpu_computes_in_float32_whatever_is_asked_for(precision):
    assert jax.default_backend() == "cpu", "products would be rounded"
    rounded = replace(BASE, training=replace(SMALL, precision=precision))
    motors = np.ones((3, 2, 2), np.float32)
    np.testing.assert_array_equal(train(rounded).encode(motors), train(BASE).encode(motors))
    assert rounded.hash() != BASE.hash()
