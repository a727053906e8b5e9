"""Calls of the compiled program: runs that are alike in one, epochs by the hundred."""

import time
from collections.abc import Hashable, Iterator, Sequence
from typing import Any, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np

from motorspace._types import Count, Record
from motorspace.models.model import UNSCALED
from motorspace.training.objective import EpochRecord
from motorspace.training.program import (
    MOST_EPOCHS,
    Task,
    TrainState,
    train_epochs,
    train_epochs_together,
)

CALL_SECONDS = 1.0
"""How long a call of the program should take: until then nothing returns to the host."""

Tree = TypeVar("Tree")


def alike(states: Sequence[TrainState], tasks: Sequence[Task]) -> list[list[int]]:
    """The numbers of the runs that one program trains, for each program."""
    groups: dict[Hashable, list[int]] = {}
    for n, (state, task) in enumerate(zip(states, tasks, strict=True)):
        arrays, rest = eqx.partition((state.with_scaling(UNSCALED), task), eqx.is_array)
        shapes = tuple((leaf.shape, leaf.dtype) for leaf in jax.tree.leaves(arrays))
        leaves, structure = jax.tree.flatten(rest)
        program = (jax.tree.structure(arrays), shapes, structure, tuple(leaves))
        groups.setdefault(program, []).append(n)
    return [*groups.values()]


def calls(
    states: Sequence[TrainState], tasks: Sequence[Task], until: int, every: int = MOST_EPOCHS
) -> Iterator[tuple[list[TrainState], list[list[Record]]]]:
    """The states after each call of their program up to an epoch, and the records of that call."""
    bare = [state.with_scaling(UNSCALED) for state in states]
    alone, (own, shared) = len(states) == 1, parted(tasks)
    now, epoch, pace = bare[0] if alone else stacked(bare), int(states[0].epoch), 1
    while epoch < until:
        num = min(pace, until - epoch, every - epoch % every)
        begun = time.perf_counter()
        if alone:
            now, records = train_epochs(now, tasks[0], jnp.int32(num))
        else:
            now, records = train_epochs_together(now, own, shared, jnp.int32(num))
        on_host = jax.tree.map(np.asarray, records)
        seconds = time.perf_counter() - begun
        after, of_runs = ([now], [on_host]) if alone else _rows(now, on_host)
        yield (
            [new.with_scaling(old.model.scaling) for new, old in zip(after, states, strict=True)],
            [_logged(epoch, records, num) for records in of_runs],
        )
        epoch += num
        pace = min(MOST_EPOCHS, max(1, int(CALL_SECONDS * num / seconds)))


def _logged(epoch: int, records: EpochRecord, num: int) -> list[Record]:
    """The records of `num` epochs after `epoch` as what is written."""
    columns = {name: value for name, value in vars(records).items() if value is not None}
    return [
        {"epoch": epoch + n + 1} | {name: float(value[n]) for name, value in columns.items()}
        for n in range(num)
    ]


def stacked(trees: Sequence[Tree]) -> Tree:
    """Trees that are alike as one, whose arrays have a row for each."""
    arrays, rest = zip(*(eqx.partition(tree, eqx.is_array) for tree in trees), strict=True)
    return eqx.combine(jax.tree.map(lambda *leaves: jnp.stack(leaves), *arrays), rest[0])


def parted(tasks: Sequence[Task]) -> tuple[Task, Task]:
    """Tasks that are alike as what differs, with a row for each, and what does not."""
    first, *others = tasks

    def differs(leaf: Any, *same: Any) -> bool:
        return eqx.is_array(leaf) and not all(leaf is s or bool((leaf == s).all()) for s in same)

    own = jax.tree.map(differs, first, *others)
    parts = [eqx.partition(task, own) for task in tasks]
    return stacked([mine for mine, _ in parts]), parts[0][1]


def _rows(states: TrainState, records: EpochRecord) -> tuple[list[TrainState], list[EpochRecord]]:
    """The state and the records of each run of a batch."""
    num = len(records.prediction_loss)
    return (
        [_nth(states, jnp.int32(n)) for n in range(num)],
        [jax.tree.map(lambda leaf, n=n: leaf[n], records) for n in range(num)],
    )


@eqx.filter_jit
def _nth(together: Tree, place: Count) -> Tree:
    return jax.tree.map(lambda leaf: leaf[place] if eqx.is_array(leaf) else leaf, together)
