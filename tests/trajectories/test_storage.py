"""Trajectories come back from their file unchanged, or not at all."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from safetensors.numpy import save_file

from motorspace import UserError
from motorspace.trajectories.storage import load_trajectories, save_trajectories
from motorspace.trajectories.transitions import Displacements, Experience, Trajectories

CONFIG = {"agent": "forward", "horizon": 6, "nested": {"rates": [0.5, None]}}


def trajectories(seed: int = 0) -> Trajectories:
    rng = np.random.default_rng(seed)
    draw = lambda *shape: jnp.asarray(rng.normal(size=shape), jnp.float32)  # noqa: E731
    experience = Experience(draw(7, 9), draw(7, 6, 2), jnp.arange(7, dtype=jnp.int32), draw(7, 9))
    return Trajectories(experience, Displacements(draw(7, 3), jnp.full((7, 3), jnp.nan)))


def same(one: Trajectories, other: Trajectories) -> bool:
    pairs = zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    return all(
        a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f") for a, b in pairs
    )


def test_everything_comes_back(tmp_path):
    path = tmp_path / "some.safetensors"
    save_trajectories(str(path), trajectories(), config=CONFIG)
    loaded, config = load_trajectories(str(path))
    assert same(loaded, trajectories())
    assert not same(loaded, trajectories(1))
    assert config == CONFIG


def test_a_file_is_replaced_and_nothing_is_left_beside_it(tmp_path):
    path = tmp_path / "some.safetensors"
    save_trajectories(path, trajectories(), config=CONFIG)
    save_trajectories(path, trajectories(1), config={})
    loaded, config = load_trajectories(path)
    assert same(loaded, trajectories(1)) and config == {}
    assert list(tmp_path.iterdir()) == [path]


def test_a_failed_write_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "some.safetensors"
    save_trajectories(path, trajectories(), config=CONFIG)

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("motorspace._files.os.fsync", full)
    with pytest.raises(UserError, match="cannot be written \\(No space left on device\\)"):
        save_trajectories(path, trajectories(1), config={})
    assert same(load_trajectories(path)[0], trajectories())
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("keep", [0, 5, 100, -1])
def test_a_cut_file_is_told(tmp_path, keep):
    path = tmp_path / "some.safetensors"
    save_trajectories(path, trajectories(), config=CONFIG)
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(UserError, match=r"some\.safetensors: .*damaged"):
        load_trajectories(path)


def test_a_changed_value_is_told(tmp_path):
    path = tmp_path / "some.safetensors"
    save_trajectories(path, trajectories(), config=CONFIG)
    content = bytearray(path.read_bytes())
    content[-10] ^= 1
    path.write_bytes(content)
    with pytest.raises(UserError, match="does not match its checksum"):
        load_trajectories(path)


def test_other_files_are_told(tmp_path):
    with pytest.raises(UserError, match="cannot be read \\(No such file or directory\\)"):
        load_trajectories(tmp_path / "nowhere.safetensors")
    with pytest.raises(UserError, match="cannot be read \\(Is a directory\\)"):
        load_trajectories(tmp_path)
    save_file({"weights": np.zeros(3)}, tmp_path / "weights.safetensors")
    with pytest.raises(UserError, match="the file holds something else"):
        load_trajectories(tmp_path / "weights.safetensors")
    with pytest.raises(UserError, match="cannot be written"):
        save_trajectories(tmp_path / "no" / "folder", trajectories(), config={})
