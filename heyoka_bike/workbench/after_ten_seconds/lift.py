"""The first time at which a wheel leaves the floor, proved for one initial state."""

from dataclasses import dataclass, replace
from fractions import Fraction

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.motion.events import FRONT_LIFT, REAR_LIFT, Event, events
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.reference.proof.enclose import Progress, enclose

_AFTER = Fraction(1, 2**10)
"""So long after a lift in binary64 the candidate ends [s]."""

_PRECISION = "binary128"


@dataclass(frozen=True, slots=True)
class ProvedLift:
    """Proved statements about the wheels of a motion.

    Attributes
    ----------
    lift : Event or None
        The first time that a normal force passes zero, enclosed. None if that was not shown.
    is_decided : bool
        Whether nothing was left open before it, or up to `end`: then both wheels press on the
        floor until there.
    end : Fraction
        How far was looked [s].
    """

    lift: Event | None
    is_decided: bool
    end: Fraction


def prove_lift(
    bicycle: Bicycle, maneuver: Maneuver, time: float | None, progress: Progress | None = None
) -> ProvedLift:
    """Prove when a wheel leaves the floor first, or that none does within the maneuver.

    Parameters
    ----------
    bicycle, maneuver
        The start; the duration counts where no lift is expected.
    time
        Of the lift, as found in binary64 [s]; None if none was found.

    Raises
    ------
    NotCertifiedError
        No certificate was found.
    MissingPackageError
        heyoka is not installed.
    """
    end = maneuver.duration if time is None else Fraction(time) + _AFTER
    run = integrate(bicycle, replace(maneuver, duration=end, spacing=end), _PRECISION)
    certificate = enclose(run, progress)
    found = list(events(run, (REAR_LIFT, FRONT_LIFT), certificate))
    lift = next((x for x in found if x.rises is False), None)
    before = found if lift is None else found[: found.index(lift)]
    return ProvedLift(lift, not before, end)
