"""The record of every epoch as scalars for TensorBoard."""

from pathlib import Path
from types import TracebackType

from motorspace._errors import UserError
from motorspace._types import Record
from motorspace.export.files import needs


class TensorBoardLog:
    """A callback for `train` that writes each value of an epoch's record as a scalar.

    Files are written with tensorboardX (extra `tensorboard`) and read by
    `tensorboard --logdir FOLDER`. A run that is resumed goes on in the same folder.

        with TensorBoardLog(folder) as log:
            train(config, callback=log)

    Args:
        folder: Where the event files go; made if need be.

    Raises:
        UserError: tensorboardX is not installed, or the folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        with needs("tensorboard"):
            from tensorboardX import SummaryWriter
        try:
            self._writer = SummaryWriter(str(folder), flush_secs=10)
        except OSError as error:
            raise UserError(
                f"the TensorBoard log cannot be written ({error.strerror})",
                where=folder,
                remedy="give a folder that can be written to",
            ) from None

    def __call__(self, record: Record) -> None:
        """Write one epoch's record; its number is the step."""
        for name, value in record.items():
            if name != "epoch":
                self._writer.add_scalar(name, value, int(record["epoch"]))

    def close(self) -> None:
        """Write what is still in memory."""
        self._writer.close()

    def __enter__(self) -> "TensorBoardLog":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
