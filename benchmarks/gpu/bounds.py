"""What the device could do at most: copies, products, launches, and updates beside their bounds."""

import re
from collections.abc import Iterator
from functools import partial
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp

from benchmarks.gpu.ours import compiled_update, ours
from benchmarks.gpu.sizes import Sizes
from benchmarks.gpu.timing import Case, Row, rate, timed, value
from benchmarks.gpu.training import counted
from benchmarks.programs import of_one
from benchmarks.roofline import SAMPLE_FLOPS
from motorspace.training.config import RunConfig

PRODUCTS = {"float32": "float32", "tf32": "tensorfloat32"}
"""What JAX calls the precision of each product."""
PASSES = 8
"""Times that an update reads or writes each weight at least: the weight and both moments read and
written, the gradient written and read."""
KERNEL = re.compile(r" (?:fusion|custom-call)\(")
"""Operations of a compiled program that become kernels of their own."""


def roofline(sizes: Sizes) -> Iterator[Case]:
    """The device's limits first, then updates of more and more runs beside them."""
    limits: dict[str, float] = {}
    yield partial(_copy, sizes, limits)
    for name in PRODUCTS:
        yield partial(_product, name, sizes, limits)
    yield partial(_launch, sizes)
    yield partial(_iteration, sizes, limits)
    for num in sizes.bounded:
        yield partial(_counts, num, sizes, limits)
        yield partial(_update, num, sizes, limits)


def _copy(sizes: Sizes, limits: dict[str, float]) -> list[Row]:
    """Each number read and written once."""
    numbers = jnp.zeros(sizes.copied, jnp.float32)
    again = jax.jit(lambda numbers: numbers + 1.0)
    moved = 2 * 4 * sizes.copied
    timing = timed(lambda: again(numbers), sizes)
    limits["bytes"] = moved / timing.median
    return rate("copy", f"{4 * sizes.copied / 2**20:,.2f} MiB", moved / 1e9, "GB/s", timing)


def _product(name: str, sizes: Sizes, limits: dict[str, float]) -> list[Row]:
    side = sizes.product
    left, right = jax.random.normal(jax.random.key(0), (2, side, side), jnp.float32)
    multiply = jax.jit(lambda a, b: jnp.matmul(a, b, precision=PRODUCTS[name]))
    flop = 2 * side**3
    timing = timed(lambda: multiply(left, right), sizes)
    limits[PRODUCTS[name]] = flop / timing.median
    return rate(f"product, {name}", f"{side:,}³", flop / 1e12, "TFLOP/s", timing)


def _launch(sizes: Sizes) -> list[Row]:
    """A kernel that does next to nothing, waited for each time."""
    one = jnp.zeros((), jnp.float32)
    tiny = jax.jit(lambda x: x + 1.0)
    timing = timed(lambda: tiny(one), sizes)
    return value("a call of a tiny program", "1 number", 1e6 * timing.median, "µs")


def _iteration(sizes: Sizes, limits: dict[str, float]) -> list[Row]:
    """The same kernel within a loop on the device."""
    one, num = jnp.zeros((), jnp.float32), sizes.iterations
    loop = jax.jit(lambda x: jax.lax.fori_loop(0, num, lambda _, x: x * 0.5 + 1.0, x))
    timing = timed(lambda: loop(one), sizes)
    limits["iteration"] = timing.median / num
    taken = 1e6 * limits["iteration"]
    return value("an iteration of a loop", f"{num:,} iterations", taken, "µs")


def _counts(num: int, sizes: Sizes, limits: dict[str, float]) -> list[Row]:
    """Operations, bytes and kernels of an update: counted by the compiler, and by hand."""
    config = sizes.paper()
    program = compiled_update(config, num)
    by_xla: Any = program.cost_analysis()
    flop, moved = by_hand(config, num)
    kernels = len(KERNEL.findall(program.as_text()))
    size = counted(num)
    limits[f"kernels of {size}"] = float(kernels)
    return [
        *value("an update, compiler's count", size, by_xla["flops"] / 1e9, "GFLOP"),
        *value("an update, dense products by hand", size, flop / 1e9, "GFLOP"),
        *value("an update, compiler's count", size, by_xla["bytes accessed"] / 1e6, "MB"),
        *value("an update, weights and moments by hand", size, moved / 1e6, "MB"),
        *value("an update, kernels", size, float(kernels), "kernels"),
    ]


def by_hand(config: RunConfig, num_runs: int) -> tuple[float, float]:
    """FLOP of the dense products of an update of the paper's network, and bytes of its weights."""
    state, _ = of_one(config)
    weights = sum(leaf.size for leaf in jax.tree.leaves(eqx.filter(state.model, eqx.is_array)))
    batch = config.training.batch_size
    return float(num_runs * batch * SAMPLE_FLOPS), float(num_runs * PASSES * 4 * weights)


def _update(num: int, sizes: Sizes, limits: dict[str, float]) -> list[Row]:
    """Updates a second on given transitions, beside the nearest of the bounds by hand."""
    config = sizes.paper()
    updates = sizes.epochs * config.training.num_updates
    timing = timed(ours(config, num, sizes.epochs, fresh=False), sizes)
    bounds = _bounds(config, num, limits)
    nearest = min(bounds, key=lambda name: bounds[name])
    more = {"beside": f"bound by {nearest}", "bound": bounds[nearest], "bounds": bounds}
    return rate("updates", counted(num), updates, "updates/s", timing, **more)


def _bounds(config: RunConfig, num: int, limits: dict[str, float]) -> dict[str, float]:
    """Updates a second that each limit of the device would allow.

    That of the launches is no strict one: kernels that do not wait for each other may overlap.
    """
    flop, moved = by_hand(config, num)
    launching = limits[f"kernels of {counted(num)}"] * limits["iteration"]
    strict = {"products": limits["float32"] / flop, "memory": limits["bytes"] / moved}
    return strict | {"launches": 1 / launching}
