"""Clocks that add up steps end late: a row just beyond the end is compared, a row far beyond is
not.

A wrong last row at 10.0000001 s was once left out, and the file was called correct.
"""

import numpy as np
import pytest

from generators.made_results import made
from generators.published_columns import published_table
from heyoka_bike import score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.numbers.chebyshev import argument, clenshaw, locate
from heyoka_bike.scoring.evidence.as_compared import RowsOutside
from heyoka_bike.scoring.reading.results import Results, Rows

DIGITS = 24
"""Correct digits of a segment just beyond its end, compared with 31 within it."""


@pytest.mark.parametrize("number", [1, 2, 3])
def test_a_piece_tells_the_motion_a_hundredth_beyond_its_end(reference, number):
    """Just beyond its end, a segment agrees with the proved next segment."""
    m = reference[number]
    breaks = m.breaks
    lengths = np.diff(breaks)
    # Choose segments that are no longer than the segment after them. The proof of that next segment
    # covers the point just beyond the end.
    at = np.flatnonzero(lengths[:-1] <= lengths[1:])
    t = breaks[at + 1] + lengths[at] / 100
    exact, zero = (t, np.zeros_like(t)), np.zeros_like(t)
    assert (locate(breaks, exact) == at + 1).all()
    c = [np.stack([getattr(m.dense, part)[k] for k in BENCHMARK_COLUMNS]) for part in ("hi", "lo")]
    right = clenshaw(*c, at + 1, argument(breaks, at + 1, (t, zero)))
    found = clenshaw(*c, at, argument(breaks, at, (t, zero)))
    for k, key in enumerate(BENCHMARK_COLUMNS):
        apart = np.abs((found[0][k] - right[0][k]) + (found[1][k] - right[1][k]))
        assert apart.max() < 10.0**-DIGITS * m.scale(key), key
    assert m.reach == pytest.approx(10 + lengths[-1] / 100, rel=1e-15)


def late(reference, by):
    """The whole run; its last row is late by `by` [s]."""
    parts = []
    for rows in made(reference).maneuvers:
        time = rows.time.copy()
        time[-1] += by
        parts.append(Rows(rows.maneuver, time, np.zeros_like(time), rows.values, {}, rows.quantum))
    return Results("late.txt", "text", tuple(parts), 16)


@pytest.mark.parametrize("by", [1e-12, 1e-7, 1e-4, 1e-3])
def test_a_wrong_last_row_is_wrong(reference, by):
    results = late(reference, by)
    for rows in results.maneuvers:
        for values in rows.values.values():
            values[-1] *= 0.99
    report = score(results, reference)
    assert not report.is_right
    assert ": wrong" in report.verdict


def test_a_right_last_row_is_right(reference):
    """The last row is that of the motion at the written time, to first order in the delay."""
    by = 1e-6
    results = late(reference, by)
    for rows in results.maneuvers:
        for key, values in rows.values.items():
            a, b, c = reference[rows.maneuver][key][-3:]
            values[-1] += by * (3 * c - 4 * b + a) / 0.02
    report = score(results, reference)
    assert report.is_right
    assert all(m.rows == 1001 and m.coverage == 1 for m in report.maneuvers)


def test_what_is_farther_on_is_left_out_and_told(reference):
    report = score(late(reference, 0.01), reference)
    (outside,) = {x for x in report.seen if isinstance(x, RowsOutside)}
    assert outside.rows == 1
    assert report.is_right
    assert [m.rows for m in report.maneuvers] == [1000, 1000, 1000]


def test_the_digits_that_differ_are_said(reference, tmp_path):
    path = tmp_path / "r.txt"
    table = published_table(reference, (2,))
    table[-1, 0] = 10.0051
    np.savetxt(path, table, "%.17g")
    (said,) = [f.message for f in score(path, maneuver=2).findings if f.code == "time_outside"]
    assert "10.0051" in said
    assert said.startswith("1 row at ")
