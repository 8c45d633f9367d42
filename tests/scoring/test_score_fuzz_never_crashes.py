"""Whatever its bytes, a result file is scored or refused in one line; no file causes a hang."""

import gzip
import io
import json
import os
import random
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import BicycleError, Exit
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.series import score_files
from heyoka_bike.showing.formats import json as as_json
from heyoka_bike.showing.formats.output import render

# The timeout is generous, because it must end tests that hang, not tests on slow machines.
pytestmark = pytest.mark.timeout(300)

REFERENCE = load_reference()
DOCUMENTED = {Exit.INPUT, Exit.NOTHING_SCORED}
MANY = 100_000
# The fuzzed files have only a few rows, so these requirements demand little.
_ENOUGH = ["scd >= 1", "columns >= 1", "coverage >= 0"]

PIECES = [
    b"nan", b"inf", b"-inf", b"1e999", b"-1e308", b"1e-400", b"1d5", b"1.5-101", b"1_0", b"0x10",
    b"1.#IND", b"1.#INF", b",", b";", b"\t", b" ", b"\n", b"\r", b"\r\n", b"\0", b"#", b"%", b"//",
    b"!", b'"', b"'", b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff", b"\xff", b"\x1f\x8b",
    b"PK\x03\x04",
    b"\x93NUMPY", b"\x89HDF\r\n\x1a\n", b"MATLAB 5.0", b"time", b"roll_angle", b"maneuver", b"-",
    b"+", b".", b"..", b"1,5", b"9" * 400, b"0." + b"3" * 400, b"1e" + b"9" * 50, b"\xe2\x88\x92",
    b"\xd9\xa1", b"\x1b[31m", b"(", b")", b"j", b"True", b"-0", b"10.000000000000002", b"11", b"-1",
]  # fmt: skip


def excerpt(keep):
    """A few rows of all maneuvers, as an array of shape (n, 25)."""
    columns = [REFERENCE[1].time[keep]]
    for number in REFERENCE:
        columns += [REFERENCE[number].rows[key][keep] for key in BENCHMARK_COLUMNS]
    return np.column_stack(columns)


def as_text(array, form="%.17g", **more):
    buffer = io.BytesIO()
    np.savetxt(buffer, array, form, **more)
    return buffer.getvalue()


def saved(save, **arrays):
    buffer = io.BytesIO()
    save(buffer, **arrays)
    return buffer.getvalue()


def hdf5(array):
    import h5py

    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as f:
        f["results"] = array
    return buffer.getvalue()


def mat(array):
    from scipy.io import savemat

    buffer = io.BytesIO()
    savemat(buffer, {"results": array})
    return buffer.getvalue()


def json_files(table):
    """JSON with columns by name in one object, and with one object of a row per line."""
    names = ["time", *BENCHMARK_COLUMNS]
    columns = dict(zip(names, table.T.tolist(), strict=True))
    records = [json.dumps(dict(zip(names, row, strict=True))) for row in table.tolist()]
    return [json.dumps({"results": columns}).encode(), "\n".join(records).encode()]


def netcdf(table):
    from scipy.io import netcdf_file

    buffer = io.BytesIO()
    f = netcdf_file(buffer, "w")
    f.createDimension("time", len(table))
    for name, x in zip(("time", *BENCHMARK_COLUMNS), table.T, strict=True):
        f.createVariable(name, "f8", ("time",))[:] = x
    f.flush()
    return buffer.getvalue()


def workbook(table):
    from openpyxl import Workbook

    book = Workbook()
    for row in (["time", *BENCHMARK_COLUMNS], *table.tolist()):
        book.active.append(row)
    return saved(book.save)


def good_files():
    table = excerpt(slice(0, 200, 12))
    names = "time," + ",".join(BENCHMARK_COLUMNS)
    nine = table[:, :9]
    each = [table[:, [0, *range(8 * m - 7, 8 * m + 1)]] for m in REFERENCE]
    long = np.vstack([np.insert(rows, 0, m, 1) for m, rows in enumerate(each, 1)])
    array = io.BytesIO()
    np.save(array, table)
    return [
        as_text(table),
        as_text(nine, "%.9e", delimiter=", ", header="my program\ntime [s]\n", comments="% "),
        as_text(nine, "%.6f", delimiter=";", header=names, comments="").replace(b".", b","),
        as_text(nine, "%.15e").replace(b"e", b"D").replace(b"\n", b"\r\n"),
        as_text(nine).decode().encode("utf-16"),
        gzip.compress(as_text(table, "%.8g"), mtime=0),
        array.getvalue(),
        saved(np.savez, results=nine),
        saved(np.savez_compressed, time=nine[:, 0], roll_angle=nine[:, 1]),
        hdf5(table),
        mat(nine),
        *json_files(nine),
        json.dumps(table.tolist(), indent=0).encode(),
        as_text(long, "%.12g", delimiter=",", header=f"maneuver,{names}", comments=""),
        as_text(table[:, [0, 3, 4]], delimiter=",", header="t [s],v [m/s],V [J]", comments=""),
        as_text(table.T),
        saved(lambda buffer: np.save(buffer, np.stack(each))),
        saved(np.savez, t=table[:, 0], y=table[:, 1:].T),
        netcdf(nine),
        workbook(nine[:5]),
    ]


GOOD = good_files()


def damage(raw, pick):
    """Replace, insert, delete, repeat or cut off some stretches of bytes, and flip some bits."""
    for _ in range(pick.choice((1, 1, 1, 2, 4))):
        start = pick.randint(0, len(raw))
        end = min(len(raw), start + pick.randint(0, 30))
        piece = pick.choice(PIECES) if pick.random() < 0.8 else pick.randbytes(pick.randint(1, 8))
        how = pick.randrange(6)
        if how == 0:
            raw = raw[:start] + piece + raw[end:]
        elif how == 1:
            raw = raw[:start] + piece + raw[start:]
        elif how == 2:
            raw = raw[:start] + raw[end:]
        elif how == 3:
            raw = raw[:end] + raw[start:]
        elif how == 4 and pick.random() < 0.3:
            raw = raw[:start]
        elif start < len(raw):
            raw = raw[:start] + bytes([raw[start] ^ 1 << pick.randrange(8)]) + raw[start + 1 :]
    return raw


def check(raw, path, renderers=(as_json.render,)):
    """Score a file and return its exit code."""
    path.write_bytes(raw)
    try:
        scored = score_files([read_results(path)], REFERENCE, require=_ENOUGH)
        code = Exit.OK if scored.passed else Exit.CHECK_FAILED
        for render in renderers:
            assert render(scored)
        json.loads(as_json.render(scored), parse_constant=pytest.fail)
        said = None
    except BicycleError as e:
        code, said = e.exit_code, str(e)
    if said is not None:
        assert said.isprintable(), repr(said)
        assert len(said) < 1000
        assert code in DOCUMENTED
    return code


def everything(scored):
    return [render(scored, name) for name in ("table", "html", "junit", "csv")]


def test_the_undamaged_files_are_scored(tmp_path):
    for raw in GOOD:
        assert check(raw, tmp_path / "results") == Exit.OK


def loop(seed, count, folder):
    """Exit codes of damaged files. Each file has its own seed, so it can be made again."""
    path = folder / f"results-{os.getpid()}"
    codes = []
    for i in range(count):
        pick = random.Random(f"{seed}-{i}")
        raw = damage(pick.choice(GOOD), pick)
        renderers = (everything,) if i % 50 == 0 else ()
        try:
            codes.append(int(check(raw, path, renderers)))
        except BaseException as e:
            raise AssertionError(f"damaged file {seed}-{i}: {type(e).__name__}: {e}") from e
    return codes


@pytest.mark.proof
def test_damaged_files_end_with_a_documented_code(tmp_path):
    codes = loop("short", 400, tmp_path)
    # The damage must have all three effects: some files still pass, some cannot be read, and some
    # fail the requirement.
    assert {Exit.OK, Exit.INPUT, Exit.CHECK_FAILED} <= set(codes)


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    st.lists(st.one_of(st.sampled_from(PIECES), st.binary(max_size=6)), max_size=60).map(b"".join)
)
def test_bytes_of_any_kind_end_with_a_documented_code(tmp_path, raw):
    check(raw, tmp_path / "results")


NUMBERS = st.one_of(
    st.floats(), st.floats(0, 10), st.sampled_from([0.0, 1e300, -1e300, 5e-324, 10.0])
)


@settings(max_examples=100, deadline=None, suppress_health_check=list(HealthCheck))
@given(st.lists(st.lists(NUMBERS, min_size=9, max_size=9), min_size=1, max_size=5))
# The sum of these two times overflows binary64.
@example([[t, *[0.0] * 8] for t in (8.988465674311579e307, 8.98846567431158e307)])
def test_rows_of_any_numbers_end_with_a_documented_code(tmp_path, rows):
    check(as_text(np.array(rows)), tmp_path / "results", (everything,))


@pytest.mark.slow
@pytest.mark.timeout(4 * 3600)
def test_100_000_damaged_files_end_with_a_documented_code(tmp_path):
    """This test takes about half an hour on 2 cores."""
    jobs = [(f"long-{i}", MANY // 100, tmp_path) for i in range(100)]
    workers = os.cpu_count() or 1
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        codes = [code for found in pool.map(loop, *zip(*jobs, strict=True)) for code in found]
    assert len(codes) == MANY
