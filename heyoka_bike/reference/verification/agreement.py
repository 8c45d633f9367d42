"""Checks that the numbers of a set agree with one another, with the model and with their bounds.

No tolerance is chosen here. A number of the set comes with its certified bound, so it is a ball
[hi + lo - bound, hi + lo + bound] that holds the exact value. Whatever must be zero, or equal, for
exact values is evaluated on these balls (FLINT/Arb), and the result must hold zero, or overlap.
Each function looks at one maneuver and counts in tallies, to be joined over the maneuvers.
"""

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import groupby, pairwise
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS, NonnegativeRoots, motion_columns
from heyoka_bike.errors import UndecidedError
from heyoka_bike.motion.trajectory import evaluator, row_times
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.ball_chebyshev import basis
from heyoka_bike.numbers.rounding import Enclosure, decimal_above, decimal_digits, hi_lo
from heyoka_bike.reference.layout import CANDIDATE, HDF5, MOTION, NODES, TEXT, TEXT_50
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.proof.certificate_file import kept
from heyoka_bike.reference.proof.first_row import exact_columns
from heyoka_bike.reference.proof.rows import (
    EVALUATION_BITS,
    TEXT_DIGITS,
    constant_columns,
    distance,
    enclose_rows,
    rounded_times,
)
from heyoka_bike.reference.values import Dense, Values
from heyoka_bike.reference.verification.checks import Tally
from heyoka_bike.reference.verification.outcome import StoredManeuver

BITS = 256
"""Of what is evaluated from hi + lo, which have 32 digits (107 bits): roundoff does not count."""

STATE = ("roll_angle", "pitch", "steer_angle", "roll_rate", "steer_rate", "forward_speed", "yaw")
"""The columns from which all others follow, in the order of the state of the regular form."""


def row_zero(x: StoredManeuver, tally: Tally) -> None:
    """The first row and the times, where they are rational numbers: correctly rounded."""
    rows = x.reference.rows
    for name, exact in exact_columns(x.bicycle, x.maneuver).items():
        if name not in rows:
            continue
        found = _stored(rows, name, 0)
        bound = Fraction(float(rows.bound[name][0]))
        is_near = abs(exact - _exact(rows, name, 0)) <= bound
        if not tally.counts(is_near and _same_bits(found, hi_lo(exact, name))):
            tally.fail(
                f"{x.at(name, 0)}: found {_pair(*found)}, bound {float(bound):.2g}, "
                f"expected exactly {exact}"
            )
    for i, t in enumerate(row_times(x.maneuver)):
        found = (float(x.reference.time[i]), float(x.reference.time_lo[i]))
        if not tally.counts(_same_bits(found, hi_lo(t, "time"))):
            tally.fail(f"{x.at('time', i)}: found {_pair(*found)}, expected exactly {t}")


def energies_add_up(x: StoredManeuver, tally: Tally) -> None:
    """Potential and kinetic energy add up to the mechanical energy, which never changes."""
    names = ("potential_energy", "kinetic_energy", "mechanical_energy")
    rows = x.reference.rows
    first = _exact(rows, names[2], 0)
    for i in range(x.maneuver.rows):
        potential, kinetic, total = (_exact(rows, name, i) for name in names)
        allowed = sum(Fraction(float(rows.bound[name][i])) for name in names)
        off = abs(potential + kinetic - total)
        if not tally.counts(off <= allowed, float(off) / scale(x.reference, names[2])):
            tally.fail(
                f"{x.at('energies', i)}: potential + kinetic - mechanical is {float(off):.2g} J, "
                f"the bounds allow {float(allowed):.2g} J"
            )
        if not tally.counts(total == first):
            tally.fail(f"{x.at(names[2], i)}: differs from row 0 by {float(total - first):.2g} J")


def own_state(x: StoredManeuver, contact: Tally, columns: Tally) -> None:
    """Every row from its own roll, pitch, steer, their rates, speed and yaw: contact, columns."""
    m = x.reference
    balls = Balls(BITS)
    equations = Equations.of(x.bicycle, balls)
    k = equations.k
    with balls.precision():
        for i in range(x.maneuver.rows):
            state = _state(x, i, k.length)
            height = front_contact_height(k, balls, *state[:3])
            if not contact.counts(holds_zero(height), float(height.mid())):
                contact.fail(f"{x.at('front wheel', i)}: {_show(height)} m above the floor")
            made = equations.columns(state)
            follows(x, m, i, made, columns, "from what the row's own state gives")


def _state(x: StoredManeuver, row: int, length: flint.arb) -> list[flint.arb]:
    """The state of the regular form in a row, by its columns."""
    *angles_and_rates, speed, yaw = (stored_ball(x.reference.rows, name, row) for name in STATE)
    return [*angles_and_rates, speed / length, yaw]


def follows(
    x: StoredManeuver, m: ReferenceManeuver, row: int, made: Mapping[str, flint.arb], tally: Tally,
    what: str,
) -> None:  # fmt: skip
    """The columns of a row are those that were made of a state."""
    for name in m.columns:
        off = made[name] - stored_ball(m.rows, name, row)
        if not tally.counts(holds_zero(off), float(off.mid()) / scale(m, name)):
            tally.fail(f"{x.at(name, row)}: differs by {_show(off)} {m.units[name]} {what}")


def text_17(x: StoredManeuver, tally: Tally) -> None:
    """The text of 17 digits is what hi reads as."""
    for name in BENCHMARK_COLUMNS:
        hi = x.reference.rows.hi[name]
        for i, token in enumerate(x.files[TEXT].columns[x.number, name]):
            if not tally.counts(_same_bits((float(token),), (float(hi[i]),))):
                tally.fail(f"{x.at(name, i)}: found {token}, expected {hi[i]:.17g}")


def text_50(x: StoredManeuver, tally: Tally) -> None:
    """Each hi and lo is the rounding of the text of 50 digits, and within its bound of it."""
    rows = x.reference.rows
    for name in BENCHMARK_COLUMNS:
        for i, token in enumerate(x.files[TEXT_50].columns[x.number, name]):
            number = Fraction(token)
            # The exact value is anywhere within half a unit of the last digit.
            half = half_unit(token)
            found = _stored(rows, name, i)
            low, high = (hi_lo(number + side * half, name) for side in (-1, 1))
            bound = Fraction(float(rows.bound[name][i]))
            is_near = abs(number - _exact(rows, name, i)) <= bound + half
            if not tally.counts(low <= found <= high and is_near):
                tally.fail(
                    f"{x.at(name, i)}: found {token}, which {HDF5} has as {_pair(*found)}, "
                    f"bound {float(bound):.2g}"
                )


def rounded_rows(x: StoredManeuver, rounding: Tally, bounds: Tally, digits: Tally) -> None:
    """hi, lo, their bounds and the text of 50 digits, if there, against the candidate's enclosures.

    The enclosures are narrower than a unit in the last place of all of them, so each has to be the
    one that follows, to the last bit.
    """
    run, rows, text = x.run, x.reference.rows, x.long_text
    at = evaluator(run, run.bits + EVALUATION_BITS, x.certificate)
    first = exact_columns(run.bicycle, run.maneuver)
    for i, row in enumerate(enclose_rows(at, first, constant_columns(run), is_proof=False)):
        for name in x.reference.columns:
            value, where, found = row[name], x.at(name, i), _stored(rows, name, i)
            rounding.values += 1
            try:
                expected = hi_lo(value, where)
                if not _same_bits(found, expected):
                    rounding.fail(f"{where}: found {_pair(*found)}, expected {_pair(*expected)}")
                if text is not None and name in BENCHMARK_COLUMNS:
                    written, token = text.columns[x.number, name][i], _digits(value, where)
                    if not digits.counts(written == token):
                        digits.fail(f"{where}: found {written}, expected {token}")
            except UndecidedError as e:
                rounding.fail(f"{e} (the certificate's bounds are too large)")
            bound, largest = float(rows.bound[name][i]), distance(value, *found)
            is_right = _smallest_distance(value, *found) <= Fraction(bound) and bound <= largest
            if not bounds.counts(is_right, bound / scale(x.reference, name)):
                bounds.fail(
                    f"{x.at(f'{name}_bound', i)}: found {bound:.17g}, expected {largest:.17g}"
                )


def candidate_joins(x: StoredManeuver, tally: Tally) -> None:
    """Pieces of the candidate join exactly, and the first begins at the initial state.

    `generate` carries the state from step to step as exact integers, so nothing is left over.
    """
    run = x.run
    for i, (piece, after) in enumerate(pairwise(run.pieces), start=1):
        for name, now, then in zip(run.states, piece, after, strict=True):
            if not tally.counts(sum(now) == then[0]):
                jump = Fraction(sum(now) - then[0], 2**run.grid)
                tally.fail(
                    f"{run.maneuver.name}: {name} jumps by {float(jump):.2g} at break {i}, "
                    f"t = {float(run.breaks[i]):.6g} s"
                )
    balls = Balls(run.grid + EVALUATION_BITS)
    with balls.precision():
        equations = Equations.of(run.bicycle, balls, is_regular=run.is_regular)
        start = initial_state(equations, run.maneuver)
        # Rounded to the grid, either way where the ball does not decide.
        unit = flint.arb(2) ** -run.grid
        for name, exact, row in zip(run.states, start, run.pieces[0], strict=True):
            off = abs(exact - row[0] * unit)
            if not tally.counts(not off > unit):
                tally.fail(f"{run.maneuver.name}: {name} begins {_show(off)} off the initial state")


def equations_of_motion(x: StoredManeuver, tally: Tally) -> None:
    """The candidate satisfies the equations of motion at the rows.

    Its distance from the exact motion is at most the certified bound B, so by Markov's inequality
    its derivative, a polynomial of degree n over a step h, is off by no more than 2 n^2 B / h; what
    B does to the right-hand side is in its ball.
    """
    run = x.run
    at = evaluator(run, run.bits + EVALUATION_BITS, x.certificate)
    with at.balls.precision():
        unit = flint.arb(2) ** -run.grid
        rows = enumerate(row_times(run.maneuver))
        for piece, inside in groupby(rows, lambda row: run.piece_at(row[1])):
            a, bounds = run.breaks[piece], x.certificate.pieces[piece]
            length = run.breaks[piece + 1] - a
            slopes = [flint.arb_poly(list(c)).derivative() for c in run.pieces[piece]]
            for i, t in inside:
                s, h = exact_ball((t - a) / length), exact_ball(length)
                force = at.equations.rates_with_yaw(at.state(t, piece))
                for name, p, f, bound in zip(run.states, slopes, force, bounds, strict=True):
                    off = p(s) * unit / h - f
                    allowed = 2 * run.order**2 * exact_ball(bound) / h
                    if not tally.counts(is_within(off, allowed), float(off.mid())):
                        tally.fail(
                            f"{run.maneuver.name}: {name}, row {i}: its derivative is {_show(off)} "
                            f"off the equations, the bounds allow {_show(allowed)}"
                        )


def dense(x: StoredManeuver, at_rows: Tally, joins: Tally, *, file: str = HDF5) -> None:
    """The dense output of a file: its value at the rows, and how its pieces join."""
    m: ReferenceManeuver = x.files[file]
    names = tuple(m.dense.hi)
    breaks = [Fraction(float(t)) for t in m.breaks]
    times = list(row_times(x.maneuver))

    def compare(
        tally: Tally, off: flint.arb, bounds: tuple[float, float], name: str, what: str
    ) -> None:
        allowed = flint.arb(bounds[0]) + bounds[1]
        if not tally.counts(is_within(off, allowed), float(off.mid()) / scale(m, name)):
            tally.fail(
                f"{x.maneuver.name}: dense {name}, {what} by {_show(off)} {m.units[name]}, the "
                f"bounds allow {_show(allowed)} {m.units[name]}"
            )

    with flint.ctx.workprec(BITS):
        ends = [flint.arb(-1), flint.arb(1)]
        before: list[flint.arb] = []
        for j, (a, b) in enumerate(pairwise(breaks)):
            # A break belongs to the piece on its right, the end to the last.
            is_last = j == len(breaks) - 2
            rows = [i for i, t in enumerate(times) if a <= t and (t < b or (is_last and t == b))]
            arguments = [exact_ball((2 * times[i] - a - b) / (b - a)) for i in rows]
            coefficients = flint.arb_mat([_coefficients(m.dense, name, j) for name in names])
            values = basis(arguments + ends, NODES) * coefficients.transpose()
            *at, start, end = values.tolist()
            for i, row in zip(rows, at, strict=True):
                for name, value in zip(names, row, strict=True):
                    both = float(m.dense.bound[name][j]), float(m.rows.bound[name][i])
                    compare(at_rows, value - _sum(m.rows, name, i), both, name, f"row {i}: differs")
            where = f"break {j} (t = {float(a):.6g} s): jumps"
            for name, now, then in zip(names, start, before or start, strict=True):
                if before:
                    both = float(m.dense.bound[name][j - 1]), float(m.dense.bound[name][j])
                    compare(joins, now - then, both, name, where)
            before = end
    if breaks[-1] < x.maneuver.duration:
        at_rows.fail(f"{x.maneuver.name}: the dense output ends at {float(breaks[-1]):.6g} s")


def certified(x: StoredManeuver, tally: Tally) -> None:
    """The entry of a maneuver in the certificate, as far as it follows from the other files."""
    states, run = x.entry["state_bounds"], x.files.get(CANDIDATE)
    if run is not None and set(states) != set(run.states):
        tally.fail(f"{x.maneuver.name}: state_bounds: expected {', '.join(run.states)}")
    for name, bound in states.items():
        tally.values += 2
        if Fraction(bound["end"]) > Fraction(bound["interval"]):
            tally.fail(f"{x.maneuver.name}: {name}: the bound at the end is larger than over all")
    expected: dict[str, Any] = {
        "maneuver": x.maneuver.name,
        "entries": x.maneuver.rows * len(x.reference.columns),
        "ambiguous": 0,
        **({} if run is None else {"steps": run.steps}),
        "bound": max((s["interval"] for s in states.values()), key=Fraction),
        "bound_end": max((s["end"] for s in states.values()), key=Fraction),
    }
    _same(tally, x, x.entry, expected)
    _same(tally, x, x.entry["dense_relative_bounds"], _relative_bounds(x.reference))
    # Sets before 1.3.0 say nothing of the whole motion.
    if MOTION in x.files and (said := x.entry.get("motion")):
        _same(tally, x, said, {"entries": x.maneuver.rows * len(x.motion.columns)})
        _same(tally, x, said["dense_relative_bounds"], _relative_bounds(x.motion))
    tally.largest = float(Fraction(x.entry["bound"]))


def integration(x: StoredManeuver, tally: Tally) -> None:
    """The energy and contact drift of the candidate are those in the certificate."""
    drift = evaluator(x.run, x.run.bits + EVALUATION_BITS).drift()
    # Sets before 2.0.0 say nothing of it.
    said = x.entry.get("integration", {})
    _same(tally, x, said, {key: y for key, y in kept(drift, x.run.bits).items() if key in said})
    tally.counts(True, drift.performance)


def _relative_bounds(m: ReferenceManeuver) -> dict[str, str]:
    return {
        name: decimal_above(Fraction(float(bound.max())) / Fraction(scale(m, name)))
        for name, bound in m.dense.bound.items()
    }


def _same(
    tally: Tally, x: StoredManeuver, found: Mapping[str, Any], expected: Mapping[str, Any]
) -> None:
    for key, value in expected.items():
        if not tally.counts(found[key] == value):
            tally.fail(
                f"{x.maneuver.name}: {key}: found {found[key]!r:.60}, expected {value!r:.60}"
            )


def scale(m: ReferenceManeuver, name: str) -> float:
    """Largest absolute value of a column, 1 for one that vanishes."""
    return m.scale(name) or 1.0


def _coefficients(dense: Dense, name: str, piece: int) -> list[flint.arb]:
    """Chebyshev coefficients of a column on a piece."""
    pairs = zip(dense.hi[name][piece].tolist(), dense.lo[name][piece].tolist(), strict=True)
    return [flint.arb(hi) + lo for hi, lo in pairs]


def _stored(values: Values, name: str, row: int) -> tuple[float, float]:
    return float(values.hi[name][row]), float(values.lo[name][row])


def _exact(values: Values, name: str, row: int) -> Fraction:
    hi, lo = _stored(values, name, row)
    return Fraction(hi) + Fraction(lo)


def _sum(values: Values, name: str, row: int) -> flint.arb:
    hi, lo = _stored(values, name, row)
    return flint.arb(hi) + lo


def stored_ball(values: Values, name: str, row: int) -> flint.arb:
    """The ball that holds the exact value."""
    return flint.arb(_sum(values, name, row), float(values.bound[name][row]))


def _digits(x: Enclosure | Fraction, where: str) -> str:
    """The 50 digits that an enclosure decides, or else those of its middle, the candidate's value.

    The certificate's bound over the whole run can be too large for small values at its beginning,
    which `generate` decides by the bounds of single pieces.
    """
    try:
        return decimal_digits(x, TEXT_DIGITS, where)
    except UndecidedError:
        assert isinstance(x, Enclosure)
        return decimal_digits(Fraction(x.low + x.high, 2 << x.grid), TEXT_DIGITS, where)


def _smallest_distance(x: Enclosure | Fraction, hi: float, lo: float) -> Fraction:
    """Smallest distance of an exact number in its enclosure from hi + lo."""
    if isinstance(x, Fraction):
        return abs(x - Fraction(hi) - Fraction(lo))
    rest = x.minus(hi).minus(lo)
    return Fraction(max(rest.low, -rest.high, 0), 1 << rest.grid)


def half_unit(token: str) -> Fraction:
    """Half a unit of the last of the 50 digits; none for an exact zero."""
    _, _, exponent = token.partition("e")
    return Fraction(10) ** (int(exponent) - TEXT_DIGITS + 1) / 2 if exponent else Fraction(0)


def _same_bits(found: Sequence[float], expected: Sequence[float]) -> bool:
    """True if the numbers are equal bit by bit, the sign of zero included."""
    return np.array(found).tobytes() == np.array(expected).tobytes()


def _pair(hi: float, lo: float) -> str:
    return f"{hi!r} + {lo!r}"


def holds_zero(x: flint.arb) -> bool:
    """True if a ball is finite and holds zero."""
    return bool(x.is_finite() and x.contains(0))


def is_within(x: flint.arb, limit: flint.arb | float) -> bool:
    """True if a ball is finite and holds a number that is at most so large."""
    return bool(abs(x).lower() <= limit)


def _show(x: flint.arb) -> str:
    return f"{float(x.mid()):.2g}"


def follows_from_state(x: StoredManeuver, tally: Tally) -> None:
    """Every column of a row follows from the state in the reference's row, and the integrals."""
    m = x.motion
    expected = rounded_times(x.maneuver)
    if any(a.tobytes() != b.tobytes() for a, b in zip(expected, (m.time, m.time_lo), strict=True)):
        tally.fail(f"{x.maneuver.name}: its times are not the multiples of the spacing")
    balls = NonnegativeRoots(BITS)
    equations = Equations.of(x.bicycle, balls)
    with balls.precision():
        for i in range(x.maneuver.rows):
            integrals = (stored_ball(m.rows, name, i) for name in INTEGRALS)
            state = [*_state(x, i, equations.k.length), *integrals]
            made = motion_columns(equations, state)
            follows(x, m, i, made, tally, f"from what the state in {HDF5} gives")


def identities(x: StoredManeuver, tally: Tally) -> None:
    """Unit quaternions, and wheels whose lowest points are the contact points on the floor."""
    m = x.motion
    for i in range(x.maneuver.rows):
        with flint.ctx.workprec(BITS):
            at = {name: stored_ball(m.rows, name, i) for name in m.columns}
            found = {}
            for end, radius in (("rear", x.bicycle["rR"]), ("front", x.bicycle["rF"])):
                a, *v = (at[f"{end}_frame_q{j}"] for j in range(4))
                found[f"{end} quaternion"] = a * a + sum(c * c for c in v) - 1
                # Of the axle, and how far the wheel's plane is from the vertical.
                axle = [at[f"{end}_frame_r{j}2"] for j in (1, 2, 3)]
                arm = exact_ball(radius.rational) / (1 - axle[2] * axle[2]).sqrt()
                down = [-axle[2] * axle[0], -axle[2] * axle[1], 1 - axle[2] * axle[2]]
                hub = [at[f"{end}_hub_{axis}"] for axis in "xyz"]
                contact = [at[f"{end}_contact_x"], at[f"{end}_contact_y"], flint.arb(0)]
                for axis, h, d, c in zip("xyz", hub, down, contact, strict=True):
                    found[f"{end} wheel, {axis} of its lowest point"] = h + arm * d - c
        for what, off in found.items():
            if not tally.counts(holds_zero(off), float(off.mid())):
                tally.fail(f"{x.at(what, i)}: off by {float(off.mid()):.2g}")


def rolling(x: StoredManeuver, tally: Tally) -> None:
    """The integrals' dense output changes at the rates that the reference has at its rows.

    A polynomial of degree n that is off by B over a piece of length h has, by Markov's inequality,
    a derivative off by at most 2 n^2 B / h; what is off here is nearly one.
    """
    m = x.motion
    breaks = [Fraction(float(t)) for t in m.breaks]
    rows = x.reference.rows
    with flint.ctx.workprec(BITS):
        radius = exact_ball(x.bicycle["rR"].rational)

        def piece_of(row: tuple[int, Fraction]) -> int:
            return min(bisect_right(breaks, row[1]) - 1, len(breaks) - 2)

        for piece, inside in groupby(enumerate(row_times(x.maneuver)), piece_of):
            a, b = breaks[piece], breaks[piece + 1]
            slopes = [_derivative(m.dense, name, piece) for name in _ROLLING]
            for i, t in inside:
                speed = stored_ball(rows, "forward_speed_contact", i)
                yaw = stored_ball(rows, "yaw", i)
                turning = stored_ball(rows, "forward_speed_wheel_spin", i) / radius
                rates = (speed * yaw.cos(), speed * yaw.sin(), -turning)
                for name, slope, rate in zip(_ROLLING, slopes, rates, strict=True):
                    at = exact_ball((2 * t - a - b) / (b - a))
                    off = slope(at) * 2 / exact_ball(b - a) - rate
                    allowed = 2 * NODES**2 * float(m.dense.bound[name][piece]) / exact_ball(b - a)
                    if not tally.counts(is_within(off, allowed), float(off.mid())):
                        tally.fail(
                            f"{x.at(f'dense {name}', i)}: its rate is {float(off.mid()):.2g} "
                            f"{m.units[name]} s-1 off that of the reference"
                        )


_ROLLING = INTEGRALS[:3]
"""The integrals whose rates are columns of the reference, up to a factor."""


def _derivative(dense: Dense, name: str, piece: int) -> flint.arb_poly:
    """The derivative by the argument of a Chebyshev piece."""
    polynomials = (
        c * flint.arb_poly(flint.fmpz_poly.chebyshev_t(order))
        for order, c in enumerate(_coefficients(dense, name, piece))
    )
    return sum(polynomials, flint.arb_poly([])).derivative()
