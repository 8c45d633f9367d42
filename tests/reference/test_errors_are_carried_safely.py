"""Bounds on the propagation of errors are valid for linear equations with known solutions.

The matrix of the equations is A + B s. The candidate's Y and V are cut at low order, so the
contributions of their defects to the bounds are large, and leaving one out would be visible.
"""

from __future__ import annotations

import random
from collections.abc import Iterator

import flint
import pytest

from heyoka_bike.numbers.ball_matrices import (
    Polynomial,
    abs_times,
    fundamental,
    identity,
    norm,
    perron,
    solution,
    turned,
    value,
)
from heyoka_bike.reference.proof.enclose import MATRIX_BITS, SIZE, Carried, Flow, Frame

EXACT = 40
"""Number of terms of the true solution, whose rest is below 1e-30."""
TIMES = [flint.arb(i) / 8 for i in range(9)]


def matrix(rng: random.Random, low: float, high: float) -> flint.arb_mat:
    return flint.arb_mat([[rng.uniform(low, high) for _ in range(SIZE)] for _ in range(SIZE)])


def zero() -> flint.arb_mat:
    return flint.arb_mat(SIZE, SIZE)


@pytest.fixture(params=range(2))
def rng(request: pytest.FixtureRequest) -> Iterator[random.Random]:
    with flint.ctx.workprec(MATRIX_BITS):
        yield random.Random(request.param)


def system(rng: random.Random, length: int, low: float = -0.02) -> list[flint.arb_mat]:
    found = [matrix(rng, low, 0.02), matrix(rng, low, 0.02)]
    return found + [zero()] * (length - 2)


def flow(a: Polynomial, length: int) -> Flow:
    """Return the flow of polynomials with few terms."""
    found = Flow.of(a[:length], zero())
    assert found.eta < 1
    return found


def slope(p: Polynomial, s: flint.arb) -> flint.arb_mat:
    return value([m * k for k, m in enumerate(p)][1:], s)


@pytest.mark.parametrize("length", [2, 4, 8])
def test_the_defects_of_y_and_v_are_bounded(rng: random.Random, length: int) -> None:
    """Test at some times, with a matrix that has a tail."""
    a = system(rng, EXACT, low=0.0)
    weights, tail = perron(a), matrix(rng, 0, 0.1)
    for rest in (zero(), tail):
        y, bound_y, v, bound_v = fundamental(a[:length], rest, weights)
        found_y, found_v = 0.0, 0.0
        for s in TIMES:
            now = value(a, s) + rest
            found_y = max(found_y, float(norm(slope(y, s) - now * value(y, s), weights)))
            found_v = max(found_v, float(norm(slope(v, s) + value(v, s) * now, weights)))
        assert found_y <= bound_y < 10 * found_y + 1e-9
        assert found_v <= bound_v < 10 * found_v + 1e-9


def test_what_rounding_leaves_over_of_a_solution_is_enclosed(rng: random.Random) -> None:
    """With 12 bits, low orders contain only rounding errors, at both ends of -1 <= s <= 1."""
    a = system(rng, 6)
    g = [matrix(rng, -1, 1) for _ in a]
    with flint.ctx.workprec(12):
        x, left_over = solution(a, identity(SIZE), g)
    for s in (flint.arb(-1), flint.arb(1)):
        low = [
            sum((a[j] * x[m - j] for j in range(m + 1)), g[m]) - x[m + 1] * (m + 1)
            for m in range(len(a) - 1)
        ]
        found = value(low, s)
        pairs = list(zip(found.entries(), left_over.entries(), strict=True))
        assert all(bound.contains(e) for e, bound in pairs)
        assert any(abs(e) > 1e-5 for e, _ in pairs)


def test_v_is_nearly_the_inverse_of_y(rng: random.Random) -> None:
    f = flow(system(rng, EXACT), 5)
    worst = 0.0
    for s in TIMES:
        product = value(f.v, s) * value(f.y, s)
        worst = max(worst, float(norm(product - identity(SIZE), f.weights)))
        inverse = value(f.y, s).inv()
        assert norm(inverse, f.weights) <= f.size_inverse
    assert 0 < worst <= f.eta


def test_nothing_is_known_of_an_inverse_that_is_not_near(rng: random.Random) -> None:
    poor = Flow.of([x * 10 for x in system(rng, 2, low=0.01)], zero())
    assert poor.eta > 1
    assert not poor.size_inverse.is_finite()


@pytest.mark.parametrize("length", [3, 5])
def test_no_solution_leaves_the_bounds(rng: random.Random, length: int) -> None:
    """Solve e' = A e + force, for initial errors at corners of the frame and worst forces."""
    a = system(rng, EXACT)
    f = flow(a, length)
    y, _ = solution(a, identity(SIZE))
    frame = Frame(matrix(rng, -1, 1), [flint.arb(rng.uniform(0, 1)) for _ in range(SIZE)])
    forces = [flint.arb(rng.uniform(0, 1)) for _ in range(SIZE)]
    carried = Carried(f, frame)
    sup, added = carried.bounds(forces)
    end = carried.end(added)
    inverse = end.matrix.inv()
    corners = [[rng.choice((-1, 1)) * r for r in frame.radii] for _ in range(20)]
    for s in TIMES:
        from_start = value(y, s) * frame.matrix
        # Integrate the force that is worst for each variable at each time. The rectangle rule has a
        # relative error below 1/20.
        worst = [flint.arb(0)] * SIZE
        steps = 32
        for j in range(steps):
            tau = s * (2 * j + 1) / (2 * steps)
            reach = abs_times(value(y, s) * value(y, tau).inv(), forces)
            worst = [x + s * r / steps for x, r in zip(worst, reach, strict=True)]
        for corner in corners:
            e = from_start * flint.arb_mat([[x] for x in corner])
            for i in range(SIZE):
                assert abs(e[i, 0]) + 0.95 * worst[i] <= sup[i]
    for corner in corners:
        e = value(y, flint.arb(1)) * frame.matrix * flint.arb_mat([[x] for x in corner])
        inside = inverse * e
        assert all(abs(inside[i, 0]) <= end.radii[i] for i in range(SIZE))


NOTHING = [flint.arb(0)] * SIZE
FORCES = [flint.arb(1)] * SIZE


def test_what_the_defect_of_y_leaves_out_is_charged(rng: random.Random) -> None:
    """For nonnegative equations a short series of Y is too small, unless its defect counts."""
    a = system(rng, EXACT, low=0.01)
    carried = Carried(flow(a, 2), Frame(identity(SIZE), FORCES))
    sup, added = carried.bounds(NOTHING)
    end = carried.end(added)
    y_end = value(solution(a, identity(SIZE))[0], flint.arb(1))
    truth = abs_times(y_end, FORCES)
    inside = abs_times(end.matrix.inv() * y_end, FORCES)
    assert all(x <= y for x, y in zip(truth, sup, strict=True))
    assert any(x > y for x, y in zip(truth, carried.incoming, strict=True))
    assert all(x <= y for x, y in zip(inside, end.radii, strict=True))


def test_the_whole_motion_may_be_a_defect() -> None:
    """With Y = 1, e' = k e + force is all defect: exp(k) from 1, (exp(k) - 1) / k from force."""
    with flint.ctx.workprec(MATRIX_BITS):
        k, one = flint.arb("0.4"), flint.arb(1)
        f = Flow([identity(SIZE)], [identity(SIZE)], FORCES, k, one, flint.arb(0), one)
        sup, _ = Carried(f, Frame(identity(SIZE), FORCES)).bounds(NOTHING)
        assert all(k.exp() <= x < 1.1 * k.exp() for x in sup)
        sup, _ = Carried(f, Frame(identity(SIZE), NOTHING)).bounds(FORCES)
        assert all((k.exp() - 1) / k <= x < 1.4 * (k.exp() - 1) / k for x in sup)


def test_a_poor_inverse_is_charged() -> None:
    """V is a third smaller than the inverse of Y = 1, so forces seem a third less effective."""
    with flint.ctx.workprec(MATRIX_BITS):
        third = flint.arb(1) / 3
        v = [identity(SIZE) * (1 - third)]
        f = Flow([identity(SIZE)], v, FORCES, flint.arb(0), flint.arb(1), third, flint.arb(1))
        sup, added = Carried(f, Frame(identity(SIZE), NOTHING)).bounds(FORCES)
        assert all(x >= 1 for x in (*sup, *added))


def test_forces_may_do_most_on_the_way() -> None:
    """For e' = (1 - 2 s) e / 5 a force at 0 has grown by exp(1/20) at 1/2, but not at all at 1."""
    with flint.ctx.workprec(MATRIX_BITS):
        fifth, most = flint.arb(1) / 5, flint.arb("0.05").exp()
        a = [identity(SIZE) * fifth, identity(SIZE) * (-2 * fifth)] + [zero()] * 18
        carried = Carried(flow(a, 20), Frame(identity(SIZE), NOTHING))
        assert all(carried.push_end[i, i] < most <= carried.push[i, i] for i in range(SIZE))


def test_a_turned_frame_holds_what_it_held_and_what_is_added(rng: random.Random) -> None:
    end = matrix(rng, -1, 1)
    radii, added = ([flint.arb(rng.uniform(0, 1)) for _ in range(SIZE)] for _ in range(2))
    frame, found = turned(end, radii, added)
    inverse = frame.inv()
    for _ in range(200):
        x, y = ([rng.choice((-1, 1)) * r for r in by] for by in (radii, added))
        point = end * flint.arb_mat([[c] for c in x]) + flint.arb_mat([[c] for c in y])
        inside = inverse * point
        assert all(abs(inside[i, 0]) <= found[i] for i in range(SIZE))
    assert all(x <= 10 * y for x, y in zip(found, Frame(end, radii).bound(), strict=True))
