"""Events of a motion: upright, greatest lean, a wheel leaving the floor, the end of the model.

An event is a zero of a function of the state, isolated by `crossings`. With a certificate what is
said is proved of the exact motion: every zero is in one of the events, and those with `is_single`
are exactly one zero each. What could not be decided is among them, and says so.

The model holds both wheels on the floor: their normal forces may pull. A *fall* is where a real
bicycle stops obeying it: the first time that a normal force is zero, or the end of the model, where
a wheel lies on the floor.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import floor

import flint

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.errors import InputError, SingularMotionError
from heyoka_bike.motion.crossings import Quantity, crossings
from heyoka_bike.motion.evaluator import evaluator
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.numbers.arithmetic import Number, span_ball
from heyoka_bike.numbers.precision import Precision

UPRIGHT = "upright"
GREATEST_LEAN = "greatest lean"
LEAST_LEAN = "least lean"
REAR_LIFT = "rear wheel leaves the floor"
FRONT_LIFT = "front wheel leaves the floor"
SINGULAR = "singularity"
FALL = "fall"
"""The first of `REAR_LIFT`, `FRONT_LIFT` and `SINGULAR`."""

LONGEST = Fraction(1000)
"""Longest time that is searched for a fall [s]."""

_GUARD_BITS = 64
_FIRST_LOOK, _LONGER = Fraction(16), 4
# The run that follows a first look ends so long after the event [s]: many times the error of
# binary64, and little beside the pieces before a singularity.
_MARGIN = Fraction(1, 2**16)
_BEFORE_SINGULARITY = Fraction(1, 2**20)


def _lean_rate(equations: Equations, state: Sequence[Number]) -> Number:
    # A state variable of the regular form, exact where a maneuver starts.
    return state[3] if equations.is_regular else equations.unfold(state)[1].p


KINDS: Mapping[str, Quantity] = {
    UPRIGHT: lambda equations, state: state[0],
    GREATEST_LEAN: _lean_rate,
    LEAST_LEAN: _lean_rate,
    REAR_LIFT: lambda equations, state: forces(equations, state).rear.normal,
    FRONT_LIFT: lambda equations, state: forces(equations, state).front.normal,
}
"""The functions that vanish at events: roll [rad], its rate [rad/s], the normal forces [N].

At a greatest lean the roll angle has a maximum in magnitude, at a least lean a minimum that is not
zero; in between there may be an upright.
"""


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happens along a motion.

    Attributes
    ----------
    what : str
        One of `KINDS`, or `SINGULAR`.
    time : arb
        An enclosure of the time [s]. That of a singularity holds the time at which the step became
        too short, and is as wide as the run is far from it.
    rises : bool or None
        Whether the function goes from negative to positive over `time`. None if it has the same
        sign before and after, or one that is not known: undecided whether the event takes place at
        all, as where a function only touches zero.
    is_single : bool
        Whether it is shown to happen exactly once in `time`. Else it happens an odd number of
        times, or, where `rises` is None, any number.
    """

    what: str
    time: flint.arb
    rises: bool | None
    is_single: bool

    @property
    def sooner(self) -> Fraction:
        """A time [s] shortly before it, at which a run that meets a singularity is still good."""
        return _fraction(self.time) - 2 * _BEFORE_SINGULARITY


@dataclass(frozen=True, slots=True)
class Followed:
    """A motion up to an event, or as long as it was waited for.

    Attributes
    ----------
    run : Trajectory
        It ends shortly after the event, or shortly before a singularity.
    event : Event or None
        None if nothing happened.
    """

    run: Trajectory
    event: Event | None


def follow(
    bicycle: Bicycle, maneuver: Maneuver, precision: Precision | str | int = "binary64", *,
    until: str = FALL, longest: Fraction = LONGEST,
) -> Followed:  # fmt: skip
    """Integrate a maneuver until something happens, whatever its own duration is.

    Parameters
    ----------
    bicycle, maneuver
        What is integrated.
    precision
        Of the run and of the event, see `Precision.of`.
    until
        `FALL`, or one of `KINDS`; a singularity ends the motion in any case.
    longest : Fraction
        How long to wait for it [s].

    Returns
    -------
    Followed
        The run, and the event that ends it.

    Raises
    ------
    InputError
        The initial state is unreachable, or a wheel is pulled to the floor there; another `until`.
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
    bicycle: Bicycle, maneuver: Maneuver, *, until: str = FALL, longest: Fraction = LONGEST
) -> Event | None:
    """The first event after the start, from a run in binary64; see `follow`."""
    if until != FALL and until not in KINDS:
        raise InputError(f"found event '{until}', expected {', '.join((FALL, *KINDS))}")
    kinds = (REAR_LIFT, FRONT_LIFT) if until == FALL else (until,)
    duration = min(_FIRST_LOOK, longest)
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
        duration = min(duration * _LONGER, longest)


def singularity(error: SingularMotionError) -> Event:
    """The event that stopped a run."""
    time = flint.arb(error.time, float(_BEFORE_SINGULARITY))
    return Event(SINGULAR, time, rises=None, is_single=False)


def events(
    run: Trajectory, kinds: Sequence[str] = tuple(KINDS), certificate: Certificate | None = None
) -> Iterator[Event]:
    """All events after the start up to the end of a run, in their order.

    Parameters
    ----------
    run : Trajectory
    kinds
        Of `KINDS`.
    certificate : Certificate, optional
        Of the run. With it every event of the exact motion is in one of those given, and their
        times are enclosures: proved in ball arithmetic. Without it the same is said of the run's
        polynomials, on pieces where an interpolation in binary64 sees that there may be one. That
        is not proved.

    Returns
    -------
    iterator of Event
        Those that are undecided too, see `Event.rises`.
    """
    at = evaluator(run, run.bits + _GUARD_BITS, certificate)
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
    """Times at which a function of the state vanishes; see `events`."""
    found = crossings(run, quantity, certificate)
    with flint.ctx.workprec(run.bits + _GUARD_BITS):
        return [Event(what, span_ball(c.low, c.high), c.rises, c.is_single) for c in found]


def _decided(run: Trajectory, kinds: Sequence[str]) -> Iterator[Event]:
    """Events that take place."""
    return (e for e in events(run, kinds) if e.rises is not None)


def _check_start(run: Trajectory) -> None:
    """Both wheels must press on the floor."""
    at = evaluator(run, run.bits + _GUARD_BITS)
    for wheel, kind in (("rear", REAR_LIFT), ("front", FRONT_LIFT)):
        with at.balls.precision():
            force = float(KINDS[kind](at.equations, at.state(Fraction(0))))
        if not force > 0:
            raise InputError(
                f"{run.maneuver.name}: found a normal force of {force:.6g} N on the {wheel} wheel "
                "at the start, expected both wheels to press on the floor"
            )


def _fraction(t: flint.arb) -> Fraction:
    """Midpoint of a time, rounded down to 2^-40 s."""
    return Fraction(floor(t.mid() * 2**40), 2**40)
