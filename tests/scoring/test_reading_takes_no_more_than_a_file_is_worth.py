"""Small files that claim to be large are refused at once; a long file is in memory only once."""

import io
import json
import os
import subprocess
import sys
import zipfile

import numpy as np
import pytest
from openpyxl import Workbook

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.source import read_results

# [bytes] limit of the memory for a row of three numbers. It is used for the values, the low part of
# the time, the line number, and one more column while they are combined. An earlier version needed
# 128 bytes.
MOST_OF_A_ROW = 100
MEASURED = """
import resource, sys
from heyoka_bike.scoring.reading.source import read_results
def most():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
read_results(sys.argv[1], maneuver=1)
few = most()
rows = len(read_results(sys.argv[2], maneuver=1).maneuvers[0].time)
print((most() - few) / rows)
"""


def sheet_with(row):
    """A good sheet with one more row, given as XML."""
    book, made = Workbook(), io.BytesIO()
    for values in (["time", "roll"], [0, 1.5], [1, 2.5]):
        book.active.append(values)
    book.save(made)
    changed = io.BytesIO()
    with zipfile.ZipFile(made) as old, zipfile.ZipFile(changed, "w", zipfile.ZIP_DEFLATED) as new:
        for name in old.namelist():
            data = old.read(name)
            if name.endswith("sheet1.xml"):
                data = data.replace(b"</sheetData>", row + b"</sheetData>")
            new.writestr(name, data)
    return changed.getvalue()


@pytest.mark.timeout(60)
@pytest.mark.parametrize(
    "row",
    [
        b'<row r="99999999999"><c r="A99999999999"><v>1</v></c></row>',
        b'<row r="1048577"><c r="A1048577"><v>1</v></c></row>',
        b'<row r="4"><c r="XFD4"><v>1</v></c></row>',
    ],
)
def test_a_cell_far_away_is_refused(row, tmp_path):
    path = tmp_path / "r.xlsx"
    path.write_bytes(sheet_with(row))
    with pytest.raises(InputError, match="found cells beyond row 1048576 or column 1000 in"):
        read_results(path)


def test_cells_that_are_empty_are_none(tmp_path):
    path = tmp_path / "r.xlsx"
    path.write_bytes(
        sheet_with(b'<row r="900"><c r="A900"><v>2</v></c><c r="B900"><v>3</v></c></row>')
    )
    assert read_results(path).maneuvers[0].time.tolist() == [0, 1, 2]


@pytest.mark.parametrize("blank", ["\n", " \t\r\n"])
def test_blank_lines_before_the_numbers(blank, tmp_path):
    count = (3 << 20) // len(blank)
    path = tmp_path / "r.txt"
    path.write_text(blank * count + "time roll\n0 1.5\n1 2.5\n", newline="")
    (rows,) = read_results(path).maneuvers
    assert rows.time.tolist() == [0, 1]
    path.write_text(blank * count + "time roll\n0 1.5\n1 x\n2 3.5\n", newline="")
    with pytest.raises(InputError, match="found 'x' as value 2") as caught:
        read_results(path)
    assert (caught.value.line, caught.value.column) == (count + 3, 2)


@pytest.mark.parametrize(
    "document",
    [
        lambda: {f"k{i}": [1, 2] for i in range(110_000)},
        lambda: [[f"k{i}" for i in range(110_000)], [1] * 110_000],
        lambda: [["k"] * 110_000, [1] * 110_000],
    ],
    ids=["object", "heading", "equal"],
)
@pytest.mark.timeout(60)
def test_names_beyond_number_are_refused(document, tmp_path):
    path = tmp_path / "r.json"
    path.write_text(json.dumps(document()))
    with pytest.raises(InputError, match="arrays and groups, expected at most 100000"):
        read_results(path)


@pytest.mark.proof
def test_a_long_text_is_in_memory_once(tmp_path):
    """The second file is measured, so the memory for imports and the first file is not counted."""
    path, few = tmp_path / "r.txt", tmp_path / "few.txt"
    i = np.arange(2_000_000)
    lines = [f"{a / 1e6:.6f} {b / 1e5:.5f} {c / 1e6:.6f}\n"
             for a, b, c in zip(i, i * 37 % 1001, i * 31 % 997, strict=True)]  # fmt: skip
    path.write_text("time roll steer\n" + "".join(lines))
    few.write_text("time roll steer\n" + "".join(lines[:200_000]))
    run = subprocess.run(
        [sys.executable, "-c", MEASURED, few, path], env=os.environ, text=True,
        capture_output=True, check=True, timeout=120,
    )  # fmt: skip
    assert float(run.stdout) < MOST_OF_A_ROW


def calls_of(path):
    """Count the function calls for reading a file, even if it is rejected."""
    count = 0

    def note(frame, event, _):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(note)
    try:
        read_results(path)
    except InputError:
        pass
    finally:
        sys.setprofile(None)
    return count


ROW = " ".join(map(str, range(9))) + "\n"


@pytest.mark.parametrize(
    ("line", "end"),
    [
        ("time roll steer\n", ""), ("# time roll\n", ROW), ("\n", ""), ("\n", ROW), ("\r", ""),
        (" \t\n", ROW), ("name ", "\n" + ROW), ("name,", "\n" + ROW), (",", ""), ('"', ""),
        ("[", ""), ("\t", ROW), ("word\n", ROW),
    ],
)  # fmt: skip
def test_lines_that_are_no_rows_cost_no_more_than_rows(line, end, tmp_path):
    """A further line takes at most twenty calls; a heading used to take hundreds."""
    path, count = tmp_path / "r.txt", 100_000
    calls = []
    for n in (count, 2 * count):
        path.write_text(line * n + end, newline="")
        calls.append(calls_of(path))
    assert calls[1] - calls[0] <= 20 * count


def test_a_heading_is_found_below_a_long_preface(tmp_path):
    path = tmp_path / "r.txt"
    path.write_text("# a word of the log\n" * 20_000 + "time roll\n0 1.5\n1 2.5\n")
    (rows,) = read_results(path).maneuvers
    assert rows.time.tolist() == [0, 1]
    path.write_text("words of a log, no names\n" * 9_000 + "time roll\n0 1.5\n1 2.5\n")
    assert read_results(path).maneuvers[0].time.tolist() == [0, 1]
    path.write_text("words of a log, no names\n" * 11_000 + "time roll\n0 1.5\n1 2.5\n")
    with pytest.raises(InputError, match="no row of numbers in the first 10000 lines"):
        read_results(path)


@pytest.mark.timeout(60)
def test_blanks_within_a_heading_are_passed_once(tmp_path):
    """A search that restarts at every blank would take minutes."""
    path = tmp_path / "r.txt"
    path.write_text(f"time{' ' * 300_000}roll\n0 1.5\n1 2.5\n")
    assert read_results(path).maneuvers[0].time.tolist() == [0, 1]
