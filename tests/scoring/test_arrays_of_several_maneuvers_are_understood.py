"""Arrays are read with an axis or a column for the maneuver, with the time stored apart, and
transposed."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.source import read_results

ROWS = 11
# The axes of the array are maneuver, row and column. The times of all maneuvers are equal.
CUBE = np.random.default_rng(3).standard_normal((3, ROWS, 9))
CUBE[:, :, 0] = np.arange(ROWS) / 7
TIME = CUBE[0, :, 0]


def assert_cube(results, findings=()):
    assert [rows.maneuver for rows in results.maneuvers] == [1, 2, 3]
    for rows, table in zip(results.maneuvers, CUBE, strict=True):
        assert np.array_equal(rows.time, TIME)
        assert sorted(rows.values) == sorted(KEYS)
        for key, x in zip(KEYS, table.T[1:], strict=True):
            assert np.array_equal(rows.values[key], x)
    assert tuple(dict.fromkeys(f.code for f in results.findings)) == findings


def wide(cube=CUBE):
    return np.hstack([TIME[:, None], *cube[:, :, 1:]])


@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0), (0, 2, 1), (2, 1, 0), (1, 0, 2)])
def test_an_axis_for_the_maneuvers(axes, tmp_path):
    cube = CUBE.transpose(axes)
    np.save(tmp_path / "r.npy", cube)
    assert_cube(read_results(tmp_path / "r.npy"))
    np.savez(tmp_path / "r.npz", results=cube, mass=3.0)
    assert_cube(read_results(tmp_path / "r.npz"))


def test_lists_of_maneuvers():
    assert_cube(read_results([x.tolist() for x in CUBE]))


@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0), (0, 2, 1)])
def test_a_time_beside_an_axis_for_the_maneuvers(axes):
    assert_cube(read_results({"t": TIME, "y": CUBE[:, :, 1:].transpose(axes)}))


@pytest.mark.parametrize("turn", [False, True])
def test_named_columns_with_an_axis_for_the_maneuvers(turn):
    columns = {key: CUBE[:, :, 1 + k] for k, key in enumerate(KEYS)}
    columns = {key: x.T if turn else x for key, x in columns.items()}
    assert_cube(read_results({"time": TIME, **columns}))
    assert_cube(read_results({"time": TIME, "maneuver": [1, 2, 3], **columns}))
    times = CUBE[:, :, 0].T if turn else CUBE[:, :, 0]
    assert_cube(read_results({"time": times, **columns}))
    first = {key: x[::-1] if not turn else x[:, ::-1] for key, x in columns.items()}
    assert_cube(read_results({"time": TIME, "maneuver": [3, 2, 1], **first}))
    some = {key: x[:2] if not turn else x[:, :2] for key, x in columns.items()}
    results = read_results({"time": TIME, "maneuver": [1, 3], **some})
    assert [rows.maneuver for rows in results.maneuvers] == [1, 3]


def test_a_time_beside_the_rest():
    assert_cube(read_results({"t": TIME, "y": wide()[:, 1:]}))
    assert_cube(read_results({"y": wide()[:, 1:].T, "t": TIME[:, None]}))
    assert_cube(read_results({"tout": TIME, "yout": wide()[:, 1:], "xout": wide()[:, 1:] + 1}))
    each = {f"m{m + 1}": CUBE[m, :, 1:] for m in range(3)}
    assert_cube(read_results({"tout": TIME, **each}))
    # An array that contains all columns takes precedence over an array without the time.
    assert_cube(read_results({"t": TIME, "states": wide()[:, 1:9] + 1, "results": wide()}))
    (rows,) = read_results({"t": TIME, "y": CUBE[1, :, 1:]}, maneuver=2).maneuvers
    assert rows.maneuver == 2
    assert np.array_equal(rows.values["steer_rate"], CUBE[1, :, 8])


def test_what_an_integrator_of_scipy_returns():
    found = solve_ivp(lambda t, y: -y, (0, 1), np.arange(1.0, 9.0), t_eval=np.linspace(0, 1, 7))
    (rows,) = read_results(found).maneuvers
    assert np.array_equal(rows.time, found.t)
    assert np.array_equal(rows.values["roll_angle"], found.y[0])


def long_rows(at, numbers=(1, 2, 3)):
    rows = [np.insert(row, at, m) for m, x in zip(numbers, CUBE, strict=True) for row in x]
    names = ["time", *KEYS]
    names.insert(at, "Maneuver")
    return names, np.array(rows)


@pytest.mark.parametrize("numbers", [(1, 2, 3), (0, 1, 2)])
@pytest.mark.parametrize("at", [0, 1, 5, 9])
def test_a_column_for_the_maneuver(at, numbers, tmp_path):
    names, rows = long_rows(at, numbers)
    path = tmp_path / "r.csv"
    np.savetxt(path, rows, "%.17g", delimiter=",", header=",".join(names), comments="")
    assert_cube(read_results(path))
    assert_cube(read_results(dict(zip(names, rows.T, strict=True))))
    np.savetxt(path, rows, "%.17g")
    assert_cube(read_results(path, columns=names))
    shuffled = np.random.default_rng(0).permutation(rows)
    assert_cube(read_results(dict(zip(names, shuffled.T, strict=True))), ("times_unsorted",))


@pytest.mark.parametrize("label", ["maneuver_{}", "m{}", '"Maneuver {}"', "M-{}", "T{}", "run {}"])
def test_a_column_of_names_of_maneuvers(label, tmp_path):
    names, rows = long_rows(0)
    lines = [",".join((label.format(int(r[0])), *(f"{x:.17g}" for x in r[1:]))) for r in rows]
    path = tmp_path / "r.csv"
    path.write_text("\n".join([",".join(names), *lines]))
    assert_cube(read_results(path))
    labels = [label.format(int(r[0])).strip('"') for r in rows]
    assert_cube(read_results(dict(zip(names, [labels, *rows.T[1:]], strict=True))))


def test_a_number_of_the_maneuver_beside_the_columns():
    columns = dict(zip(("time", *KEYS), CUBE[1].T, strict=True))
    (rows,) = read_results({"maneuver": 2, **columns}).maneuvers
    assert rows.maneuver == 2
    with pytest.raises(InputError, match="found maneuver 7, expected 1 to 3"):
        read_results({"maneuver": 7, **columns})


@pytest.mark.parametrize(
    ("value", "found"), [(4, "4"), (1.5, "1.5"), (np.nan, "no number"), (-1, "-1")]
)
def test_a_wrong_number_of_a_maneuver(value, found, tmp_path):
    names, rows = long_rows(0)
    rows[4, 0] = value
    fragment = f"found {found} in the column 'Maneuver', expected 1 to 3"
    with pytest.raises(InputError, match=f"row 5: {fragment}"):
        read_results(dict(zip(names, rows.T, strict=True)))
    path = tmp_path / "r.csv"
    np.savetxt(path, rows, "%.17g", delimiter=",", header=",".join(names), comments="")
    with pytest.raises(InputError, match=f"r.csv:6: {fragment}"):
        read_results(path)


@pytest.mark.parametrize("width", [8, 24])
def test_a_missing_time_is_guessed(width, tmp_path):
    table = np.ones((30, width)) * np.arange(30)[:, None]
    path = tmp_path / "r.txt"
    np.savetxt(path, table)
    for source in (path, table):
        with pytest.raises(InputError, match=rf"found {width} columns.*is the time missing\?"):
            read_results(source)


def test_a_text_on_its_side_is_turned(tmp_path):
    path = tmp_path / "r.txt"
    for separator in (" ", ",", ";"):
        np.savetxt(path, wide().T, "%.17g", delimiter=separator)
        assert_cube(read_results(path), ("transposed",))
    path.write_text(path.read_text().replace(".", ","))
    assert_cube(read_results(path), ("transposed",))
    # A transposed table is refused if its first row cannot be the time, or if it has neither 9 nor
    # 25 rows.
    table = wide().T
    table[0, 5] = -1
    for wrong in (table, wide().T[:24]):
        np.savetxt(path, wrong)
        with pytest.raises(InputError, match=f"found {ROWS} columns.*, expected 9 or 25"):
            read_results(path)


def test_shapes_that_mean_nothing():
    for shape in itertools.permutations((3, ROWS, 7)):
        with pytest.raises(InputError, match="found an array of shape"):
            read_results(np.zeros(shape))
