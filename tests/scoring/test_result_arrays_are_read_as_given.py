"""Arrays in files and in memory are read exactly, whatever the format, type and orientation."""

import gzip
import io

import h5py
import numpy as np
import pytest
import scipy.io

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.source import read_results

NUMBERS = np.random.default_rng(1).standard_normal((12, 25))
NUMBERS[:, 0] = np.sort(np.abs(NUMBERS[:, 0]))
NINE = NUMBERS[:, :9]


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def npz(compressed=False, **arrays):
    buffer = io.BytesIO()
    (np.savez_compressed if compressed else np.savez)(buffer, **arrays)
    return buffer.getvalue()


def mat(version="5", compressed=False, **arrays):
    buffer = io.BytesIO()
    scipy.io.savemat(buffer, arrays, format=version, do_compression=compressed)
    return buffer.getvalue()


def hdf5(userblock=0, **arrays):
    buffer = io.BytesIO()
    with h5py.File(buffer, "w", userblock_size=userblock) as f:
        for name, array in arrays.items():
            f[name] = array
    content = buffer.getvalue()
    return (
        b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(userblock)[:userblock] + content[userblock:]
    )


def named(table, prefix="", names=KEYS):
    return {f"{prefix}{name}": table[:, j] for j, name in enumerate(("time", *names))}


def maneuvers(table):
    return {
        f"maneuver_{m}": {
            "time": table[:, 0],
            **dict(zip(KEYS, table.T[8 * m - 7 :], strict=False)),
        }
        for m in (1, 2, 3)
    }


def assert_same(results, table, numbers=(1, 2, 3)):
    """Check that the results equal the columns of the table."""
    assert [rows.maneuver for rows in results.maneuvers] == list(numbers)
    for m, rows in enumerate(results.maneuvers):
        assert np.array_equal(rows.time, table[:, 0])
        assert sorted(rows.values) == sorted(KEYS)
        for k, key in enumerate(KEYS):
            assert np.array_equal(rows.values[key], table[:, 1 + 8 * m + k])
            assert rows.values[key].dtype == np.float64
            assert rows.values[key].dtype.isnative


FILES = {
    "npy": npy(NUMBERS),
    "npy in Fortran's order": npy(np.asfortranarray(NUMBERS)),
    "npy, big end first": npy(NUMBERS.astype(">f8")),
    "npz": npz(results=NUMBERS),
    "npz, compressed": npz(True, arr_0=NUMBERS, note=np.array(3)),
    "npz of named columns": npz(time=NUMBERS[:, 0], **{
        f"m{m}_{key}": NUMBERS[:, 8 * m - 7 + k]
        for m in (1, 2, 3) for k, key in enumerate(KEYS)}),
    "npz of maneuvers": npz(**{f"maneuver_{m}": NUMBERS[:, [0, *range(8 * m - 7, 8 * m + 1)]]
                               for m in (1, 2, 3)}),
    "npz of groups": npz(**{f"m{m}": np.rec.fromarrays(
        [NUMBERS[:, 0], *NUMBERS.T[8 * m - 7 : 8 * m + 1]], names=",".join(("t", *KEYS)))
        for m in (1, 2, 3)}),
    "mat": mat(results=NUMBERS, speed=4.0, name="bicycle"),
    "mat, compressed": mat(compressed=True, results=NUMBERS),
    "mat, version 4": mat("4", results=NUMBERS),
    "mat, structures": mat(**maneuvers(NUMBERS)),
    "mat, a structure of structures": mat(out=maneuvers(NUMBERS), n=3.0),
    "mat, version 7.3": hdf5(512, results=NUMBERS.T.copy()),
    "HDF5": hdf5(results=NUMBERS, speed=4.0, name="bicycle"),
    "HDF5 in a group": hdf5(**{"run/results": NUMBERS}),
    "HDF5 groups": hdf5(**{f"maneuver_{m}/{name}": x for m, group in enumerate(maneuvers(
        NUMBERS).values(), 1) for name, x in group.items()}),
    "HDF5 groups that share times": hdf5(time=NUMBERS[:, 0], **{
        f"maneuver_{m}/{name}": x for m, group in enumerate(maneuvers(NUMBERS).values(), 1)
        for name, x in group.items() if name != "time"}),
}  # fmt: skip


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", FILES)
def test_files(kind, packed, tmp_path, monkeypatch):
    path = tmp_path / f"results.{'mat' if 'mat' in kind else 'dat'}"
    path.write_bytes(gzip.compress(FILES[kind]) if packed else FILES[kind])
    results = read_results(path)
    assert_same(results, NUMBERS)
    assert results.findings == ()
    assert results.format == kind.lower().replace(",", "").split()[0]
    assert results.significant_digits == 16
    if kind != "mat, version 4":
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(path.read_bytes())))
        assert_same(read_results("-"), NUMBERS)


class Frame:
    """An object with the interface of a data frame."""

    columns = ("time", *KEYS)

    def __getitem__(self, name):
        return NINE[:, self.columns.index(name)]


RECORDS = np.rec.fromarrays([*NINE.T[::-1]], names=",".join(("time", *KEYS)[::-1]))
UNNAMED = np.zeros(12, dtype=[(f"f{j}", "f8") for j in range(9)])
for j in range(9):
    UNNAMED[f"f{j}"] = NINE[:, j]

NINES = {
    "array": NINE,
    "list": NINE.tolist(),
    "mapping": named(NINE),
    "mapping of lists": {k: v.tolist() for k, v in named(NINE).items()},
    "mapping in another order": dict(reversed(named(NINE).items())),
    "mapping by other names": named(NINE, names=("phi", "phidot", "v", "Epot", "Ekin", "E", "delta",
                                                 "deltadot")),
    "mapping without names": {f"x{j}": NINE[:, j] for j in range(9)},
    "columns of one column": {k: v[:, None] for k, v in named(NINE).items()},
    "records": RECORDS,
    "records by place": UNNAMED,
    "data frame": Frame(),
    "masked array": np.ma.masked_array(NINE),
}  # fmt: skip


@pytest.mark.parametrize("kind", NINES)
@pytest.mark.parametrize("maneuver", [None, 2])
def test_nine_columns_in_memory(kind, maneuver):
    results = read_results(NINES[kind], maneuver=maneuver)
    assert_same(results, NINE, [maneuver])
    assert (results.path, results.format, results.findings) == ("array", "array", ())


def test_maneuvers_in_memory():
    assert_same(read_results(NUMBERS), NUMBERS)
    assert_same(read_results(maneuvers(NUMBERS)), NUMBERS)
    one = read_results({"maneuver 2": NINE})
    assert_same(one, NINE, [2])
    assert_same(read_results({"maneuver 2": NINE}, maneuver=2), NINE, [2])
    with h5py.File(io.BytesIO(FILES["HDF5 groups"])) as f:
        assert_same(read_results(f), NUMBERS)


@pytest.mark.parametrize("table", [NUMBERS, NINE], ids=["25", "9"])
def test_transposed_arrays(table, tmp_path):
    path = tmp_path / "x"
    for content in (npy(table.T.copy()), npz(x=table.T), hdf5(x=table.T), mat(x=table.T)):
        path.write_bytes(content)
        results = read_results(path)
        assert_same(results, table, [1, 2, 3] if table is NUMBERS else [None])
        (finding,) = results.findings
        assert (finding.code, finding.severity) == ("transposed", "info")
        assert finding.evidence == {"shape": [table.shape[1], 12]}


def test_arrays_that_could_be_either_way_are_not_transposed():
    square = NUMBERS[:9, :9].copy()
    square[:, 0] = range(9)
    assert_same(read_results(square), square, [None])
    rows = np.vstack([NUMBERS, NUMBERS, NUMBERS])[:9]
    assert_same(read_results(rows), rows)
    matlab = hdf5(512, x=square.T.copy())
    assert_same(read_results({"x": square}), square, [None])
    with h5py.File(io.BytesIO(matlab)) as f:
        assert f["x"].shape == (9, 9)


def test_square_arrays_of_matlab(tmp_path):
    square = NUMBERS[:9, :9].copy()
    square[:, 0] = range(9)
    path = tmp_path / "x.mat"
    path.write_bytes(hdf5(512, x=square.T.copy()))
    assert_same(read_results(path), square, [None])


@pytest.mark.parametrize("dtype", ["f2", "f4", "f8", ">f4", "g", "i1", "i8", "u2"])
def test_types_of_numbers(dtype):
    table = (np.round(np.abs(NINE) * 9) if dtype[0] in "iu" else NINE).astype(dtype)
    table[:, 0] = range(12)
    results = read_results(table)
    (rows,) = results.maneuvers
    for k, key in enumerate(KEYS):
        exact = table[:, 1 + k].astype("g")
        assert np.array_equal(rows.values[key], exact.astype("f8"))
        if dtype == "g" and np.finfo("g").nmant > 52:
            # Binary64 numbers that are stored in a longer type have no low part.
            rest = rows.lo.get(key, 0.0)
            assert np.array_equal(rows.values[key].astype("g") + rest, exact)
            assert (key in rows.lo) == (exact != exact.astype("f8")).any()
        else:
            assert not rows.lo


def test_second_parts_are_added_exactly():
    hi, lo = np.array([1.0, 2.0, 3.0]), np.array([1e-17, -2e-16, 0.25])
    results = read_results({"time": hi, "roll": hi, "roll_lo": lo})
    (rows,) = results.maneuvers
    # A low part that is larger than a rounding error is added to the high part.
    assert rows.values["roll_angle"].tolist() == [1.0, 2.0 - 2e-16, 3.25]
    assert (rows.values["roll_angle"] + rows.lo["roll_angle"]).tolist() == (hi + lo).tolist()
    assert rows.lo["roll_angle"][0] == 1e-17
    assert results.findings == ()


def test_values_that_are_not_finite():
    table = NINE.copy()
    table[5, 3] = np.inf
    table[2, 8] = np.nan
    results = read_results(table)
    (rows,) = results.maneuvers
    assert np.isnan(rows.values["forward_speed"][5])
    assert np.isnan(rows.values["steer_rate"][2])
    (finding,) = results.findings
    assert finding.evidence == {"count": 2, "line": 3, "column": 9}
    assert "row 3, column 9" in finding.message


@pytest.mark.filterwarnings("error")
def test_long_double_that_is_not_finite():
    table = (NINE / 3).astype("g")
    table[4, 1] = np.inf
    table[5, 1] = np.nan
    if np.finfo("g").nmant > 52:
        table[6, 1] = np.ldexp(np.longdouble(1), 2000)
    (rows,) = read_results(table).maneuvers
    assert np.isnan(rows.values["roll_angle"][4:6]).all()
    assert np.isfinite(rows.lo.get("roll_angle", np.zeros(1))).all()


def test_other_datasets_are_left_out(tmp_path):
    path = tmp_path / "x"
    # The dataset's own files contain these additional columns, so they are not reported as left
    # out.
    own = dict.fromkeys(("roll_angle_bound", "roll_angle_zyx", "roll_angle_zyx_lo"), NINE[:, 1])
    path.write_bytes(hdf5(**named(NINE), **own))
    assert read_results(path).findings == ()
    many = dict(**named(NINE), tilt=NINE[:, 1], com=NINE[:, :3], forces={"x": NINE[:, 1]})
    (finding,) = read_results(many).findings
    assert (finding.code, finding.evidence["names"]) == (
        "columns_left_out",
        ["tilt", "com", "forces"],
    )
    path.write_bytes(hdf5(time=NINE[:, 0], roll=NINE[:, 1], tilt=NINE[:, 1]))
    (finding,) = read_results(path).findings
    assert (finding.code, finding.evidence["names"]) == ("columns_left_out", ["tilt"])
    groups = {f"maneuver_{m}": {"time": [0, 1], "roll": [0, 1]} for m in (1, 4)}
    (finding,) = read_results(groups).findings
    assert finding.evidence["names"] == ["maneuver 4"]


def test_links_to_other_files_and_to_themselves(tmp_path):
    path = tmp_path / "x.h5"
    with h5py.File(path, "w") as f:
        f["results"] = NUMBERS
        f["itself"] = f["/"]
        f["away"] = h5py.ExternalLink("other.h5", "/")
        f["nowhere"] = h5py.SoftLink("/none")
        f["empty"] = h5py.Empty("f8")
    assert_same(read_results(path), NUMBERS)


def test_a_filter_that_is_not_here_is_named(tmp_path):
    path = tmp_path / "x.h5"
    with h5py.File(path, "w") as f:
        made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        made.set_chunk(NUMBERS.shape)
        # Number 305 is registered with the HDF Group for LZO. It is optional here, so the file can
        # be written without the filter.
        made.set_filter(305, h5py.h5z.FLAG_OPTIONAL)
        space = h5py.h5s.create_simple(NUMBERS.shape)
        array = h5py.h5d.create(f.id, b"results", h5py.h5t.NATIVE_DOUBLE, space, made)
        array.write_direct_chunk((0, 0), NUMBERS.astype("f8").tobytes())
    said = "found /results compressed by filter 305, which is not installed here, expected gzip"
    with pytest.raises(InputError, match=said):
        read_results(path)


def test_two_tables_are_one_too_many():
    with pytest.raises(
        InputError, match="found column names 'a', 'b' not understood, expected 9 or 25 columns"
    ):
        read_results({"a": NUMBERS, "b": NUMBERS})
