"""Zeros of a function of the state along a motion, isolated.

Every piece of the motion is bisected, in time, until one of three things is shown on each span, in
ball arithmetic and for every state that the motion can have there:

- the function does not vanish;
- its rate does not vanish. Newton's method in intervals then leaves a tiny span outside of which
  the function has known signs, or nothing;
- shorter spans would not help: in the middle the function is not told from zero, and over the span
  it does not change by more than what is unknown of it.

A piece is looked at inside its own interval, where its bounds hold. What may hold zeros is joined
where it touches, also across breaks. If the rate has one sign there, signs on both sides say
whether there is exactly one zero or none; all else is kept as undecided.

With a certificate the states are those of the exact motion, the rate is taken by the equations of
motion, and what is said is proved of the exact motion. Without one it is said of the polynomials,
and pieces on which an interpolation in binary64 sees no zero are passed over: that is not proved.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np
from numpy.polynomial import chebyshev

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.motion.evaluator import evaluator
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.numbers.analytic import PowerSeries
from heyoka_bike.numbers.arithmetic import Number, exact_ball, span_ball, upper_fraction
from heyoka_bike.numbers.ball_matrices import total
from heyoka_bike.numbers.dual import Dual, Duals

Quantity = Callable[[Equations, Sequence[Number]], Number]
"""A function of a bicycle and a state of its form."""

_GUARD_BITS = 64
# Spans of one piece; a tangent zero takes two for each bit. Reached only where the function is zero
# all along and its rate is not seen to be.
_MOST = 4096
# A step of heyoka ends well inside the circle of convergence of its series, so the coefficients of
# the interpolation fall by more than ten each.
_NODES = 24
# Far above what the interpolation or the series leaves out, relative to its coefficients.
_SLACK = 1e-7
_TERMS, _LAST_TERMS = 24, 3  # of the Taylor series
_AT_ONCE = 512  # pieces in one array
# Of a piece: without a certificate, a zero so near to a start that is a zero is the start.
_AT_START = Fraction(1, 2**24)


@dataclass(frozen=True, slots=True)
class Crossing:
    """A time span outside of which there are no zeros but those of other crossings.

    Attributes
    ----------
    low, high : Fraction
        Its ends [s].
    rises : bool or None
        Whether the function goes from negative to positive over it. None if it has the same sign
        before and after, or one of the two is not known: then nothing is shown to happen.
    is_single : bool
        Whether it is shown that there is exactly one zero, and that it changes the sign.
    """

    low: Fraction
    high: Fraction
    rises: bool | None
    is_single: bool


@dataclass(frozen=True, slots=True)
class _Span:
    """A time span [s]: the sign of the function, or 0 and that of its rate, or 0 twice."""

    low: Fraction
    high: Fraction
    sign: int
    way: int = 0


def crossings(
    run: Trajectory, quantity: Quantity, certificate: Certificate | None = None
) -> list[Crossing]:
    """All zeros after the start up to the end of a run, in their order; see above."""
    along = _Along(run, quantity, certificate)
    found = []
    with along.at.balls.precision():
        start = along.exact_start()
        is_zero = bool(start == 0)
        # Polynomials without a certificate need not begin where the exact motion does.
        for group, before, after in _groups(along.spans(), _sign(start) if certificate else 0):
            if is_zero and group[0].low == 0:
                # Just after a zero the function has the sign of its rate.
                before = group[0].way
            crossing = _joined(group, before, after)
            if crossing is not None:
                found.append(crossing)
    if is_zero and certificate is None:
        return [c for c in found if c.high > run.breaks[1] * _AT_START]
    return found


def _groups(spans: Iterable[_Span], before: int) -> Iterator[tuple[list[_Span], int, int]]:
    """Spans that touch and may hold zeros, with the signs before and after them."""
    group: list[_Span] = []
    for span in spans:
        if not span.sign:
            group.append(span)
            continue
        if group:
            yield group, before, span.sign
        elif before * span.sign < 0:
            # The polynomials of a run without a certificate may jump past zero.
            yield [_Span(span.low, span.low, 0, span.sign)], before, span.sign
        before, group = span.sign, []
    if group:
        yield group, before, 0


def _joined(group: Sequence[_Span], before: int, after: int) -> Crossing | None:
    """Return the crossing that touching spans show; None if they hold no zero."""
    way, *others = {span.way for span in group}
    is_monotone = bool(way) and not others
    if is_monotone and (before == way or after == -way):
        return None
    rises = after > 0 if before * after < 0 else None
    is_single = is_monotone and rises is not None
    return Crossing(group[0].low, group[-1].high, rises, is_single)


class _Along:
    """A function of the state along a run, in balls."""

    def __init__(
        self, run: Trajectory, quantity: Quantity, certificate: Certificate | None
    ) -> None:
        self.run, self.quantity, self.certificate = run, quantity, certificate
        self.at = evaluator(run, run.bits + _GUARD_BITS, certificate)
        self.duals = self.at.equations.over(Duals(self.at.balls))
        self.series = PowerSeries(self.at.balls.bits, _TERMS)

    def exact_start(self) -> flint.arb:
        """The function of the exact initial state."""
        equations = Equations.of(self.run.bicycle, self.at.balls)
        return flint.arb(self.quantity(equations, initial_state(equations, self.run.maneuver)))

    def value(self, piece: int, t: Fraction | flint.arb) -> flint.arb:
        """The function at a time [s] of a piece."""
        return flint.arb(self.quantity(self.at.equations, self.at.state(t, piece)))

    def bounds(self, piece: int, low: Fraction, high: Fraction) -> tuple[flint.arb, flint.arb]:
        """The function over a span of a piece, and, unless that has one sign, its rate [1/s]."""
        if self.certificate is None:
            return self._seen(piece, low, high)
        span, middle = span_ball(low, high), (low + high) / 2
        whole = self.value(piece, span)
        if _sign(whole):
            return whole, flint.arb.nan()
        state = self.at.state(span, piece)
        rates = self.at.equations.rates_with_yaw(state)
        moving = [Dual(x, (rate,)) for x, rate in zip(state, rates, strict=True)]
        found = self.quantity(self.duals, moving)
        rate = flint.arb(found.slopes[0] if isinstance(found, Dual) else 0)
        return self.value(piece, middle) + rate * (span - exact_ball(middle)), rate

    def _seen(self, piece: int, low: Fraction, high: Fraction) -> tuple[flint.arb, flint.arb]:
        """The function and its rate on the polynomials, by its Taylor series.

        What the series leaves out is seen to be small, not proved.
        """
        half = exact_ball((high - low) / 2)
        with self.series.precision():
            rows = self.run.around(piece, (low + high) / 2, half, _TERMS)
            value = self.quantity(
                self.at.equations.over(self.series), [self.series.series(row) for row in rows]
            )
            here, *rest = self.series.coefficients(value)
        sizes = [abs(c) for c in rest]
        if not total(sizes[-_LAST_TERMS:]) <= _SLACK * total(sizes):
            return flint.arb.nan(), flint.arb.nan()
        bend = total(m * size for m, size in enumerate(sizes, start=1)) - sizes[0]
        over = here + flint.arb(0, (total(sizes) * (1 + _SLACK)).upper())
        return over, (rest[0] + flint.arb(0, (bend * (1 + _SLACK)).upper())) / half

    def spans(self) -> Iterator[_Span]:
        """The whole run, span by span."""
        signs = [0] * self.run.steps if self.certificate else _seen_signs(self.run, self.quantity)
        for piece, sign in enumerate(signs):
            low, high = self.run.breaks[piece : piece + 2]
            if sign:
                yield _Span(low, high, sign)
            else:
                yield from self._isolated(piece, low, high)

    def _isolated(self, piece: int, low: Fraction, high: Fraction) -> Iterator[_Span]:
        """A piece in spans on which something is shown, or nothing can be."""
        smallest = (high - low) / 2**self.run.bits
        rest, count = [(low, high)], 0
        while rest:
            low, high = rest.pop()
            count += 1
            value, rate = self.bounds(piece, low, high)
            if sign := _sign(value):
                yield _Span(low, high, sign)
            elif way := _sign(rate):
                yield from self._narrowed(piece, _Span(low, high, 0, way), rate, smallest)
            elif self._is_lost(piece, low, high, rate) or high - low < smallest or count > _MOST:
                yield _Span(low, high, 0)
            else:
                middle = (low + high) / 2
                rest += [(middle, high), (low, middle)]

    def _narrowed(
        self, piece: int, span: _Span, rate: flint.arb, smallest: Fraction
    ) -> Iterator[_Span]:
        """A span on which the rate has a sign, but for where the function is told from zero."""
        low, high, way = span.low, span.high, span.way
        while True:
            width, middle = high - low, (low + high) / 2
            # The line through the middle with any of these slopes is zero in here.
            root = exact_ball(middle) - self.value(piece, middle) / rate
            first, last = -upper_fraction(-root), upper_fraction(root)
            if last < low or first > high:
                yield _Span(span.low, span.high, way if last < low else -way)
                return
            low, high = max(low, first), min(high, last)
            if high - low < smallest or 4 * (high - low) > 3 * width:
                break
            _, tighter = self.bounds(piece, low, high)
            rate = tighter if _sign(tighter) else rate
        if span.low < low:
            yield _Span(span.low, low, -way)
        yield _Span(low, high, 0, way)
        if high < span.high:
            yield _Span(high, span.high, way)

    def _is_lost(self, piece: int, low: Fraction, high: Fraction, rate: flint.arb) -> bool:
        """True if the uncertainty in the middle of a span exceeds the change over it."""
        here = self.value(piece, (low + high) / 2)
        change = abs(rate) * exact_ball((high - low) / 2)
        hidden = here.contains(0) and change.upper() <= here.rad() / 8
        return not here.is_finite() or bool(hidden)


def _sign(x: flint.arb) -> int:
    """1 or -1 if a ball has only such numbers, else 0."""
    return int(bool(x > 0)) - int(bool(x < 0))


def _seen_signs(run: Trajectory, quantity: Quantity) -> Iterator[int]:
    """The sign of the function by piece as binary64 sees it; 0 where it may vanish."""
    equations = Equations.binary64(run.bicycle, is_regular=run.is_regular)
    nodes = chebyshev.chebpts1(_NODES)
    transform = np.linalg.inv(chebyshev.chebvander(nodes, _NODES - 1))
    for begin in range(0, run.steps, _AT_ONCE):
        state = _states(run, range(begin, min(begin + _AT_ONCE, run.steps)), (nodes + 1) / 2)
        for c in quantity(equations, tuple(state)) @ transform.T:
            is_clear = abs(c[0]) > (1 + _SLACK) * np.abs(c[1:]).sum() + _SLACK * np.abs(c).max()
            yield int(np.sign(c[0])) if is_clear else 0


def _states(run: Trajectory, pieces: range, s: Any) -> Any:
    """States at places in pieces in binary64, shape (states, pieces, places)."""
    unit = 1 << run.grid
    found = np.zeros((len(run.states), len(pieces), len(s)))
    for row, i in enumerate(pieces):
        for variable, integers in enumerate(run.pieces[i]):
            powers = [c / unit for c in integers]
            found[variable, row] = np.polynomial.polynomial.polyval(s, powers)
    return found
