"""The proof of the sensitivities succeeds, and fails if a step of it is wrong."""

import pickle
from dataclasses import replace
from fractions import Fraction

import flint
import numpy as np
import pytest

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, read_bicycle
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator
from heyoka_bike.numbers.analytic import AtPoints, NotAnalyticError
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.ball_chebyshev import basis
from heyoka_bike.numbers.ball_matrices import identity, largest, value
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.proof import sensitivity_rows, variation
from heyoka_bike.reference.proof.enclose import SIZE, Frame, enclose
from heyoka_bike.reference.proof.sensitivity_rows import differentiate
from heyoka_bike.reference.proof.variation import Unknowns
from heyoka_bike.reference.structure import UNKNOWNS
from heyoka_bike.system.resources import find_input

pytestmark = pytest.mark.proof

ORDER = list(UNKNOWNS)
# Differences over this step have an error of about the size of the step.
STEP = Fraction(1, 10**25)
BITS = 240


def ball(x):
    x = Fraction(x)
    return flint.arb(flint.fmpq(x.numerator, x.denominator))


def moved(x):
    return Exact(x.rational + STEP, x.pi_multiple)


def changed(bicycle, maneuver, unknown):
    if unknown in PARAMETERS:
        return bicycle.replace(**{unknown: moved(bicycle[unknown])}), maneuver
    key = unknown.removeprefix("initial_")
    return bicycle, replace(maneuver, **{key: moved(getattr(maneuver, key))})


def at_the_end(*motion):
    """Columns at the end of a motion, cached for several tests."""
    key = pickle.dumps(motion)
    if key not in _KNOWN:
        _KNOWN[key] = _at_the_end(*motion)
    return _KNOWN[key]


_KNOWN = {}


def _at_the_end(bicycle, maneuver, is_regular):
    at = evaluator(integrate(bicycle, maneuver, 70, is_regular=is_regular), BITS)
    with at.balls.precision():
        return at.columns(maneuver.duration)


def outside(found, run, unknowns):
    """Return columns and unknowns whose differences at the end violate the certified bounds."""
    here = at_the_end(run.bicycle, run.maneuver, run.is_regular)
    names = []
    with flint.ctx.workprec(BITS):
        a, b = (ball(t) for t in found.breaks[-2:])
        x = 2 * (ball(run.maneuver.duration) - a) / (b - a) - 1
        for unknown in unknowns:
            u = ORDER.index(unknown)
            there = at_the_end(*changed(run.bicycle, run.maneuver, unknown), run.is_regular)
            for name in here:
                difference = (there[name] - here[name]) / ball(STEP)
                c = found.coefficients[name][-1, :, u]
                value = sum((ball(x_k) * x.chebyshev_t(k) for k, x_k in enumerate(c)), flint.arb(0))
                # A difference has an error of the step times the second derivative, which is below
                # 1e4.
                if not abs(value - difference) <= ball(found.bound[name][-1, u]) + 1e-20:
                    names.append((name, unknown))
    return names


@pytest.fixture(scope="module")
def short(bicycle, maneuvers):
    """A run with an initial steer angle, and thus an initial pitch, and its certificate."""
    start = {"roll": "0.05", "steer": "0.1", "steer_rate": "0.3"}
    maneuver = replace(
        maneuvers[1], duration=Fraction(1, 20), spacing=Fraction(1, 400),
        **{key: Exact.parse(x) for key, x in start.items()},
    )  # fmt: skip
    run = integrate(bicycle, maneuver, 70)
    return run, enclose(run)


SOME = ["lam", "rF", "mB", "IHxz", "initial_steer", "initial_roll"]


@pytest.fixture(scope="module")
def proved(short):
    return differentiate(*short)


def test_differences_are_within_the_bounds(short, proved):
    assert proved.ambiguous == 0
    assert outside(proved, short[0], SOME) == []


def test_in_the_regular_form_and_for_another_bicycle(maneuvers):
    bicycle = read_bicycle(find_input("bicycles", "pista"))
    maneuver = replace(maneuvers[1], duration=Fraction(1, 20), spacing=Fraction(1, 20))
    run = integrate(bicycle, maneuver, 70, is_regular=True)
    found = differentiate(run, enclose(run))
    assert found.ambiguous == 0
    assert outside(found, run, ["c", "xH", "initial_speed"]) == []


def test_rows_are_the_polynomials_within_both_bounds(proved):
    found = proved
    assert len(found.time) == 3
    by_polynomial = found.evaluate(found.time, list(found.values))
    for name, values in found.values.items():
        apart = np.abs(values - by_polynomial[name])
        # Evaluating 24 terms in binary64 adds roundoff relative to the largest term.
        roundoff = 2.0**-47 * np.max(np.abs(found.coefficients[name]), axis=(0, 1))
        assert (apart <= found.bound[name].max(axis=0) + found.values_bound[name] + roundoff).all()


def test_the_first_row_is_exact(proved):
    for name, unknown in (
        ("roll_angle", "initial_roll"), ("steer_angle", "initial_steer"),
        ("steer_rate", "initial_steer_rate"), ("forward_speed", "initial_speed"),
    ):  # fmt: skip
        expected = np.zeros(len(ORDER))
        expected[ORDER.index(unknown)] = 1.0
        assert np.array_equal(proved.values[name][0], expected)
        assert not proved.values_bound[name][0].any()


def test_where_a_derivative_does_not_exist_there_is_no_number(maneuvers):
    """A front assembly of one point mass on the steer axis has no ratio of inertias."""
    bicycle = read_bicycle(find_input("bicycles", "two-mass-skate"))
    maneuver = replace(maneuvers[1], duration=Fraction(1, 100), spacing=Fraction(1, 100))
    run = integrate(bicycle, maneuver, 70)
    found = differentiate(run, enclose(run))
    missing = {ORDER[u] for u in np.flatnonzero(np.isnan(found.bound["yaw"][0]))}
    for c in COLUMNS:
        assert (np.isnan(found.coefficients[c.name]) == np.isnan(found.bound["yaw"][0])).all()
    assert outside(found, run, [u for u in ("w", "mB", "initial_steer") if u not in missing]) == []


def without_a_parameter(m):
    """Make the constants independent of the wheel base."""
    table = m.tolist()
    for row in table:
        row[ORDER.index("w")] = flint.arb(0)
    return flint.arb_mat(table)


def with_a_wrong_constant(m):
    """Change the derivative of a constant slightly."""
    table = m.tolist()
    table[5] = [x * (1 + flint.arb(2) ** -30) for x in table[5]]
    return flint.arb_mat(table)


@pytest.mark.parametrize("wrong", [without_a_parameter, with_a_wrong_constant])
def test_a_wrong_chain_rule_is_seen(short, monkeypatch, wrong):
    plain = Unknowns.of.__func__

    def of(cls, *arguments):
        found = plain(cls, *arguments)
        with flint.ctx.workprec(variation.BITS):
            return replace(found, by_constant=wrong(found.by_constant))

    monkeypatch.setattr(Unknowns, "of", classmethod(of))
    _is_refused_or_outside(short)


def test_a_transposed_jacobian_is_seen(short, monkeypatch):
    plain = variation._Prover._linear

    def linear(self, *arguments):
        jacobian, forcing = plain(self, *arguments)
        return [m.transpose() for m in jacobian], forcing

    monkeypatch.setattr(variation._Prover, "_linear", linear)
    _is_refused_or_outside(short)


def test_a_missing_term_of_the_motion_is_seen(short, monkeypatch):
    """The proof runs as if the equations did not depend on the constants."""
    plain = variation._Prover._linear

    def linear(self, *arguments):
        jacobian, forcing = plain(self, *arguments)
        return jacobian, [0 * m for m in forcing]

    monkeypatch.setattr(variation._Prover, "_linear", linear)
    _is_refused_or_outside(short)


def test_from_where_they_are_not_bounded_there_are_no_numbers(short, monkeypatch):
    run, certificate = short
    plain = variation._Prover._whole

    def whole(self, piece, *arguments):
        if piece.step > 0:
            raise NotAnalyticError("about to fall")
        return plain(self, piece, *arguments)

    monkeypatch.setattr(variation._Prover, "_whole", whole)
    monkeypatch.setattr(sensitivity_rows, "_PIECES_AT_ONCE", 1)
    assert run.steps > 1
    found = differentiate(run, certificate)
    assert found.breaks[-1] == float(run.breaks[-1])
    for name, bound in found.bound.items():
        assert np.isfinite(bound[0]).all()
        assert np.isnan(bound[-1]).all()
        assert np.isnan(found.coefficients[name][-1]).all()
    for values in found.values.values():
        assert np.isfinite(values[0]).all()
        assert np.isnan(values[-1]).all()


def test_what_a_solution_leaves_over_is_bounded():
    """p' = a p + g with large a and few terms: all residual terms are bounded."""
    rng = np.random.default_rng(1)
    with flint.ctx.workprec(variation.BITS):

        def matrices(rows, columns, count, size):
            return [
                flint.arb_mat((size * rng.standard_normal((rows, columns))).tolist())
                for _ in range(count)
            ]

        a, g = matrices(3, 3, 6, 2.0), matrices(3, 2, 6, 1.0)
        tail = flint.arb_mat([[0.01] * 3] * 3)
        pulls = [flint.arb(0.02)] * 3
        weights = [flint.arb(1)] * 3
        p, bound = variation._solution(a, g, tail, pulls, weights)
        worst = 0.0
        for u in np.linspace(-1, 1, 41):
            at = flint.arb(float(u))
            slope = value([m * k for k, m in enumerate(p)][1:], at)
            for sign in (-1, 1):
                off = value(a, at) + sign * tail
                left = off * value(p, at) + value(g, at) - slope
                worst = max(worst, *(abs(float(x.mid())) + 0.02 for x in left.entries()))
    assert worst <= float(bound) <= 20 * worst


def test_an_error_at_the_start_stays_inside_the_bound(short, proved, monkeypatch):
    """The bound covers derivatives with an initial error within a stated box."""
    run, certificate = short
    plain = variation._Prover.__init__
    off = Fraction(1, 10**12)

    def init(self, *arguments):
        plain(self, *arguments)
        with flint.ctx.workprec(variation.BITS):
            table = self.q.tolist()
            self.q = flint.arb_mat([[(x + ball(off)).mid() for x in row] for row in table])
            self.frame = Frame(identity(SIZE), [x + 2 * ball(off) for x in self.frame.bound()])

    monkeypatch.setattr(variation._Prover, "__init__", init)
    found = differentiate(run, certificate)
    times = np.linspace(0.0, 0.05, 41)
    there = proved.evaluate(times)
    for name, values in found.evaluate(times).items():
        apart = np.abs(values - there[name]).max(axis=0)
        assert (apart <= found.bound[name].max(axis=0) + 1e-12).all(), name
    assert 1e-9 < np.max(found.bound["roll_angle"]) < 1e-3


def test_what_interpolation_leaves_out_is_bounded(short, monkeypatch):
    """With four coefficients much is omitted, but nowhere more than the bound."""
    run, certificate = short
    monkeypatch.setattr(sensitivity_rows, "ORDERS", 4)
    equations = Equations.of(run.bicycle, Balls(variation.BITS), is_regular=False)
    unknowns = Unknowns.of(run, equations)
    along = list(variation.variations(run, certificate, unknowns))
    parts = sensitivity_rows.ColumnDerivatives.along(along, unknowns, equations)
    with flint.ctx.workprec(variation.BITS):
        fitted = sensitivity_rows.Fitted.of(parts)
        t0, t1 = ball(fitted.t0), ball(fitted.t1)
        worst = [flint.arb(0)] * len(fitted.left_out)
        for part in parts:
            times = [ball(part.t0) + ball(part.h) * flint.arb(j) / 20 for j in range(-20, 20)]
            there = basis([2 * (t - t0) / (t1 - t0) - 1 for t in times], 4) * fitted.coefficients
            difference = (there - part.at(times)).transpose().tolist()
            worst = [largest([x, *map(abs, row)]) for x, row in zip(worst, difference, strict=True)]
    assert all(x <= y for x, y in zip(worst, fitted.left_out, strict=True))
    assert sum(x > 1e-12 for x in worst) > 100
    assert all(y <= 10 * x for x, y in zip(worst, fitted.left_out, strict=True) if x > 1e-12)


def test_what_interpolation_between_nodes_leaves_out_is_bounded(short, monkeypatch):
    """With few nodes, compare with the derivatives at a time between them."""
    run, certificate = short
    monkeypatch.setattr(sensitivity_rows, "_NODE_BITS", 20)
    monkeypatch.setattr(sensitivity_rows, "_nodes", sensitivity_rows._nodes.__wrapped__)
    equations = Equations.of(run.bicycle, Balls(BITS), is_regular=False)
    with flint.ctx.workprec(variation.BITS):
        unknowns = Unknowns.of(
            run, Equations.of(run.bicycle, Balls(variation.BITS), is_regular=False)
        )
    part = next(variation.variations(run, certificate, unknowns))
    (along,) = sensitivity_rows.ColumnDerivatives.along([part], unknowns, equations)
    points, u = AtPoints(BITS), [flint.arb("0.3")]
    with points.precision():
        slopes = unknowns.gradients(Equations.every_column, equations, points, part.piece.at(u))
        one = np.array([flint.arb(1)])
        by_state = flint.arb_mat([[(x * one)[0] for x in row] for row in slopes])
        inner = [*value(part.q, u[0]).entries(), *unknowns.by_constant.entries()]
        there = by_state * flint.arb_mat(by_state.ncols(), len(unknowns.smooth), inner)
        found = along.at([ball(along.t0) + ball(along.h) * u[0]]).entries()
        pairs = list(zip(there.entries(), found, strict=True))
    assert all(x.overlaps(y) for x, y in pairs)
    assert sum(not x.overlaps(y.mid()) for x, y in pairs) > 100


def _is_refused_or_outside(short):
    """Check that the energy's derivatives contradict each other, or that differences violate the
    bounds."""
    try:
        found = differentiate(*short)
    except NotCertifiedError:
        return
    assert outside(found, short[0], ["w", "mB", "IHxz"])
