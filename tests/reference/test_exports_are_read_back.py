"""CSV, JSON and netCDF contain exactly the numbers of the reference, and score like it."""

import json
from dataclasses import replace
from fractions import Fraction

import jsonschema
import numpy as np
import pytest

from heyoka_bike import read_results, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.reference.exports import formats
from heyoka_bike.reference.exports.formats import choose
from heyoka_bike.reference.load import Reference
from heyoka_bike.reference.values import Dense, Values
from heyoka_bike.system.resources import data_folder
from support.export_programs import STEM, c_values, export, need, run

SCHEMA = data_folder().parent / "heyoka_bike" / "reference" / "exports" / "export-1.schema.json"

# Largest difference between the hi + lo of the rows and the dense output.
DENSE = 1e-28


def worst(scored):
    return [
        (c.as_understood.measures.max_abs_error, c.floor, c.as_understood.definition, c.key, m)
        for m in scored.maneuvers
        for c in m.columns
    ]


def test_csv_scores_at_the_floor(tmp_path):
    export(tmp_path, "csv")
    scored = score(read_results(tmp_path / f"{STEM}.csv"))
    columns = worst(scored)
    assert len(columns) == 24
    for error, floor, *which in columns:
        assert error <= floor, which
    assert not scored.findings


def test_csv_of_32_digits_scores_far_below_binary64(tmp_path, reference):
    export(tmp_path, "csv", "--digits", "32")
    scored = score(read_results(tmp_path / f"{STEM}.csv"))
    for error, _, _, key, m in worst(scored):
        assert error <= DENSE * reference[m.maneuver].scale(key), (m.maneuver, key)


def test_csv_is_what_it_says(tmp_path, reference):
    import pandas

    export(tmp_path, "csv", "--columns", "all")
    export(tmp_path / "long", "csv", "--columns", "all", "--digits", "32")
    short = pandas.read_csv(tmp_path / f"{STEM}.csv", comment="#", dtype=str)
    long = pandas.read_csv(tmp_path / "long" / f"{STEM}.csv", comment="#", dtype=str)
    assert list(short) == list(long)
    assert short.shape == (1001, 1 + 3 * len(COLUMNS))
    assert [Fraction(t) for t in long["time [s]"]] == [Fraction(i, 100) for i in range(1001)]
    assert long["time [s]"][7] == "0.07"
    for n, m in reference.items():
        for column in COLUMNS:
            name = f"maneuver_{n}_{column.name} [{column.unit}]"
            hi, lo = m.rows[column.name], m.rows.lo[column.name]
            assert [float(text) for text in short[name]] == hi.tolist()
            for text, x, rest in zip(long[name][::10], hi[::10], lo[::10], strict=True):
                exact = Fraction(float(x)) + Fraction(float(rest))
                assert abs(Fraction(text) - exact) <= abs(exact) * Fraction(5, 10**32)


def cut(document):
    """Return the document with shortened lists, because the schema treats all items alike."""
    match document:
        case dict():
            return {key: cut(value) for key, value in document.items()}
        case list():
            return [cut(value) for value in document[:3]]
    return document


def test_json_follows_its_schema_and_holds_every_number(tmp_path, reference):
    export(tmp_path, "json", "--columns", "all")
    document = json.loads((tmp_path / f"{STEM}.json").read_text())
    jsonschema.validate(cut(document), json.loads(SCHEMA.read_text()))
    assert [c["name"] for c in document["columns"]] == [c.name for c in COLUMNS]
    for n, m in reference.items():
        rows, pieces = (document[key][f"maneuver_{n}"] for key in ("rows", "pieces"))
        assert np.array_equal(rows["time"], m.time)
        assert np.array_equal(rows["time_lo"], m.time_lo)
        assert np.array_equal(pieces["breaks"], m.breaks)
        assert document["maneuvers"][f"maneuver_{n}"] == {"name": m.name, **m.inputs}
        for name in m.columns:
            for found, values in ((rows, m.rows), (pieces, m.dense)):
                assert np.array_equal(found[name], values[name])
                assert np.array_equal(found[name + "_lo"], values.lo[name])


def test_json_rows_are_results_that_can_be_scored(tmp_path, reference):
    export(tmp_path, "json")
    rows = json.loads((tmp_path / f"{STEM}.json").read_text())["rows"]
    scored = worst(score(read_results(rows)))
    assert len(scored) == 24
    for error, _, _, key, m in scored:
        assert error <= DENSE * reference[m.maneuver].scale(key), (m.maneuver, key)
    plain = {
        group: {n: x for n, x in arrays.items() if n in BENCHMARK_COLUMNS or n.startswith("time")}
        for group, arrays in rows.items()
    }
    for error, floor, *which in worst(score(read_results(plain))):
        assert error <= floor, which


@pytest.mark.parametrize("form", ["json", "netcdf"])
@pytest.mark.parametrize("maneuver", [None, "2"])
def test_the_files_themselves_are_results_that_can_be_scored(form, maneuver, tmp_path, reference):
    export(tmp_path, form, *(("--maneuver", maneuver) if maneuver else ()))
    results = read_results(tmp_path / f"{STEM}.{'nc' if form == 'netcdf' else form}")
    assert not results.findings
    scored = worst(score(results))
    assert len(scored) == (8 if maneuver else 24)
    for error, _, _, key, m in scored:
        assert error <= DENSE * reference[m.maneuver].scale(key), (m.maneuver, key)


def test_netcdf_opens_in_xarray(tmp_path, reference):
    import xarray

    export(tmp_path, "netcdf", "--columns", "all")
    with xarray.open_dataset(tmp_path / f"{STEM}.nc", engine="h5netcdf") as data:
        assert dict(data.sizes) == {"maneuver": 3, "row": 1001}
        assert set(data.coords) == {"maneuver", "time"}
        assert data.attrs["Conventions"] == "CF-1.8, ACDD-1.3"
        assert data.attrs["license"].startswith("MIT")
        assert data.attrs["content_sha256"] == reference.content_sha256
        assert np.array_equal(data["time"], reference[1].time)
        assert np.array_equal(data["time_lo"], reference[1].time_lo)
        for column in COLUMNS:
            found = data[column.name]
            assert found.dims == ("maneuver", "row")
            assert found.attrs["units"] == column.unit
            assert found.attrs["definition"] == column.meaning
            for n, m in reference.items():
                assert np.array_equal(found.sel(maneuver=n), m.rows[column.name])
                low = data[column.name + "_lo"].sel(maneuver=n)
                assert np.array_equal(low, m.rows.lo[column.name])


def test_netcdf_is_read_by_its_own_library(tmp_path):
    export(tmp_path, "netcdf", "--maneuver", "2", "--columns", "yaw")
    shown = run([need("ncdump"), "-v", "maneuver", f"{STEM}.nc"], tmp_path)
    assert "double yaw(maneuver, row)" in shown
    assert "row = 1001" in shown
    assert "maneuver = 2 ;" in shown
    assert run([need("ncdump"), "-k", f"{STEM}.nc"], tmp_path).strip() == "netCDF-4"


@pytest.fixture
def shorter(reference):
    """A dataset whose first maneuver ends at 0.1 s, which is not a binary64, in rows of 1/30 s."""
    m = reference[1]
    first = {name: x[:1] for name, x in m.dense.hi.items()}
    first_lo = {name: x[:1] for name, x in m.dense.lo.items()}
    rows = Values(*({name: x[:4] for name, x in v.items()} for v in (m.rows.hi, m.rows.lo)))
    short = replace(
        m,
        inputs={**m.inputs, "duration": "1/10", "spacing": "1/30"},
        time=m.time[:4], time_lo=m.time_lo[:4], rows=rows,
        dense=Dense(first, first_lo, breaks=np.array([0.0, 0.1])),
    )  # fmt: skip
    maneuvers = (short, *reference.maneuvers[1:])
    where = reference.folder
    return Reference("custom", "0" * 64, reference.bicycle, reference.parameters, maneuvers, where)


def test_maneuvers_with_times_of_their_own_get_a_table_each(shorter, tmp_path):
    import pandas

    selection = choose(shorter, None, "yaw")
    tables = formats.as_csv(selection, "x")
    assert list(tables) == ["-1.csv", "-2.csv", "-3.csv"]
    (tmp_path / "x.csv").write_bytes(tables["-1.csv"])
    table = pandas.read_csv(tmp_path / "x.csv", comment="#", dtype=str)
    assert list(table) == ["time [s]", "maneuver_1_yaw [rad]"]
    third = "0.033333333333333333333333333333333333333333333333333"
    assert table["time [s]"].tolist()[:2] == ["0", third]
    assert table["time [s]"].tolist()[3] == "0.1"
    assert list(formats.as_netcdf(selection, "x")) == ["-1.nc", "-2.nc", "-3.nc"]
    assert list(formats.as_csv(choose(shorter, 1, "yaw"), "x")) == [".csv"]


def test_an_end_that_is_no_binary64_is_kept_to_32_digits(shorter, tmp_path):
    """1/10 is below the binary64 0.1, which is inside only for the plain evaluator."""
    for suffix, data in formats.c(choose(shorter, 1, "yaw"), STEM).items():
        (tmp_path / f"{STEM}{suffix}").write_bytes(data)
    rest = float(Fraction(1, 10) - Fraction(0.1))
    hi, lo = np.array([0.1, 0.1]), np.array([0.0, rest])
    found = c_values(tmp_path, (hi, lo), 1, ["yaw"])[0, 0]
    expected = shorter[1].evaluate((hi[1:], lo[1:]))
    assert np.isnan(found[0, 1])
    assert np.isfinite(found[:, 0]).all()
    assert (found[1, 1], found[1, 2]) == (expected["yaw"][0], expected.lo["yaw"][0])


def test_a_name_cannot_leave_the_comment(shorter, tmp_path):
    hostile = "x\n#error y */ #error \\\u2028 \u00e9"
    named = replace(shorter, bicycle=hostile, maneuvers=(replace(shorter[1], name=hostile),))
    for suffix, data in formats.c(choose(named, None, "yaw"), STEM).items():
        assert data.isascii()
        (tmp_path / f"{STEM}{suffix}").write_bytes(data)
    t = np.zeros(1), np.zeros(1)
    assert np.isfinite(c_values(tmp_path, t, 1, ["yaw"])).all()
