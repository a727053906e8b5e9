"""Arrays of a training state as one file, and back."""

from pathlib import Path
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array
from safetensors import SafetensorError
from safetensors.numpy import load, save

from motorspace._errors import UserError

Tree = TypeVar("Tree")


def packed(tree: Any) -> bytes:
    """The arrays of a tree as a safetensors file, named by their place in it."""
    return save({name: np.asarray(leaf) for name, leaf in named_arrays(tree).items()})


def unpacked(template: Tree, path: Path) -> Tree:
    """`template` with the arrays of a file. Raises `UserError` unless all of them fit."""
    try:
        stored = load(path.read_bytes())
    except (OSError, SafetensorError):
        raise UserError(
            "the file is cut off or damaged", where=path, remedy="train the run anew"
        ) from None
    expected = {name: (a.shape, a.dtype) for name, a in named_arrays(template).items()}
    if {name: (a.shape, a.dtype) for name, a in stored.items()} != expected:
        raise UserError(
            "the weights do not fit the run's configuration",
            where=path,
            remedy="train the run anew",
        )
    arrays, rest = eqx.partition(template, eqx.is_array)
    leaves, structure = jax.tree_util.tree_flatten_with_path(arrays)
    loaded = [jnp.asarray(stored[jax.tree_util.keystr(path)]) for path, _ in leaves]
    return eqx.combine(jax.tree.unflatten(structure, loaded), rest)


def named_arrays(tree: Any) -> dict[str, Array]:
    """Every array of a tree by its place in it."""
    leaves = jax.tree_util.tree_leaves_with_path(eqx.filter(tree, eqx.is_array))
    return {jax.tree_util.keystr(path): leaf for path, leaf in leaves}
