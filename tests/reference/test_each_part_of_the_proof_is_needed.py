"""Each part of the proof is needed: without it a bound would be below the true error.

The tests use the first steps of the published maneuver 2, whole or damaged. Each test has been seen
to fail without the part of the proof that it names.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import flint
import numpy as np
import pytest

from heyoka_bike.bicycle.equations import initial
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import NonnegativeRoots
from heyoka_bike.errors import InputError, NotCertifiedError
from heyoka_bike.motion.trajectory import Certificate, Stretch, Trajectory
from heyoka_bike.numbers import analytic
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.ball_chebyshev import Nodes
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.proof import cauchy, dense, enclose
from heyoka_bike.reference.proof.cauchy import Circle, circle_bound, rho
from heyoka_bike.reference.proof.dense import Expansion, with_integrals
from heyoka_bike.reference.proof.enclose import MATRIX_BITS, SIZE, Carried
from heyoka_bike.reference.proof.rows import exact_columns, round_rows

pytestmark = pytest.mark.proof

STEPS = 3
BITS = 400
Rows = list[list[int]]


@pytest.fixture(scope="module")
def run(candidate: tuple[Trajectory, ...]) -> Trajectory:
    whole = candidate[1]
    breaks = whole.breaks[: STEPS + 1]
    short = replace(whole.maneuver, duration=breaks[-1], spacing=breaks[-1])
    return replace(whole, maneuver=short, breaks=breaks, pieces=whole.pieces[:STEPS])


@pytest.fixture(scope="module")
def sound(run: Trajectory) -> Certificate:
    return enclose.enclose(run)


def damaged(run: Trajectory, step: int, change: Callable[[Rows], None]) -> Trajectory:
    """Return the candidate with its coefficients of one step changed in place."""
    pieces = [[list(row) for row in piece] for piece in run.pieces]
    change(pieces[step])
    return replace(run, pieces=tuple(tuple(map(tuple, p)) for p in pieces))


def test_the_sound_candidate_is_certified(sound: Certificate) -> None:
    assert sound.worst < Fraction(1, 10**60)


# Tests that the candidate must be whole, and must start at the initial state


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda r: replace(r, breaks=(r.breaks[0], r.breaks[0], *r.breaks[2:])), "increase"),
        (lambda r: replace(r, breaks=(Fraction(1, 64), *r.breaks[1:])), "expected 0 to"),
        (lambda r: replace(r, breaks=r.breaks[:-1]), "expected 0 to"),
        (lambda r: replace(r, pieces=r.pieces[1:]), "2 pieces for 3 intervals"),
        (lambda r: replace(r, pieces=(r.pieces[0][:6], *r.pieces[1:])), "7 state variables"),
    ],
)
def test_a_candidate_that_is_not_whole(run: Trajectory, change: Any, said: str) -> None:
    with pytest.raises(NotCertifiedError, match=f"incomplete: .*{said}"):
        enclose.enclose(change(run))


@pytest.mark.parametrize("shift", ["1e-12", "-1e-12"])
def test_an_initial_pitch_beside_the_root(
    bicycle: Any, maneuvers: Any, monkeypatch: pytest.MonkeyPatch, shift: str
) -> None:
    turned = replace(maneuvers[1], steer=Exact(Fraction(1, 10)), roll=Exact(Fraction(1, 10)))
    equations = Equations.of(bicycle, Balls(237))
    assert len(initial.initial_state(equations, turned)) == SIZE
    root = initial._root
    monkeypatch.setattr(initial, "_root", lambda *a: root(*a) + flint.arb(shift))
    with pytest.raises(InputError, match="no pitch"):
        initial.initial_state(equations, turned)


def test_an_initial_pitch_that_may_be_a_double_root(
    bicycle: Any, maneuvers: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    turned = replace(maneuvers[1], steer=Exact(Fraction(1, 10)))

    def variables(_: Any, values: Sequence[flint.arb]) -> list[Dual]:
        """Replace the dual numbers of inexact values by ones whose slope may vanish."""
        return [Dual(x, (1 if x.is_exact() else flint.arb(0, 1),)) for x in values]

    monkeypatch.setattr(initial.Duals, "variables", variables)
    with pytest.raises(InputError, match="no pitch"):
        initial.initial_state(Equations.of(bicycle, Balls(237)), turned)


# Tests of the defect, and of the terms that its series omits


def test_what_the_polynomial_of_the_defect_leaves_out(
    run: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With degree 1 and a series of two terms, the whole defect consists of omitted terms."""

    def straight(rows: Rows) -> None:
        rows[:] = [row[:2] for row in rows]

    def bounds() -> list[float]:
        prover = enclose.Prover(damaged(run, 0, straight))
        prover.lengths = dict.fromkeys(prover.lengths, 2)
        piece = prover.run.piece(0)
        rim = circle_bound(piece, Equations.rates_with_yaw, prover.circles)
        return [float(x) for x in prover._defect(piece, rim)]

    truth = defects(damaged(run, 0, straight))
    assert all(x <= y for x, y in zip(truth, bounds(), strict=True))
    for part in ("geometric", "folded"):
        monkeypatch.setattr(analytic, part, lambda radius, length: flint.arb(0))
    assert any(x > y for x, y in zip(truth, bounds(), strict=True))


def defects(run: Trajectory) -> list[float]:
    """Return the defects of the first segment at its end."""
    balls = Balls(BITS)
    equations = Equations.of(run.bicycle, balls, is_regular=run.is_regular)
    piece = run.piece(0)
    with balls.precision():
        unit, h = flint.arb(2) ** -piece.grid, balls.number(piece.h)
        state = run.state(piece.t1, 0)
        slopes = [sum(m * c for m, c in enumerate(row)) * unit for row in piece.rows]
        rates = equations.rates_with_yaw(state)
        return [abs(float(x - h * r)) for x, r in zip(slopes, rates, strict=True)]


def test_what_the_polynomial_of_the_jacobian_leaves_out(run: Trajectory) -> None:
    """Compare three terms of h J with h J at the end of the segment."""
    prover = enclose.Prover(run)
    piece = run.piece(0)
    rim = circle_bound(piece, Equations.rates_with_yaw, prover.circles)
    terms, tail = prover._jacobian(piece, rim, 3)
    duals = Duals(Balls(MATRIX_BITS))
    with flint.ctx.workprec(MATRIX_BITS):
        state = duals.variables(run.state(piece.t1, 0)[:6])
        rates = prover.matrix.over(duals).rates_with_yaw(state)
        h, seen = prover.matrix.a.number(piece.h), False
        for i, rate in enumerate(rates):
            for j in range(6):
                left_out = abs(h * rate.slopes[j] - sum(m[i, j] for m in terms))
                assert left_out <= tail[i, j]
                seen |= bool(left_out > 1e-6)
        assert seen


# Tests of the bound on the error


def test_an_error_that_leaves_the_polydisc(run: Trajectory, monkeypatch: Any) -> None:
    """Self-consistent bounds would result for an error of up to 0.6 of the polydisc's radius."""
    monkeypatch.setattr(Carried, "bounds", lambda self, forces: ([x * 0.3 for x in rho()],) * 2)
    with pytest.raises(NotCertifiedError, match="expected less than 1/2"):
        enclose.enclose(run)


def test_an_error_bound_that_does_not_agree_with_itself(run: Trajectory, monkeypatch: Any) -> None:
    sizes = iter(flint.arb(2) ** (8 * n - 200) for n in range(1000))
    monkeypatch.setattr(Carried, "bounds", lambda self, forces: ([next(sizes)] * SIZE,) * 2)
    with pytest.raises(NotCertifiedError, match="expected less than 1/2"):
        enclose.enclose(run)


def test_what_is_not_linear_in_the_error(run: Trajectory, sound: Certificate, monkeypatch: Any):
    """Equations with huge second derivatives cannot be certified as accurately."""

    def curved(piece: Any, function: Any, equations: Any, radii: Any = (4,)) -> Circle:
        found = circle_bound(piece, function, equations, radii)
        if radii == (1,):
            return replace(found, values=[x * flint.arb(10) ** 65 for x in found.values])
        return found

    monkeypatch.setattr(cauchy, "circle_bound", curved)
    with contextlib.suppress(NotCertifiedError):
        assert enclose.enclose(run).worst > 10 * sound.worst


def test_y_that_is_not_resolved(run: Trajectory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(enclose, "_MATRIX_LENGTHS", (2,))
    with pytest.raises(NotCertifiedError, match="Y is not resolved at order 2"):
        enclose.enclose(run)


def test_y_that_is_badly_conditioned(run: Trajectory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(enclose, "CONDITION", 1.0)
    with pytest.raises(NotCertifiedError, match="condition number of the matrix Y"):
        enclose.enclose(run)


def test_a_halved_piece_has_the_larger_bound(run: Trajectory, monkeypatch: Any) -> None:
    """An error that grows late in a step is in the second half; an early one decays there."""
    monkeypatch.setattr(cauchy, "DEPTH", 1)
    whole = enclose.Prover.whole

    def halves_only(self: Any, piece: Any, *rest: Any) -> Any:
        if piece.h == run.piece(piece.step).h:
            raise cauchy.TooLongError("halves are to be tried")
        return whole(self, piece, *rest)

    monkeypatch.setattr(enclose.Prover, "whole", halves_only)
    large = 1 << (run.grid - 60)

    def late(rows: Rows) -> None:
        rows[0][-1] += large

    bound = enclose.enclose(damaged(run, STEPS - 1, late)).pieces[-1][0]
    assert bound >= Fraction(1, 2**60)


def test_jumps_between_pieces(run: Trajectory) -> None:
    def jump(rows: Rows) -> None:
        rows[0][0] += 1 << (run.grid - 60)

    bounds = enclose.enclose(damaged(run, 1, jump)).pieces
    assert bounds[0][0] < Fraction(1, 10**60)
    assert Fraction(1, 2**60) <= bounds[1][0] < Fraction(1, 2**50)


# Tests of quantities whose bounds follow from the bound of the state


def certificate(run: Trajectory, bound: Fraction) -> Certificate:
    return Certificate(run.states, ((bound,) * SIZE,) * run.steps, (bound,) * SIZE)


def test_rows_of_a_state_that_is_not_known_well_enough(run: Trajectory) -> None:
    rows = round_rows(run, certificate(run, Fraction(1, 10**20)))
    known = round_rows(run, enclose.enclose(run))
    assert not known.undecided
    assert not known.ambiguous
    # Row 0 and the energy follow from the initial conditions alone, so their rounding is certain.
    assert rows.undecided.keys() >= {"roll_angle", "forward_speed_com_norm"}
    assert rows.undecided["roll_angle"].tolist() == [*range(1, run.maneuver.rows)]
    assert "mechanical_energy" not in rows.undecided
    assert rows.ambiguous > sum(x.size for x in rows.undecided.values())
    for name, bound in rows.bound.items():
        apart = known.hi[name] - rows.hi[name] + (known.lo[name] - rows.lo[name])
        assert (abs(apart) <= bound).all(), name
        assert (bound[rows.undecided.get(name, [])] > 1e-25).all(), name


@pytest.mark.parametrize("number", [1, 2, 3])
@pytest.mark.parametrize("roll", ["0", "1/10", "pi/7"])
def test_what_is_exact_in_row_0_is_in_its_ball(
    bicycle: Any, maneuvers: Any, number: int, roll: str
) -> None:
    start = replace(maneuvers[number - 1], roll=Exact.parse(roll))
    exact = exact_columns(bicycle, start)
    assert len(exact) >= 10
    equations = Equations.of(bicycle, Balls(BITS))
    with equations.precision():
        values = equations.columns(initial.initial_state(equations, start))
        for name, x in exact.items():
            assert abs(values[name] - equations.a.number(x)) < 1e-100, name


def function(equations: Equations, state: Any) -> list[Any]:
    return [equations.a.sin(state[0]), state[5] * equations.a.cos(state[1])]


def expansion(run: Trajectory, bound: Fraction) -> Expansion:
    return next(dense.expansions(run, function, [Stretch(run.piece(0), (bound,) * SIZE)]))


def test_what_the_polynomial_of_a_column_leaves_out(run: Trajectory, monkeypatch: Any) -> None:
    def errors() -> list[tuple[Any, Any]]:
        found = expansion(run, Fraction(0))
        balls = Balls(dense.BITS)
        equations = Equations.of(run.bicycle, balls, is_regular=run.is_regular)
        with balls.precision():
            truth = function(equations, run.state(run.breaks[1], 0))
            pairs = zip(found.polynomials, found.remainders, truth, strict=True)
            return [(abs(x - p(flint.arb(1))), rest) for p, rest, x in pairs]

    monkeypatch.setattr(dense, "_REMAINDER_BITS", 8)
    assert all(error <= rest for error, rest in errors())
    monkeypatch.setattr(analytic, "geometric", lambda radius, length: flint.arb(0))
    assert all(error > rest for error, rest in errors())


@pytest.mark.parametrize("order", [0, 31])
def test_a_coefficient_that_is_off_is_a_distance(run: Trajectory, order: int) -> None:
    """The distance of the yaw over a tenth of a segment is the coefficient's error, hardly more."""
    exact = Stretch(run.piece(0), (Fraction(0),) * SIZE)
    found = next(dense.expansions(run, lambda equations, state: [state[6]], [exact]))
    piece = found.piece.t0, found.piece.t0 + found.piece.h / 10
    with flint.ctx.workprec(BITS):
        nodes = Nodes(32)
        values = [[found.polynomials[0]((x + 1) / 20)] for x in nodes.x]
        terms = (nodes.transform * flint.arb_mat(values)).entries()
        hi = np.array([float(x.mid()) for x in terms])
        lo = np.array([float((x - y).mid()) for x, y in zip(terms, hi.tolist(), strict=True)])
    (near,) = found.distances([(hi, lo)], piece, piece)
    assert near < 1e-30
    hi[order] += 2.0**-20
    (far,) = found.distances([(hi, lo)], piece, piece)
    assert 2.0**-20 - near <= far <= 2.0**-19.5 + near


def test_columns_of_a_state_that_is_not_known(run: Trajectory) -> None:
    """The error of sin(roll) for a state wrong by 1e-9, where cos(roll) is close to 1."""
    off = Fraction(1, 10**9)
    assert expansion(run, Fraction(0)).remainders[0] < 1e-30
    assert expansion(run, off).remainders[0] > 0.9e-9


def test_what_the_coefficients_of_an_integrand_leave_out(run: Trajectory, monkeypatch: Any) -> None:
    """With omitted terms of 1e-9 of the bound on the circle, positions are no more certain."""
    monkeypatch.setattr(analytic, "geometric", lambda radius, length: flint.arb("1e-9"))
    *_, last = with_integrals(run, certificate(run, Fraction(0)))
    time = float(run.breaks[-1])
    wheel_rate = 4.6 / 0.3
    assert float(last.bounds[9]) >= 0.99e-9 * wheel_rate * time


def test_what_the_polynomial_of_an_integral_leaves_out(run: Trajectory) -> None:
    """The integrals of a candidate with four terms have four terms too; padded ones have 40."""

    def ends(terms: int) -> tuple[list[Fraction], Sequence[Fraction]]:
        def cut(rows: Rows) -> None:
            rows[:] = [row[:4] + [0] * (terms - 4) for row in rows]

        coarse = damaged(run, 0, cut)
        stretch = next(with_integrals(coarse, certificate(coarse, Fraction(0))))
        unit = Fraction(1, 2**stretch.piece.grid)
        return [sum(row) * unit for row in stretch.piece.rows[7:]], stretch.bounds[7:]

    (found, bounds), (truth, _) = ends(4), ends(40)
    assert any(x != y for x, y in zip(found, truth, strict=True))
    assert all(abs(x - y) <= b for x, y, b in zip(found, truth, bounds, strict=True))


def test_where_an_integral_begins_may_be_rounded(run: Trajectory) -> None:
    def of_one_that_begins_at(at: Fraction) -> tuple[Fraction, Fraction]:
        integrator = dense._Integrator(run)
        integrator.at[0] = at
        stretch = integrator.stretch((Fraction(0),) * SIZE, run.piece(0), 0)
        first = Fraction(stretch.piece.rows[SIZE][0], 2**stretch.piece.grid)
        return abs(at - first), stretch.bounds[SIZE]

    rounding, bound = of_one_that_begins_at(Fraction(1, 3))
    assert 0 < rounding <= bound - of_one_that_begins_at(Fraction(0))[1]


def test_what_a_polynomial_leaves_out_is_the_rest_of_a_geometric_series() -> None:
    with flint.ctx.workprec(64):
        for radius in (2, 3, 4):
            terms = sum((flint.arb(1) / radius**m for m in range(5, 200)), flint.arb(0))
            assert abs(analytic.geometric(radius, 5) - terms) < 1e-15


def test_integrals_of_a_state_that_is_not_known(run: Trajectory) -> None:
    """The rate of the rear wheel is spin + q; its error of 1e-12 grows with time in the angle."""
    off = Fraction(1, 10**12)
    *_, last = with_integrals(run, certificate(run, off))
    assert all(bound >= off * run.breaks[-1] for bound in last.bounds[9:])
    *_, exact = with_integrals(run, certificate(run, Fraction(0)))
    assert all(bound < Fraction(1, 10**60) for bound in exact.bounds[7:])


def test_a_root_of_what_may_be_zero() -> None:
    """The root of a sum of squares whose ball reaches below zero starts at zero."""
    balls = NonnegativeRoots(64)
    with balls.precision():
        root = balls.sqrt(flint.arb(1, 3))
        assert root.contains(0)
        assert root.contains(2)
        assert root < 2.1
        assert not balls.sqrt(flint.arb(2, 1)).contains(0)
