"""Events of a motion: upright, greatest lean, a wheel leaving the floor, the end of the model.

An event is a zero of a function of the state. On each piece of a computed motion the function is
interpolated at Chebyshev nodes in binary64, which finds the zeros; each is then found again by
Newton's method on the function itself, in ball arithmetic, and enclosed between two times where it
has opposite signs. With a certificate these are times of the exact motion.

The model holds both wheels on the floor: their normal forces may pull. A *fall* is where a real
bicycle stops obeying it: the first time that a normal force is zero, or the end of the model, where
a wheel lies on the floor.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import floor
from typing import Any

import flint
import numpy as np
from numpy.polynomial import chebyshev

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.errors import InputError, SingularMotionError
from heyoka_bike.motion.evaluator import evaluator
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.precision import Precision

UPRIGHT = "upright"
GREATEST_LEAN = "greatest lean"
REAR_LIFT = "rear wheel leaves the floor"
FRONT_LIFT = "front wheel leaves the floor"
SINGULAR = "singularity"
FALL = "fall"
"""The first of `REAR_LIFT`, `FRONT_LIFT` and `SINGULAR`."""

LONGEST = Fraction(1000)
"""How long a fall is waited for [s]."""

Quantity = Callable[[Equations, Sequence[Number]], Number]
"""A function of a bicycle and a state of its form."""

_GUARD_BITS = 64
# A step of heyoka ends well inside the circle of convergence of its series, so the coefficients of
# the interpolation fall by more than ten each.
_NODES = 24
# Imaginary parts and ends of pieces: far above the error of the interpolation, far below what
# separates two events.
_NEAR = 1e-7
_AT_ONCE = 512  # pieces in one array
_NEWTON_STEPS = 200
_WIDEST = Fraction(1, 2**10)
_FIRST_LOOK, _LONGER = Fraction(16), 4
# The run that follows a first look ends so long after the event [s]: many times the error of
# binary64, and little beside the pieces before a singularity.
_MARGIN = Fraction(1, 2**16)
_BEFORE_SINGULARITY = Fraction(1, 2**20)


KINDS: Mapping[str, Quantity] = {
    UPRIGHT: lambda equations, state: state[0],
    GREATEST_LEAN: lambda equations, state: equations.unfold(state)[1].p,
    REAR_LIFT: lambda equations, state: forces(equations, state).rear.normal,
    FRONT_LIFT: lambda equations, state: forces(equations, state).front.normal,
}
"""What is zero at an event: roll [rad], its rate [rad/s], the normal forces [N]."""


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
    piece : int
        Piece of the trajectory that holds it.
    rises : bool
        Whether the function goes from negative to positive.
    """

    what: str
    time: flint.arb
    piece: int
    rises: bool

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
    found = [e for e in events(run, (first.what,)) if abs(e.time - first.time) < float(_MARGIN)]
    return Followed(run, found[0])


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
        found = next(events(run, kinds), singular)
        if found is not None or duration == longest:
            return found
        duration = min(duration * _LONGER, longest)


def singularity(error: SingularMotionError) -> Event:
    """The event that stopped a run."""
    return Event(SINGULAR, flint.arb(error.time, float(_BEFORE_SINGULARITY)), 0, False)


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
        Of the run; the times are then enclosures of those of the exact motion, without it of those
        of the run.
    """
    found = [e for kind in kinds for e in zeros(run, KINDS[kind], kind, certificate)]
    return iter(sorted(found, key=lambda e: float(e.time)))


def zeros(
    run: Trajectory, quantity: Quantity, what: str, certificate: Certificate | None = None
) -> list[Event]:
    """Times at which a function of the state changes its sign; see `events`."""
    motion = _Motion(run, quantity, certificate)
    found: list[Event] = []
    for piece, s, slope in _candidates(run, quantity):
        event = motion.refined(piece, s, slope, what)
        # What happens at a break is found on both sides of it, and the start is no event.
        last = float(found[-1].time) if found else 0.0
        if event is not None and float(event.time) > last + _NEAR * float(run.piece(piece).h):
            found.append(event)
    return found


class _Motion:
    """A function of the state along a run, in balls."""

    def __init__(
        self, run: Trajectory, quantity: Quantity, certificate: Certificate | None
    ) -> None:
        self.run, self.quantity = run, quantity
        self.at = evaluator(run, run.bits + _GUARD_BITS, certificate)

    def __call__(self, t: flint.arb, piece: int) -> flint.arb:
        value: flint.arb = self.quantity(self.at.equations, self.at.state(t, piece))
        return value

    def refined(self, piece: int, s: float, slope: float, what: str) -> Event | None:
        """The zero near a time, enclosed; None where the sign does not change."""
        run, step = self.run, self.run.piece(piece)
        h = float(step.h)
        with self.at.balls.precision():
            start = flint.arb(flint.fmpq(step.t0.numerator, step.t0.denominator))
            smallest = flint.arb(2) ** -run.bits * (1 + abs(start))
            t = start + h * s
            for _ in range(_NEWTON_STEPS):
                change = self(t, piece) * (h / slope)
                t = (t - change).mid()
                if not abs(t - start - h * s) < _NEAR * h:
                    return None
                if abs(change.mid()) < smallest / 4:
                    break
            radius = smallest
            while radius < float(_WIDEST):
                left, right = (self(t + side * radius, piece) for side in (-1, 1))
                if (left < 0 and right > 0) or (left > 0 and right < 0):
                    return Event(what, flint.arb(t, radius), piece, bool(right > 0))
                radius = 2 * radius
        return None


def _candidates(run: Trajectory, quantity: Quantity) -> Iterator[tuple[int, float, float]]:
    """Pieces, places in them (0 to 1) and slopes there, of the zeros in binary64."""
    equations = Equations.binary64(run.bicycle, is_regular=run.is_regular)
    nodes = chebyshev.chebpts1(_NODES)
    transform = np.linalg.inv(chebyshev.chebvander(nodes, _NODES - 1))
    for begin in range(0, run.steps, _AT_ONCE):
        state = _states(run, range(begin, min(begin + _AT_ONCE, run.steps)), (nodes + 1) / 2)
        values = quantity(equations, tuple(state))
        for i, c in enumerate(values @ transform.T):
            if abs(c[0]) > np.abs(c[1:]).sum():
                continue
            slopes = chebyshev.chebder(c)
            for root in sorted(chebyshev.chebroots(c), key=lambda z: z.real):
                if abs(root.imag) < _NEAR and abs(root.real) < 1 + _NEAR:
                    slope = 2 * float(chebyshev.chebval(root.real, slopes))
                    if slope:
                        yield begin + i, (float(root.real) + 1) / 2, slope


def _states(run: Trajectory, pieces: range, s: Any) -> Any:
    """States at places in pieces in binary64, shape (states, pieces, places)."""
    unit = 1 << run.grid
    found = np.zeros((len(run.states), len(pieces), len(s)))
    for row, i in enumerate(pieces):
        for variable, integers in enumerate(run.pieces[i]):
            powers = [c / unit for c in integers]
            found[variable, row] = np.polynomial.polynomial.polyval(s, powers)
    return found


def _check_start(run: Trajectory) -> None:
    """Both wheels must press on the floor."""
    for wheel, kind in (("rear", REAR_LIFT), ("front", FRONT_LIFT)):
        motion = _Motion(run, KINDS[kind], None)
        with motion.at.balls.precision():
            force = float(motion(flint.arb(0), 0))
        if not force > 0:
            raise InputError(
                f"{run.maneuver.name}: found a normal force of {force:.6g} N on the {wheel} wheel "
                "at the start, expected both wheels to press on the floor"
            )


def _fraction(t: flint.arb) -> Fraction:
    """Midpoint of a time, rounded down to 2^-40 s."""
    return Fraction(floor(t.mid() * 2**40), 2**40)
