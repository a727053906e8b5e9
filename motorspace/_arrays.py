"""Arrays from the files that others write: NumPy, Parquet, Zarr."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from motorspace._errors import UserError


def read_array(path: Path) -> np.ndarray:
    """The array in a `.npy` file, a `.zarr` folder, or the columns of a `.parquet` table.

    Pickled objects are refused. Raises `UserError` for a file that is missing, damaged, of
    another kind, or holds something other than numbers.
    """
    reader = READERS.get(path.suffix)
    if reader is None:
        raise UserError(
            f"files that end in {path.suffix!r} are not read",
            where=path,
            remedy=f"give one of {', '.join(READERS)}",
        )
    if not path.exists():
        raise UserError("there is no such file", where=path, remedy="check the path")
    try:
        array = np.asarray(reader(path))
    except ModuleNotFoundError as error:
        raise UserError(
            f"{error.name} is not installed",
            where=path,
            remedy="install the extra: pip install 'motorspace[topology]'",
        ) from None
    except Exception as error:  # every library raises its own kinds for a damaged file
        reason = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise UserError(
            f"the array cannot be read ({reason})", where=path, remedy="write the file again"
        ) from None
    if array.dtype.kind not in "fiub":
        raise UserError(
            f"the array holds {array.dtype} and no numbers",
            where=path,
            remedy="write floating-point numbers, one row for each sequence",
        )
    return array


def _npy(path: Path) -> np.ndarray:
    return np.asarray(np.load(path, allow_pickle=False))


def _parquet(path: Path) -> np.ndarray:
    import pyarrow.parquet

    table = pyarrow.parquet.read_table(path)
    return np.stack([column.to_numpy() for column in table.columns], axis=1)


def _zarr(path: Path) -> np.ndarray:
    import zarr

    return np.asarray(zarr.open_array(path, mode="r")[:])


READERS: dict[str, Callable[[Path], np.ndarray]] = {
    ".npy": _npy,
    ".parquet": _parquet,
    ".zarr": _zarr,
}
