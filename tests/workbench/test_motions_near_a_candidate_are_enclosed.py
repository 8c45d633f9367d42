"""Bounds and derivatives of `nearby` are valid for motions that start in the box."""

from dataclasses import replace
from fractions import Fraction

import flint
import pytest

from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.proof.enclose import MATRIX_BITS, SIZE
from heyoka_bike.workbench.after_ten_seconds.limit_cycle import nearby

pytestmark = pytest.mark.proof

TIME = Fraction(1, 8)
BOX = Fraction(1, 10**7)


@pytest.fixture(scope="module")
def start(maneuvers):
    return replace(maneuvers[0], duration=Fraction(1, 6), spacing=Fraction(1, 6))


def run_from(bicycle, start, **shift):
    moved = {key: Exact(getattr(start, key).rational + x) for key, x in shift.items()}
    return integrate(bicycle, replace(start, **moved), "binary128", is_regular=True)


def boxed(run, radius):
    """Return the motions near `run` with roll rate and steer rate in a box."""
    with flint.ctx.workprec(MATRIX_BITS):
        radii = [flint.arb(0)] * SIZE
        for i in (3, 4):
            radii[i] = flint.arb(flint.fmpq(radius.numerator, radius.denominator)).upper()
        # The start of the candidate is rounded, so the radii include its rounding error.
        radii = [x + flint.arb(2) ** -100 for x in radii]
    return nearby(run, radii)


def derivative(near, time=TIME):
    with flint.ctx.workprec(MATRIX_BITS):
        return near.derivative(flint.arb(flint.fmpq(time.numerator, time.denominator)))


@pytest.fixture(scope="module")
def run(bicycle, start):
    return run_from(bicycle, start)


@pytest.fixture(scope="module")
def tight(run):
    return boxed(run, Fraction(1, 10**25))


@pytest.fixture(scope="module")
def wide(run):
    return boxed(run, BOX)


@pytest.fixture(scope="module")
def other(bicycle, start):
    """Return a motion from a corner of the wide box."""
    return run_from(bicycle, start, roll_rate=BOX, steer_rate=-BOX)


def test_derivatives_are_those_of_the_motion(bicycle, start, tight):
    found = derivative(tight)
    step = Fraction(1, 10**12)
    runs = [run_from(bicycle, start, roll_rate=side * step) for side in (1, -1)]
    with flint.ctx.workprec(200):
        up, down = (run.state(TIME) for run in runs)
        for i in range(6):
            slope = (up[i] - down[i]) / (2 * flint.fmpq(step.numerator, step.denominator))
            # Central differences have two errors: roundoff divided by the step, and one
            # proportional to the step's square.
            assert abs(found[i, 3].mid() - slope) < found[i, 3].rad() + 1e-19
            assert found[i, 3].rad() < 1e-15


def test_every_motion_of_the_box_stays_within_the_bounds(run, wide, other):
    bounds = map(float, wide.certificate.pieces[run.piece_at(TIME)])
    with flint.ctx.workprec(200):
        moved = [
            float(abs(x - y).mid()) / bound
            for x, y, bound in zip(other.state(TIME), run.state(TIME), bounds, strict=True)
        ]
    assert max(moved) < 1
    # The worst corner moves by at least a tenth of the bound, although the bound covers a whole
    # segment.
    assert max(moved) > 0.1


def test_derivatives_hold_for_every_motion_of_the_box(tight, wide, other):
    all_of_them, middle = derivative(wide), derivative(tight)
    corner = derivative(boxed(other, Fraction(1, 10**25)))
    differ = 0
    for i in range(6):
        for j in range(6):
            assert all_of_them[i, j].contains(corner[i, j])
            differ += not middle[i, j].overlaps(corner[i, j])
    # The two motions have different derivatives. A box that ignored this would not contain both
    # derivatives.
    assert differ > 10


def test_a_time_outside_is_refused(tight):
    with pytest.raises(NotCertifiedError, match="expected one inside a piece"):
        derivative(tight, Fraction(2))
