"""How large each piece of work is, on a GPU and for a trial on any device."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from motorspace.training.config import RunConfig
from motorspace.training.settings import changed


@dataclass(frozen=True)
class Sizes:
    """The sizes of every part; the defaults are for a GPU."""

    repeats: int = 5
    """Times that each piece of work is measured; the median counts."""
    seconds: float = 0.5
    """What all repeats together take at least."""
    trajectories: tuple[int, ...] = (2_048, 16_384, 131_072)
    poses: tuple[int, ...] = (16_384, 262_144)
    side: float = 640.0
    """World units; random rooms in such a square have 7,100 walls."""
    runs: tuple[int, ...] = (1, 4, 16, 64, 256)
    """Runs that are trained at once."""
    networks: tuple[int, ...] = (16, 64)
    """Networks that PyTorch trains at once; the most of them also at each precision."""
    trajectories_per_epoch: int = 2_000
    batch: int = 100
    updates: int = 100
    """Updates that are measured at once."""
    network: Mapping[str, Any] = field(default_factory=dict)
    """What differs from the paper's network, where no peer has to have the same."""
    precision_runs: int = 16
    precision_epochs: int = 1_000
    precision_tests: int = 16_000
    bounded: tuple[int, ...] = (1, 16, 256)
    """Runs at once whose updates are set beside their bounds."""
    copied: int = 2**28
    """Numbers in the array that is copied."""
    product: int = 8_192
    """Rows and columns of the matrices that are multiplied."""
    iterations: int = 10_000
    """Of a loop on the device."""
    rotations: tuple[float, ...] = (0.2, 0.4, 0.6, 0.8, 1.0, 1.2)
    """Those of the table, in units of pi."""
    seeds: int = 3
    table_epochs: int = 5_000

    @property
    def epochs(self) -> int:
        """Epochs that hold so many updates."""
        return max(1, self.updates * self.batch // self.trajectories_per_epoch)

    @property
    def epoch(self) -> dict[str, int]:
        """The settings of an epoch of this size."""
        return {
            "trajectories_per_epoch": self.trajectories_per_epoch,
            "batch_size": self.batch,
        }

    def paper(self) -> RunConfig:
        """The paper's network for the forward agent, in epochs of this size."""
        return changed(RunConfig(), self.epoch | {"curriculum": 0.0})

    def config(self) -> RunConfig:
        """The same with this network."""
        return changed(self.paper(), self.network)


SMALL = Sizes(
    repeats=5,
    seconds=0.05,
    trajectories=(16, 64),
    poses=(64, 256),
    side=40.0,
    runs=(1, 2),
    networks=(2,),
    trajectories_per_epoch=20,
    batch=10,
    updates=4,
    network={"hidden_size": 4, "code_size": 2, "width_size": 8, "horizon": 2, "layout": "empty"},
    precision_runs=2,
    precision_epochs=3,
    precision_tests=100,
    bounded=(2,),
    copied=2**16,
    product=64,
    iterations=10,
    rotations=(0.8,),
    seeds=2,
    table_epochs=2,
)
"""A trial of all parts, in a few minutes on a CPU."""
