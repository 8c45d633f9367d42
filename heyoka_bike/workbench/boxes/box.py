"""Prove bounds on the weave and capsize speeds of all bicycles in a box of parameters.

Measured parameters have uncertainties. Here each parameter may lie anywhere within a number of
standard deviations of its value, independently of the others, and every statement holds for all
bicycles of that box. A standard deviation is no limit: the true value may be outside.

With x = v^2 the characteristic polynomial of the linear bicycle is

    a s^4 + v b s^3 + (c0 + c1 x) s^2 + v (d0 + d1 x) s + e0 + e1 x,

so a bicycle is stable where b, d, e and Hurwitz' determinant b c d - a d^2 - b^2 e are positive (c
is then positive too). Signs of polynomials over the whole box decide everything (`box_range`):

- capsize: if e0 and e1 differ in sign, e changes sign once. A speed is above that of all bicycles
  if the sign of e there is that of e1 for all of them, and below if it is that of e0.
- weave: if d0 < 0 < d1, d is positive beyond the x where it vanishes. If e is positive there, the
  determinant is negative; if its leading coefficient is positive, it changes sign once beyond. A
  speed is above that if d and the determinant are positive, and below if the latter is negative.

A bound starts at the critical speed of an extreme bicycle and moves outward until the sign is
proved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from typing import NamedTuple

import flint

from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle
from heyoka_bike.bicycle.stability.linear import characteristic, closed_form
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.arithmetic import Balls, Number, upper_fraction
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.exact import ZERO, Exact
from heyoka_bike.showing.document import Block, Paragraph, TableBlock
from heyoka_bike.workbench.boxes.box_range import Affines, Function, Side, corner, sign_over, slopes

# Number of guard bits beyond the digits requested. A few hundred operations lose one or two digits,
# and powers of v lose more.
_BITS_OF_RANGES = 64
_BITS_PER_DIGIT = Fraction(7, 2)

# Upper limit of v^2 in the search for capsize speeds [m^2/s^2]. It is above any capsize speed of
# interest.
_HIGH = 10**6
# Maximum number of steps in the search for an extreme critical speed. Each step goes to the corner
# of the box where the previous result suggests the extreme. Two or three steps suffice.
_MAX_STEPS = 10
# Relative margins by which v^2 moves outward until the proof succeeds, as exponents of two. A
# margin for roundoff is tried before them.
_MARGINS = (-20, -16, -12, -10, -8, -7, -6, -5, -4, -3, -2, -1)

Interval = tuple[Fraction, Fraction | None]
"""Speeds [m/s]; unbounded above if the second is None."""


@dataclass(frozen=True, slots=True)
class CriticalSpeed:
    """A weave or capsize speed over the box [m/s].

    Attributes
    ----------
    low, high
        Proved bounds: every bicycle of the box has exactly one such speed between them.
    least, most
        Speeds attained by bicycles of the box.
    deviation
        Standard deviation to first order, for independent parameters.
    """

    low: Fraction
    high: Fraction
    least: Fraction
    most: Fraction
    deviation: Fraction


@dataclass(frozen=True, slots=True)
class BoxStability:
    """Statements that hold for every bicycle of the box.

    Attributes
    ----------
    sigmas
        Half widths of the box in standard deviations.
    digits
        Number of digits of the decimals in a report.
    parameters
        Number of parameters with an uncertainty.
    weave, capsize
        The critical speed, if every bicycle has one, or none if none has; None if neither is
        proved.
    every
        Speeds at which every bicycle is proved to be stable; None if there are none.
    some
        Speeds outside of which no bicycle is stable (proved); None if none is stable anywhere.
    """

    sigmas: Fraction
    digits: int
    parameters: int
    weave: tuple[CriticalSpeed, ...] | None
    capsize: tuple[CriticalSpeed, ...] | None
    every: Interval | None
    some: Interval | None

    def as_json(self) -> dict[str, object]:
        """Return all statements as JSON values; numbers are decimals, rounded to the safe side."""
        return {
            "standard_deviations": str(self.sigmas),
            "parameters": self.parameters,
            **{
                name: None if speeds is None else [_bounds(v, self.digits) for v in speeds]
                for name, speeds in (("weave", self.weave), ("capsize", self.capsize))
            },
            "all_stable": _ends(self.every, self.digits, inward=True),
            "some_stable": _ends(self.some, self.digits, inward=False),
        }

    def blocks(self) -> tuple[Block, ...]:
        """Return the statements as a table."""
        said = (
            f"Every bicycle whose {self.parameters} uncertain parameters are each within "
            f"{self.sigmas} standard deviation(s):"
        )
        rows = []
        for name, speeds in (("weave", self.weave), ("capsize", self.capsize)):
            if speeds is None:
                rows.append([f"{name} speed [m/s]", "not decided", "", "", "", ""])
            elif not speeds:
                rows.append([f"{name} speed [m/s]", "none", "", "", "", ""])
            rows += [
                [f"{name} speed [m/s]", *_bounds(v, self.digits).values()] for v in speeds or ()
            ]
        for name, interval, inward in (
            ("all are stable [m/s]", self.every, True),
            ("none is stable outside [m/s]", self.some, False),
        ):
            ends = _ends(interval, self.digits, inward=inward)
            found = ["no speed", ""] if ends is None else [x or "no end" for x in ends.values()]
            rows.append([name, *found, "", "", ""])
        heading = ("proved", "from", "to", "attained from", "attained to", "standard deviation")
        return Paragraph(said), TableBlock(heading, rows)


def stability_box(bicycle: Bicycle, sigmas: Fraction, digits: int) -> BoxStability:
    """Enclose the critical speeds of all bicycles within some standard deviations of this one.

    Parameters
    ----------
    bicycle : Bicycle
        A bicycle with uncertainties; a parameter without one is exact.
    sigmas : Fraction
        Half width of the box in standard deviations.
    digits : int
        Digits to which the results are not affected by roundoff.

    Raises
    ------
    InputError
        The bicycle has no uncertainties, or the box contains values that the model cannot use.
    """
    if not any(u.sign for u in bicycle.uncertainties.values()):
        raise InputError(
            f"found no uncertainties of '{bicycle.name}', expected at least one in its file"
        )
    balls = Balls(int(digits * _BITS_PER_DIGIT) + _BITS_OF_RANGES)
    with balls.precision():
        box = _Box.around(bicycle, sigmas, balls)
        if box.sign(lambda p: p.a) != 1:
            raise InputError(
                f"the mass matrix of roll and steer of '{bicycle.name}' may be singular within "
                f"{float(sigmas):g} standard deviations, expected fewer standard deviations"
            )
        b, e, hurwitz = conditions = (box.damping(), box.capsize(), box.weave())
        return BoxStability(
            sigmas=sigmas,
            digits=digits,
            parameters=sum(bool(u.sign) for u in bicycle.uncertainties.values()),
            weave=hurwitz.speeds if b.sure else None,
            capsize=e.speeds,
            every=_common([x.sure for x in conditions]),
            some=_common([x.possible for x in conditions]),
        )


@dataclass(frozen=True, slots=True)
class _Condition:
    """Proved statements about where a polynomial of the speed is positive.

    Attributes
    ----------
    speeds
        Speeds at which the polynomial changes its sign, as in `BoxStability`.
    sure, possible
        Speeds at which it is positive for every bicycle, and speeds outside of which for none.
    """

    speeds: tuple[CriticalSpeed, ...] | None
    sure: Interval | None
    possible: Interval | None


_WHOLE_RANGE: Interval = (Fraction(0), None)
_IS_POSITIVE, _NEGATIVE = _Condition((), _WHOLE_RANGE, _WHOLE_RANGE), _Condition((), None, None)
_NOT_PROVED = _Condition(None, None, _WHOLE_RANGE)


class _Polynomials(NamedTuple):
    """Coefficients of the characteristic polynomial, as polynomials in x = v^2.

    The lowest power of x is first.
    """

    a: Number
    b: Number
    c: tuple[Number, Number]
    d: tuple[Number, Number]
    e: tuple[Number, Number]

    def d_at(self, x: Number) -> Number:
        return self.d[0] + self.d[1] * x

    def e_at(self, x: Number) -> Number:
        return self.e[0] + self.e[1] * x

    def hurwitz_at(self, x: Number) -> Number:
        c, d, e = self.c[0] + self.c[1] * x, self.d_at(x), self.e_at(x)
        return self.b * c * d - self.a * d * d - self.b * self.b * e

    @property
    def capsize(self) -> Number:
        """The value of x = v^2 where e vanishes."""
        return -self.e[0] / self.e[1]

    @property
    def weave(self) -> Number:
        """The largest zero x = v^2 of Hurwitz' determinant, if that is positive for larger x."""
        a, b, c, d, e = self
        p0 = b * c[0] * d[0] - a * d[0] * d[0] - b * b * e[0]
        p1 = b * (c[0] * d[1] + c[1] * d[0]) - 2 * a * d[0] * d[1] - b * b * e[1]
        p2 = b * c[1] * d[1] - a * d[1] * d[1]
        return (_sqrt(p1 * p1 - 4 * p0 * p2) - p1) / (2 * p2)


Select = Callable[[_Polynomials], Number]
Rising = Callable[[_Polynomials, Number], Number]


@dataclass(frozen=True, slots=True)
class _Box:
    """A box of parameters around a bicycle, in the order of `PARAMETERS`."""

    sides: Sequence[Side]
    centre: Sequence[flint.arb]
    deviations: Sequence[flint.arb]
    balls: Balls

    @classmethod
    def around(cls, bicycle: Bicycle, sigmas: Fraction, balls: Balls) -> _Box:
        sides, centre, deviations = [], [], []
        for symbol in PARAMETERS:
            x, u = balls.number(bicycle[symbol]), bicycle.uncertainties.get(symbol, ZERO)
            ends = x, x
            if u.sign and sigmas:
                low, high = (_moved(bicycle, symbol, k) for k in (-sigmas, sigmas))
                ends = balls.number(low), balls.number(high)
            sides.append(ends)
            centre.append(x)
            deviations.append(balls.number(u))
        return cls(sides, centre, deviations, balls)

    def function(self, select: Select) -> Function:
        """Return a function of the parameters: the value that `select` makes of `_Polynomials`."""
        return lambda x: select(self.polynomials(x))

    def polynomials(self, x: Sequence[Number]) -> _Polynomials:
        """Return the polynomials of one bicycle, or enclosures of those of a box of bicycles."""
        p = dict(zip(PARAMETERS, x, strict=True))
        g = p["g"]
        a, b, c, d, e = characteristic(*closed_form(p, Duals(Affines(self.balls))))
        return _Polynomials(a, b, (g * c[0], c[1]), (g * d[0], d[1]), (g * g * e[0], g * e[1]))

    def sign(self, select: Select) -> int | None:
        """Return the sign of a value that is proved for all bicycles of the box, or None."""
        return sign_over(self.function(select), self.sides, self.balls)

    def damping(self) -> _Condition:
        """Return the speeds at which the coefficient b is proved to be positive."""
        sign = self.sign(lambda p: p.b)
        return {1: _IS_POSITIVE, -1: _NEGATIVE}.get(sign or 0, _NOT_PROVED)

    def capsize(self) -> _Condition:
        """Return the speeds at which the coefficient e is proved to be positive."""
        first, last = self.sign(lambda p: p.e[0]), self.sign(lambda p: p.e[1])
        if first == 1 and last is None:
            return self._lowest_capsize()
        if first is None or last is None:
            return _NOT_PROVED
        if first == last:
            return _IS_POSITIVE if first > 0 else _NEGATIVE
        speed = self._speed(
            lambda p: p.capsize,
            lambda x: self.sign(lambda p: p.e_at(x)) == last,
            lambda x: self.sign(lambda p: p.e_at(x)) == first,
            lambda p, x: last * p.e_at(x),
        )
        if speed is None:
            return _NOT_PROVED
        if first > 0:
            return _Condition((speed,), (Fraction(0), speed.low), (Fraction(0), speed.high))
        return _Condition((speed,), (speed.high, None), (speed.low, None))

    def _lowest_capsize(self) -> _Condition:
        """Return the same as `capsize`, if some bicycles may have no capsize speed."""
        least = self._extreme(
            lambda p: p.capsize, lambda p, x: -p.e_at(x), -1, start=flint.arb(_HIGH)
        )
        low = self._outward(least, -1, lambda x: self.sign(lambda p: p.e_at(x)) == 1)
        if low is None or not low > 0:
            return _NOT_PROVED
        return _Condition(None, (Fraction(0), -upper_fraction(-low.sqrt())), _WHOLE_RANGE)

    def weave(self) -> _Condition:
        """Return the speeds at which d and Hurwitz' determinant are proved to be positive."""
        d = self.sign(lambda p: p.d[0]), self.sign(lambda p: p.d[1])
        if d == (-1, -1):
            return _NEGATIVE
        is_once = (
            d == (-1, 1)
            and self.sign(lambda p: p.e[0] * p.d[1] - p.e[1] * p.d[0]) == 1
            and self.sign(lambda p: p.b * p.c[1] - p.a * p.d[1]) == 1
        )
        if not is_once:
            return _NOT_PROVED
        speed = self._speed(
            lambda p: p.weave,
            lambda x: (
                self.sign(lambda p: p.d_at(x)) == 1 and self.sign(lambda p: p.hurwitz_at(x)) == 1
            ),
            lambda x: self.sign(lambda p: p.hurwitz_at(x)) == -1,
            _Polynomials.hurwitz_at,
        )
        if speed is None:
            return _NOT_PROVED
        return _Condition((speed,), (speed.high, None), (speed.low, None))

    def _speed(
        self,
        square: Select,
        is_above: Callable[[flint.arb], bool],
        is_below: Callable[[flint.arb], bool],
        rising: Rising,
    ) -> CriticalSpeed | None:
        """Return the range of a critical speed over the box; `square` is its v^2 for one bicycle.

        `is_above` and `is_below` prove that a v^2 is above or below the critical one of all
        bicycles. `rising` is negative below the critical v^2 of a bicycle and positive above it.
        """
        nominal = square(self.polynomials(self.centre))
        most = self._extreme(square, rising, 1, start=nominal)
        least = self._extreme(square, rising, -1, start=nominal)
        high, low = self._outward(most, 1, is_above), self._outward(least, -1, is_below)
        if high is None or low is None:
            return None

        def speed(x: Sequence[Number]) -> Number:
            return _sqrt(square(self.polynomials(x)))

        parts = zip(slopes(speed, self.centre, self.balls), self.deviations, strict=True)
        deviation = sum(((s * u) ** 2 for s, u in parts), flint.arb(0)).sqrt()
        least, most = least.sqrt(), most.sqrt()
        return CriticalSpeed(
            low=-upper_fraction(-low.sqrt()), high=upper_fraction(high.sqrt()),
            least=upper_fraction(least), most=-upper_fraction(-most),
            deviation=upper_fraction(deviation),
        )  # fmt: skip

    def _extreme(self, square: Select, rising: Rising, sign: int, *, start: flint.arb) -> flint.arb:
        """Return the largest (or smallest) critical v^2 found, going from corner to corner."""
        x = start
        for _ in range(_MAX_STEPS):
            found = square(self.polynomials(self._farthest(x, rising, sign)))
            if not sign * (found - x) > 0:
                break
            x = found
        return x

    def _farthest(self, x: flint.arb, rising: Rising, sign: int) -> tuple[flint.arb, ...]:
        """Return the corner of the box whose critical v^2 is probably farthest beyond x."""
        return corner(self.function(lambda p: -sign * rising(p, x)), self.sides, self.balls)

    def _outward(
        self, x: flint.arb, sign: int, is_beyond: Callable[[flint.arb], bool]
    ) -> flint.arb | None:
        """Return a v^2 slightly beyond x, proved to be beyond the critical one of all bicycles."""
        roundoff = _BITS_OF_RANGES // 2 - self.balls.bits
        for exponent in (roundoff, *_MARGINS):
            moved = (x * (1 + sign * flint.arb(2) ** exponent)).mid()
            if is_beyond(moved):
                return moved
        return None


def _moved(bicycle: Bicycle, symbol: str, sigmas: Fraction) -> Exact:
    """Return a parameter `sigmas` standard deviations away; check that the model allows it."""
    x, u = bicycle[symbol], bicycle.uncertainties[symbol]
    moved = Exact(x.rational + sigmas * u.rational, x.pi_multiple + sigmas * u.pi_multiple)
    try:
        bicycle.replace(**{symbol: moved})
    except InputError as e:
        raise InputError(f"{float(sigmas):+g} standard deviations: {e}") from None
    return moved


def _common(intervals: Sequence[Interval | None]) -> Interval | None:
    """Return the intersection of the intervals."""
    low, high = _WHOLE_RANGE
    for interval in intervals:
        if interval is None:
            return None
        low, high = max(low, interval[0]), _lesser(high, interval[1])
    return (low, high) if high is None or low < high else None


def _lesser(x: Fraction | None, y: Fraction | None) -> Fraction | None:
    return min((v for v in (x, y) if v is not None), default=None)


def _sqrt(x: Number) -> Number:
    """Return the square root of a ball or of a dual number over balls."""
    return x.chain(x.value.sqrt(), 1 / (2 * x.value.sqrt())) if isinstance(x, Dual) else x.sqrt()


# Number of digits of a standard deviation. It is estimated to first order only, so more digits
# would have no meaning.
_DEVIATION_DIGITS = 3


def uncertain_stability(bicycle: Bicycle, sigmas: str, digits: int) -> BoxStability:
    """Enclose weave and capsize speeds for parameters within `sigmas` standard deviations.

    Raises
    ------
    InputError
        `sigmas` is not a positive number, or the bicycle has no uncertainties.
    """
    return stability_box(bicycle, parse_sigmas(sigmas), digits)


def parse_sigmas(text: str) -> Fraction:
    """Read a positive number of standard deviations.

    Raises
    ------
    InputError
        The text is not a positive number.
    """
    try:
        sigmas = Exact.parse(text).fraction()
    except ValueError:
        sigmas = Fraction(0)
    if sigmas <= 0:
        raise InputError(
            f"--uncertainty: found {quoted(text)}, expected a positive number of standard "
            "deviations"
        )
    return sigmas


def below(x: Fraction, digits: int) -> str:
    """Return a decimal at or below x."""
    return str(_divided(x, digits, ROUND_FLOOR))


def above(x: Fraction, digits: int) -> str:
    """Return a decimal at or above x."""
    return str(_divided(x, digits, ROUND_CEILING))


def _divided(x: Fraction, digits: int, rounding: str) -> Decimal:
    return Context(prec=digits, rounding=rounding).divide(
        Decimal(x.numerator), Decimal(x.denominator)
    )


def _bounds(v: CriticalSpeed, digits: int) -> dict[str, str]:
    """Return the numbers of a critical speed as decimals: bounds rounded outward, others inward."""
    return {
        "from": below(v.low, digits),
        "to": above(v.high, digits),
        "attained_from": above(v.least, digits),
        "attained_to": below(v.most, digits),
        "standard_deviation": above(v.deviation, _DEVIATION_DIGITS),
    }


def _ends(interval: Interval | None, digits: int, *, inward: bool) -> dict[str, str | None] | None:
    """Return an interval of speeds as decimals, rounded inward or outward."""
    if interval is None:
        return None
    low, high = interval
    begin, end = (above, below) if inward else (below, above)
    return {"from": begin(low, digits), "to": None if high is None else end(high, digits)}
