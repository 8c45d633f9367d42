"""Events of a motion: upright, greatest lean, a wheel leaving the floor, the end of the model.

An event is a zero of a function of the state. Every piece of the motion is bisected in time until
ball arithmetic shows one of three things on each span, for every state that the motion can have
there:

- the function does not vanish;
- its rate does not vanish. Newton's method in intervals then either shows that there is no zero, or
  isolates a tiny span outside of which the function has known signs;
- shorter spans would not help: in the middle the function cannot be distinguished from zero, and
  over the span it changes by less than its uncertainty.

A piece is examined only inside its own interval, where its bounds hold. Adjacent spans that may
contain zeros are joined, also across breaks. If the rate has one sign there, the signs on both
sides show whether there is exactly one zero or none. Every other case is reported as undecided.

With a certificate the states are those of the exact motion, the rate follows from the equations of
motion, and the result is proved for the exact motion: every zero is in one of the events, and each
event with `is_single` is exactly one zero. Without a certificate the result is about the
polynomials, and pieces in which a binary64 interpolation finds no zero are skipped, which is no
proof.

The model keeps both wheels on the floor, so its normal forces may pull. A *fall* is the moment from
which a real bicycle would not follow the model: the first time that a normal force is zero, or the
end of the model, where a wheel lies on the floor.

A dataset ends at the last row that the motion reaches (`ending`). If that is earlier than
requested, the name of the maneuver says so, in every file.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil, floor
from typing import Any

import flint
import numpy as np
from numpy.polynomial import chebyshev

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import MAX_ROWS, Bicycle, Maneuver
from heyoka_bike.errors import InputError, SingularMotionError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Certificate, Trajectory, evaluator
from heyoka_bike.numbers.analytic import Samples
from heyoka_bike.numbers.arithmetic import Number, exact_ball, sign_of, span_ball, upper_fraction
from heyoka_bike.numbers.ball_matrices import total
from heyoka_bike.numbers.double import with_usual_errors
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision

UPRIGHT = "upright"
GREATEST_LEAN = "greatest lean"
LEAST_LEAN = "least lean"
REAR_LIFT = "rear wheel leaves the floor"
FRONT_LIFT = "front wheel leaves the floor"
SINGULAR = "singularity"
FALL = "fall"
"""The first of `REAR_LIFT`, `FRONT_LIFT` and `SINGULAR`."""

MAX_SEARCH_TIME = Fraction(1000)
"""The search for a fall ends at this time [s]."""

_FIRST_SEARCH, _GROWTH = Fraction(16), 4
# The precise run ends this long after the event found by the binary64 run [s]. This is much longer
# than the error of binary64, and much shorter than the pieces before a singularity.
_MARGIN = Fraction(1, 2**16)
_BEFORE_SINGULARITY = Fraction(1, 2**20)


# Maximum number of spans of one piece that are examined. Around a zero where the function touches
# zero without crossing it, each bisection adds two spans. Only a function that is zero throughout,
# and whose rate cannot be shown to be zero, reaches the limit.
_MOST_SPANS = 4096
# Number of interpolation nodes in a piece. A step of heyoka ends well inside the circle of
# convergence of its series, so each coefficient of the interpolation is smaller than the previous
# one by more than a factor of ten.
_NODES_OF_PIECE = 24
# Allowance for the truncation of an interpolation or a series, relative to the sum of its
# coefficients. It is far above the truncation error. A series is not used if its last coefficients
# exceed this allowance.
_SLACK = 1e-7
# Number of terms of the Taylor series, and how many of its last terms are checked.
_TERMS_OF_PIECE, _LAST_TERMS = 24, 3
# Radius of the circle on which `Samples` evaluates a function. With this radius, aliasing changes
# the terms of the series by less than 4^-32 of the function.
_RADIUS_OF_SAMPLES = 4
_PIECES_AT_ONCE = 512  # maximum number of pieces in one array
# Fraction of the first piece. If the function is zero at the start and there is no certificate, a
# zero within this fraction counts as the start itself.
_AT_START = Fraction(1, 2**24)


Quantity = Callable[[Equations, Sequence[Number]], Number]
"""A function of a bicycle and a state of its form."""


def _lean_rate(equations: Equations, state: Sequence[Number]) -> Number:
    # In the regular form the roll rate is a state variable, exact at the start of a maneuver.
    return state[3] if equations.is_regular else equations.unfold(state)[1].p


KINDS: Mapping[str, Quantity] = {
    UPRIGHT: lambda equations, state: state[0],
    GREATEST_LEAN: _lean_rate,
    LEAST_LEAN: _lean_rate,
    REAR_LIFT: lambda equations, state: forces(equations, state).rear.normal,
    FRONT_LIFT: lambda equations, state: forces(equations, state).front.normal,
}
"""The functions that vanish at events: roll [rad], its rate [rad/s], the normal forces [N].

The magnitude of the roll angle has a maximum at a greatest lean and a nonzero minimum at a least
lean. The bicycle may be upright in between.
"""


@dataclass(frozen=True, slots=True)
class Event:
    """A zero of one of the functions in `KINDS` along a motion, or a singularity.

    Attributes
    ----------
    what : str
        One of `KINDS`, or `SINGULAR`.
    time : arb
        An enclosure of the time [s]. For a singularity it contains the time at which the step
        became too short, and its width is the distance of the run from the singularity.
    rises : bool or None
        Whether the function goes from negative to positive over `time`. None if its signs before
        and after are equal or unknown: then it is undecided whether the event takes place, for
        instance where the function only touches zero.
    is_single : bool
        Whether the event is shown to happen exactly once in `time`. If not, it happens an odd
        number of times, or any number of times if `rises` is None.
    """

    what: str
    time: flint.arb
    rises: bool | None
    is_single: bool

    @property
    def sooner(self) -> Fraction:
        """A time [s] shortly before a singularity, at which a run is still accurate."""
        return _fraction(self.time) - 2 * _BEFORE_SINGULARITY


@dataclass(frozen=True, slots=True)
class Followed:
    """A motion that was integrated up to an event, or up to the end of the search.

    Attributes
    ----------
    run : Trajectory
        It ends shortly after the event, or shortly before a singularity.
    event : Event or None
        None if nothing happened.
    """

    run: Trajectory
    event: Event | None


@with_usual_errors
def follow(
    bicycle: Bicycle, maneuver: Maneuver, precision: Precision | str | int = "binary64", *,
    until: str = FALL, longest: Fraction = MAX_SEARCH_TIME,
) -> Followed:  # fmt: skip
    """Integrate a maneuver until an event happens, whatever its own duration is.

    Parameters
    ----------
    bicycle, maneuver
        The bicycle and the maneuver to integrate.
    precision
        Precision of the run and of the event, see `Precision.of`.
    until
        `FALL`, or one of `KINDS`; a singularity ends the motion in any case.
    longest : Fraction
        The search ends at this time [s].

    Returns
    -------
    Followed
        The run, and the event that ends it.

    Raises
    ------
    InputError
        The initial state is unreachable, a wheel is pulled to the floor there, or `until` is
        unknown.
    MissingPackageError
        heyoka is not installed.
    """
    first = first_event(bicycle, maneuver, until=until, longest=longest)
    if first is None:
        end = longest
    elif first.what == SINGULAR:
        end = first.sooner
    else:
        end = _fraction(first.time) + _MARGIN
    run = integrate(bicycle, replace(maneuver, duration=end), precision)
    if first is None or first.what == SINGULAR:
        return Followed(run, first)
    found = (e for e in _decided(run, (first.what,)) if abs(e.time - first.time) < float(_MARGIN))
    return Followed(run, next(found))


def first_event(
    bicycle: Bicycle, maneuver: Maneuver, *, until: str = FALL, longest: Fraction = MAX_SEARCH_TIME
) -> Event | None:
    """Return the first event after the start, from a run in binary64; see `follow`."""
    if until != FALL and until not in KINDS:
        raise InputError(f"found event '{until}', expected one of {', '.join((FALL, *KINDS))}")
    kinds = (REAR_LIFT, FRONT_LIFT) if until == FALL else (until,)
    duration = min(_FIRST_SEARCH, longest)
    while True:
        singular: Event | None = None
        try:
            run = integrate(bicycle, replace(maneuver, duration=duration))
        except SingularMotionError as e:
            singular = singularity(e)
            if singular.sooner <= 0:
                return singular
            run = integrate(bicycle, replace(maneuver, duration=singular.sooner))
        if until == FALL:
            _check_start(run)
        found = next(_decided(run, kinds), singular)
        if found is not None or duration == longest:
            return found
        duration = min(duration * _GROWTH, longest)


def singularity(error: SingularMotionError) -> Event:
    """Return, as an event, the singularity that stopped a run."""
    time = flint.arb(error.time, float(_BEFORE_SINGULARITY))
    return Event(SINGULAR, time, rises=None, is_single=False)


def events(
    run: Trajectory, kinds: Sequence[str] = tuple(KINDS), certificate: Certificate | None = None
) -> Iterator[Event]:
    """Yield all events after the start up to the end of a run, in order of time.

    Parameters
    ----------
    run : Trajectory
    kinds
        Keys of `KINDS`.
    certificate : Certificate, optional
        The certificate of the run. With it, every event of the exact motion is one of the events
        yielded, and their times are enclosures: this is proved in ball arithmetic. Without it, the
        events are those of the run's polynomials, searched for in the pieces in which a binary64
        interpolation finds a possible zero. That is no proof.

    Returns
    -------
    iterator of Event
        Undecided events are included, see `Event.rises`.
    """
    at = evaluator(run, certificate=certificate)
    found: list[Event] = []
    with at.balls.precision():
        for kind in kinds:
            for event in zeros(run, KINDS[kind], kind, certificate):
                if kind not in (GREATEST_LEAN, LEAST_LEAN) or event.rises is None:
                    found.append(event)
                    continue
                roll = at.state(event.time)[0]
                if not (roll < 0 or roll > 0):
                    found.append(replace(event, rises=None, is_single=False))
                elif (event.rises == bool(roll < 0)) == (kind == GREATEST_LEAN):
                    found.append(event)
    return iter(sorted(found, key=lambda e: float(e.time)))


def zeros(
    run: Trajectory, quantity: Quantity, what: str, certificate: Certificate | None = None
) -> list[Event]:
    """Return all zeros of a function of the state after the start of a run, in order of time.

    Parameters
    ----------
    run, certificate
        See `events`.
    quantity
        The function.
    what
        Name of the events.
    """
    along = _FunctionAlongRun(run, quantity, certificate)
    found = []
    with along.at.balls.precision():
        start = along.exact_start()
        is_zero, earliest = bool(start == 0), run.breaks[1] * _AT_START
        # Without a certificate the polynomials need not begin exactly at the initial state, so the
        # sign at the start is not used.
        for group, before, after in _groups(along.spans(), sign_of(start) if certificate else 0):
            if is_zero and group[0].low == 0:
                # Just after a zero the function has the sign of its rate.
                before = group[0].way
            way, *others = {span.way for span in group}
            is_monotone = bool(way) and not others
            holds_none = is_monotone and (before == way or after == -way)
            is_start = is_zero and not certificate and group[-1].high <= earliest
            if holds_none or is_start:
                continue
            rises = after > 0 if before * after < 0 else None
            time = span_ball(group[0].low, group[-1].high)
            found.append(Event(what, time, rises, is_monotone and rises is not None))
    return found


@dataclass(frozen=True, slots=True)
class _Span:
    """A time span [s] with the sign of the function and of its rate; 0 if a sign is not known."""

    low: Fraction
    high: Fraction
    sign: int
    way: int = 0


def _groups(spans: Iterable[_Span], before: int) -> Iterator[tuple[list[_Span], int, int]]:
    """Yield groups of adjacent spans that may contain zeros, with the signs before and after."""
    group: list[_Span] = []
    for span in spans:
        if not span.sign:
            group.append(span)
            continue
        if group:
            yield group, before, span.sign
        elif before * span.sign < 0:
            # Without a certificate the polynomials of a run may be discontinuous, so the function
            # may jump past zero.
            yield [_Span(span.low, span.low, 0, span.sign)], before, span.sign
        before, group = span.sign, []
    if group:
        yield group, before, 0


class _FunctionAlongRun:
    """A function of the state along a run, in ball arithmetic."""

    def __init__(
        self, run: Trajectory, quantity: Quantity, certificate: Certificate | None
    ) -> None:
        self.run, self.quantity, self.certificate = run, quantity, certificate
        self.at = evaluator(run, certificate=certificate)
        self.duals = self.at.equations.over(Duals(self.at.balls))
        self.samples = Samples.of(self.at.balls.bits, _TERMS_OF_PIECE, _RADIUS_OF_SAMPLES)

    def exact_start(self) -> flint.arb:
        """Return the value of the function at the exact initial state."""
        equations = Equations.of(self.run.bicycle, self.at.balls)
        return flint.arb(self.quantity(equations, initial_state(equations, self.run.maneuver)))

    def value(self, piece: int, t: Fraction | flint.arb) -> flint.arb:
        """Return the function at a time [s] of a piece."""
        return flint.arb(self.quantity(self.at.equations, self.at.state(t, piece)))

    def bounds(self, piece: int, low: Fraction, high: Fraction) -> tuple[flint.arb, flint.arb]:
        """Enclose the function over a span, and its rate [1/s] if the sign is not clear."""
        if self.certificate is None:
            return self._estimated(piece, low, high)
        span, middle = span_ball(low, high), (low + high) / 2
        whole = self.value(piece, span)
        if sign_of(whole):
            return whole, flint.arb.nan()
        state = self.at.state(span, piece)
        rates = self.at.equations.rates_with_yaw(state)
        moving = [Dual(x, (rate,)) for x, rate in zip(state, rates, strict=True)]
        found = self.quantity(self.duals, moving)
        rate = flint.arb(found.slopes[0] if isinstance(found, Dual) else 0)
        return self.value(piece, middle) + rate * (span - exact_ball(middle)), rate

    def _estimated(self, piece: int, low: Fraction, high: Fraction) -> tuple[flint.arb, flint.arb]:
        """Estimate the function and its rate on the polynomials by a Taylor series.

        The truncation error is observed to be small, not bounded.
        """
        half, a = exact_ball((high - low) / 2), self.samples
        with a.precision():
            state = a.polynomials(self.run.around(piece, (low + high) / 2, half, _TERMS_OF_PIECE))
            value = self.quantity(self.at.equations.over(a), state)
            ((here, *rest),) = a.coefficients([value])
        sizes = [abs(c) for c in rest]
        if not total(sizes[-_LAST_TERMS:]) <= _SLACK * total(sizes):
            return flint.arb.nan(), flint.arb.nan()
        bend = total(m * size for m, size in enumerate(sizes, start=1)) - sizes[0]
        over = here + flint.arb(0, (total(sizes) * (1 + _SLACK)).upper())
        return over, (rest[0] + flint.arb(0, (bend * (1 + _SLACK)).upper())) / half

    def spans(self) -> Iterator[_Span]:
        """Divide the run into spans, each with the sign of the function; 0 if it is not known."""
        signs = (
            [0] * self.run.steps if self.certificate else _estimated_signs(self.run, self.quantity)
        )
        for piece, sign in enumerate(signs):
            low, high = self.run.breaks[piece : piece + 2]
            if sign:
                yield _Span(low, high, sign)
            else:
                yield from self._isolated(piece, low, high)

    def _isolated(self, piece: int, low: Fraction, high: Fraction) -> Iterator[_Span]:
        """Divide a piece into spans on which a sign is shown, or on which none can be shown."""
        smallest = (high - low) / 2**self.run.bits
        rest, count = [(low, high)], 0
        while rest:
            low, high = rest.pop()
            count += 1
            value, rate = self.bounds(piece, low, high)
            if sign := sign_of(value):
                yield _Span(low, high, sign)
            elif way := sign_of(rate):
                yield from self._narrowed(piece, _Span(low, high, 0, way), rate, smallest)
            elif (
                self._is_undecidable(piece, low, high, rate)
                or high - low < smallest
                or count > _MOST_SPANS
            ):
                yield _Span(low, high, 0)
            else:
                middle = (low + high) / 2
                rest += [(middle, high), (low, middle)]

    def _narrowed(
        self, piece: int, span: _Span, rate: flint.arb, smallest: Fraction
    ) -> Iterator[_Span]:
        """Cut off the ends of a span where the function has a sign; its rate keeps its sign."""
        low, high, way = span.low, span.high, span.way
        while True:
            width, middle = high - low, (low + high) / 2
            # Interval Newton method: for every possible slope, the line through the value in the
            # middle has its zero in `root`.
            root = exact_ball(middle) - self.value(piece, middle) / rate
            first, last = -upper_fraction(-root), upper_fraction(root)
            if last < low or first > high:
                yield _Span(span.low, span.high, way if last < low else -way)
                return
            low, high = max(low, first), min(high, last)
            if high - low < smallest or 4 * (high - low) > 3 * width:
                break
            _, tighter = self.bounds(piece, low, high)
            rate = tighter if sign_of(tighter) else rate
        if span.low < low:
            yield _Span(span.low, low, -way)
        yield _Span(low, high, 0, way)
        if high < span.high:
            yield _Span(high, span.high, way)

    def _is_undecidable(self, piece: int, low: Fraction, high: Fraction, rate: flint.arb) -> bool:
        """True if the uncertainty in the middle of a span exceeds the change over it."""
        here = self.value(piece, (low + high) / 2)
        change = abs(rate) * exact_ball((high - low) / 2)
        hidden = here.contains(0) and change.upper() <= here.rad() / 8
        return not here.is_finite() or bool(hidden)


def _estimated_signs(run: Trajectory, quantity: Quantity) -> Iterator[int]:
    """Yield the sign of the function for each piece, in binary64; 0 if it may vanish there."""
    equations = Equations.binary64(run.bicycle, is_regular=run.is_regular)
    nodes = chebyshev.chebpts1(_NODES_OF_PIECE)
    transform = np.linalg.inv(chebyshev.chebvander(nodes, _NODES_OF_PIECE - 1))
    for begin in range(0, run.steps, _PIECES_AT_ONCE):
        state = _states(run, range(begin, min(begin + _PIECES_AT_ONCE, run.steps)), (nodes + 1) / 2)
        for c in quantity(equations, tuple(state)) @ transform.T:
            is_clear = abs(c[0]) > (1 + _SLACK) * np.abs(c[1:]).sum() + _SLACK * np.abs(c).max()
            yield int(np.sign(c[0])) if is_clear else 0


def _states(run: Trajectory, pieces: range, s: Any) -> Any:
    """Return states at positions s in pieces, in binary64, shape (states, pieces, positions)."""
    unit = 1 << run.grid
    found = np.zeros((len(run.states), len(pieces), len(s)))
    for row, i in enumerate(pieces):
        for variable, integers in enumerate(run.pieces[i]):
            powers = [c / unit for c in integers]
            found[variable, row] = np.polynomial.polynomial.polyval(s, powers)
    return found


def _decided(run: Trajectory, kinds: Sequence[str]) -> Iterator[Event]:
    """Yield the events that certainly take place."""
    return (e for e in events(run, kinds) if e.rises is not None)


def _check_start(run: Trajectory) -> None:
    """Raise an error unless both wheels press on the floor at the start."""
    at = evaluator(run)
    for wheel, kind in (("rear", REAR_LIFT), ("front", FRONT_LIFT)):
        with at.balls.precision():
            force = float(KINDS[kind](at.equations, at.state(Fraction(0))))
        if not force > 0:
            raise InputError(
                f"{run.maneuver.name}: found a normal force of {force:.6g} N on the {wheel} wheel "
                "at the start, expected both wheels to press on the floor"
            )


def _fraction(t: flint.arb) -> Fraction:
    """Return the midpoint of a time, rounded down to a multiple of 2^-40 s."""
    return Fraction(floor(t.mid() * 2**40), 2**40)


@dataclass(frozen=True, slots=True)
class Ending:
    """A maneuver that ends at its last row.

    Attributes
    ----------
    maneuver : Maneuver
    said : str or None
        Why the maneuver ends there; None if it has its own duration.
    is_early : bool
        Whether the duration is shorter than requested.
    """

    maneuver: Maneuver
    said: str | None = None
    is_early: bool = False


def ending(bicycle: Bicycle, maneuver: Maneuver, until: str | None = None) -> Ending:
    """Return the maneuver with its duration cut at an event or a time.

    Parameters
    ----------
    until
        ``fall``, or a time [s] in place of the maneuver's duration.

    Raises
    ------
    InputError
        `until` is not valid, or fewer than two rows would remain.
    """
    if until == FALL:
        return _until_fall(bicycle, maneuver)
    asked = maneuver if until is None else replace(maneuver, duration=_time(maneuver, until))
    try:
        integrate(bicycle, asked)
    except SingularMotionError as e:
        kept = _last_row_before(maneuver, singularity(e), str(e))
        name = f"{maneuver.name}, stopped at {float(kept):g} of {float(asked.duration):g} s"
        return Ending(replace(maneuver, name=name, duration=kept), str(e), is_early=True)
    return Ending(asked)


def _until_fall(bicycle: Bicycle, maneuver: Maneuver) -> Ending:
    event = first_event(bicycle, maneuver, longest=MAX_SEARCH_TIME)
    if event is None:
        said = f"it does not fall within {float(MAX_SEARCH_TIME):g} s"
        name = f"{maneuver.name}, no fall within {float(MAX_SEARCH_TIME):g} s"
        return Ending(replace(maneuver, name=name), said, is_early=True)
    said = f"the {event.what}" if event.what != SINGULAR else "the motion meets a singularity"
    said = f"{said} at t = {float(event.time):.9g} s"
    return Ending(replace(maneuver, duration=_last_row_before(maneuver, event, said)), said)


def _last_row_before(maneuver: Maneuver, event: Event, said: str) -> Fraction:
    """Return the time of the last row before an event [s]."""
    row = ceil(event.sooner / maneuver.spacing) - 1
    if row < 1:
        raise InputError(
            f"{maneuver.name}: {said}, before its second row at {float(maneuver.spacing):g} s; "
            "use a shorter spacing, or a motion that lasts longer"
        )
    _check_rows(maneuver, row)
    return row * maneuver.spacing


def _time(maneuver: Maneuver, text: str) -> Fraction:
    try:
        time = Exact.parse(text)
    except ValueError as e:
        raise InputError(f"--until: {e}, or 'fall'") from None
    if not time.is_rational or time.rational <= 0:
        raise InputError(f"--until: found '{text}', expected 'fall' or a positive time [s]")
    rows = time.rational / maneuver.spacing
    if rows.denominator != 1:
        raise InputError(
            f"--until: found {text} s, expected a multiple of the spacing of {maneuver.name}, "
            f"{float(maneuver.spacing):g} s"
        )
    _check_rows(maneuver, int(rows))
    return time.rational


def _check_rows(maneuver: Maneuver, last: int) -> None:
    if last >= MAX_ROWS:
        raise InputError(
            f"{maneuver.name}: found {last + 1} rows, expected {MAX_ROWS} or fewer; use a longer "
            "spacing"
        )
