"""Every way of writing the same rows gives the same numbers."""

import codecs
import gzip
import io
import re
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.scoring.reading import result_file
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.reading.text import rows as text_rows

NAMES = ("time", *(f"m{m}_{key}" for m in (1, 2, 3) for key in BENCHMARK_COLUMNS))


@pytest.fixture(scope="module")
def rows(folder):
    """Rows of the published text, with both signs, zeros and exponents."""
    lines = (folder / "uncontrolled-bicycle.txt").read_text().splitlines()
    return [line.split() for line in (*lines[:5], *lines[95:100], lines[1000])]


def text(rows, separator=" ", end="\n"):
    return "".join(separator.join(row) + end for row in rows)


def changed(rows, change):
    return [[change(number) for number in row] for row in rows]


def parts(number):
    """Mantissa and exponent of a number; times have few digits."""
    digits = 16 if len(number) > 5 else 9
    mantissa, _, power = f"{float(number):.{digits}e}".partition("e")
    return mantissa, int(power)


def fortran(number):
    """A number as Fortran writes double precision: 0.1D+01."""
    mantissa, power = parts(number)
    return f"{mantissa}D{power:+03d}"


def long_exponent(number):
    """A number with a three-digit exponent and no letter, as Fortran writes very small values."""
    mantissa, power = parts(number)
    return f"{mantissa}{power:+04d}"


def heading(line):
    return lambda rows: f"{line}\n{text(rows)}".encode()


WAYS = {
    "blanks": lambda rows: text(rows).encode(),
    "many blanks": lambda rows: text(rows, "    ", "  \n").replace("\n", "\n   ").encode(),
    "tabs": lambda rows: text(rows, "\t").encode(),
    "tabs and blanks": lambda rows: text(rows, " \t ").encode(),
    "two tabs": lambda rows: text(rows, "\t\t").encode(),
    "commas": lambda rows: text(rows, ",").encode(),
    "commas and blanks": lambda rows: text(rows, ", ").encode(),
    "blanks and commas": lambda rows: text(rows, "  , ").encode(),
    "semicolons": lambda rows: text(rows, ";").encode(),
    "blanks and semicolons": lambda rows: text(rows, " ; ").encode(),
    "decimal commas, semicolons": lambda rows: text(rows, ";").replace(".", ",").encode(),
    "decimal commas, tabs": lambda rows: text(rows, "\t").replace(".", ",").encode(),
    "decimal commas, blanks": lambda rows: text(rows, "  ").replace(".", ",").encode(),
    "separator at the end": lambda rows: text(rows, ",", ",\n").encode(),
    "separator and blank at the end": lambda rows: text(rows, ";", " ; \n").encode(),
    "tab at the end": lambda rows: text(rows, "\t", "\t\n").encode(),
    "no line feed at the end": lambda rows: text(rows).rstrip().encode(),
    "blank lines": lambda rows: ("\n\n" + text(rows, end="\n \t\n\n")).encode(),
    "lines of separators at the end": lambda rows: (text(rows, ";") + ";" * 24 + "\n").encode(),
    "capital E": lambda rows: text(rows).upper().encode(),
    "D": lambda rows: text(changed(rows, fortran), "  ").encode(),
    "small d": lambda rows: text(changed(rows, fortran)).lower().encode(),
    "Q": lambda rows: text(changed(rows, fortran)).replace("D", "q").encode(),
    "exponents without a letter": lambda rows: text(changed(rows, long_exponent)).encode(),
    "plus signs": lambda rows: text(
        changed(rows, lambda x: x if x[0] == "-" else f"+{x}")).encode(),
    "no zero before the point": lambda rows: re.sub(r"(?<![0-9])0\.", ".", text(rows)).encode(),
    "nothing after the point": lambda rows: re.sub(r"(?<!\S)([0-9]+)(?!\S)", r"\1.",
                                                   text(rows)).encode(),
    "a heading": heading("bicycle benchmark: results of my program"),
    "headings and units": heading("My program 3.1\n\n=====\n(s) [rad] rad/s\n--- ---"),
    "a long heading": heading("This program comes without any warranty.\n" * 1000),
    "a few numbers above": heading("25 11\nstep 0.01 of 10 s\n3 maneuvers"),
    "numbered columns": heading(" ".join(str(i) for i in range(1, 26))),
    "columns numbered from zero": heading(" ".join(str(i) for i in range(25))),
    "names": heading(" ".join(NAMES)),
    "names in a comment": heading("# " + " ".join(NAMES)),
    "comments": lambda rows: ("# a\n% b, 1 2\n! c\n// d\n  # 1 2 3 4 5\n"
                              + text(rows, end="\n# x\n") + "# the end").encode(),
    "comments after rows": lambda rows: (
        text(rows[:2], end="# 1 2\n") + text(rows[2:4], end=" % x\n")
        + text(rows[4:6], end="\t! x\n") + text(rows[6:], end=" //\n")).encode(),
    "Octave": heading("# Created by Octave\n# name: x\n# type: matrix\n# rows: 11\n# columns: 25"),
    "quotes": lambda rows: text(changed(rows, lambda x: f'"{x}"'), ",").encode(),
    "single quotes": lambda rows: text(changed(rows, lambda x: f"'{x}'"), " ").encode(),
    "some quotes": lambda rows: text([['"0.01"', *row[1:]] if row[0] == "0.01" else row
                                      for row in rows], ";").encode(),
    "quotes and decimal commas": lambda rows: text(
        changed(rows, lambda x: f'"{x}"'.replace(".", ",")), ",").encode(),
    "minus sign": lambda rows: text(rows).replace("-", "\u2212").encode(),
    "no-break spaces": lambda rows: text(rows, "\xa0").encode(),
    "BOM": lambda rows: codecs.BOM_UTF8 + text(rows).encode(),
    "BOM and names": lambda rows: codecs.BOM_UTF8 + heading(" ".join(NAMES))(rows),
    "UTF-16": lambda rows: text(rows).encode("utf-16"),
    "UTF-16, big end first": lambda rows: codecs.BOM_UTF16_BE + text(rows).encode("utf-16-be"),
    "UTF-16 without BOM": lambda rows: text(rows).encode("utf-16-le"),
    "UTF-16 without BOM, big end": lambda rows: text(rows).encode("utf-16-be"),
    "UTF-32": lambda rows: text(rows).encode("utf-32"),
    "latin-1": lambda rows: "Neigung °, Gerät Ä\n".encode("latin-1") + text(rows).encode(),
    "CRLF": lambda rows: text(rows, end="\r\n").encode(),
    "CR": lambda rows: text(rows, end="\r").encode(),
    "CR CR LF": lambda rows: text(rows, end="\r\r\n").encode(),
    "UTF-16 and CRLF": lambda rows: text(rows, end="\r\n").encode("utf-16"),
    "gzip": lambda rows: gzip.compress(text(rows).encode()),
    "gzip in two parts": lambda rows: (gzip.compress(text(rows[:5]).encode())
                                       + gzip.compress(text(rows[5:]).encode())),
}  # fmt: skip


def assert_same(results, rows):
    """Check that the results are exactly the numbers of the rows."""
    assert [r.maneuver for r in results.maneuvers] == [1, 2, 3]
    for m, r in enumerate(results.maneuvers):
        exact = [Fraction(row[0]) for row in rows]
        assert r.time.tolist() == [float(t) for t in exact]
        assert r.time_lo.tolist() == [float(t - Fraction(float(t))) for t in exact]
        assert list(r.values) == list(BENCHMARK_COLUMNS)
        for k, values in enumerate(r.values.values()):
            assert values.tolist() == [float(row[1 + 8 * m + k]) for row in rows]
        assert r.time is results.maneuvers[0].time
        assert not r.lo


@pytest.mark.parametrize("reader", ["quick", "careful"])
@pytest.mark.parametrize("way", WAYS)
def test_the_same_rows(way, reader, rows, tmp_path, monkeypatch):
    if reader == "careful":
        monkeypatch.setattr(text_rows, "parse_block", lambda *_: None)
    path = tmp_path / "results.xlsx"
    path.write_bytes(WAYS[way](rows))
    results = read_results(path)
    assert_same(results, rows)
    assert results.path == str(path)
    assert results.format == "text"
    # Two numbers alone in a line may be an interrupted row, so the line is reported as not read.
    said = ["lines_not_read"] if way == "a few numbers above" else []
    assert [f.code for f in results.findings] == said
    assert results.significant_digits == 17


@pytest.mark.parametrize("way", ["CRLF", "CR", "blank lines", "comments", "UTF-16", "gzip", "D"])
@pytest.mark.parametrize("size", [1, 7, 500, 1201])
def test_blocks_may_end_anywhere(way, size, rows, tmp_path, monkeypatch):
    monkeypatch.setattr(result_file, "_BYTES_AT_ONCE", size)
    monkeypatch.setattr(result_file, "_BYTES_OF_HEAD", 600)
    path = tmp_path / "x"
    path.write_bytes(WAYS[way](rows))
    assert_same(read_results(path), rows)


QUICK = set(WAYS) - {
    "exponents without a letter", "quotes and decimal commas", "lines of separators at the end",
    "comments", "comments after rows", "many blanks",  # these files end in lines without numbers
    "quotes", "single quotes", "some quotes", "minus sign", "no-break spaces",
}  # fmt: skip


@pytest.mark.parametrize("way", sorted(QUICK))
def test_the_quick_reader_takes_plain_numbers(way, rows, tmp_path, monkeypatch):
    def refuse(*_):
        pytest.fail("read line by line")

    monkeypatch.setattr(text_rows.RowReader, "_line_by_line", refuse)
    path = tmp_path / "x"
    path.write_bytes(WAYS[way](rows))
    assert_same(read_results(path), rows)


@pytest.mark.parametrize("way", ["blanks", "gzip", "UTF-16", "CR"])
def test_standard_input(way, rows, monkeypatch):
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(WAYS[way](rows))))
    results = read_results("-")
    assert_same(results, rows)
    assert results.path == "-"


def test_a_pipe(rows, tmp_path):
    code = "from heyoka_bike import read_results; print(read_results('/dev/stdin'))"
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], input=text(rows).encode(),
        capture_output=True, timeout=60,
    )  # fmt: skip
    assert b"maneuver 3: 11 rows" in run.stdout, run.stderr


def test_the_published_text(folder):
    results = read_results(folder / "uncontrolled-bicycle.txt")
    table = np.loadtxt(folder / "uncontrolled-bicycle.txt")
    assert results.findings == ()
    assert results.significant_digits == 17
    for m, rows in enumerate(results.maneuvers):
        assert not rows.lo
        for k, (key, values) in enumerate(rows.values.items()):
            assert np.array_equal(values, table[:, 1 + 8 * m + k])
            assert (rows.quantum[key].base, rows.quantum[key].digits) == (2, 53)


@pytest.mark.parametrize("name", ["uncontrolled-bicycle-50digits.txt", "uncontrolled-bicycle.h5"])
def test_the_published_digits_beyond_binary64(name, folder, reference):
    results = read_results(folder / name)
    assert results.findings == ()
    assert results.significant_digits == (50 if name.endswith("txt") else 31)
    for m, rows in enumerate(results.maneuvers, start=1):
        assert np.array_equal(rows.time, reference[m].time)
        assert np.array_equal(rows.time_lo, reference[m].time_lo)
        # The additional columns of uncontrolled-bicycle.h5 are the same quantities in different
        # definitions.
        keys = {c.key for c in COLUMNS} if name.endswith("h5") else set(BENCHMARK_COLUMNS)
        assert set(rows.values) == set(rows.lo) == keys
        for key in keys:
            assert np.array_equal(rows.values[key], reference[m].rows.hi[key])
            assert np.array_equal(rows.lo[key], reference[m].rows.lo[key])


NOT_FINITE = ["nan", "NaN", "-nan", "NAN", "nan(ind)", "-nan(ind)", "NaN(123)",
              "inf", "-Inf", "+INF", "Infinity", "-infinity",
              "1.#IND", "-1.#IND00", "1.#INF", "-1.#INF00", "1.#QNAN", "1.#QNAN0",
              "1.#SNAN", "1e999", "-2.5D+400"]  # fmt: skip


@pytest.mark.parametrize("reader", ["quick", "careful"])
@pytest.mark.parametrize("separator", [" ", ",", ";", "\t"])
@pytest.mark.parametrize("token", NOT_FINITE)
def test_values_that_are_not_finite(token, separator, reader, rows, tmp_path, monkeypatch):
    if reader == "careful":
        monkeypatch.setattr(text_rows, "parse_block", lambda *_: None)
    bad = [list(row) for row in rows]
    bad[4][3] = bad[4][5] = bad[7][24] = token
    path = tmp_path / "x"
    path.write_text("# one line\n" + text(bad, separator))
    results = read_results(path)
    assert np.isnan(results.maneuvers[0].values["forward_speed"][4])
    assert np.isnan(results.maneuvers[0].values["kinetic_energy"][4])
    assert np.isnan(results.maneuvers[2].values["steer_rate"][7])
    assert sum(np.isnan(v).sum() for m in results.maneuvers for v in m.values.values()) == 3
    assert not any(np.isinf(v).any() for m in results.maneuvers for v in m.values.values())
    (finding,) = results.findings
    assert (finding.code, finding.severity) == ("not_finite", "warning")
    assert finding.evidence == {"count": 3, "line": 6, "column": 4}
    assert "line 6, column 4" in finding.message


@pytest.mark.parametrize(
    "end", ["0.1", "0.1 0.2", "0.1 0.2 1.5e-", "0.1 0.2 -", "0.1 0.2 3.", "0.1 0.2\n", "0.1\r\n",
            " ".join(["0.1"] * 24) + " 2.5e-", " ".join(["0.1"] * 24)],
)  # fmt: skip
def test_a_last_row_that_is_cut(end, rows, tmp_path):
    path = tmp_path / "x"
    path.write_text(text(rows) + end)
    results = read_results(path)
    assert_same(results, rows)
    (finding,) = results.findings
    assert (finding.code, finding.severity) == ("last_row_incomplete", "warning")
    assert finding.evidence == {"line": 12}


def test_rows_after_blocks_of_another_kind(rows, tmp_path, monkeypatch):
    """One odd block changes neither the values of the other blocks nor the line numbers."""
    monkeypatch.setattr(result_file, "_BYTES_AT_ONCE", 1000)
    many = [[f"{i}", *rows[i % 11][1:]] for i in range(200)]
    many[150][7] = "nan"
    lines = text(many).splitlines(keepends=True)
    lines[50] = lines[50].replace("\n", "  # remark\n")
    lines.insert(100, "\n# a comment\n")
    path = tmp_path / "x"
    path.write_text("".join(lines))
    results = read_results(path)
    assert results.maneuvers[0].time.tolist() == list(range(200))
    for m, r in enumerate(results.maneuvers):
        for k, values in enumerate(r.values.values()):
            expected = [float(row[1 + 8 * m + k]) for row in many]
            assert np.array_equal(values, expected, equal_nan=True)
    (finding,) = results.findings
    assert finding.evidence == {"count": 1, "line": 153, "column": 8}


def test_reading_imports_nothing_heavy():
    code = """
import sys
import heyoka_bike.scoring.reading.source
print(sorted({m.partition(".")[0] for m in sys.modules} & {"scipy", "h5py", "gzip"}))
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert run.stdout.strip() == "[]", run.stderr
