"""A row of a spreadsheet means the same as a row of text, and its cells contain the numbers."""

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.evidence.as_read import LastRowIncomplete
from heyoka_bike.scoring.reading.source import read_results

openpyxl = pytest.importorskip("openpyxl")

NAMES = ["time", *BENCHMARK_COLUMNS]
UNITS = ["s", "rad", "rad/s", "m/s", "J", "J", "J", "rad", "rad/s"]
COUNTING = [*range(1, 10)]
# openpyxl writes 16 digits, so values with 15 digits are used.
VALUES = [
    [i / 100, *(float(f"{x:.15g}") for x in np.random.default_rng(i).uniform(-1, 1, 8))]
    for i in range(20)
]


def words(decimal="."):
    return [[repr(x).replace(".", decimal) for x in row] for row in VALUES]


def mixed():
    """Rows in which every third number is a text with a decimal comma."""
    rows = zip(VALUES, words(","), strict=True)
    return [
        [w if j % 3 == 1 else x for j, (x, w) in enumerate(zip(*row, strict=True))] for row in rows
    ]


SHEETS = {
    "plain": VALUES,
    "heading": [NAMES, *VALUES],
    "heading and units": [NAMES, UNITS, *VALUES],
    "commented heading": [["# time", *NAMES[1:]], *VALUES],
    "counted columns": [COUNTING, *VALUES],
    "counted columns below a heading": [NAMES, COUNTING, *VALUES],
    "counted from zero": [[*range(9)], *VALUES],
    "comments": [["# made by a program"], *VALUES[:5], ["% 5 rows"], *VALUES[5:]],
    "comments beside rows": [[*VALUES[0], "# the start"], *VALUES[1:]],
    "blank rows": [[], [], NAMES, [], *VALUES[:3], [], *VALUES[3:]],
    "an empty column": [[None, *row] for row in VALUES],
    "numbers as words": [NAMES, *words()],
    "decimal commas": [NAMES, *words(",")],
    "decimal commas among numbers": [NAMES, *mixed()],
    "lines in one column": [[",".join(row)] for row in [NAMES, *words()]],
    "lines with decimal commas": [[";".join(row)] for row in [NAMES, *words(",")]],
    "a column of words": [[*NAMES, "phase"], *([*row, "free"] for row in VALUES)],
    "a column of words, decimal commas": [[*NAMES, "phase"], *([*r, "free"] for r in words(","))],
    "a column of words, comments": [["# a"], [*NAMES, "phase"], *([*r, "free"] for r in VALUES)],
}  # fmt: skip


def saved(path, rows):
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    book.save(path)
    return path


def assert_values(results, expected=VALUES):
    (rows,) = results.maneuvers
    assert rows.time.tolist() == [row[0] for row in expected]
    for j, key in enumerate(BENCHMARK_COLUMNS, 1):
        assert rows.values[key].tolist() == [row[j] for row in expected], key


@pytest.mark.parametrize("way", SHEETS)
def test_rows_of_a_sheet(way, tmp_path):
    assert_values(read_results(saved(tmp_path / "r.xlsx", SHEETS[way]), maneuver=1))


@pytest.mark.parametrize("rows", [VALUES, words(","), [[",".join(x)] for x in words()]])
def test_a_last_row_that_is_incomplete_is_told(rows, tmp_path):
    cut = [*rows[:-1], rows[-1][:4] if len(rows[-1]) > 1 else [rows[-1][0][:30]]]
    results = read_results(saved(tmp_path / "r.xlsx", cut), maneuver=1)
    assert_values(results, VALUES[:-1])
    assert LastRowIncomplete(20) in [x for x in results.seen if isinstance(x, LastRowIncomplete)]


@pytest.mark.parametrize(
    ("row", "fragment"),
    [
        ([0.05, *[None] * 7, 1.0], "found an empty cell as value 2, expected a number"),
        ([0.05, "n/a", *[1.0] * 7], "found 'n/a' as value 2, expected a number"),
        ([0.05, "0.1.2", *[1.0] * 7], "found '0.1.2' as value 2, expected a number"),
        ([0.05, True, *[1.0] * 7], "found 'True' as value 2, expected a number"),
        ([0.05, 1.0], "found 2 values, expected 9"),
    ],
)
def test_another_row_is_refused_where_it_is(row, fragment, tmp_path):
    with pytest.raises(InputError) as caught:
        read_results(saved(tmp_path / "r.xlsx", [NAMES, *VALUES[:5], row, *VALUES[6:]]), maneuver=1)
    assert fragment in str(caught.value)
    assert caught.value.line == 7


@pytest.mark.parametrize("separator", [",", ";"])
@pytest.mark.parametrize("length", [1, 40_000])
def test_a_text_with_words_may_be_long(separator, length, tmp_path):
    rows = words("," if separator == ";" else ".")
    lines = [[*NAMES, "phase"], *([*row, "free" * length] for row in rows)]
    path = tmp_path / "r.csv"
    path.write_text("".join(separator.join(line) + "\n" for line in lines))
    assert_values(read_results(path, maneuver=1))


@pytest.mark.parametrize("count", [2, 8, 10])
@pytest.mark.parametrize("kind", ["csv", "xlsx"])
def test_as_many_columns_are_told_as_there_are(kind, count, tmp_path):
    path = tmp_path / f"r.{kind}"
    if kind == "csv":
        path.write_text("".join(",".join(map(str, row)) + "\n" for row in [NAMES, *VALUES]))
    else:
        saved(path, [NAMES, *VALUES])
    with pytest.raises(InputError, match=f"found 9 columns, expected {count} columns as"):
        read_results(path, maneuver=1, columns=[*NAMES, "-"][:count])
