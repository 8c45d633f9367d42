"""Whether the numbers of a reference set agree with one another, with the model and their bounds.

No tolerance is chosen here. A number of the set comes with its certified bound, so it is a ball
[hi + lo - bound, hi + lo + bound] that holds the exact value. Whatever must be zero, or equal, for
exact values is evaluated on these balls (FLINT/Arb), and the result must hold zero, or overlap.
Each function looks at one maneuver and returns tallies, to be joined over the maneuvers.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.errors import UndecidedError
from heyoka_bike.motion.evaluator import evaluator
from heyoka_bike.motion.trajectory import Certificate, Trajectory, row_times
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.rounding import Enclosure, decimal_above, decimal_digits, hi_lo, upward
from heyoka_bike.reference.layout import CANDIDATE, CERTIFICATE, HDF5, NODES
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.proof.first_row import exact_columns
from heyoka_bike.reference.proof.rows import (
    EVALUATION_BITS,
    TEXT_DIGITS,
    constant_columns,
    enclose_rows,
)
from heyoka_bike.reference.values import Values
from heyoka_bike.reference.verification.checks import Tally
from heyoka_bike.reference.verification.schema import Text

BITS = 256
"""Of what is evaluated from hi + lo, which have 32 digits (107 bits): roundoff does not count."""

STATE = ("roll_angle", "pitch", "steer_angle", "roll_rate", "steer_rate", "forward_speed", "yaw")
"""The columns from which all others follow, in the order of the state of the regular form."""


@dataclass(frozen=True, slots=True)
class Stored:
    """One maneuver as the files have it.

    Attributes
    ----------
    number : int
        From 1.
    bicycle, maneuver
        What the manifest says it is.
    reference : ReferenceManeuver
        Rows and dense output.
    """

    number: int
    bicycle: Bicycle
    maneuver: Maneuver
    reference: ReferenceManeuver

    def at(self, name: str, row: int) -> str:
        """Where a value is, in words."""
        return f"{self.maneuver.name}: {name}, row {row}"

    def scale(self, name: str) -> float:
        """Largest absolute value of a column, 1 for one that vanishes."""
        return self.reference.scale(name) or 1.0


def row_zero(x: Stored) -> list[Tally]:
    """The first row and the times, where they are rational numbers: correctly rounded."""
    tally = Tally("row_zero", HDF5)
    rows = x.reference.rows
    for name, exact in exact_columns(x.bicycle, x.maneuver).items():
        tally.values += 1
        found = (float(rows.hi[name][0]), float(rows.lo[name][0]))
        bound = Fraction(float(rows.bound[name][0]))
        if not _same_bits(found, hi_lo(exact, name)) or abs(exact - _exact(rows, name, 0)) > bound:
            tally.fail(
                f"{x.at(name, 0)}: found {_pair(*found)}, bound {float(bound):.2g}, "
                f"expected exactly {exact}"
            )
    for i, t in enumerate(row_times(x.maneuver)):
        tally.values += 1
        found = (float(x.reference.time[i]), float(x.reference.time_lo[i]))
        if not _same_bits(found, hi_lo(t, "time")):
            tally.fail(f"{x.at('time', i)}: found {_pair(*found)}, expected exactly {t}")
    return [tally]


def energies_add_up(x: Stored) -> list[Tally]:
    """Potential and kinetic energy add up to the mechanical energy, which never changes."""
    tally = Tally("energy", HDF5)
    names = ("potential_energy", "kinetic_energy", "mechanical_energy")
    rows = x.reference.rows
    first = _exact(rows, names[2], 0)
    for i in range(x.maneuver.rows):
        potential, kinetic, total = (_exact(rows, name, i) for name in names)
        allowed = sum(Fraction(float(rows.bound[name][i])) for name in names)
        off = abs(potential + kinetic - total)
        tally.values += 2
        tally.largest = max(tally.largest, float(off) / x.scale(names[2]))
        if off > allowed:
            tally.fail(
                f"{x.at('energies', i)}: potential + kinetic - mechanical is {float(off):.2g} J, "
                f"the bounds allow {float(allowed):.2g} J"
            )
        if total != first:
            tally.fail(f"{x.at(names[2], i)}: differs from row 0 by {float(total - first):.2g} J")
    return [tally]


def own_state(x: Stored) -> list[Tally]:
    """Every row from its own roll, pitch, steer, their rates, speed and yaw: contact, columns."""
    contact, consistent = Tally("contact", HDF5), Tally("columns", HDF5)
    names = x.reference.columns
    balls = Balls(BITS)
    equations = Equations.of(x.bicycle, balls)
    k = equations.k
    with balls.precision():
        for i in range(x.maneuver.rows):
            stored = {name: stored_ball(x.reference.rows, name, i) for name in names}
            roll, pitch, steer, roll_rate, steer_rate, speed, yaw = (stored[n] for n in STATE)
            height = front_contact_height(k, balls, roll, pitch, steer)
            contact.values += 1
            contact.largest = max(contact.largest, abs(float(height.mid())))
            if not holds_zero(height):
                contact.fail(f"{x.at('front wheel', i)}: {_show(height)} m above the floor")
            state = [roll, pitch, steer, roll_rate, steer_rate, speed / k.length, yaw]
            for name, value in equations.columns(state).items():
                off = value - stored[name]
                consistent.values += 1
                consistent.largest = max(consistent.largest, abs(float(off.mid())) / x.scale(name))
                if not holds_zero(off):
                    consistent.fail(
                        f"{x.at(name, i)}: differs by {_show(off)} {x.reference.units[name]} "
                        "from what the row's own state gives"
                    )
    return [contact, consistent]


def text_17(x: Stored, text: Text) -> list[Tally]:
    """The text of 17 digits is what hi reads as."""
    tally = Tally("text", text.file.name)
    for name in BENCHMARK_COLUMNS:
        hi = x.reference.rows.hi[name]
        for i, token in enumerate(text.columns[x.number, name]):
            tally.values += 1
            if not _same_bits((float(token),), (float(hi[i]),)):
                tally.fail(f"{x.at(name, i)}: found {token}, expected {hi[i]:.17g}")
    return [tally]


def text_50(x: Stored, text: Text) -> list[Tally]:
    """Each hi and lo is the rounding of the text of 50 digits, and within its bound of it."""
    tally = Tally("text", text.file.name)
    rows = x.reference.rows
    for name in BENCHMARK_COLUMNS:
        for i, token in enumerate(text.columns[x.number, name]):
            tally.values += 1
            number = Fraction(token)
            # The exact value is anywhere within half a unit of the last digit.
            half = half_unit(token)
            found = (float(rows.hi[name][i]), float(rows.lo[name][i]))
            low, high = (hi_lo(number + side * half, name) for side in (-1, 1))
            bound = Fraction(float(rows.bound[name][i]))
            if not (low <= found <= high) or abs(number - sum(map(Fraction, found))) > bound + half:
                tally.fail(
                    f"{x.at(name, i)}: found {token}, which {HDF5} has as {_pair(*found)}, "
                    f"bound {float(bound):.2g}"
                )
    return [tally]


def rounded_rows(
    x: Stored, run: Trajectory, certificate: Certificate,
    text: Text | None,
) -> list[Tally]:  # fmt: skip
    """hi, lo, their bounds and the text of 50 digits, if given, against the candidate's enclosures.

    The enclosures are narrower than a unit in the last place of all of them, so each has to be the
    one that follows, to the last bit.
    """
    rounding, bounds = Tally("rounding", HDF5), Tally("row_bounds", HDF5)
    digits = None if text is None else Tally("digits", text.file.name)
    rows = x.reference.rows
    at = evaluator(run, run.bits + EVALUATION_BITS, certificate)
    first = exact_columns(run.bicycle, run.maneuver)
    enclosed = enclose_rows(at, first, constant_columns(run), is_proof=False)
    for i, row in enumerate(enclosed):
        for name, value in row.items():
            where = x.at(name, i)
            found = (float(rows.hi[name][i]), float(rows.lo[name][i]))
            rounding.values += 1
            bounds.values += 1
            try:
                expected = hi_lo(value, where)
                if not _same_bits(found, expected):
                    rounding.fail(f"{where}: found {_pair(*found)}, expected {_pair(*expected)}")
                if digits is not None and text is not None and name in BENCHMARK_COLUMNS:
                    digits.values += 1
                    token = _digits(value, where)
                    if text.columns[x.number, name][i] != token:
                        digits.fail(
                            f"{where}: found {text.columns[x.number, name][i]}, expected {token}"
                        )
            except UndecidedError as e:
                rounding.fail(f"{e} (the certificate's bounds are too large)")
            near, far = _distances(value, *found)
            bound = float(rows.bound[name][i])
            bounds.largest = max(bounds.largest, bound / x.scale(name))
            if not near <= Fraction(bound) <= Fraction(upward(far)):
                bounds.fail(
                    f"{x.at(f'{name}_bound', i)}: found {bound:.17g}, expected {upward(far):.17g}"
                )
    return [rounding, bounds, *([] if digits is None else [digits])]


def candidate_joins(run: Trajectory) -> list[Tally]:
    """Pieces of the candidate join exactly, and the first begins at the initial state.

    `generate` carries the state from step to step as exact integers, so nothing is left over.
    """
    tally = Tally("candidate_joins", CANDIDATE)
    for i, (piece, after) in enumerate(pairwise(run.pieces), start=1):
        for name, now, then in zip(run.states, piece, after, strict=True):
            tally.values += 1
            if sum(now) != then[0]:
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
            tally.values += 1
            off = abs(exact - row[0] * unit)
            if off > unit:
                tally.fail(f"{run.maneuver.name}: {name} begins {_show(off)} off the initial state")
    return [tally]


def motion(run: Trajectory, certificate: Certificate) -> list[Tally]:
    """The candidate satisfies the equations of motion at the rows.

    Its distance from the exact motion is at most the certified bound B, so by Markov's inequality
    its derivative, a polynomial of degree n over a step h, is off by no more than 2 n^2 B / h; what
    B does to the right-hand side is in its ball.
    """
    tally = Tally("equations_of_motion", CANDIDATE)
    balls = Balls(run.bits + EVALUATION_BITS)
    equations = Equations.of(run.bicycle, balls, is_regular=run.is_regular)
    with balls.precision():
        unit = flint.arb(2) ** -run.grid
        slopes: tuple[int, list[flint.arb_poly]] = (-1, [])
        for i, t in enumerate(row_times(run.maneuver)):
            piece = run.piece_at(t)
            a, b = run.breaks[piece], run.breaks[piece + 1]
            h = exact_ball(b - a)
            if slopes[0] != piece:
                slopes = piece, [flint.arb_poly(list(c)).derivative() for c in run.pieces[piece]]
            s = exact_ball((t - a) / (b - a))
            bounds = certificate.pieces[piece]
            state = [
                flint.arb(value, exact_ball(bound).upper())
                for value, bound in zip(run.state(t, piece), bounds, strict=True)
            ]
            force = equations.rates_with_yaw(state)
            for name, p, f, bound in zip(run.states, slopes[1], force, bounds, strict=True):
                off = p(s) * unit / h - f
                allowed = 2 * run.order**2 * exact_ball(bound) / h
                tally.values += 1
                tally.largest = max(tally.largest, abs(float(off.mid())))
                if not abs(off).lower() <= allowed:
                    tally.fail(
                        f"{run.maneuver.name}: {name}, row {i}: its derivative is {_show(off)} "
                        f"off the equations, the bounds allow {_show(allowed)}"
                    )
    return [tally]


def dense(x: Stored, file: str = HDF5) -> list[Tally]:
    """The dense output: its value at the rows, and how its pieces join."""
    at_rows, joins = Tally("dense_rows", file), Tally("dense_joins", file)
    m = x.reference
    names = tuple(m.dense.hi)
    breaks = [Fraction(float(t)) for t in m.breaks]
    times = list(row_times(x.maneuver))
    with flint.ctx.workprec(BITS):
        ends = flint.arb_mat([[1] * NODES, [(-1) ** k for k in range(NODES)]])
        before: list[flint.arb] | None = None
        for j, (a, b) in enumerate(pairwise(breaks)):
            # A break belongs to the piece on its right, the end to the last.
            is_last = j == len(breaks) - 2
            rows = [i for i, t in enumerate(times) if a <= t and (t < b or (is_last and t == b))]
            coefficients = flint.arb_mat(
                [
                    [flint.arb(float(m.dense.hi[n][j, c])) + float(m.dense.lo[n][j, c])
                     for n in names]
                    for c in range(NODES)
                ]
            )  # fmt: skip
            values = _chebyshev([(2 * times[i] - a - b) / (b - a) for i in rows]) * coefficients
            for r, i in enumerate(rows):
                for c, name in enumerate(names):
                    allowed = flint.arb(float(m.dense.bound[name][j])) + float(
                        m.rows.bound[name][i]
                    )
                    off = values[r, c] - _sum(m.rows, name, i)
                    _note(at_rows, off, allowed, x, name, f"{x.at(f'dense {name}', i)}: differs")
            end, start = ((ends * coefficients).tolist()[side] for side in (0, 1))
            if before is not None:
                for c, name in enumerate(names):
                    allowed = flint.arb(float(m.dense.bound[name][j - 1])) + float(
                        m.dense.bound[name][j]
                    )
                    what = (
                        f"{x.maneuver.name}: dense {name}, break {j} (t = {float(a):.6g} s): jumps"
                    )
                    _note(joins, start[c] - before[c], allowed, x, name, what)
            before = end
    end_time = float(breaks[-1])
    if breaks[-1] < x.maneuver.duration:
        at_rows.fail(f"{x.maneuver.name}: the dense output ends at {end_time:.6g} s")
    return [at_rows, joins]


def certified(x: Stored, run: Trajectory | None, entry: Mapping[str, Any]) -> list[Tally]:
    """What the certificate says of a maneuver, as far as it follows from the other files."""
    tally = Tally("certificate", CERTIFICATE)
    states = entry["state_bounds"]
    if run is not None and set(states) != set(run.states):
        tally.fail(f"{x.maneuver.name}: state_bounds: expected {', '.join(run.states)}")
    for name, bound in states.items():
        tally.values += 2
        if Fraction(bound["end"]) > Fraction(bound["interval"]):
            tally.fail(f"{x.maneuver.name}: {name}: the bound at the end is larger than over all")
    expected: dict[str, Any] = {
        "maneuver": x.maneuver.name,
        "entries": x.maneuver.rows * len(COLUMNS),
        "ambiguous": 0,
        **({} if run is None else {"steps": run.steps}),
        "bound": max((s["interval"] for s in states.values()), key=Fraction),
        "bound_end": max((s["end"] for s in states.values()), key=Fraction),
    }
    found = {key: entry[key] for key in expected} | entry["dense_relative_bounds"]
    _same(tally, x, found, expected | _relative_bounds(x.reference))
    tally.largest = float(Fraction(entry["bound"]))
    return [tally]


def certified_motion(x: Stored, motion: ReferenceManeuver, entry: Mapping[str, Any]) -> list[Tally]:
    """What the certificate says of the whole motion, as far as it follows from motion.h5."""
    tally = Tally("certificate", CERTIFICATE, largest=float(Fraction(entry["bound"])))
    found = entry["motion"]["dense_relative_bounds"] | {"entries": entry["motion"]["entries"]}
    expected: dict[str, Any] = {"entries": x.maneuver.rows * len(motion.columns)}
    _same(tally, x, found, expected | _relative_bounds(motion))
    return [tally]


def _relative_bounds(m: ReferenceManeuver) -> dict[str, str]:
    return {
        name: decimal_above(Fraction(float(bound.max())) / Fraction(m.scale(name) or 1.0))
        for name, bound in m.dense.bound.items()
    }


def _same(tally: Tally, x: Stored, found: Mapping[str, Any], expected: Mapping[str, Any]) -> None:
    for key, value in expected.items():
        tally.values += 1
        if found[key] != value:
            tally.fail(
                f"{x.maneuver.name}: {key}: found {found[key]!r:.60}, expected {value!r:.60}"
            )


def certificate_of(run: Trajectory, entry: Mapping[str, Any]) -> Certificate:
    """The bounds that a certificate states for a run; those of the interval hold on every piece."""
    states = entry["state_bounds"]
    interval = tuple(Fraction(states[name]["interval"]) for name in run.states)
    end = tuple(Fraction(states[name]["end"]) for name in run.states)
    return Certificate(run.states, (interval,) * run.steps, end)


def _note(
    tally: Tally, off: flint.arb, allowed: flint.arb, x: Stored, name: str, what: str
) -> None:
    tally.values += 1
    tally.largest = max(tally.largest, abs(float(off.mid())) / x.scale(name))
    if not abs(off).lower() <= allowed:
        unit = x.reference.units[name]
        tally.fail(f"{what} by {_show(off)} {unit}, the bounds allow {_show(allowed)} {unit}")


def _chebyshev(arguments: Sequence[Fraction]) -> flint.arb_mat:
    """T_0 .. T_(N-1) at each argument, by row."""
    rows = []
    for argument in arguments:
        x = exact_ball(argument)
        row = [flint.arb(1), x]
        while len(row) < NODES:
            row.append(2 * x * row[-1] - row[-2])
        rows.append(row)
    return flint.arb_mat(rows) if rows else flint.arb_mat(0, NODES)


def _exact(values: Values, name: str, row: int) -> Fraction:
    return Fraction(float(values.hi[name][row])) + Fraction(float(values.lo[name][row]))


def _sum(values: Values, name: str, row: int) -> flint.arb:
    return flint.arb(float(values.hi[name][row])) + float(values.lo[name][row])


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


def _distances(x: Enclosure | Fraction, hi: float, lo: float) -> tuple[Fraction, Fraction]:
    """Smallest and largest distance of an exact number in its enclosure from hi + lo."""
    stored = Fraction(hi) + Fraction(lo)
    if isinstance(x, Fraction):
        return abs(x - stored), abs(x - stored)
    unit = Fraction(1, 1 << x.grid)
    low, high = x.low * unit - stored, x.high * unit - stored
    near = Fraction(0) if low <= 0 <= high else min(abs(low), abs(high))
    return near, max(abs(low), abs(high))


def half_unit(token: str) -> Fraction:
    """Half a unit of the last of the 50 digits; none for an exact zero."""
    _, _, exponent = token.partition("e")
    return Fraction(10) ** (int(exponent) - TEXT_DIGITS + 1) / 2 if exponent else Fraction(0)


def _same_bits(found: Sequence[float], expected: Sequence[float]) -> bool:
    """Whether the numbers are the same, the sign of zero included."""
    return np.array(found).tobytes() == np.array(expected).tobytes()


def _pair(hi: float, lo: float) -> str:
    return f"{hi!r} + {lo!r}"


def holds_zero(x: flint.arb) -> bool:
    """Whether zero is in the ball; one that is not finite tells nothing, and must not pass."""
    return bool(x.is_finite() and x.contains(0))


def _show(x: flint.arb) -> str:
    return f"{float(x.mid()):.2g}"
