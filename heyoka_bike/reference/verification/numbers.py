"""Checks that the numbers of a dataset agree with each other, with the model and their bounds.

No tolerance is chosen here. A number of the dataset comes with its certified bound, so it is a ball
[hi + lo - bound, hi + lo + bound] that contains the exact value. Expressions that are zero for
exact values are evaluated on these balls (FLINT/Arb), and the result must contain zero. Numbers
that are equal for exact values must have balls that overlap. Each function checks one maneuver and
counts in tallies, which are then joined over the maneuvers.

The motion can also be integrated again, to count the digits that agree. Every column is compared at
every row with the most precise published number, which is the text with 50 digits or else hi + lo,
and with the trajectory in candidate.h5, which has about 65 digits. The certificate determines how
many digits must agree: it bounds the error of a run with p bits by some B. Truncation and roundoff
of a Taylor integration are proportional to 2^-p, and the motion magnifies them independently of p,
so the error of a run with q bits is expected to be below 2^(p - q) B. This is not a proof, because
only the published run is certified. States with that uncertainty are evaluated as balls; each must
overlap the published number with its bound.
"""

import time
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import groupby, pairwise
from math import inf, log10
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS, NonnegativeRoots, motion_columns
from heyoka_bike.errors import UndecidedError
from heyoka_bike.motion.heyoka_adapter import require_heyoka
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Certificate, Trajectory, evaluator, row_times
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.ball_chebyshev import basis
from heyoka_bike.numbers.precision import MAX_DIGITS, Precision
from heyoka_bike.numbers.rounding import Enclosure, decimal_digits, hi_lo
from heyoka_bike.numbers.working import working_bits
from heyoka_bike.reference.layout import CANDIDATE, HDF5, MOTION, NODES, TEXT, TEXT_50
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.proof.certificate import drift_entry, relative_bounds
from heyoka_bike.reference.proof.rows import (
    TEXT_DIGITS,
    constant_columns,
    distance,
    enclose_rows,
    exact_columns,
    rounded_times,
)
from heyoka_bike.reference.values import Dense, Values
from heyoka_bike.reference.verification.outcome import (
    Agreement,
    Check,
    StoredManeuver,
    Tally,
    Verification,
)
from heyoka_bike.system.jobs import OnStage
from heyoka_bike.system.parallel import Progress, side_by_side

BITS = 256
"""Precision of evaluations from hi + lo, which have 107 bits: high enough to neglect roundoff."""

_STATE_COLUMNS = (
    "roll_angle",
    "pitch",
    "steer_angle",
    "roll_rate",
    "steer_rate",
    "forward_speed",
    "yaw",
)
"""Columns from which all others follow, in the order of the state of the regular form."""

_ROLLING = INTEGRALS[:3]
"""Integrals whose time derivatives are columns of the reference, up to a factor."""


def row_zero(x: StoredManeuver, tally: Tally) -> None:
    """Check that the rational values in the first row, and all times, are correctly rounded."""
    rows = x.reference.rows
    for name, exact in exact_columns(x.bicycle, x.maneuver).items():
        if name not in rows:
            continue
        found, bound = _stored(rows, name, 0), _bound(rows, name, 0)
        is_near = abs(exact - _exact(rows, name, 0)) <= bound
        tally.counts(
            is_near and _same_bits(found, hi_lo(Enclosure.of(exact), name)),
            f"{x.at(name, 0)}: found {_pair(*found)}, bound {float(bound):.2g}, "
            f"expected exactly {exact}",
        )
    for i, t in enumerate(row_times(x.maneuver)):
        found = (float(x.reference.time[i]), float(x.reference.time_lo[i]))
        said = f"{x.at('time', i)}: found {_pair(*found)}, expected exactly {t}"
        tally.counts(_same_bits(found, hi_lo(Enclosure.of(t), "time")), said)


def energies_add_up(x: StoredManeuver, tally: Tally) -> None:
    """Check that potential and kinetic energy add up to a constant mechanical energy."""
    names = ("potential_energy", "kinetic_energy", "mechanical_energy")
    rows = x.reference.rows
    first, size = _exact(rows, names[2], 0), scale(x.reference, names[2])
    for i in range(x.maneuver.rows):
        potential, kinetic, total = (_exact(rows, name, i) for name in names)
        allowed = sum(_bound(rows, name, i) for name in names)
        off = abs(potential + kinetic - total)
        tally.counts(
            off <= allowed,
            f"{x.at('energies', i)}: potential + kinetic - mechanical is {float(off):.2g} J, but "
            f"the bounds allow only {float(allowed):.2g} J",
            float(off) / size,
        )
        said = f"{x.at(names[2], i)}: differs from row 0 by {float(total - first):.2g} J"
        tally.counts(total == first, said)


def own_state(x: StoredManeuver, contact: Tally, columns: Tally) -> None:
    """Check, in each row, contact and all columns against the state variables of the same row."""
    balls = NonnegativeRoots(BITS)
    equations = Equations.of(x.bicycle, balls)
    with balls.precision():
        for i in range(x.maneuver.rows):
            state = _state(x, i, equations.k.length)
            height = front_contact_height(equations.k, balls, *state[:3])
            said = f"{x.at('front wheel', i)}: {_show(height)} m above the floor"
            contact.counts(holds_zero(height), said, float(height.mid()))
            made = equations.columns(state)
            _follow(x, x.reference, i, made, columns, "from the value of the row's own state")


def follows_from_state(x: StoredManeuver, tally: Tally) -> None:
    """Check each row of the whole motion against the reference's row and the integrals."""
    m = x.motion
    expected = rounded_times(x.maneuver)
    if any(a.tobytes() != b.tobytes() for a, b in zip(expected, (m.time, m.time_lo), strict=True)):
        tally.fail(f"{x.maneuver.name}: the times are not multiples of the spacing")
    balls = NonnegativeRoots(BITS)
    equations = Equations.of(x.bicycle, balls)
    with balls.precision():
        for i in range(x.maneuver.rows):
            integrals = (stored_ball(m.rows, name, i) for name in INTEGRALS)
            state = [*_state(x, i, equations.k.length), *integrals]
            made = motion_columns(equations, state)
            _follow(x, m, i, made, tally, f"from the value of the state in {HDF5}")


def _state(x: StoredManeuver, row: int, length: flint.arb) -> list[flint.arb]:
    """Return the state of the regular form in a row, from its columns."""
    *angles_and_rates, speed, yaw = (
        stored_ball(x.reference.rows, name, row) for name in _STATE_COLUMNS
    )
    return [*angles_and_rates, speed / length, yaw]


def _follow(
    x: StoredManeuver, m: ReferenceManeuver, row: int, made: Mapping[str, flint.arb], tally: Tally,
    what: str,
) -> None:  # fmt: skip
    """Check that the columns of a row equal the values `made`, computed from a state."""
    for name in m.columns:
        off = made[name] - stored_ball(m.rows, name, row)
        said = f"{x.at(name, row)}: differs by {_show(off)} {m.units[name]} {what}"
        tally.counts(holds_zero(off), said, float(off.mid()) / scale(m, name))


def text_17(x: StoredManeuver, tally: Tally) -> None:
    """Check that the text with 17 digits equals hi.

    An undecided zero is written with an exponent, as in the text with 50 digits.
    """
    for name in BENCHMARK_COLUMNS:
        hi = x.reference.rows.hi[name].tolist()
        undecided = _undecided(x.reference.rows, name)
        for i, token in enumerate(x.files[TEXT].columns[x.number, name]):
            said = f"{x.at(name, i)}: found {token}, expected {hi[i]:.17g}"
            is_known = i in undecided or not token.startswith("0e")
            tally.counts(is_known and _same_bits((float(token),), (hi[i],)), said)


def text_50(x: StoredManeuver, tally: Tally) -> None:
    """Check that hi and lo are the rounded text with 50 digits, with an error below the bound.

    For undecided rows only the bound is checked.
    """
    rows = x.reference.rows
    for name in BENCHMARK_COLUMNS:
        undecided = _undecided(rows, name)
        for i, token in enumerate(x.files[TEXT_50].columns[x.number, name]):
            # The written number is rounded: the exact value lies between number - half and number +
            # half.
            number, half = Fraction(token), nearness(token)
            found, bound = _stored(rows, name, i), _bound(rows, name, i)
            low, high = (hi_lo(Enclosure.of(number + side * half), name) for side in (-1, 1))
            is_near = abs(number - _exact(rows, name, i)) <= bound + half
            tally.counts(
                (i in undecided or low <= found <= high) and is_near,
                f"{x.at(name, i)}: found {token}, but {HDF5} has {_pair(*found)}, "
                f"bound {float(bound):.2g}",
            )


def rounded_rows(x: StoredManeuver, rounding: Tally, bounds: Tally, digits: Tally) -> None:
    """Check hi, lo, bounds and the 50-digit text against enclosures computed from the candidate.

    For decided values the enclosure is narrower than a unit in their last place, so they must equal
    the rounded enclosure to the last bit. Undecided values must lie within their bound.
    """
    run, rows, text = x.run, x.reference.rows, x.long_text
    at = evaluator(run, certificate=x.certificate)
    first = exact_columns(run.bicycle, run.maneuver)
    undecided = {name: _undecided(rows, name) for name in x.reference.columns}
    for i, row in enumerate(enclose_rows(at, first, constant_columns(run), is_proof=False)):
        for name in x.reference.columns:
            value, where, found = row[name], x.at(name, i), _stored(rows, name, i)
            try:
                if i not in undecided[name]:
                    expected = hi_lo(value, where)
                    said = f"{where}: found {_pair(*found)}, expected {_pair(*expected)}"
                    rounding.counts(_same_bits(found, expected), said)
                if text is not None and name in BENCHMARK_COLUMNS:
                    written = text.columns[x.number, name][i]
                    digits.counts(*_is_written(value, written, where))
            except UndecidedError as e:
                rounding.counts(False, f"{e} (the certificate's bounds are too large)")
            bound, largest = float(rows.bound[name][i]), distance(value, *found)
            bounds.counts(
                _smallest_distance(value, *found) <= Fraction(bound) and bound <= largest,
                f"{x.at(f'{name}_bound', i)}: found {bound:.17g}, expected {largest:.17g}",
                bound / scale(x.reference, name),
            )


def candidate_joins(x: StoredManeuver, tally: Tally) -> None:
    """Check that the pieces of the candidate join exactly and begin at the initial state.

    `generate` carries the state from step to step as exact integers, so there are no jumps.
    """
    run = x.run
    for i, (piece, after) in enumerate(pairwise(run.pieces), start=1):
        for name, now, then in zip(run.states, piece, after, strict=True):
            jump = Fraction(sum(now) - then[0], 2**run.grid)
            tally.counts(
                jump == 0,
                f"{run.maneuver.name}: {name} jumps by {float(jump):.2g} at break {i}, "
                f"t = {float(run.breaks[i]):.6g} s",
            )
    equations = run.equations(Balls(run.grid + 64))
    with equations.precision():
        start = initial_state(equations, run.maneuver)
        # The first state is rounded to a multiple of 2^-grid. Both neighbours are accepted if the
        # ball does not decide between them.
        unit = flint.arb(2) ** -run.grid
        for name, exact, row in zip(run.states, start, run.pieces[0], strict=True):
            off = abs(exact - row[0] * unit)
            said = (
                f"{run.maneuver.name}: the first value of {name} differs by {_show(off)} from the "
                "initial state"
            )
            tally.counts(not off > unit, said)


def equations_of_motion(x: StoredManeuver, tally: Tally) -> None:
    """Check that the candidate satisfies the equations of motion at the rows.

    Its distance from the exact motion is at most the certified bound. The ball of the right-hand
    side includes the effect of that distance.
    """
    run = x.run
    at = evaluator(run, certificate=x.certificate)

    def polynomials(piece: int) -> Iterator[_Changing]:
        unit, bounds = flint.arb(2) ** -run.grid, x.certificate.pieces[piece]
        for name, row, bound in zip(run.states, run.pieces[piece], bounds, strict=True):
            p = flint.arb_poly(list(row)) * unit
            yield _Changing(name, p, exact_ball(bound), "off the equations")

    def rates(row: int, t: Fraction, piece: int) -> Sequence[flint.arb]:
        return at.equations.rates_with_yaw(at.state(t, piece))

    with at.balls.precision():
        _change_at(x, tally, run.breaks, run.order, polynomials, rates)


def rolling(x: StoredManeuver, tally: Tally) -> None:
    """Check that the dense output of the integrals changes at the rates in the reference's rows.

    The limit uses the number of coefficients as the degree, which is one more than the degree of
    the piece, so it is slightly too large.
    """
    m, rows = x.motion, x.reference.rows
    breaks = [Fraction(float(t)) for t in m.breaks]

    def polynomials(piece: int) -> Iterator[_Changing]:
        for name in _ROLLING:
            terms = enumerate(_coefficients(m.dense, name, piece))
            p = sum(
                (c * flint.arb_poly(flint.fmpz_poly.chebyshev_t(k)) for k, c in terms),
                flint.arb_poly([]),
            )
            what = f"{m.units[name]} s-1 off that of the reference"
            bound = flint.arb(float(m.dense.bound[name][piece]))
            yield _Changing(f"dense {name}", p(flint.arb_poly([-1, 2])), bound, what)

    def rates(row: int, t: Fraction, piece: int) -> Sequence[flint.arb]:
        names = ("forward_speed_contact", "yaw", "forward_speed_wheel_spin")
        speed, yaw, spin = (stored_ball(rows, name, row) for name in names)
        return speed * yaw.cos(), speed * yaw.sin(), -spin / exact_ball(x.bicycle["rR"].rational)

    with working_bits(BITS):
        _change_at(x, tally, breaks, NODES, polynomials, rates)


@dataclass(frozen=True)
class _Changing:
    """A polynomial in s, 0 <= s <= 1 on a piece, and a bound on its error.

    The text `off` ends the sentence that reports the error of its derivative.
    """

    name: str
    polynomial: flint.arb_poly
    bound: flint.arb
    off: str


def _change_at(
    x: StoredManeuver, tally: Tally, breaks: Sequence[Fraction], degree: int,
    polynomials: Callable[[int], Iterable[_Changing]],
    rates: Callable[[int, Fraction, int], Sequence[flint.arb]],
) -> None:  # fmt: skip
    """Check the derivatives of polynomials against the rates at each row.

    `polynomials` takes a piece; `rates` takes a row, its time and its piece. If a polynomial of
    degree n has an error of at most B on a piece of length h, Markov's inequality bounds the error
    of its derivative by 2 n^2 B / h.
    """

    def piece_of(row: tuple[int, Fraction]) -> int:
        return min(bisect_right(breaks, row[1]) - 1, len(breaks) - 2)

    for piece, inside in groupby(enumerate(row_times(x.maneuver)), piece_of):
        a, b = breaks[piece], breaks[piece + 1]
        h = exact_ball(b - a)
        moving = [(p, p.polynomial.derivative()) for p in polynomials(piece)]
        for i, t in inside:
            s = exact_ball((t - a) / (b - a))
            for (p, slope), rate in zip(moving, rates(i, t, piece), strict=True):
                off, allowed = slope(s) / h - rate, 2 * degree**2 * p.bound / h
                said = f"{x.at(p.name, i)}: its derivative is {_show(off)} {p.off}, "
                said += f"the bounds allow {_show(allowed)}"
                tally.counts(is_within(off, allowed), said, float(off.mid()))


def identities(x: StoredManeuver, tally: Tally) -> None:
    """Check that quaternions have unit length and wheels touch the floor at the contact points."""
    m = x.motion
    for i in range(x.maneuver.rows):
        with working_bits(BITS):
            at = {name: stored_ball(m.rows, name, i) for name in m.columns}
            found = {}
            for end, radius in (("rear", x.bicycle["rR"]), ("front", x.bicycle["rF"])):
                a, *v = (at[f"{end}_frame_q{j}"] for j in range(4))
                found[f"{end} quaternion"] = a * a + sum(c * c for c in v) - 1
                # The third component of the axle's direction is the sine of the wheel's
                # inclination.
                axle = [at[f"{end}_frame_r{j}2"] for j in (1, 2, 3)]
                arm = exact_ball(radius.rational) / (1 - axle[2] * axle[2]).sqrt()
                down = [-axle[2] * axle[0], -axle[2] * axle[1], 1 - axle[2] * axle[2]]
                hub = [at[f"{end}_hub_{axis}"] for axis in "xyz"]
                contact = [at[f"{end}_contact_x"], at[f"{end}_contact_y"], flint.arb(0)]
                for axis, h, d, c in zip("xyz", hub, down, contact, strict=True):
                    found[f"{end} wheel, {axis} of its lowest point"] = h + arm * d - c
        for what, off in found.items():
            said = f"{x.at(what, i)}: off by {_show(off)}"
            tally.counts(holds_zero(off), said, float(off.mid()))


def dense(x: StoredManeuver, at_rows: Tally, joins: Tally) -> None:
    """Check the dense output of a file: its values at the rows, and the jumps between pieces."""
    m: ReferenceManeuver = x.files[at_rows.file]
    names = tuple(m.dense.hi)
    breaks = [Fraction(float(t)) for t in m.breaks]
    times = list(row_times(x.maneuver))

    def compare(tally: Tally, off: flint.arb, a: float, b: float, name: str, what: str) -> None:
        allowed, unit = flint.arb(float(a)) + float(b), m.units[name]
        said = f"{x.maneuver.name}: dense {name}, {what} by {_show(off)} {unit}, the "
        said += f"bounds allow {_show(allowed)} {unit}"
        tally.counts(is_within(off, allowed), said, float(off.mid()) / scale(m, name))

    with working_bits(BITS):
        ends = [flint.arb(-1), flint.arb(1)]
        before: list[flint.arb] = []
        for j, (a, b) in enumerate(pairwise(breaks)):
            # A break between two pieces belongs to the later piece. The end of the run belongs to
            # the last piece.
            is_last = j == len(breaks) - 2
            rows = [i for i, t in enumerate(times) if a <= t and (t < b or (is_last and t == b))]
            arguments = [exact_ball((2 * times[i] - a - b) / (b - a)) for i in rows]
            coefficients = flint.arb_mat([_coefficients(m.dense, name, j) for name in names])
            values = basis(arguments + ends, NODES) * coefficients.transpose()
            *at, start, end = values.tolist()
            for i, row in zip(rows, at, strict=True):
                for name, value in zip(names, row, strict=True):
                    off, bounds = value - _sum(m.rows, name, i), m.dense.bound[name]
                    compare(at_rows, off, bounds[j], m.rows.bound[name][i], name,
                            f"row {i}: differs")  # fmt: skip
            where = f"break {j} (t = {float(a):.6g} s): jumps"
            for name, now, then in zip(names, start, before, strict=True) if before else ():
                bounds = m.dense.bound[name]
                compare(joins, now - then, bounds[j - 1], bounds[j], name, where)
            before = end
    if breaks[-1] < x.maneuver.duration:
        at_rows.fail(f"{x.maneuver.name}: the dense output ends at {float(breaks[-1]):.6g} s")


def certified(x: StoredManeuver, tally: Tally) -> None:
    """Check the entry of a maneuver in the certificate, as far as the other files determine it."""
    states, run = x.entry["state_bounds"], x.files.get(CANDIDATE)
    if run is not None and set(states) != set(run.states):
        tally.fail(f"{x.maneuver.name}: state_bounds: expected {', '.join(run.states)}")
    for name, bound in states.items():
        tally.values += 2
        if Fraction(bound["end"]) > Fraction(bound["interval"]):
            tally.fail(
                f"{x.maneuver.name}: {name}: the bound at the end exceeds that over the interval"
            )
    expected: dict[str, Any] = {
        "maneuver": x.maneuver.name,
        "entries": x.maneuver.rows * len(x.reference.columns),
        "ambiguous": x.reference.rows.ambiguous + _short(x),
        **({} if run is None else {"steps": run.steps}),
        "bound": max((s["interval"] for s in states.values()), key=Fraction),
        "bound_end": max((s["end"] for s in states.values()), key=Fraction),
    }
    _same(tally, x, x.entry, expected)
    _same(tally, x, x.entry["dense_relative_bounds"], relative_bounds(x.reference))
    # Certificates before 1.3.0 have no entry for the file of the whole motion.
    if MOTION in x.files and (said := x.entry.get("motion")):
        _same(tally, x, said, {"entries": x.maneuver.rows * len(x.motion.columns)})
        _same(tally, x, {"ambiguous": 0} | said, {"ambiguous": x.motion.rows.ambiguous})
        _same(tally, x, said["dense_relative_bounds"], relative_bounds(x.motion))
    tally.largest = float(Fraction(x.entry["bound"]))


def integration(x: StoredManeuver, tally: Tally) -> None:
    """Check the energy and contact drift of the candidate against the certificate."""
    drift = evaluator(x.run).drift()
    # Certificates before 2.0.0 do not state the drift of the energy.
    said = x.entry.get("integration", {})
    entry = drift_entry(drift, x.run.bits)
    _same(tally, x, said, {key: y for key, y in entry.items() if key in said})
    tally.counts(True, "", drift.performance)


def _same(
    tally: Tally, x: StoredManeuver, found: Mapping[str, Any], expected: Mapping[str, Any]
) -> None:
    for key, value in expected.items():
        said = f"{x.maneuver.name}: {key}: found {found[key]!r:.60}, expected {value!r:.60}"
        tally.counts(found[key] == value, said)


@lru_cache(256)
def scale(m: ReferenceManeuver, name: str) -> float:
    """Return the largest absolute value of a column, or 1 for a column of zeros."""
    return m.scale(name) or 1.0


def _coefficients(dense: Dense, name: str, piece: int) -> list[flint.arb]:
    """Return the Chebyshev coefficients of a column on a piece."""
    pairs = zip(dense.hi[name][piece].tolist(), dense.lo[name][piece].tolist(), strict=True)
    return [flint.arb(hi) + lo for hi, lo in pairs]


def _stored(values: Values, name: str, row: int) -> tuple[float, float]:
    return float(values.hi[name][row]), float(values.lo[name][row])


def _exact(values: Values, name: str, row: int) -> Fraction:
    return sum(map(Fraction, _stored(values, name, row)), Fraction(0))


def _bound(values: Values, name: str, row: int) -> Fraction:
    return Fraction(float(values.bound[name][row]))


def _sum(values: Values, name: str, row: int) -> flint.arb:
    hi, lo = _stored(values, name, row)
    return flint.arb(hi) + lo


def stored_ball(values: Values, name: str, row: int) -> flint.arb:
    """Return the ball that contains the exact value."""
    return flint.arb(_sum(values, name, row), float(values.bound[name][row]))


def _undecided(values: Values, name: str) -> frozenset[int]:
    """Return the indices of the rows whose rounding is declared undecided."""
    return frozenset(values.undecided.get(name, np.empty(0)).tolist())


def _short(x: StoredManeuver) -> int:
    """Count the entries of the 50-digit text that are written with fewer digits."""
    if x.long_text is None:
        return 0
    columns = (x.long_text.columns[x.number, name] for name in BENCHMARK_COLUMNS)
    return sum(_is_short(token) for column in columns for token in column)


def _is_short(token: str) -> bool:
    """True if an entry of the 50-digit text has fewer digits, because the others are undecided."""
    digits, _, exponent = token.partition("e")
    return bool(exponent) and sum(map(str.isdigit, digits)) < TEXT_DIGITS


def _is_written(x: Enclosure, token: str, where: str) -> tuple[bool, str]:
    """Return whether an entry of the 50-digit text fits its enclosure, and the error message."""
    if _is_short(token):
        number, near = Fraction(token), nearness(token)
        said = f"{where}: found {token}, expected a number within a unit of its last digit"
        return x.low - near <= number <= x.high + near, said
    expected = _digits(x, where)
    return token == expected, f"{where}: found {token}, expected {expected}"


def _digits(x: Enclosure, where: str) -> str:
    """Return the 50 digits that an enclosure decides, or else those of its midpoint.

    The certificate's bound over the whole run can be too large for small values at its beginning,
    which `generate` decides by the bounds of single pieces.
    """
    try:
        return decimal_digits(x, TEXT_DIGITS, where)
    except UndecidedError:
        return decimal_digits(Enclosure.of((x.low + x.high) / 2), TEXT_DIGITS, where)


def _smallest_distance(x: Enclosure, hi: float, lo: float) -> Fraction:
    """Return the smallest distance between hi + lo and a number in the enclosure."""
    rest = x.minus(hi, lo)
    return max(rest.low, -rest.high, Fraction(0))


def nearness(token: str) -> Fraction:
    """Return the largest distance of an entry of the text with 50 digits from the exact value.

    It is half a unit of the last digit, a whole unit for an entry with fewer digits, and zero for
    an exact zero.
    """
    digits, _, exponent = token.partition("e")
    if not exponent:
        return Fraction(0)
    unit = Fraction(10) ** (int(exponent) - sum(map(str.isdigit, digits)) + 1)
    return unit if _is_short(token) else unit / 2


def _same_bits(found: Sequence[float], expected: Sequence[float]) -> bool:
    """True if two sequences of numbers are equal bit by bit, including the sign of zero."""
    return np.array(found).tobytes() == np.array(expected).tobytes()


def _pair(hi: float, lo: float) -> str:
    return f"{hi!r} + {lo!r}"


def holds_zero(x: flint.arb) -> bool:
    """True if a ball is finite and contains zero."""
    return bool(x.is_finite() and x.contains(0))


def is_within(x: flint.arb, limit: flint.arb) -> bool:
    """True if a ball is finite and contains a number of absolute value at most `limit`."""
    return bool(abs(x).lower() <= limit)


def _show(x: flint.arb) -> str:
    return f"{float(x.mid()):.2g}"


QUICK: tuple[str | int, ...] = ("binary128", 40)
"""Precisions of a quick rerun."""
MORE_DIGITS = 20
"""Additional digits of the second run of a full rerun, relative to the dataset's own run."""


def run_again(
    found: Verification, *, is_quick: bool = False, progress: Progress | None = None
) -> Verification:
    """Integrate the maneuvers of a dataset again, each with two precisions, in parallel.

    Parameters
    ----------
    found
        Result of the checks. If a check failed, nothing is integrated, and a check named ``rerun``
        states this.

    Raises
    ------
    MissingPackageError
        heyoka is not installed.
    """
    if not found.passed:
        message = "not made, because another check failed"
        unmade = Check("rerun", None, "", message, {"values": 0})
        return replace(found, checks=(*found.checks, unmade))
    require_heyoka()
    jobs = [
        (part, precision)
        for part in found.parts
        for precision in precisions(part.run, is_quick=is_quick)
    ]
    motions = [
        (f"{part.maneuver.name}, {precision.name}", float(part.maneuver.duration))
        for part, precision in jobs
    ]
    agreements = tuple(side_by_side(agreement, jobs, motions, progress))
    checks = (*found.checks, *(a.check() for a in agreements))
    return replace(found, checks=checks, agreements=agreements)


def precisions(run: Trajectory, *, is_quick: bool) -> tuple[Precision, ...]:
    """Return the precisions with which a maneuver is integrated again."""
    if is_quick:
        return tuple(map(Precision.of, QUICK))
    digits = int(run.precision.split()[0])
    more = min(digits + MORE_DIGITS, MAX_DIGITS)
    return Precision.of(digits), Precision.of(more)


def agreement(part: StoredManeuver, precision: Precision, report: OnStage) -> Agreement:
    """Integrate a maneuver and compare the result with the published numbers."""
    run = part.run
    start = time.perf_counter()
    again = integrate(
        run.bicycle, run.maneuver, precision, progress=lambda t: report("integrate", t)
    )
    seconds = time.perf_counter() - start
    bits = max(run.evaluation_bits, again.evaluation_bits)
    at_run, at_again = evaluator(run, bits), evaluator(again, bits)
    # The two runs have different steps, and possibly different state variables, so one bound is
    # used for all times and states.
    worst = part.certificate.worst * (1 + Fraction(2) ** (run.bits - again.bits))
    bounds = (worst,) * len(again.states)
    off_by = Certificate(again.states, (bounds,) * again.steps, bounds)
    around = evaluator(again, bits, off_by)
    names = part.reference.columns
    off = {kind: dict.fromkeys(names, 0.0) for kind in ("published", "candidate", "allowed")}
    tally = Tally("rerun", HDF5)
    with at_run.balls.precision():
        for i, t in enumerate(row_times(run.maneuver)):
            found, ball, candidate = at_again.columns(t), around.columns(t), at_run.columns(t)
            for name in names:
                published = _published(part, name, i)
                widths = {"allowed": ball[name].rad() + published.rad()}
                for kind, number in (("published", published), ("candidate", candidate[name])):
                    apart = widths[kind] = (found[name] - number).mid()
                    tally.counts(
                        ball[name].is_finite() and ball[name].overlaps(number),
                        f"{part.at(name, i)}: {precision.name}: {float(apart):.2g} from the {kind} "
                        f"value, expected at most {float(ball[name].rad() + number.rad()):.2g}",
                    )
                for kind, width in widths.items():
                    off[kind][name] = max(off[kind][name], abs(float(width)))
            report("compare", float(t))
    most = min(run.bits, again.bits) * log10(2)

    def digits(kind: str) -> dict[str, float]:
        return {
            name: min(-log10(x / scale(part.reference, name)) if x else inf, most)
            for name, x in off[kind].items()
        }

    return Agreement(
        maneuver=part.maneuver.name, precision=precision.name, published=digits("published"),
        candidate=digits("candidate"), promised=digits("allowed"), tally=tally,
        steps=again.steps, seconds=seconds,
    )  # fmt: skip


def _published(part: StoredManeuver, name: str, row: int) -> flint.arb:
    """Return a ball around the most precise published number of a value, with its bound."""
    text = part.long_text
    if text is None or (part.number, name) not in text.columns:
        return stored_ball(part.reference.rows, name, row)
    token = text.columns[part.number, name][row]
    return flint.arb(exact_ball(Fraction(token)), exact_ball(nearness(token)).upper())
