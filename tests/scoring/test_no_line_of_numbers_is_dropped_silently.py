"""A line with numbers is read, quoted with its line number, or rejected with an error.

Headings and comments that contain a number are not reported.
"""

from itertools import groupby

import numpy as np
import pytest

from generators.published_columns import published_table
from heyoka_bike import read_results, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.errors import InputError
from heyoka_bike.scoring.evidence.as_read import LinesNotRead


@pytest.fixture
def table(reference):
    """Every fifth row of maneuver 2: the time and the eight columns."""
    return published_table(reference, (2,), every=5)


def lines_of(table, separator=" ", form="%.15g"):
    return [separator.join(form % x for x in row) for row in table]


@pytest.fixture
def results(tmp_path):
    def read(lines):
        path = tmp_path / "mine.txt"
        path.write_text("\n".join(lines) + "\n")
        return read_results(path, maneuver=2)

    return read


def skipped(results):
    """Return the quoted lines by their number."""
    found = [x for x in results.seen if isinstance(x, LinesNotRead)]
    return {number: text for x in found for number, text in x.first}


def values(results):
    (rows,) = results.maneuvers
    return np.column_stack([rows.time, *(rows.values[key] for key in KEYS)])


def repeated(row):
    """A row as list-directed output writes it: equal neighbours as a count and a value."""
    counts = ((field, len([*same])) for field, same in groupby(row))
    return ", ".join(f"{n}*{field}" if n > 1 else field for field, n in counts)


def test_repeat_counts_are_expanded_in_any_row(results, table):
    rows = [[f"{x:.15g}" for x in row] for row in table]
    rows[40][1:3] = ["0.25", "0.25"]
    lines = [repeated(row) for row in rows]
    assert lines[0].startswith("2*0,")
    assert "2*0.25" in lines[40]
    found = results(lines)
    assert np.array_equal(values(found), np.array(rows, dtype=float))
    assert not skipped(found)


@pytest.mark.parametrize("line", [0, 40])
def test_a_null_value_is_refused(results, table, line):
    lines = lines_of(table, ", ")
    lines[line] = "2*, " + lines[line].split(", ", 2)[2]
    with pytest.raises(InputError, match=rf":{line + 1}:1: found '2\*' as value 1, expected a"):
        results(lines)


def test_counts_that_make_too_much_of_a_few_bytes_are_refused(results):
    with pytest.raises(InputError, match=r"999\*0"):
        results([" ".join(["999*0"] * 9)] * 50)


@pytest.mark.parametrize(("form", "power", "digits"), [("%.15f", 3, 1e-12), ("%.4f", 2, 0.005001)])
def test_the_common_factor_of_matlab_is_applied(results, table, form, power, digits):
    lines = ["m2 =", "", f"   1.0e+{power:02d} *", "", *lines_of(table / 10**power, "   ", form)]
    found = results(lines)
    assert np.abs(values(found) - table).max() <= digits
    # The resolution is one unit of the last decimal place, times the conversion factor.
    (rows,) = found.maneuvers
    quantum = rows.quantum["roll_angle"].at(rows.values["roll_angle"])
    assert quantum == pytest.approx(10.0 ** (power - len(form % 0) + 2))
    (said,) = [f for f in found.findings if f.code == "common_factor"]
    assert f"multiplied by 1e{power}" in said.message
    assert not skipped(found)


def test_times_with_a_factor_are_exact_decimals(results, table):
    lines = ["   1.0e+03 *", *lines_of(table / 1e3, "   ", "%.15f")]
    (rows,) = results(lines).maneuvers
    i = np.arange(len(table))
    assert np.array_equal(rows.time, i * 5 / 100)


def displayed(table, width, ends=("through", "Columns %d %s %d", "Column %d")):
    """Return the lines of a matrix that is printed in blocks of `width` columns."""
    word, several, one = ends
    lines = []
    for first in range(0, table.shape[1], width):
        part = table[:, first : first + width]
        names = (first + 1, word, first + part.shape[1])
        lines += ["", " " + (several % names if part.shape[1] > 1 else one % names[0]), ""]
        lines += lines_of(part, "   ")
    return lines


@pytest.mark.parametrize("width", [2, 4, 8])
@pytest.mark.parametrize(
    "ends",
    [("through", "Columns %d %s %d", "Column %d"), ("to", "Columns %d %s %d:", "Column %d:")],
)
def test_blocks_of_columns_are_put_side_by_side(results, table, width, ends):
    found = results(["m2 =", *displayed(table, width, ends)])
    assert np.abs(values(found) - table).max() <= 1e-11
    assert found.maneuvers[0].quantum
    assert not skipped(found)


def test_a_block_of_columns_with_a_row_less_is_refused(results, table):
    lines = displayed(table, 4)
    del lines[-1]
    with pytest.raises(InputError, match="found 200 rows below 'Column 9', expected 201 as below"):
        results(lines)


def test_a_block_of_columns_that_is_missing_is_refused(results, table):
    lines = displayed(table, 4)
    at = lines.index(" Columns 5 through 8")
    del lines[at : lines.index(" Column 9")]
    with pytest.raises(InputError, match="found 'Column 9', expected a block of columns from 5"):
        results(lines)


UNREAD = {
    "the size of the table": ("201 9", 0),
    "half a row before the rows": ("0.5 0.1, 0.2", 0),
    "a row in the separators of another program": ("0;0;0.5;4.6;794.1195;1042.9;1837.0;0;0", 0),
    "a row made a comment": ("# 0.5 0 0 0 0 0 0 0 0", 50),
    "a row made a comment behind the rows": ("% 0.5 0 0 0 0 0 0 0 0", 201),
}


@pytest.mark.parametrize("what", UNREAD)
def test_a_line_of_numbers_that_is_not_read_is_quoted(results, table, what):
    line, at = UNREAD[what]
    lines = lines_of(table)
    lines.insert(at, line)
    found = results(lines)
    assert skipped(found) == {at + 1: line}
    (said,) = [f for f in found.findings if f.code == "lines_not_read"]
    assert said.severity == "warning"
    assert f"line {at + 1}: '{line[:10]}" in said.message


def test_many_lines_are_counted(results, table):
    lines = [x for line in lines_of(table) for x in (line, f"# {line}")]
    found = results(lines)
    assert list(skipped(found)) == [2, 4, 6]
    (said,) = [f for f in found.findings if f.code == "lines_not_read"]
    assert said.evidence["count"] == 201
    assert "and 198 more" in said.message


HEADING = " ".join(["time", *KEYS])
QUIET = {
    "a parameter": ["# dt = 0.01"],
    "two parameters": ["# dt 0.01 t_end 10"],
    "some values of a start": ["# start: 0 0.5 4.6"],
    "a day": ["# 2024-01-05 12:00:00", "2024-01-05 12:00:00"],
    "a version": ["MBDyn 1.7.3", "(c) 2024"],
    "a title": ["maneuver 2, 0.01 s, 10 s"],
    "names and units": [HEADING, "s rad rad/s m/s J J J rad rad/s"],
    "units that are 1": [HEADING, "s rad 1 1 J J J rad 1"],
    "names": [HEADING.replace("roll_angle", "m2_roll_angle")],
    "columns that are counted": ["1 2 3 4 5 6 7 8 9"],
}


@pytest.mark.parametrize("what", QUIET)
def test_headings_and_comments_are_reported_to_nobody(results, table, what):
    assert not skipped(results([*QUIET[what], *lines_of(table)]))


def test_the_numbers_of_maneuvers_above_names_are_read(table, tmp_path):
    """Names in several lines, as pandas writes column levels."""
    path = tmp_path / "mine.txt"
    wide = np.column_stack([table, table[:, 1:], table[:, 1:]])
    above = ["".join(["maneuver", *(f",{n}" * 8 for n in (1, 2, 3))])]
    above += [",".join(HEADING.split() + HEADING.split()[1:] * 2)]
    path.write_text("\n".join([*above, *lines_of(wide, ",")]) + "\n")
    found = read_results(path)
    assert [rows.maneuver for rows in found.maneuvers] == [1, 2, 3]
    assert not skipped(found)


def test_a_requirement_tells_the_line(table, tmp_path):
    path = tmp_path / "mine.txt"
    path.write_text("\n".join(["201 9", *lines_of(table)]) + "\n")
    report = score(path, maneuver=2)
    assert any("line 1: '201 9'" in finding.message for finding in report.findings)


def test_exponents_of_mathematica_are_read(results, table):
    lines = [line.replace("e", "*^") for line in lines_of(table, "\t")]
    assert any("*^-" in line for line in lines)
    assert np.array_equal(values(results(lines)), values(results(lines_of(table, "\t"))))
