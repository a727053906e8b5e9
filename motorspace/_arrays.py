"""Arrays from the files that others write: NumPy, Parquet, Arrow, Zarr, safetensors, text.

What a file is, its content says; its name need not. A file may hold several arrays, or a table
with several columns: the one that is wanted is picked by name.
"""

import gzip
import io
import re
import warnings
import zipfile
from collections.abc import Callable, Sequence
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from motorspace._errors import UserError
from motorspace._text_tables import text_table

File = io.BufferedReader | io.BytesIO
ZARR = ("zarr.json", ".zarray", ".zgroup")
UNNAMED = ("", "Unnamed: 0")
"""What pandas calls the index in the first line of a CSV file."""
INDEX = re.compile(r"__index_level_\d+__")
"""What pandas calls an index without a name in Parquet."""


def read_array(path: str | Path, *, name: str = "") -> np.ndarray:
    """Returns the numbers in a file, or in one of the arrays or some of the columns it holds.

    Reads `.npy`, `.npz`, Parquet, Arrow (Feather), Zarr arrays and groups, safetensors, and text
    tables (comma, semicolon, tab or space), each also compressed with gzip, whatever they are
    called. Pickled objects are refused. Columns that are the index of a pandas table are left
    out, with a warning.

    Args:
        path: The file, or `FILE:NAMES` to choose: `data.npz:codes`, `table.parquet:h*`,
            `table.csv:dx,dy,turn`. Several names are put side by side as columns.
        name: The array to take from a file that holds one of this name among others.

    Raises:
        UserError: For a file that is missing, damaged, of another kind, or does not hold numbers.

    Example:
        >>> read_array("nowhere.npy")
        Traceback (most recent call last):
        motorspace._errors.UserError: nowhere.npy: there is no such file; check the path.
    """
    file, chosen = _split(str(path))
    if not file.exists():
        raise UserError("there is no such file", where=file, remedy="check the path")
    try:
        contents = _zarr(file) if file.is_dir() else _read(file)
        array = contents.pick(chosen, name, file)
    except UserError:
        raise
    except ModuleNotFoundError as error:
        raise UserError(
            f"{error.name} is not installed",
            where=file,
            remedy="install the extra: pip install 'motorspace[topology]'",
        ) from None
    except Exception as error:  # every library raises its own kinds for a damaged file
        reason = str(error).strip().partition("\n")[0] or type(error).__name__
        raise UserError(
            f"the array cannot be read ({reason})", where=file, remedy="write the file again"
        ) from None
    if array.dtype.kind not in "fiub":
        raise UserError(
            f"the array holds {array.dtype}, not real numbers",
            where=path,
            remedy="write floating-point numbers, one row for each sequence",
        )
    return array


class _Contents(NamedTuple):
    """The arrays in a file by name."""

    arrays: dict[str, np.ndarray]
    columns: bool = False
    """Whether they are the columns of one table."""

    def pick(self, chosen: str, name: str, file: Path) -> np.ndarray:
        """Those `chosen` by the user; else the one called `name`; else all, where that is clear."""
        parts = [chosen] if chosen in self.arrays else chosen.split(",")
        names = [n for part in parts for n in self.arrays if n == part or fnmatchcase(n, part)]
        if chosen and not names:
            raise UserError(
                f"there is no {chosen!r}", where=file, remedy=f"choose from {self._described()}"
            )
        if not chosen and name in self.arrays:
            names = [name]
        if not names and (len(self.arrays) == 1 or self._one_table()):
            names = [*self.arrays]
        if not self.arrays:
            raise UserError("the file holds no array", where=file, remedy="write the file again")
        if not names:
            raise UserError(
                f"the file holds {self._described()}",
                where=file,
                remedy=f"choose one, as in {file}:{next(iter(self.arrays))}",
            )
        if len(names) == 1 and not self.columns:
            return self.arrays[names[0]]
        return self._side_by_side(names, file)

    def _one_table(self) -> bool:
        return self.columns and all(column.ndim == 1 for column in self.arrays.values())

    def _side_by_side(self, names: Sequence[str], file: Path) -> np.ndarray:
        columns = [self.arrays[n] for n in names]
        for n, column in zip(names, columns, strict=True):
            if column.dtype.kind not in "fiub":
                raise UserError(
                    f"{n!r} holds no numbers",
                    where=file,
                    remedy=f"choose the columns that do, as in {file}:NAME,NAME or {file}:h*",
                )
        if len({len(column) for column in columns}) > 1:
            raise UserError(f"{', '.join(names)} differ in length", where=file)
        if len(columns) == 1 and columns[0].ndim > 1:
            return columns[0]
        return np.concatenate([column.reshape(len(column), -1) for column in columns], axis=1)

    def _described(self) -> str:
        shown = [f"{n} {a.shape}" if not self.columns else n for n, a in self.arrays.items()]
        return ", ".join(shown[:20]) + (" ..." if len(shown) > 20 else "")


def _split(path: str) -> tuple[Path, str]:
    """The file, and what is chosen from it by `FILE:NAMES`."""
    file, colon, chosen = path.rpartition(":")
    if colon and chosen and not Path(path).exists() and Path(file).exists():
        return Path(file), chosen
    return Path(path), ""


def _read(path: Path) -> _Contents:
    with path.open("rb") as file:
        return _by_content(file, path)


def _by_content(file: File, path: Path) -> _Contents:
    head = file.read(128)
    file.seek(0)
    if not head:
        raise UserError("the file is empty", where=path, remedy="write the file again")
    for magic, reader in READERS.items():
        if head.startswith(magic):
            return reader(file, path)
    for magic, (what, remedy) in FOREIGN.items():
        if head.startswith(magic):
            raise UserError(f"{what} is not read", where=path, remedy=remedy)
    if head[8:9] == b"{" and b"\0" in head[:8]:
        import safetensors.numpy

        return _Contents(safetensors.numpy.load(file.read()))
    if b"\0" in head:
        raise UserError(
            "the array cannot be read (unknown content)",
            where=path,
            remedy="write it with numpy.save, or as a Parquet, Zarr or CSV file",
        )
    return _text(file, path)


def _npy(file: File, path: Path) -> _Contents:
    array = np.asarray(np.load(file, allow_pickle=False))
    if array.dtype.names:
        return _Contents({n: array[n] for n in array.dtype.names}, columns=True)
    return _Contents({path.stem: array})


def _gzip(file: File, path: Path) -> _Contents:
    return _by_content(io.BytesIO(gzip.decompress(file.read())), path)


def _zip(file: File, path: Path) -> _Contents:
    inside = zipfile.ZipFile(file).namelist()
    if any(n.endswith(ZARR) for n in inside):
        return _zarr(path)
    if not any(n.endswith(".npy") for n in inside):
        known = {"data.pkl": "a PyTorch file", "xl/workbook.xml": "a spreadsheet"}
        what = next((w for end, w in known.items() for n in inside if n.endswith(end)), "this zip")
        raise UserError(
            f"{what} is not read",
            where=path,
            remedy="write its array with numpy.save (tensor.numpy(force=True)), or as CSV",
        )
    file.seek(0)
    with np.load(file, allow_pickle=False) as arrays:
        return _Contents(dict(arrays))


def _parquet(file: File, path: Path) -> _Contents:
    import pyarrow.parquet

    return _columns(pyarrow.parquet.read_table(file), path)


def _arrow(file: File, path: Path) -> _Contents:
    import pyarrow.feather

    return _columns(pyarrow.feather.read_table(file), path)


def _columns(table: Any, path: Path) -> _Contents:
    """The columns of an Arrow table without the index that pandas has written."""
    stored = (table.schema.pandas_metadata or {}).get("index_columns", [])
    index = [n for n in table.column_names if n in stored or INDEX.fullmatch(n)]
    _warn_of_index(index, path)
    kept = (n for n in table.column_names if n not in index)
    return _Contents({n: _column(table[n], n, path) for n in kept}, columns=True)


def _column(column: Any, name: str, path: Path) -> np.ndarray:
    """A column of numbers [N], or of lists (of lists) of equally many: [N, ...]."""
    import pyarrow.compute
    from pyarrow.types import is_fixed_size_list, is_large_list, is_list

    array, shape = column.combine_chunks(), [len(column)]
    while is_list(array.type) or is_large_list(array.type) or is_fixed_size_list(array.type):
        lengths = pyarrow.compute.list_value_length(array).unique().to_pylist()
        if len(lengths) != 1 or None in lengths:
            raise UserError(
                f"the lists in the column {name!r} differ in length",
                where=path,
                remedy="give equally many numbers in every row",
            )
        shape.append(lengths[0])
        array = array.flatten()
    return np.asarray(array.to_numpy(zero_copy_only=False)).reshape(shape)


def _zarr(path: Path) -> _Contents:
    if path.is_dir() and not any((path / n).exists() for n in ZARR):
        raise UserError(
            "this is a folder and no Zarr store", where=path, remedy="give a file, or a Zarr store"
        )
    import zarr

    store = str(path) if path.is_dir() else zarr.storage.ZipStore(path, mode="r")
    found = zarr.open(store, mode="r")
    if isinstance(found, zarr.Array):
        return _Contents({path.stem: np.asarray(found[:])})
    arrays = {n: a for n, a in found.members(max_depth=None) if isinstance(a, zarr.Array)}
    return _Contents({n: np.asarray(a[:]) for n, a in sorted(arrays.items())})


def _text(file: File, path: Path) -> _Contents:
    columns = text_table(file.read(), path)
    index = [n for n in columns if n in UNNAMED]
    _warn_of_index([n or "the column without a name" for n in index], path)
    return _Contents({n: columns[n] for n in columns if n not in index}, columns=True)


def _warn_of_index(names: Sequence[str], path: Path) -> None:
    if names:
        warnings.warn(
            f"{path}: left out {', '.join(names)}, the index of a pandas table",
            UserWarning,
            stacklevel=2,
        )


READERS: dict[bytes, Callable[[File, Path], _Contents]] = {
    b"\x93NUMPY": _npy,
    b"PK\x03\x04": _zip,
    b"PAR1": _parquet,
    b"ARROW1": _arrow,
    b"\x1f\x8b": _gzip,
}
"""How files begin, and what reads them; all others are text."""

FOREIGN = {
    b"\x89HDF": ("an HDF5 file", "write its array with numpy.save(FILE, h5py.File(...)[NAME][:])"),
    b"MATLAB": ("a MATLAB file", "write numpy.save(FILE, scipy.io.loadmat(...)[NAME])"),
    b"\x80": ("a pickled object, which may run code,", "write its array with numpy.save"),
    b"SQLite": ("a database", "write its table as CSV or Parquet"),
    b"{": ("JSON", "write numpy.save(FILE, numpy.array(json.load(...)))"),
    b"[": ("JSON", "write numpy.save(FILE, numpy.array(json.load(...)))"),
}
"""How files begin that are not read: what they are, and how to convert them."""
