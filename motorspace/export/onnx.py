"""A run's networks as ONNX files."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np

from motorspace.export.files import Files, needs, write_files
from motorspace.export.network import described, largest_difference, network_of
from motorspace.training.run import Run


def export_onnx(run: Run, out: Path, *, force: bool = False) -> None:
    """Write the run's encoder and predictor as `encoder.onnx` and `predictor.onnx`.

    encoder.onnx: motors [N, T, M] float32, num_steps [N] int32 -> codes [N, C] float32.
    predictor.onnx: sensors [N, K] float32, codes [N, C] float32 -> later_sensors [N, K] float32.
    N and T are free (encoders mlp and identity: T is the run's horizon). Commands and sensors
    are in the units that the network was trained in.

    Args:
        run: A trained run.
        out: The folder to write into.
        force: Replace files that are already there.

    Raises:
        UserError: The encoder is a class of the user's own, onnx or onnxruntime is not installed,
            onnxruntime's results differ from the run's by more than 1e-5 (nothing is written),
            or a file is already there.
    """
    write_files(out, onnx_files(run), force=force)


def onnx_files(run: Run) -> Files:
    """The files of `export_onnx`, checked against the run. Raises `UserError` as it does."""
    network = network_of(run)
    about = {name: json.dumps(value) for name, value in described(run, network).items()}
    with needs("onnx"):
        import onnxruntime  # noqa: F401

        from motorspace.export.onnx_graph import encoder_model, predictor_model
    encoder = encoder_model(network, about).SerializeToString()
    predictor = predictor_model(network, about).SerializeToString()
    encode, predict = _runnable(encoder), _runnable(predictor)
    largest_difference(
        run,
        network,
        lambda motors, num_steps: encode({"motors": motors, "num_steps": num_steps}),
        lambda sensors, codes: predict({"sensors": sensors, "codes": codes}),
    )
    return {"encoder.onnx": encoder, "predictor.onnx": predictor}


def _runnable(content: bytes) -> Callable[[dict[str, np.ndarray]], np.ndarray]:
    """The function of named arrays that a file holds, as onnxruntime computes it."""
    from onnxruntime import InferenceSession

    session = InferenceSession(content, providers=["CPUExecutionProvider"])
    return lambda inputs: np.asarray(session.run(None, inputs)[0])
