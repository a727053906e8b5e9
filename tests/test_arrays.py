"""Arrays of others: what is read, and what is refused in a sentence."""

import numpy as np
import pytest

from motorspace import UserError
from motorspace._arrays import read_array

ARRAY = np.arange(12.0).reshape(4, 3)


def test_the_same_array_from_every_kind_of_file(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    zarr = pytest.importorskip("zarr")
    np.save(tmp_path / "a.npy", ARRAY)
    table = pyarrow.table({f"c{i}": column for i, column in enumerate(ARRAY.T)})
    parquet.write_table(table, tmp_path / "a.parquet")
    zarr.save_array(str(tmp_path / "a.zarr"), ARRAY)
    for name in ("a.npy", "a.parquet", "a.zarr"):
        np.testing.assert_array_equal(read_array(tmp_path / name), ARRAY)


@pytest.mark.parametrize("name", ["a.npy", "a.parquet", "a.zarr"])
def test_damaged_files_are_refused(tmp_path, name):
    (tmp_path / name).write_bytes(b"nothing of the kind")
    with pytest.raises(UserError, match=f"{name}: the array cannot be read"):
        read_array(tmp_path / name)


def test_pickled_objects_and_text_are_refused(tmp_path):
    # The header alone says that objects follow, and is enough to refuse.
    header = {"descr": "|O", "fortran_order": False, "shape": (2,)}
    with (tmp_path / "objects.npy").open("wb") as file:
        np.lib.format.write_array_header_1_0(file, header)
    with pytest.raises(UserError, match="cannot be read"):
        read_array(tmp_path / "objects.npy")
    np.save(tmp_path / "text.npy", np.array(["a", "b"]))
    with pytest.raises(UserError, match="no numbers"):
        read_array(tmp_path / "text.npy")
