"""Files of pandas, polars, xarray, SciPy, hdf5storage, Octave and json contain what was written.

`written/write.py` and `written/write.m` made them from rows of the published text.
"""

import gzip
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.errors import MissingPackageError
from heyoka_bike.scoring.reading.source import read_results

HERE = Path(__file__).parent / "written"
FILES = sorted(p.name for p in HERE.iterdir() if not p.stem.startswith("write"))
ROWS = np.loadtxt(HERE / "rows.txt")

FORMATS = {
    ".txt": "text", ".csv": "text", ".tsv": "text", ".json": "json", ".jsonl": "json",
    ".ndjson": "json", ".xlsx": "xlsx", ".parquet": "parquet", ".arrow": "arrow",
    ".feather": "arrow", ".mat": "mat", ".nc": "hdf5", ".h5": "hdf5",
}  # fmt: skip
# Number of digits of the files whose numbers are written with 15 or 16 digits. They are read with
# that precision.
DIGITS = {"pandas.xlsx": 16, "sheets.xlsx": 16, "xlsxwriter.xlsx": 16}


def digits_of(name):
    is_of_pandas = name.startswith("pandas-") and ".json" in name
    return DIGITS.get(name, 13 if is_of_pandas else 17)


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("name", FILES)
def test_every_number_is_read(name, packed, tmp_path):
    if FORMATS[Path(name).suffix] in ("parquet", "arrow"):
        pytest.importorskip("pyarrow")
    path = HERE / name
    if packed:
        path = tmp_path / f"{name}.gz"
        path.write_bytes(gzip.compress((HERE / name).read_bytes(), 1))
    results = read_results(path)
    assert results.format == ("netcdf" if name == "xarray-3.nc" else FORMATS[Path(name).suffix])
    assert [rows.maneuver for rows in results.maneuvers] == [1, 2, 3]
    tolerance = 0 if digits_of(name) == 17 else 0.51 * 10.0 ** (1 - digits_of(name))
    for m, rows in enumerate(results.maneuvers):
        # The times in the file are the nearest binary64 numbers, or have 17 digits. In both cases
        # they mean the decimal numbers.
        for i, (hi, lo) in enumerate(zip(rows.time, rows.time_lo, strict=True)):
            assert abs(Fraction(hi) + Fraction(lo) - Fraction(91 * i, 100)) < 1e-30
        assert sorted(rows.values) == sorted(KEYS)
        for k, key in enumerate(KEYS):
            expected = ROWS[:, 8 * m + k + 1]
            # pandas writes values below one with a fixed number of decimals.
            scale = np.maximum(np.abs(expected), 1.0 if digits_of(name) == 13 else 0.0)
            assert np.all(np.abs(rows.values[key] - expected) <= tolerance * scale), (m, key)
    said = {f.code for f in results.findings} - {"times_read_as_multiples"}
    assert said <= {"columns_left_out"}
    left_out = [f for f in results.findings if f.code == "columns_left_out"]
    assert not left_out or name.startswith(("pandas", "trajectory")), left_out


@pytest.mark.parametrize("package", ["openpyxl", "pyarrow"])
def test_a_package_that_is_missing_is_named(package, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, package, None)
    name = "pandas.xlsx" if package == "openpyxl" else "pandas.parquet"
    with pytest.raises(MissingPackageError, match=f"{name}: .*pip install {package}$") as caught:
        read_results(HERE / name)
    assert caught.value.exit_code == 1


def test_the_decimals_of_json_are_exact(tmp_path):
    path = tmp_path / "r.json"
    long = "0.15000000000000000000000000000001"
    times = ["0.1", "0.20", "0.3", long]
    rolls = [f"{i}.12345678901234567890123456789{i}" for i in range(4)]
    path.write_text(
        f'{{"t": [{", ".join(times)}], "roll": [{",".join(rolls)}], "v": [4, 4, 4, 4]}}'
    )
    results = read_results(path)
    (rows,) = results.maneuvers
    order = [0, 3, 1, 2]
    for hi, lo, i in zip(rows.time, rows.time_lo, order, strict=True):
        assert abs(Fraction(hi) + Fraction(lo) - Fraction(times[i])) < Fraction(1, 10**32)
    rest = zip(rows.values["roll_angle"], rows.lo["roll_angle"], order, strict=True)
    for hi, lo, i in rest:
        assert abs(Fraction(hi) + Fraction(lo) - Fraction(rolls[i])) < Fraction(1, 10**30)
    assert rows.quantum["roll_angle"].digits == 31
    # A constant column counts as written with the digits of the other columns.
    assert rows.quantum["forward_speed"] == rows.quantum["roll_angle"]
    assert results.significant_digits == 31


@pytest.mark.parametrize(
    "shape", ['{{"t":[{0}],"roll":[{1}]}}', "[[{0}],[{1}]]", '{{"t":[{0}],\n"roll":["{2}"]}}']
)
def test_json_and_text_are_understood_alike(shape, tmp_path):
    numbers = [["0.5", "1.25", "2"], ["1e-3", "-2.5E-10", "NaN"]]
    if shape.startswith("[["):
        numbers = list(zip(*numbers, strict=True))
        shape = "[[{0}],[{1}],[{2}]]"
        rows = [",".join(row) for row in numbers]
        content = shape.format(*rows)
        columns = ["t", "roll"]
    else:
        content = shape.format(",".join(numbers[0]), ",".join(numbers[1]), '","'.join(numbers[1]))
        columns = None
        numbers = list(zip(*numbers, strict=True))
    (tmp_path / "r.json").write_text(content)
    (tmp_path / "r.csv").write_text("t,roll\n" + "\n".join(",".join(row) for row in numbers))
    found = read_results(tmp_path / "r.json", columns=columns)
    expected = read_results(tmp_path / "r.csv")
    for a, b in zip(found.maneuvers, expected.maneuvers, strict=True):
        assert np.array_equal(a.time, b.time)
        assert np.array_equal(a.values["roll_angle"], b.values["roll_angle"], equal_nan=True)
        assert dict(a.quantum) == dict(b.quantum)
    assert [f.code for f in found.findings] == [f.code for f in expected.findings]


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-16-le"])
def test_json_in_other_encodings(encoding, tmp_path):
    path = tmp_path / "r.json"
    path.write_bytes((HERE / "json-columns.json").read_text().encode(encoding))
    assert len(read_results(path).maneuvers) == 3


def test_a_text_that_begins_with_a_bracket(tmp_path):
    path = tmp_path / "r.txt"
    path.write_text("[my program]\ntime roll\n0 1.5\n1 2.5\n")
    assert read_results(path).format == "text"
