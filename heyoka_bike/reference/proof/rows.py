"""The rows of a table: enclosures of the exact values, and their correct rounding.

At t = 0 many values are rational (a speed of 4 m/s, an energy). A ball around an exactly
representable number does not decide its rounding, however small it is. So row 0 is evaluated in
exact arithmetic, over the field of rational functions in the half-angle tangents of the tilt and of
the initial roll, which are treated as independent unknowns. A value in which the unknowns cancel is
rational for every tilt and roll, and so for the given ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from math import isqrt
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COLUMNS, DEFINITIONS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.outputs import columns
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle, Maneuver
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import (
    Certificate,
    Evaluator,
    OnTime,
    Trajectory,
    evaluator,
    row_times,
)
from heyoka_bike.numbers.arithmetic import Arithmetic, Balls, Number, exact_ball
from heyoka_bike.numbers.double import Double
from heyoka_bike.numbers.exact import Exact, shortest_decimal
from heyoka_bike.numbers.rounding import (
    Enclosure,
    Value,
    decided_digits,
    hi_lo,
    nearest_pair,
    upward,
)
from heyoka_bike.reference.layout import text_files
from heyoka_bike.reference.proof.variation import COUNT, Varied, slope
from heyoka_bike.reference.values import RoundedRows, Values

_RING = flint.fmpz_mpoly_ctx.get([("t", 5)], flint.Ordering.lex)
_ONE_POLYNOMIAL = _RING.constant(1)
# Placeholder for a pitch that is not known as an exact number.
_SOME_NUMBER = Exact(Fraction(1), Fraction(1))


_STATE_OF_START = {
    "roll_angle": "roll",
    "roll_rate": "roll_rate",
    "forward_speed": "speed",
    "steer_angle": "steer",
    "steer_rate": "steer_rate",
    "forward_speed_hub_global_x": "speed",  # at zero yaw the heading is the x axis
}
"""Columns whose initial value is an input of the maneuver."""


def exact_columns(bicycle: Bicycle, maneuver: Maneuver) -> dict[str, Fraction]:
    """Return those columns of the initial state whose values are rational, by name.

    A missing value is irrational, or not recognised as rational: with an initial steer angle, any
    value that depends on the pitch. Without a lean all roll angles are zero. Without roll and steer
    rates the pitch rate is zero: the condition that both wheels touch the floor is an equation for
    roll, steer and pitch, and its derivative with respect to the pitch is not zero.
    """
    known = {name: getattr(maneuver, key) for name, key in _STATE_OF_START.items()}
    found = {name: x.rational for name, x in known.items() if x.is_rational} | {"yaw": Fraction(0)}
    if maneuver.roll.is_zero:
        found |= {c.name: Fraction(0) for c in DEFINITIONS["roll_angle"]}
    a = RationalFunctions()
    equations = Equations.of(bicycle, a)
    zero = a.number(0)
    pitch = zero if maneuver.steer.is_zero else a.number(_SOME_NUMBER)
    roll, steer, roll_rate, steer_rate, speed = (a.number(getattr(maneuver, x)) for x in START)
    state = [roll, pitch, steer, roll_rate, steer_rate, speed / equations.k.length, zero]
    o, u = equations.unfold(state)
    u = u._replace(p=roll_rate)
    if roll_rate.is_zero and steer_rate.is_zero:
        # The roll and steer rates are zero at the start, so the rate of the pitch, q - nu, is zero,
        # too: q and nu are one number.
        turn = next((x for x in (u.q, u.nu) if x.num is not None), a.unknown())
        u = u._replace(q=turn, nu=turn)
    values = columns(equations.k, a, o, u, roll, pitch, steer, zero)
    found |= {name: x for name, v in values.items() if (x := v.rational()) is not None}
    return found


def exact_derivatives(
    bicycle: Bicycle, maneuver: Maneuver
) -> Mapping[str, Sequence[Fraction | None]]:
    """Return derivatives of the columns at the start; None for one not recognised as rational.

    With an initial steer angle only the derivatives of the inputs themselves are known.
    """
    place = {key: len(PARAMETERS) + i for i, key in enumerate(START)}
    found: dict[str, Sequence[Fraction | None]] = {
        name: [Fraction(int(i == place[key])) for i in range(COUNT)]
        for name, key in _STATE_OF_START.items()
    }
    found["yaw"] = [Fraction(0)] * COUNT
    if not maneuver.steer.is_zero:
        return found
    a = RationalFunctions()
    varied = Varied.of(bicycle, maneuver, a.number(0), a, is_regular=True)
    columns = varied.columns(Equations.of(bicycle, a))
    return {
        name: [_element(slope(x, i)).rational() for i in range(COUNT)]
        for name, x in columns.items()
    } | found


def _operator(operate: Callable[[Element, Element], Element]) -> Callable[[Element, Any], Element]:
    """Return an operator whose second operand may also be an integer."""

    def of_any(self: Element, other: Any) -> Element:
        is_known = isinstance(other, Element | int)
        return operate(self, _element(other)) if is_known else NotImplemented

    return of_any


class Element:
    """A rational function, an angle known only by its exact value, or an unknown number."""

    __slots__ = ("angle", "den", "num")

    def __init__(self, num: Any, den: Any = _ONE_POLYNOMIAL, angle: Exact | None = None) -> None:
        self.num, self.den, self.angle = num, den, angle
        if num is not None and den != _ONE_POLYNOMIAL:
            common = num.gcd(den)
            self.num, self.den = num // common, den // common

    def rational(self) -> Fraction | None:
        """The value if it is a rational number, else None."""
        if self.num is None or not (self.num.is_constant() and self.den.is_constant()):
            return None
        num, den = (p.leading_coefficient() if p != 0 else 0 for p in (self.num, self.den))
        return Fraction(int(num), int(den))

    @property
    def is_zero(self) -> bool:
        return self.num is not None and self.num == 0

    @_operator
    def __add__(self, x: Element) -> Element:
        if self.is_zero or x.is_zero:
            return x if self.is_zero else self
        if self.num is None or x.num is None:
            return _UNKNOWN
        return Element(self.num * x.den + x.num * self.den, self.den * x.den)

    @_operator
    def __mul__(self, x: Element) -> Element:
        if self.is_zero or x.is_zero:
            return _ZERO
        if self.num is None or x.num is None:
            return _UNKNOWN
        return Element(self.num * x.num, self.den * x.den)

    @_operator
    def __truediv__(self, x: Element) -> Element:
        if x.is_zero:
            return _UNKNOWN
        return self * (_UNKNOWN if x.num is None else Element(x.den, x.num))

    def __neg__(self) -> Element:
        return self * -1

    def __sub__(self, other: Element | int) -> Element:
        return self + -other

    def __rsub__(self, other: int) -> Element:
        return _element(other) - self

    def __rtruediv__(self, other: int) -> Element:
        return _element(other) / self

    __radd__ = __add__
    __rmul__ = __mul__


_UNKNOWN = Element(None)
_ZERO = Element(_RING.constant(0))


def _element(x: Element | int) -> Element:
    return x if isinstance(x, Element) else Element(_RING.constant(x))


class RationalFunctions(Arithmetic):
    """The arithmetic of `Element`, for at most five different angles and unknown numbers."""

    def __init__(self) -> None:
        self._angles: list[Exact | None] = []

    def unknown(self) -> Element:
        """Return a new unknown number, which has the same value wherever it occurs."""
        self._angles.append(None)
        return Element(_RING.gens()[len(self._angles) - 1])

    def number(self, value: Exact | Fraction | int) -> Element:
        exact = value if isinstance(value, Exact) else Exact(Fraction(value))
        if not exact.is_rational:
            return Element(None, angle=exact)
        num, den = exact.rational.numerator, exact.rational.denominator
        return Element(_RING.constant(num), _RING.constant(den))

    def sin(self, x: Element) -> Element:
        t = self._half_tangent(x)
        return _UNKNOWN if t is None else Element(2 * t, 1 + t * t)

    def cos(self, x: Element) -> Element:
        t = self._half_tangent(x)
        return _UNKNOWN if t is None else Element(1 - t * t, 1 + t * t)

    def sqrt(self, x: Element) -> Element:
        value = x.rational()
        if value is None or value < 0:
            return _UNKNOWN
        num, den = isqrt(value.numerator), isqrt(value.denominator)
        if num * num != value.numerator or den * den != value.denominator:
            return _UNKNOWN
        return self.number(Fraction(num, den))

    def atan2(self, y: Element, x: Element) -> Element:
        """Return the angle if it is zero or already known, else a new unknown."""
        if y.num is None or x.num is None:
            return _UNKNOWN
        if y.is_zero and (r := x.rational()) is not None and r > 0:
            return _ZERO
        for angle in filter(None, self._angles):
            e = self.number(angle)
            sine, cosine = self.sin(e), self.cos(e)
            factor = (x / cosine).rational()
            if (y * cosine - x * sine).is_zero and factor is not None and factor > 0:
                return e
        return _UNKNOWN

    def sum(self, terms: Iterable[Number]) -> Number:
        return sum(terms, _ZERO)

    def _half_tangent(self, x: Element) -> Any:
        rational = x.rational()
        value = x.angle if rational is None else Exact(rational)
        if value is None:
            return None
        if value.is_zero:
            return _RING.constant(0)
        if value not in self._angles:
            if len(self._angles) == len(_RING.gens()):
                return None
            self._angles.append(value)
        return _RING.gens()[self._angles.index(value)]


TEXT_DIGITS = 50


def constant_columns(run: Trajectory) -> dict[str, Value]:
    """Return the columns with constant exact values: the energy, or all columns of a steady motion.

    The energy follows from the initial state alone.
    """
    exact = exact_columns(run.bicycle, run.maneuver)
    if "mechanical_energy" in exact and not run.maneuver.is_straight:
        return {"mechanical_energy": exact["mechanical_energy"]}
    equations = Equations.of(run.bicycle, Balls(run.evaluation_bits))
    with equations.precision():
        start = equations.columns(initial_state(equations, run.maneuver))
    if run.maneuver.is_straight:
        return {**start, **exact}
    return {"mechanical_energy": start["mechanical_energy"]}


def round_rows(
    run: Trajectory, certificate: Certificate, progress: OnTime = lambda _: None
) -> RoundedRows:
    """Round every entry of the rows of a run, from enclosures of the exact values.

    Row 0 follows from the initial state in exact arithmetic, as far as it is rational. The other
    rows follow from the candidate and the certified bound on its distance from the exact motion.
    """
    at = evaluator(run, certificate=certificate)
    first = exact_columns(run.bicycle, run.maneuver)
    constant = constant_columns(run)
    enclosed = enclose_rows(at, first, constant, progress)
    names = [c.name for c in COLUMNS]
    rounded = round_columns(names, enclosed, _nearest)
    if rounded.undecided:
        by_state = {name: x for name, x in rounded.undecided.items() if name not in constant}
        enclosed = _as_claimed(run, certificate, enclosed, by_state)
        rounded = round_columns(names, enclosed, _nearest)
    text = {
        name: [decided_digits(row[name], TEXT_DIGITS) for row in enclosed]
        for name in BENCHMARK_COLUMNS
    }
    return RoundedRows(
        rounded.hi, rounded.lo, rounded.bound, undecided=rounded.undecided,
        text={name: tuple(token for token, _ in column) for name, column in text.items()},
        undecided_text={
            name: rows
            for name, column in text.items()
            if (rows := tuple(i for i, (_, is_decided) in enumerate(column) if not is_decided))
        },
    )  # fmt: skip


def _as_claimed(
    run: Trajectory, certificate: Certificate, enclosed: Sequence[dict[str, Enclosure]],
    undecided: Mapping[str, Any],
) -> Sequence[dict[str, Enclosure]]:  # fmt: skip
    """Widen the undecided entries of rows to the bounds that certificate.json states for the run.

    A reader who has only the certificate can then check the bound.
    """
    at = evaluator(run, certificate=certificate.claimed)
    found = list(map(dict, enclosed))
    with at.balls.precision():
        for i in sorted({i for rows in undecided.values() for i in rows.tolist()}):
            columns = at.columns(run.maneuver.time(i))
            for name, rows in undecided.items():
                if i in rows:
                    found[i][name] = Enclosure.of(columns[name])
    return found


def round_columns(
    names: Sequence[str], rows: Iterable[Mapping[str, Any]],
    rounded: Callable[[Any], tuple[float, float, float, bool]],
) -> Values:  # fmt: skip
    """Round columns; `rounded` returns hi, lo, their bound, and whether they are decided."""
    table = np.array([[rounded(row[name]) for name in names] for row in rows]).transpose(2, 1, 0)
    *parts, decided = (dict(zip(names, np.ascontiguousarray(part), strict=True)) for part in table)
    rows_of = {name: np.flatnonzero(x == 0).astype(np.int64) for name, x in decided.items()}
    return Values(*parts, undecided={name: x for name, x in rows_of.items() if x.size})


def _nearest(x: Enclosure) -> tuple[float, float, float, bool]:
    hi, lo, is_decided = nearest_pair(x)
    return hi, lo, distance(x, hi, lo), is_decided


def render_texts(maneuvers: Sequence[Maneuver], rows: Sequence[RoundedRows]) -> dict[str, bytes]:
    """Return the text files: one of 25 columns, or one of 9 columns for each maneuver."""
    files = {}
    for file in text_files(maneuvers):
        first = maneuvers[file.numbers[0] - 1]
        times = [shortest_decimal(first.time(i), TEXT_DIGITS) for i in range(first.rows)]
        columns = [
            r.text[name] if file.is_long else list(map(_of_17_digits, r.hi[name], r.text[name]))
            for r in (rows[number - 1] for number in file.numbers)
            for name in BENCHMARK_COLUMNS
        ]
        lines = (" ".join(row) for row in zip(times, *columns, strict=True))
        files[file.name] = ("\n".join(lines) + "\n").encode()
    return files


def _of_17_digits(hi: float, text: str) -> str:
    """Return a binary64 with 17 digits; an undecided zero is written as in the 50-digit text."""
    return text if hi == 0 and text.startswith("0e") else f"{hi:.17g}"


def distance(x: Enclosure, hi: float, lo: float) -> float:
    """Return an upper bound, as binary64, of the distance of the enclosed number from hi + lo."""
    return upward(x.minus(hi, lo).size())


def enclose_rows(
    at: Evaluator, first: Mapping[str, Fraction], constant: Mapping[str, Value],
    progress: OnTime = lambda _: None, *, is_proof: bool = True,
) -> Sequence[dict[str, Enclosure]]:  # fmt: skip
    """Enclose every column in each row: exactly in row 0 and for constants if they are known.

    In a proof, a constant column must agree with its enclosure from the state.
    """
    rows = []
    with at.balls.precision():
        for i, t in enumerate(row_times(at.trajectory.maneuver)):
            found = at.columns(t)
            for name, x in constant.items() if is_proof else ():
                if not found[name].overlaps(x if isinstance(x, flint.arb) else exact_ball(x)):
                    raise NotCertifiedError(
                        f"{at.trajectory.maneuver.name}: {name}, row {i}: the state gives "
                        f"{found[name]}, but the value that should be constant is {x}"
                    )
            row: dict[str, Value] = {**found, **constant}
            if i == 0:
                row |= first
            rows.append({name: Enclosure.of(x) for name, x in row.items()})
            progress(float(t))
    return rows


def rounded_times(maneuver: Maneuver) -> Double:
    """Return the times of the rows [s], of shape (rows,)."""
    hi, lo = np.array([hi_lo(Enclosure.of(t), "time") for t in row_times(maneuver)]).T
    return hi.copy(), lo.copy()
