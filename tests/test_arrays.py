"""Arrays of others: what is read, and what is refused in a sentence."""

import gzip
import json

import numpy as np
import pytest

from motorspace import UserError
from motorspace._arrays import read_array

ARRAY = np.arange(12.0).reshape(4, 3) + 0.5


def lines(separator=",", header="x,y,z", end="\n", decimal="."):
    rows = [separator.join(map(str, row)).replace(".", decimal) for row in ARRAY]
    return end.join([header.replace(",", separator), *rows] if header else rows)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """One array in files of every kind."""
    pyarrow = pytest.importorskip("pyarrow")
    feather = pytest.importorskip("pyarrow.feather")
    parquet = pytest.importorskip("pyarrow.parquet")
    zarr = pytest.importorskip("zarr")
    safetensors = pytest.importorskip("safetensors.numpy")
    folder = tmp_path_factory.mktemp("arrays")
    np.save(folder / "array.npy", ARRAY)
    np.savez(folder / "one.npz", anything=ARRAY)
    np.savez(folder / "two.npz", codes=ARRAY, displacements=ARRAY[:, :2])
    columns = pyarrow.table({f"h{i}": column for i, column in enumerate(ARRAY.T)})
    lists = pyarrow.table({"codes": ARRAY.tolist(), "d": ARRAY[:, :2].tolist()})
    parquet.write_table(columns, folder / "columns.parquet")
    parquet.write_table(lists, folder / "lists.parquet")
    parquet.write_table(lists.select(["codes"]), folder / "list.parquet")
    feather.write_feather(columns, folder / "columns.feather")
    zarr.save_array(str(folder / "array.zarr"), ARRAY)
    group = zarr.open_group(str(folder / "group.zarr"), mode="w")
    group["codes"] = ARRAY
    group.create_group("run")["d"] = ARRAY[:, :2]
    safetensors.save_file({"codes": ARRAY}, folder / "array.safetensors")
    (folder / "array.npy.gz").write_bytes(gzip.compress((folder / "array.npy").read_bytes()))
    return folder


WHOLE = (
    *("array.npy", "one.npz", "columns.parquet", "list.parquet", "columns.feather"),
    *("array.zarr", "array.safetensors", "array.npy.gz"),
)


@pytest.mark.parametrize("name", WHOLE)
def test_the_same_array_from_every_kind_of_file(folder, name):
    np.testing.assert_array_equal(read_array(folder / name), ARRAY)
    np.testing.assert_array_equal(read_array(str(folder / name)), ARRAY)


def test_the_content_of_a_file_counts_and_not_its_name(folder, tmp_path):
    for name in ("array.npy", "one.npz", "columns.parquet"):
        for other in ("plain", "codes.csv", "codes.NPY"):
            (tmp_path / other).write_bytes((folder / name).read_bytes())
            np.testing.assert_array_equal(read_array(tmp_path / other), ARRAY)


@pytest.mark.parametrize("name", ["two.npz", "lists.parquet", "group.zarr"])
def test_one_of_several_arrays_is_picked_by_name(folder, name):
    np.testing.assert_array_equal(read_array(folder / name, name="codes"), ARRAY)
    np.testing.assert_array_equal(read_array(f"{folder / name}:codes", name="other"), ARRAY)
    with pytest.raises(UserError, match=rf"the file holds codes.*choose one, as in .*{name}:codes"):
        read_array(folder / name)
    with pytest.raises(UserError, match="there is no 'nothing'; choose from codes"):
        read_array(f"{folder / name}:nothing")


def test_arrays_within_groups_and_columns_of_tables_are_chosen(folder):
    np.testing.assert_array_equal(read_array(f"{folder}/group.zarr:run/d"), ARRAY[:, :2])
    np.testing.assert_array_equal(read_array(f"{folder}/columns.parquet:h2,h0"), ARRAY[:, [2, 0]])
    np.testing.assert_array_equal(read_array(f"{folder}/columns.parquet:h*"), ARRAY)
    assert read_array(f"{folder}/columns.parquet:h1").shape == (4, 1)


TEXTS = {
    "header": lines(),
    "no header": lines(header=""),
    "spaces": lines(" ", header=""),
    "tabs, comment": "# made by hand\n\n" + lines("\t"),
    "semicolons": lines(";"),
    "decimal commas": lines(";", decimal=","),
    "tabs and decimal commas": lines("\t", decimal=","),
    "trailing separators": "\n".join(line + ";" for line in lines(";").splitlines()),
    "windows": "\ufeff" + lines(end="\r\n"),
    "numbered header": lines(header="0,1,2"),
    "quotes": lines(header='"x","y","z"'),
}


@pytest.mark.parametrize("case", TEXTS)
def test_tables_as_text_are_read_however_they_are_written(tmp_path, case):
    (tmp_path / "a.csv").write_text(TEXTS[case], encoding="utf-8")
    np.testing.assert_array_equal(read_array(tmp_path / "a.csv"), ARRAY)
    (tmp_path / "a.csv.gz").write_bytes(gzip.compress(TEXTS[case].encode()))
    np.testing.assert_array_equal(read_array(tmp_path / "a.csv.gz"), ARRAY)


def test_cells_without_a_number_are_not_a_number(tmp_path):
    (tmp_path / "a.csv").write_text("a,b,b\n1,,true\nNA,2,false\n")
    found = read_array(tmp_path / "a.csv")
    np.testing.assert_array_equal(found, [[1, np.nan, 1], [np.nan, 2, 0]])


@pytest.mark.parametrize("header", [",x,y,z", ",0,1,2", "Unnamed: 0,x,y,z"])
def test_the_index_of_a_pandas_table_is_no_code(tmp_path, header):
    rows = [f"{i},{line}" for i, line in enumerate(lines(header="").splitlines())]
    (tmp_path / "a.csv").write_text("\n".join([header, *rows]))
    with pytest.warns(UserWarning, match=r"left out .*, the index of a pandas table"):
        np.testing.assert_array_equal(read_array(tmp_path / "a.csv"), ARRAY)


@pytest.mark.parametrize(
    ("index", "metadata"),
    [("__index_level_0__", None), ("time", {"pandas": json.dumps({"index_columns": ["time"]})})],
)
def test_the_index_of_a_pandas_table_in_parquet_is_no_code(tmp_path, index, metadata):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    columns = {f"h{i}": column for i, column in enumerate(ARRAY.T)} | {index: np.arange(4)}
    table = pyarrow.table(columns).replace_schema_metadata(metadata)
    parquet.write_table(table, tmp_path / "a.parquet")
    with pytest.warns(UserWarning, match=f"left out {index}, the index of a pandas table"):
        np.testing.assert_array_equal(read_array(tmp_path / "a.parquet"), ARRAY)


def test_lists_of_lists_missing_numbers_and_other_columns_in_parquet(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")

    def written(**columns):
        parquet.write_table(pyarrow.table(columns), tmp_path / "a.parquet")
        return tmp_path / "a.parquet"

    assert read_array(written(m=[[[1, 2], [3, 4], [5, 6]]] * 2)).shape == (2, 3, 2)
    np.testing.assert_array_equal(read_array(written(h=[1.0, None])), [[1.0], [np.nan]])
    np.testing.assert_array_equal(read_array(written(h=[True, False])), [[1], [0]])
    with pytest.raises(UserError, match="the lists in the column 'h' differ in length"):
        read_array(written(h=[[1.0], [1.0, 2.0]]))
    with pytest.raises(UserError, match="'label' holds no numbers; choose the columns that do"):
        read_array(written(h=[1.0, 2.0], label=["a", "b"]))


def test_fields_of_a_structured_array_are_columns(tmp_path):
    np.save(tmp_path / "a.npy", np.array([(1.0, 2)], [("x", float), ("n", int)]))
    np.testing.assert_array_equal(read_array(tmp_path / "a.npy"), [[1.0, 2.0]])


@pytest.mark.parametrize("begin", [b"\x93NUMPY", b"PK\x03\x04", b"PAR1", b"ARROW1", b"\x1f\x8b"])
def test_damaged_files_are_refused(tmp_path, begin):
    (tmp_path / "a.npy").write_bytes(begin + b"nothing of the kind")
    with pytest.raises(UserError, match=r"a\.npy: the array cannot be read"):
        read_array(tmp_path / "a.npy")


REFUSED = {
    "empty": (b"", "the file is empty"),
    "words": (b"nothing of the kind", "the file holds no numbers"),
    "ragged": (b"a,b\n1,2\n3\n", "line 3 has 1 values, and the first has 2"),
    "word": (b"a,b\n1,2\n3,x\n", "line 3 holds 'x', which is no number"),
    "pickle": (
        b"\x80\x04\x95\r\x00\x00\x00\x00\x00\x00\x00]\x94G?\xf0\x00\x00\x00\x00\x00\x00a.",
        "a pickled object, which may run code, is not read",
    ),
    "HDF5": (b"\x89HDF\r\n\x1a\n\0\0", r"an HDF5 file is not read; .*h5py"),
    "MATLAB": (b"MATLAB 5.0 MAT-file", r"a MATLAB file is not read; .*loadmat"),
    "JSON": (b"[[1, 2]]", r"JSON is not read; .*json\.load"),
    "unknown": (bytes(range(64)), r"unknown content.*write it with numpy\.save"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_array_is_refused_with_a_remedy(tmp_path, case):
    content, message = REFUSED[case]
    (tmp_path / "a").write_bytes(content)
    with pytest.raises(UserError, match=message):
        read_array(tmp_path / "a")


def test_pickled_objects_text_and_complex_numbers_are_refused(tmp_path):
    # The header alone says that objects follow, and is enough to refuse.
    header = {"descr": "|O", "fortran_order": False, "shape": (2,)}
    with (tmp_path / "objects.npy").open("wb") as file:
        np.lib.format.write_array_header_1_0(file, header)
    with pytest.raises(UserError, match="cannot be read"):
        read_array(tmp_path / "objects.npy")
    for name, array in (("text", np.array(["a", "b"])), ("complex", ARRAY + 1j)):
        np.save(tmp_path / f"{name}.npy", array)
        with pytest.raises(UserError, match="not real numbers"):
            read_array(tmp_path / f"{name}.npy")


def test_folders_zips_and_stores_without_arrays_are_refused(tmp_path):
    zarr = pytest.importorskip("zarr")
    with pytest.raises(UserError, match="this is a folder and no Zarr store"):
        read_array(tmp_path)
    zarr.open_group(str(tmp_path / "empty.zarr"), mode="w")
    with pytest.raises(UserError, match="the file holds no array"):
        read_array(tmp_path / "empty.zarr")
    import zipfile

    with zipfile.ZipFile(tmp_path / "model.pt", "w") as file:
        file.writestr("model/data.pkl", b"")
    with pytest.raises(UserError, match="a PyTorch file is not read"):
        read_array(tmp_path / "model.pt")
    with pytest.raises(UserError, match="there is no such file"):
        read_array(tmp_path / "nowhere.npy")
