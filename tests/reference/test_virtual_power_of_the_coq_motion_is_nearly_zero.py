"""The motion that Coq proves obeys Newton's and Euler's equations: a check, not a theorem.

The theorems are about the program of `Equations.v`. Here its rates move the four rigid bodies of
`oracles.virtual_power`. For every state of the tube around the certificate's polynomials, balls
enclose what violates the balance of these bodies: their virtual power, the front wheel's slip, and
its height above the floor.

On a segment let R(t, e) be one of these numbers at the state p(t) + e, where p are the polynomials
and e is at most the claim of the certificate. It differs from R(t, 0) by at most the claim times
the sum of abs(dR/de), anywhere in the tube. R(t, 0) differs from its Taylor polynomial in time by
the next term, whose coefficient is enclosed at all times of the segment. All derivatives follow
from truncated series of balls.
"""

from __future__ import annotations

import functools
import random
import re
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint
import pytest

from checker.formal import export
from generators.sign_flips import changed
from heyoka_bike.bicycle.equations import model
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, benchmark
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers import arithmetic
from heyoka_bike.numbers.arithmetic import exact_ball
from heyoka_bike.numbers.exact import Exact
from oracles.power_series import PowerSeries
from oracles.vectors import Balls
from oracles.virtual_power import Balance, Jet, balance
from support.coq_program import FORMAL, STATES, Program

BITS = 128
TERMS = 24  # number of terms of the Taylor polynomials in time
# Number of parts into which a segment is divided, by maneuver. On each part the derivatives with
# respect to the state are enclosed. Maneuver 1 has the widest tube, so it needs the most parts.
PARTS = {1: 4, 2: 1, 3: 1}
NUMBERS = Balls(30)
BENCHMARK, _ = benchmark()
README = (FORMAL / "README.md").read_text()
ROW = re.compile(
    r"^\| ([123]) \|" + r" (\S+) of (\S+) \|" * 3 + r" (\S+) \| (\S+) \|$", re.MULTILINE
)
# For each maneuver: the bounds on the three powers (each with the size of its terms), the bound on
# the slip, and the bound on the height.
STATED = {int(row[0]): [float(x) for x in row[1:]] for row in ROW.findall(README)}
POWERS = ("roll", "steer", "spin")

pytestmark = pytest.mark.proof

Coefficients = Sequence[Sequence[flint.arb]]


class Tube:
    """The states near the polynomials of one segment."""

    def __init__(self, rows: Sequence[Sequence[int]], claim: Fraction) -> None:
        self.rows = [flint.arb_poly(list(row)) for row in rows]
        self.claim = exact_ball(claim)

    def series(self, time: flint.arb) -> Coefficients:
        """Return Taylor coefficients of the polynomials at a time from the segment's middle."""
        scale = exact_ball(Fraction(1, 2**export.GRID))
        moved = [row(flint.arb_poly([time, 1])) for row in self.rows]
        return [[c * scale for c in row.coeffs()] for row in moved]

    def variations(self, time: flint.arb) -> Coefficients:
        """Return all states of the tube as series whose coefficients are partial derivatives.

        The series are not in time. Each state variable has its own power of z, from z^7 to z^13.
        Products of two of these powers are truncated. So the coefficients of these powers in a
        function of the state are its partial derivatives.
        """
        states = [row[0] + flint.arb(0, self.claim.upper()) for row in self.series(time)]
        powers = range(1, 2 * STATES)
        return [
            [x, *(flint.arb(int(power == STATES + i)) for power in powers)]
            for i, x in enumerate(states)
        ]


def violations(program: Program, states: Coefficients, length: int) -> dict[str, list[flint.arb]]:
    """Return series of the virtual powers, the slip and the height."""
    numbers = PowerSeries(BITS, length)
    with numbers.precision():
        found = moved(program, [numbers.series(row[:length]) for row in states])
        slip = {f"slip {axis}": x for axis, x in zip("xyz", found.slip, strict=True)}
        named = {**found.powers, **slip, "height": found.height}
        return {name: numbers.coefficients(x) for name, x in named.items()}


def moved(program: Program, state: Sequence[Any]) -> Balance:
    """Return the balance of the bodies that the program moves, at zero yaw."""
    rates = program.rates(state, NUMBERS)
    jets = [Jet(x, rate) for x, rate in zip(state, rates, strict=True)]
    roll, pitch, steer, _, _, spin, _ = jets
    roll_rate, pitch_rate, steer_rate, _, _, _, yaw_rate = program.rates(jets, NUMBERS)
    # The floor is the same in all directions, so the yaw angle may be zero.
    yaw = Jet(0 * roll.value, yaw_rate.value)
    angles = {"yaw": yaw, "roll": roll, "pitch": pitch, "steer": steer}
    changing = {"yaw": yaw_rate, "roll": roll_rate, "pitch": pitch_rate, "steer": steer_rate}
    return balance(NUMBERS, BENCHMARK, angles, {**changing, "spin": spin})


def enclosures(
    program: Program, tube: Tube, half: Fraction, parts: int, terms: int = TERMS
) -> dict[str, flint.arb]:
    """Enclose the violations of all states of a tube.

    The times are from `half` before to `half` after the middle of the tube's segment.
    """
    with flint.ctx.workprec(BITS):
        during = flint.arb(0, exact_ball(half).upper())
        at_middle = violations(program, tube.series(flint.arb(0)), terms)
        at_any_time = violations(program, tube.series(during), terms + 1)
        slopes = []
        for n in range(parts):
            middle = exact_ball(half * Fraction(2 * n + 1 - parts, parts))
            near = tube.variations(middle + during / parts)
            slopes.append(violations(program, near, 2 * STATES))
        found = {}
        for name, row in at_middle.items():
            x = flint.arb_poly([*row, at_any_time[name][terms]])(during)
            steepest = [sum(abs(c) for c in part[name][STATES:]) for part in slopes]
            balls = [x + flint.arb(0, (slope * tube.claim).upper()) for slope in steepest]
            found[name] = functools.reduce(flint.arb.union, balls)
        return found


def program_of(bicycle: Bicycle) -> Program:
    """Return the program that the package's equations give for a bicycle."""
    return Program(export.equations_file(Equations.of(bicycle, export.Tape())))


def is_refused(program: Program, tube: Tube) -> bool:
    """True if a violation differs from zero for all states of the tube at its middle."""
    found = enclosures(program, tube, Fraction(0), parts=1, terms=1)
    return any(not x.contains(0) for x in found.values())


def tube_of(candidate: Sequence[Trajectory], maneuver: int, segment: int) -> Tube:
    """Return the tube of the certificate that Coq checks."""
    equations = Equations.of(BENCHMARK, arithmetic.Balls(export.BITS))
    rows = export.polynomials(equations, candidate[maneuver - 1], segment)
    return Tube(rows, export.Frame.of(maneuver).claim)


def sizes(program: Program, tube: Tube) -> dict[str, float]:
    """Return the sum of the magnitudes of all terms of each virtual power, at the middle."""
    with flint.ctx.workprec(BITS):
        found = moved(program, [row[0] for row in tube.series(flint.arb(0))])
        return {name: float(sum(map(abs, terms))) for name, terms in found.terms.items()}


@pytest.fixture(scope="module")
def tube(candidate: tuple[Trajectory, ...]) -> Tube:
    """A segment of maneuver 2 in which all angles and rates are large."""
    return tube_of(candidate, 2, 4)


@pytest.mark.parametrize("maneuver", [1, 2, 3])
def test_all_states_of_the_tube_obey_newton_and_euler(
    candidate: tuple[Trajectory, ...], maneuver: int
) -> None:
    program = Program.of_coq()
    stated = STATED[maneuver]
    limits = dict(zip(POWERS, stated[0:6:2], strict=True)) | {"height": stated[7]}
    largest = dict.fromkeys(POWERS, 0.0)
    for k in range(export.PIECES):
        near = tube_of(candidate, maneuver, k)
        for name, x in enclosures(program, near, export.LENGTH / 2, PARTS[maneuver]).items():
            assert x.contains(0), (k, name)
            assert abs(x) <= limits.get(name, stated[6]), (k, name)
        for name, size in sizes(program, near).items():
            largest[name] = max(largest[name], size)
    assert all(largest[name] >= size for name, size in zip(POWERS, stated[1:6:2], strict=True))


@pytest.mark.parametrize("symbol", sorted(PARAMETERS))
def test_another_bicycle_is_refused(tube: Tube, symbol: str) -> None:
    x, factor = BENCHMARK[symbol], 1 + Fraction(1, 10**9)
    other = Exact(factor * x.rational, factor * x.pi_multiple)
    assert is_refused(program_of(BENCHMARK.replace(**{symbol: other})), tube)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        pytest.param("b.i22 * q - b.spin * v", "b.i22 * q", id="gyroscopic moment of the wheels"),
        pytest.param("w1 * h2 - q * h1", "w1 * h2", id="gyroscopic moment of the frames"),
        pytest.param("b.i11 * w1 + b.i13 * w3", "b.i11 * w1", id="product of inertia"),
        pytest.param("push = b.m * side_speed", "push = 0 * side_speed", id="side force"),
        pytest.param("turn = u.steer_rate * u.w1_f", "turn = 0 * u.q", id="turning of the fork"),
    ],
)
def test_a_missing_term_is_refused(tube: Tube, old: str, new: str) -> None:
    with changed(model, old, new).applied():
        program = program_of(BENCHMARK)
    assert is_refused(program, tube)


def test_every_plus_and_minus_of_the_program_matters(tube: Tube) -> None:
    opposite = {"Add": "Sub", "Sub": "Add"}
    program, unnoticed = Program.of_coq(), []
    for i, (name, *places) in enumerate(program.operations):
        if name in opposite:
            program.operations[i] = (opposite[name], *places)
            if not is_refused(program, tube):
                unnoticed.append(i)
            program.operations[i] = (name, *places)
    assert unnoticed == []


@pytest.mark.parametrize(
    ("half", "terms"),
    [pytest.param(Fraction(0), 1, id="one time"), pytest.param(export.LENGTH / 2, 2, id="all")],
)
def test_no_state_of_a_tube_is_outside_its_enclosures(
    tube: Tube, half: Fraction, terms: int
) -> None:
    """The bicycle is another, so that the violations vary; few terms have a large remainder."""
    rng = random.Random("states of a tube")
    program = program_of(BENCHMARK.replace(mB=Exact(Fraction(86))))
    found = enclosures(program, tube, half, 4, terms)
    with flint.ctx.workprec(BITS):
        for _ in range(50):
            part = flint.arb(rng.randint(-1000, 1000)) / 1000
            rows = tube.series(part * exact_ball(half))
            state = [[x[0] + rng.choice((-1, 1)) * tube.claim] for x in rows]
            for name, x in violations(program, state, 1).items():
                assert found[name].contains(x[0]), name
