"""A run's networks as a module that needs NumPy alone, for a robot."""

import inspect
import io
import json
from pathlib import Path

import numpy as np

from motorspace.export import numpy_model
from motorspace.export.files import Files, write_files
from motorspace.export.network import described, largest_difference, named_weights, network_of
from motorspace.training.run import Run


def export_numpy(run: Run, out: Path, *, force: bool = False) -> None:
    """Write the run's encoder and predictor as a Python module that needs NumPy alone.

    The folder then holds `motorspace_model.py`, `weights.npz` and `model.json`:

        from motorspace_model import load
        model = load("FOLDER")
        codes = model.encode(motors, num_steps)
        later_sensors = model.predict(sensors, codes)

    Args:
        run: A trained run.
        out: The folder to write into.
        force: Replace files that are already there.

    Raises:
        UserError: The encoder is a class of the user's own, the module's results differ from the
            run's by more than 1e-5 (nothing is written), or a file is already there.
    """
    write_files(out, numpy_files(run), force=force)


def numpy_files(run: Run) -> Files:
    """The files of `export_numpy`, checked against the run. Raises `UserError` as it does."""
    network = network_of(run)
    description, weights = described(run, network), named_weights(network)
    model = numpy_model.Model(description, weights)
    description["largest_difference"] = largest_difference(
        run, network, model.encode, model.predict
    )
    packed = io.BytesIO()
    np.savez(packed, allow_pickle=False, **weights)
    return {
        "motorspace_model.py": inspect.getsource(numpy_model).encode(),
        "weights.npz": packed.getvalue(),
        "model.json": (json.dumps(description, indent=1) + "\n").encode(),
    }
