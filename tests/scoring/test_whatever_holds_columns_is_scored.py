"""A path, an array, columns by name, a data frame and a dataset give the same score."""

import io
from contextlib import suppress

import numpy as np
import pytest

import heyoka_bike as hb
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.errors import BicycleError, DatasetError, InputError
from heyoka_bike.system.resources import data_folder

FILE = data_folder() / "peers" / "exudyn-h0.001.txt"
TABLE = np.loadtxt(FILE)
TIME = TABLE[:, 0]
MANEUVERS = {
    n: {"time": TIME, **dict(zip(KEYS, TABLE.T[8 * n - 7 : 8 * n + 1], strict=True))}
    for n in (1, 2, 3)
}
ROLL = MANEUVERS[2]["roll_angle"]


def digits(report):
    return {(n, key): c.scd for n, m in report.items() for key, c in m.items()}


@pytest.fixture(scope="module")
def expected():
    return digits(hb.score(TABLE))


def frame(columns):
    pandas = pytest.importorskip("pandas")
    return pandas.DataFrame(columns)


def dataset():
    xarray = pytest.importorskip("xarray")
    stacked = {key: np.array([m[key] for m in MANEUVERS.values()]) for key in KEYS}
    columns = {key: (("maneuver", "time"), x) for key, x in stacked.items()}
    return xarray.Dataset(columns, coords={"time": TIME, "maneuver": [1, 2, 3]})


WHOLE = {
    "a list of rows": lambda: TABLE.tolist(),
    "maneuvers by number": lambda: MANEUVERS,
    "frames by number": lambda: {n: frame(m) for n, m in MANEUVERS.items()},
    "arrays by number": lambda: {np.int64(n): np.transpose([*m.values()])
                                 for n, m in MANEUVERS.items()},
    "results by number": lambda: {n: hb.read_results(m, maneuver=n) for n, m in MANEUVERS.items()},
    "results": lambda: hb.read_results(TABLE),
    "several results": lambda: [hb.read_results(m, maneuver=n) for n, m in MANEUVERS.items()],
    "a dataset": dataset,
}  # fmt: skip


@pytest.mark.parametrize("kind", WHOLE)
def test_all_maneuvers(kind, expected):
    assert digits(hb.score(WHOLE[kind]())) == expected


def test_a_file_by_its_name_or_path(expected):
    for path in (str(FILE), FILE, [FILE]):
        found = digits(hb.score(path))
        assert found.keys() == expected.keys()
        # The times are the written decimals, both in the file and in the evenly spaced array.
        assert found == pytest.approx(expected, abs=1e-6)


def test_columns_of_any_kind_of_array(expected):
    pandas = pytest.importorskip("pandas")
    one = {(n, key): x for (n, key), x in expected.items() if n == 2}
    series = {name: pandas.Series(x) for name, x in MANEUVERS[2].items()}
    assert digits(hb.score(series, maneuver=2)) == one
    assert digits(hb.score(**series, maneuver=2)) == one
    with pytest.warns(PendingDeprecationWarning, match="matrix"):
        matrix = np.matrix(TABLE)
    assert digits(hb.score(matrix)) == expected


class Simulated:
    """Like the result of `simulate`, this object has a method `table`."""

    def __init__(self, rows=None):
        self.rows = np.transpose([*MANEUVERS[2].values()]) if rows is None else rows

    def table(self):
        return self.rows


def test_a_simulation_of_all_maneuvers(expected):
    assert digits(hb.score(Simulated(TABLE))) == expected


ONE = {
    "columns": lambda: hb.score(MANEUVERS[2], maneuver=2),
    "a frame": lambda: hb.score(frame(MANEUVERS[2]), maneuver=2),
    "a frame by its times": lambda: hb.score(frame(MANEUVERS[2]).set_index("time"), maneuver=2),
    "records": lambda: hb.score(frame(MANEUVERS[2]).to_records(index=False), maneuver=2),
    "keywords": lambda: hb.score(**MANEUVERS[2], maneuver=2),
    "times and keywords": lambda: hb.score(
        TIME, maneuver=2, **{k: x for k, x in MANEUVERS[2].items() if k != "time"}),
    "not told which": lambda: hb.score(MANEUVERS[2]),
    "columns in another order": lambda: hb.score(
        TABLE[:, [0, *range(16, 8, -1)]], maneuver=2, columns=",".join(("time", *KEYS[::-1]))),
    "a simulation": lambda: hb.score({2: Simulated()}),
    "results told later": lambda: hb.score(hb.read_results(MANEUVERS[2]), maneuver=2),
}  # fmt: skip


@pytest.mark.parametrize("kind", ONE)
def test_one_maneuver(kind, expected):
    assert digits(ONE[kind]()) == {(n, key): x for (n, key), x in expected.items() if n == 2}


def test_results_that_do_not_tell_their_maneuver_are_told():
    upright = hb.read_results({"time": TIME[:1], "roll_angle": ROLL[:1]})
    with pytest.raises(BicycleError, match="to choose it, use maneuver=N"):
        hb.score(upright)
    assert list(hb.score(upright, maneuver=2)) == [2]


def test_columns_by_any_of_their_names():
    by_key = digits(hb.score(TIME, roll_angle=ROLL, maneuver=2))
    assert by_key == digits(hb.score(t=TIME, phi=ROLL, maneuver=2))
    assert by_key == digits(hb.score(TIME, m2_roll_angle=ROLL))
    every = np.array([m["roll_angle"] for m in MANEUVERS.values()])
    assert list(hb.score(TIME, roll_angle=every)) == [1, 2, 3]


def test_the_reference_may_be_its_folder(folder, reference):
    found = hb.score(TABLE, folder)
    assert found.reference_sha256 == hb.score(TABLE, reference).reference_sha256


def test_one_requirement_needs_no_list():
    assert not hb.score(TABLE, require="scd >= 6").passed
    assert len(hb.score(TABLE, require=["scd >= 3", "coverage >= 1"]).requirements) == 2


REFUSED = {
    "nothing": (lambda: hb.score(), "found a NoneType, expected the path of a file, an array"),
    "a set": (lambda: hb.score({1, 2}), "found a set, expected the path of a file"),
    "bytes in memory": (lambda: hb.score(io.BytesIO()), "found a BytesIO, expected the path"),
    "a report": (lambda: hb.score(hb.score(TABLE)), "found a Report, which is a score already"),
    "no such file": (lambda: hb.score("none.txt"), "none.txt: cannot be read (No such file"),
    "seven columns": (lambda: hb.score(TABLE[:, :7]), "array: found 7 columns, expected 9 or 25"),
    "a column's name": (lambda: hb.score(TIME, rol_angle=ROLL), "did you mean roll_angle?"),
    "an option's name": (lambda: hb.score(TIME, requires=ROLL), "found a column 'requires'"),
    "no times": (lambda: hb.score(roll_angle=ROLL), "columns without their times"),
    "times twice": (lambda: hb.score(TIME, time=TIME, roll_angle=ROLL), "found times twice"),
    "columns without a time": (
        lambda: hb.score({"roll_angle": ROLL, "steer_angle": ROLL}), "without their times"),
    "lengths": (
        lambda: hb.score(TIME, roll_angle=ROLL[:5]), "1001 values of 'time' and 5 of 'roll_angle'"),
    "text": (
        lambda: hb.score(TIME, roll_angle=["0.1"] * 7 + ["x"] * 994),
        "roll_angle: row 8: found 'x', expected a number"),
    "no time": (
        lambda: hb.score(np.where(TIME == 1, np.nan, TIME), roll_angle=ROLL),
        "array: row 101: found a time that is not finite"),
    "a list of columns": (
        lambda: hb.score([MANEUVERS[1], MANEUVERS[2]]), "expected maneuvers by number"),
    "another maneuver": (lambda: hb.score(TABLE, maneuver=4), "found maneuver 4, expected 1 to 3"),
    "a maneuver in words": (lambda: hb.score(TABLE, maneuver="2"), "found maneuver '2', expected"),
    "a maneuver's number": (lambda: hb.score({4: TABLE}), "found maneuver 4, expected 1 to 3"),
    "a maneuver of three": (
        lambda: hb.score(TABLE, maneuver=2), "results of maneuvers 1, 2 and 3",
    ),
    "a maneuver twice": (lambda: hb.score([FILE, FILE]), "found maneuver 1 twice"),
    "told columns": (lambda: hb.score(TABLE, columns="time,foo"), "columns: found 'foo'"),
    "another reference": (lambda: hb.score(TABLE, TABLE), "reference: found a ndarray"),
    "a requirement": (lambda: hb.score(TABLE, require="scd"), "require: found 'scd'"),
}  # fmt: skip


class Odd:
    """An object that looks as if it had columns."""

    def __init__(self, columns):
        self.columns = columns


def loop():
    found = {"time": TIME}
    found["again"] = found
    return found


ODD = {
    "None": None, "a number": 3.0, "a large number": 10**400, "a boolean": True, "bytes": b"x",
    "a function": len, "a class": Odd, "no columns": Odd(None),
    "columns that are not there": Odd(["time"]), "an iterator": iter([1]), "a loop": loop(),
    "objects": np.array([None] * 9), "dates": np.array(["2020-01-01"] * 9, "datetime64[s]"),
    "no rows": np.empty((0, 9)), "ragged rows": [[1.0], [1.0, 2.0]], "an empty row": [[]],
    "decimals that are none": [["x"] * 9], "a column that is none": {"time": TIME, "roll": None},
    "numbers as names": {0: TIME, 1: ROLL}, "numbers and names": {1: TIME, "time": ROLL},
    "maneuvers without columns": {1: None, 2: []}, "nothing by name": {}, "nothing": [],
    "times that are infinite": {"time": TIME * np.nan, "roll": ROLL}, "a folder": "/", "": "",
    "a name that cannot be": "a\0b", "a name and a number": ["a", 3],
    "no numbers": np.zeros(3, "V8"), "masked": np.ma.masked_all((5, 9)),
    "one value": {"time": 1.0, "roll": 0.1},
}  # fmt: skip


@pytest.mark.parametrize("kind", ODD)
def test_whatever_is_given_an_error_is_one_of_the_package(kind):
    odd = ODD[kind]
    calls = (
        lambda: hb.score(odd), lambda: hb.score(odd, maneuver=2), lambda: hb.compare(odd),
        lambda: hb.score(odd, roll_angle=ROLL), lambda: hb.compare(a=TABLE, b=odd),
        lambda: hb.score_series(odd), lambda: hb.score(TABLE, columns=odd),
        lambda: hb.score(TABLE, maneuver=odd), lambda: hb.score(TABLE, require=odd),
    )  # fmt: skip
    accepted = 0
    for call in calls:
        with suppress(BicycleError):
            call()
            accepted += 1
    assert accepted < len(calls)


@pytest.mark.parametrize("kind", REFUSED)
def test_anything_else_is_refused_in_one_clear_line(kind, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    call, says = REFUSED[kind]
    with pytest.raises(InputError) as raised:
        call()
    assert says in str(raised.value)
    assert "\n" not in str(raised.value)
    assert "--" not in str(raised.value)


def test_a_folder_without_a_set_is_refused(tmp_path):
    with pytest.raises(DatasetError, match=r"no manifest\.json found"):
        hb.score(TABLE, tmp_path)


def test_programs_are_compared_by_name(expected):
    found = hb.compare(mine=TABLE, theirs=FILE, part={2: MANEUVERS[2]}, cpu={"theirs": 0.5})
    assert [run.name for run in found.runs] == ["mine", "theirs", "part"]
    assert [run.cpu for run in found.runs] == [None, 0.5, None]
    assert digits(found["mine"]) == expected
    assert [r.file.path for r in found] == ["mine", str(FILE), "part"]
    assert list(found["part"]) == [2]
    assert digits(hb.compare({"My code, v2": TABLE, "other": FILE})["My code, v2"]) == expected
    coarse = FILE.with_name("exudyn-h0.01.txt")
    for several in (hb.compare([FILE, coarse]), hb.compare(FILE, coarse)):
        assert [run.name for run in several.runs] == [FILE.name, coarse.name]
    assert not hb.compare(a=TABLE, b=coarse, require="scd >= 3").passed


@pytest.mark.parametrize(
    ("arguments", "named", "says"),
    [
        ([], {}, "found 0 programs, expected two or more"),
        ([], {"a": TABLE}, "found 1 program, expected two or more; score() judges one"),
        ([[FILE]], {"b": FILE}, "found programs with and without names"),
        ([], {"a": TABLE, "b": TABLE[:, :7]}, "b: found 7 columns, expected 9 or 25"),
        (
            [],
            {"a": TABLE, "b": TABLE, "cpu": {"c": 1.0}},
            "cpu: found 'c', expected one of a, b",
        ),
        ([{"": TABLE, "b": TABLE}], {}, "name: found an empty name"),
    ],
)
def test_what_cannot_be_compared_is_refused(arguments, named, says):
    with pytest.raises(InputError) as raised:
        hb.compare(*arguments, **named)
    assert says in str(raised.value)


def test_a_column_never_filled_in_is_left_out_side_by_side_too():
    empty = TABLE.copy()
    empty[:, 15] = 0.0
    alone = hb.score(empty)
    assert "steer_angle" not in alone[2] or alone[2]["steer_angle"].scd is None
    assert digits(hb.compare(a=empty, b=TABLE)["a"]) == digits(alone)


def test_runs_may_be_arrays():
    coarse = np.loadtxt(FILE.with_name("exudyn-h0.01.txt"))
    found = hb.score_series([coarse, TABLE], steps=[0.01, 0.001])
    assert [run.step for run in found.runs] == [0.01, 0.001]
    assert 1.9 < found.convergence[0].orders[0] < 2.1, "Exudyn's solver is of order 2"


def test_the_diagnosis_takes_the_same(monkeypatch):
    """`diagnose` accepts the same inputs as `score`; the search is tested elsewhere."""
    from heyoka_bike.scoring.diagnosis import diagnose as module

    monkeypatch.setattr(module, "diagnosed", lambda report, *_: report)
    found = hb.diagnose(TIME, roll_angle=ROLL, maneuver=2)
    assert digits(found) == digits(hb.score(TIME, roll_angle=ROLL, maneuver=2))
    with pytest.raises(BicycleError, match="found 7 columns"):
        hb.diagnose(TABLE[:, :7])
