"""PyTorch on the same device: the same network, transitions and batches, one and many at once."""

import importlib.util
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from benchmarks.gpu.simulation import default_device, poses, scanned
from benchmarks.gpu.sizes import Sizes
from benchmarks.gpu.timing import Case, Row, Skipped, rate, timed
from benchmarks.gpu.training import counted, trained
from benchmarks.programs import transitions
from motorspace.worlds.layouts import layout

LEARNING_RATE = 6e-3
OURS = "training, motorspace"
OUR_SCANS = "scans, motorspace"
Update = Callable[[], object]
"""One update on a batch that it chooses at random."""


def peers(sizes: Sizes) -> Iterator[Case]:
    """Ours and theirs, each eagerly and as a CUDA graph, then a lidar."""
    device = torch_device()
    for num in (1, *sizes.networks):
        yield partial(trained, OURS, sizes.paper(), num, sizes)
        make = one_network if num == 1 else many_networks
        for captured in (False, True):
            yield partial(_pytorch, make, num, device, sizes, captured=captured)
    scene = layout("paper"), sizes.poses[0], default_device()
    yield partial(scanned, OUR_SCANS, *scene, sizes)
    yield partial(vmas, device, sizes)


def torch_device() -> str:
    """Where PyTorch computes: beside JAX. Raises `Skipped` where it cannot."""
    import jax

    if importlib.util.find_spec("torch") is None:
        raise Skipped("PyTorch is not installed")
    import torch

    if jax.default_backend() != "gpu":
        return "cpu"
    if not torch.cuda.is_available():
        raise Skipped("PyTorch sees no GPU")
    return "cuda"


def _pytorch(
    make: Callable[..., Update], num: int, device: str, sizes: Sizes, *, captured: bool
) -> list[Row]:
    """The row of one of PyTorch's ways."""
    import torch

    if captured and device == "cpu":
        raise Skipped("a CUDA graph needs a GPU")
    torch.set_float32_matmul_precision("highest")  # float32 in every product, as ours
    torch.backends.cudnn.allow_tf32 = False
    update = make(num, device, sizes)
    if captured:
        update = as_graph(update)
    updates = sizes.epochs * sizes.paper().training.num_updates

    def run() -> None:
        for _ in range(updates):
            update()
        if device == "cuda":
            torch.cuda.synchronize()

    way = "nn.LSTM" if num == 1 else "vmap"
    work = f"training, PyTorch {way}{', CUDA graph' * captured}"
    samples = num * updates * sizes.batch
    timing = timed(run, sizes)
    return rate(work, counted(num), samples, "samples/s", timing, beside=OURS)


def as_graph(update: Update) -> Update:
    """The update captured once, then launched as a whole."""
    import torch

    stream = torch.cuda.Stream()
    stream.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(stream):
        for _ in range(3):
            update()
    torch.cuda.current_stream().wait_stream(stream)
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.graph(graph):
        update()
    return graph.replay


def one_network(num: int, device: str, sizes: Sizes) -> Update:
    """The library's own recurrent layer and its fused Adam."""
    del num
    import torch

    from benchmarks.suites.training import Fused

    network, data = Fused().to(device), on_device(device, sizes)
    adam = adam_of(network.parameters(), device)

    def update() -> None:
        rows = torch.randint(len(data[0]), (sizes.batch,), device=device)
        motors, sensors, later = (values[rows] for values in data)
        adam.zero_grad(set_to_none=True)
        torch.nn.functional.mse_loss(network(motors, sensors), later).backward()
        adam.step()

    return update


def many_networks(num: int, device: str, sizes: Sizes) -> Update:
    """One network, written out by steps, over stacked weights; Adam is the same for each weight."""
    import torch
    from torch.func import functional_call, grad, stack_module_state, vmap

    from benchmarks.suites.training import Unrolled

    weights, _ = stack_module_state([Unrolled().to(device) for _ in range(num)])
    network, data = Unrolled().to("meta"), on_device(device, sizes)
    adam = adam_of(weights.values(), device)

    def loss(weights: Any, motors: Any, sensors: Any, later: Any) -> Any:
        predicted = functional_call(network, weights, (motors, sensors))
        return torch.nn.functional.mse_loss(predicted, later)

    gradients_of = vmap(grad(loss))

    def update() -> None:
        rows = torch.randint(len(data[0]), (num, sizes.batch), device=device)
        detached = {name: weight.detach() for name, weight in weights.items()}
        gradients = gradients_of(detached, *(values[rows] for values in data))
        for name, weight in weights.items():
            weight.grad = gradients[name]
        adam.step()

    return update


def adam_of(weights: Any, device: str) -> Any:
    """Adam as one kernel, which a CUDA graph may hold."""
    import torch

    cuda = device == "cuda"
    return torch.optim.Adam(weights, lr=LEARNING_RATE, fused=True, capturable=cuda)


def on_device(device: str, sizes: Sizes) -> tuple[Any, Any, Any]:
    """The transitions that ours learns from: commands, scaled sensors before and after."""
    import torch

    data = transitions(sizes.paper())
    arrays = data.motors, data.sensors / 10.0, data.later_sensors / 10.0
    motors, sensors, later = (torch.tensor(np.asarray(v), device=device) for v in arrays)
    return motors, sensors, later


def vmas(device: str, sizes: Sizes) -> list[Row]:
    """The lidar of VMAS in the paper's world, a world of its batch for each pose."""
    if importlib.util.find_spec("vmas") is None:
        raise Skipped("VMAS is not installed")
    import torch

    from benchmarks.suites.sensing import FAN, MAX_RANGE, vmas_world

    world, num = layout("paper"), sizes.poses[0]
    places, agent = vmas_world(world, num)
    places.to(device)
    given = poses(world, num)
    at = torch.tensor(np.stack([given.x, given.y], 1), device=device)
    agent.set_pos(at, batch_index=None)
    angles = np.asarray(FAN[:, None] + given.heading).T.copy()
    turned = torch.tensor(angles, device=device, dtype=torch.float32)

    def run() -> None:
        with torch.no_grad():
            others = partial(_other_than, agent)
            places.cast_rays(agent, turned, max_range=MAX_RANGE, entity_filter=others)
        if device == "cuda":
            torch.cuda.synchronize()

    timing = timed(run, sizes)
    return rate("scans, VMAS", f"{num:,} poses", num, "scans/s", timing, beside=OUR_SCANS)


def _other_than(agent: Any, entity: Any) -> bool:
    return entity is not agent
