"""The end of a run: the maneuver's duration, another time, or the fall of the bicycle.

A set of rows ends at the last row that the motion reaches. Where that is sooner than was asked for
the maneuver's name says so, and with it every file.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil

from heyoka_bike.bicycle.parameters import MAX_ROWS, Bicycle, Maneuver
from heyoka_bike.errors import InputError, SingularMotionError
from heyoka_bike.motion.events import FALL, LONGEST, SINGULAR, Event, first_event, singularity
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.exact import Exact


@dataclass(frozen=True, slots=True)
class Ending:
    """A maneuver with the duration that it gets.

    Attributes
    ----------
    maneuver : Maneuver
    said : str or None
        What ends it, where that is not its own duration.
    is_early : bool
        Whether it is less than what was asked for.
    """

    maneuver: Maneuver
    said: str | None = None
    is_early: bool = False


def ending(bicycle: Bicycle, maneuver: Maneuver, until: str | None = None) -> Ending:
    """The maneuver up to its end.

    Parameters
    ----------
    until
        ``fall``, or a time [s] in place of the maneuver's duration.

    Raises
    ------
    InputError
        No such end, or none that leaves two rows.
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
    event = first_event(bicycle, maneuver, longest=LONGEST)
    if event is None:
        said = f"it does not fall within {float(LONGEST):g} s"
        name = f"{maneuver.name}, no fall within {float(LONGEST):g} s"
        return Ending(replace(maneuver, name=name), said, is_early=True)
    said = f"the {event.what}" if event.what != SINGULAR else "the motion meets a singularity"
    said = f"{said} at t = {float(event.time):.9g} s"
    return Ending(replace(maneuver, duration=_last_row_before(maneuver, event, said)), said)


def _last_row_before(maneuver: Maneuver, event: Event, said: str) -> Fraction:
    """The time of the last row before an event [s]."""
    row = ceil(event.sooner / maneuver.spacing) - 1
    if row < 1:
        raise InputError(
            f"{maneuver.name}: {said}, before its second row at {float(maneuver.spacing):g} s, "
            "expected a motion that lasts longer, or a shorter spacing"
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
            f"--until: found {text} s, expected a whole number of the spacings of {maneuver.name}, "
            f"{float(maneuver.spacing):g} s"
        )
    _check_rows(maneuver, int(rows))
    return time.rational


def _check_rows(maneuver: Maneuver, last: int) -> None:
    if last >= MAX_ROWS:
        raise InputError(
            f"{maneuver.name}: found {last + 1} rows, expected {MAX_ROWS} or fewer (a longer "
            "spacing)"
        )
