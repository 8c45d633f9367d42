"""A column score states the size of its error, and whether rounding to the digits written explains
it.

The test rounds the values itself, so it knows half a unit of the last digit independently of the
program.
"""

from dataclasses import replace

import numpy as np
import pytest

from heyoka_bike import score
from heyoka_bike.scoring.measures import measures

PLACES = 3
HALF_DIGIT = 10.0**-PLACES / 2


@pytest.fixture(scope="module")
def written(reference, tmp_path_factory):
    """Return a function that scores rounded roll angles; row 5 is wrong by `off` units of the last
    digit."""

    def result(off):
        m = reference[2]
        roll = np.round(m["roll_angle"], PLACES)
        roll[5] += off * 10.0**-PLACES
        path = tmp_path_factory.mktemp("few") / "result.csv"
        rows = zip(m.time, roll, strict=True)
        lines = ["time,roll_angle", *(f"{t:.2f},{x:.{PLACES}f}" for t, x in rows)]
        path.write_text("\n".join(lines))
        return score(path, maneuver=2)[2]

    return result


@pytest.mark.parametrize(("off", "is_hidden"), [(0, True), (1, True), (3, False)])
def test_rounding_explains_four_halves_of_a_last_digit(written, off, is_hidden):
    roll = written(off)["roll_angle"]
    assert roll.hidden == pytest.approx(4 * HALF_DIGIT)
    assert roll.is_hidden is is_hidden
    assert roll.error == roll.max_abs_error / roll.scale
    assert (roll.max_abs_error <= 4 * HALF_DIGIT) is is_hidden


def test_a_column_without_values_has_no_error_and_is_not_compared(written):
    m = written(0)
    roll = m["roll_angle"]
    nothing = measures(np.empty(0), np.empty(0), np.empty(0), roll.scale)
    empty = replace(roll, values=0, as_understood=replace(roll.as_understood, measures=nothing))
    assert empty.error == 0.0
    assert not empty.is_hidden
    assert m.compared == (roll,)
    assert replace(m, columns=(empty,)).compared == ()
