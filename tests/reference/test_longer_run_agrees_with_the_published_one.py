"""The published 70-digit candidate and a run at 90 digits agree to 65 digits at every row."""

import flint
import pytest

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.motion.trajectory import evaluator, row_times
from support.tiers import ONE_MANEUVER

BITS = 440  # precision of the comparison, well above that of both runs


@pytest.mark.parametrize("number", ONE_MANEUVER)
def test_every_column_agrees_to_65_digits_at_every_row(candidate, long_run, number):
    short, long = candidate[number - 1], long_run(number)
    at_short, at_long = evaluator(short, BITS), evaluator(long, BITS)
    largest = dict.fromkeys((c.name for c in COLUMNS), flint.arb(0))
    difference = dict(largest)
    with at_short.balls.precision():
        for t in row_times(short.maneuver):
            a, b = at_short.columns(t), at_long.columns(t)
            for name in largest:
                largest[name] = largest[name].max(abs(b[name]))
                difference[name] = difference[name].max(abs(a[name] - b[name]))
        # The difference is relative to the column's scale, because a value near zero has few
        # significant digits.
        for name in largest:
            assert difference[name] < largest[name] * flint.arb(10) ** -65, name


@pytest.mark.proof
def test_the_check_sees_a_change_in_the_66th_digit(candidate):
    """The comparison above fails for a candidate with a change of 1e-64 in its first roll rate."""
    run = candidate[1]
    broken = [[list(row) for row in piece] for piece in run.pieces]
    broken[10][0][1] += 2**run.grid // 10**64
    pieces = tuple(tuple(map(tuple, piece)) for piece in broken)
    with flint.ctx.workprec(BITS):
        t = run.breaks[11] - (run.breaks[11] - run.breaks[10]) / 4
        shift = abs(
            type(run)(**{f: getattr(run, f) for f in FIELDS} | {"pieces": pieces}).state(t)[0]
            - run.state(t)[0]
        )
        assert shift > flint.arb(10) ** -65


FIELDS = (
    "bicycle", "maneuver", "precision", "bits", "is_regular", "order", "grid", "breaks", "pieces",
)  # fmt: skip
