"""Updates of the paper's network for the forward agent: the same sizes, fresh weights, Adam."""

import itertools
import os

import jax
import jax.numpy as jnp
import numpy as np
import torch
from torch import nn

from benchmarks.harness import Contender, Launch, report, take_turns
from benchmarks.programs import ONE_EPOCH, of_one, sampler
from benchmarks.roofline import fma_peak
from motorspace.training.config import RunConfig
from motorspace.training.program import train_epochs
from motorspace.training.settings import changed
from motorspace.trajectories.transitions import Experience

UPDATES = 10


def main() -> None:
    """Ours and both of PyTorch's ways, on the same transitions."""
    threads, batch = int(os.environ["BENCHMARK_THREADS"]), int(os.environ["BENCHMARK_BATCH"])
    torch.set_num_threads(threads)
    epoch = {"trajectories_per_epoch": UPDATES * batch, "batch_size": batch, "curriculum": 0.0}
    config = changed(RunConfig(), epoch)
    data = sampler(config)(jax.random.key(0), jnp.array(1))
    contenders = [
        motorspace(config, data),
        pytorch("nn.LSTM, fused Adam", Fused(), data, batch),
        pytorch("torch.compile, fused Adam", torch.compile(Unrolled()), data, batch),
        fma_peak(threads),
    ]
    rates, first, foreign = take_turns(contenders, seconds=1.5)
    report(Launch(f"training, batch {batch}", "samples", threads, rates, first, {}, foreign))


def motorspace(config: RunConfig, data: Experience) -> Contender:
    given = of_one(config, data)

    def run() -> None:
        jax.block_until_ready(train_epochs(*given, ONE_EPOCH))

    return Contender("motorspace", run, len(data))


class Paper(nn.Module):
    """What both networks share: the code and the predictor."""

    def __init__(self) -> None:
        super().__init__()
        self.to_code = nn.Linear(100, 50)
        widths = itertools.pairwise((59, 200, 200, 200))
        hidden = [layer for i, o in widths for layer in (nn.Linear(i, o), nn.ReLU())]
        self.predictor = nn.Sequential(*hidden, nn.Linear(200, 9))

    def from_hidden(self, hidden: torch.Tensor, sensors: torch.Tensor) -> torch.Tensor:
        code = torch.sigmoid(self.to_code(hidden))
        return self.predictor(torch.cat([code, sensors], 1))


class Fused(Paper):
    """The library's own recurrent layer."""

    def __init__(self) -> None:
        super().__init__()
        self.lstm = nn.LSTM(2, 100, batch_first=True)

    def forward(self, motors: torch.Tensor, sensors: torch.Tensor) -> torch.Tensor:
        return self.from_hidden(self.lstm(motors)[0][:, -1], sensors)


class Unrolled(Paper):
    """The recurrence written out, as a compiler likes it: the first step without its state."""

    def __init__(self) -> None:
        super().__init__()
        self.from_input, self.from_hidden_state = nn.Linear(2, 400), nn.Linear(100, 400, bias=False)

    def forward(self, motors: torch.Tensor, sensors: torch.Tensor) -> torch.Tensor:
        inputs = self.from_input(motors)
        hidden, memory = None, 0.0
        for step in range(motors.shape[1]):
            gates = inputs[:, step]
            if hidden is not None:
                gates = gates + self.from_hidden_state(hidden)
            write, keep, content, read = gates.chunk(4, 1)
            memory = torch.sigmoid(keep) * memory + torch.sigmoid(write) * torch.tanh(content)
            hidden = torch.sigmoid(read) * torch.tanh(memory)
        return self.from_hidden(hidden, sensors)


def pytorch(name: str, network: nn.Module, data: Experience, batch: int) -> Contender:
    sensors, motors, later = (
        torch.tensor(np.asarray(v))
        for v in (data.sensors / 10.0, data.motors, data.later_sensors / 10.0)
    )
    adam = torch.optim.Adam(network.parameters(), lr=1e-3, fused=True)

    def run() -> None:
        for rows in torch.randperm(len(data)).split(batch):
            predicted = network(motors[rows], sensors[rows])
            loss = nn.functional.mse_loss(predicted, later[rows])
            adam.zero_grad()
            loss.backward()
            adam.step()

    return Contender(name, run, len(data))


if __name__ == "__main__":
    main()
