"""Evidence from the first rows: the way in which an error begins shows some forces.

Every maneuver begins upright and straight. There gravity does no work, so the kinetic energy has no
slope. The bicycle is symmetric, so errors of a symmetric model begin in proportion to the initial
roll rate. Both statements are exact at the start, and testing them needs one column and no
simulation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import ANGLE_OF, LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Severity, maneuvers
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY
from heyoka_bike.scoring.recognition import FASTEST_MODE
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import floor_of
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# Duration of the beginning of a run, in which the bicycle is still nearly in its initial state [s],
# and minimum number of rows in this time after the first row.
_BEGINNING, _FEWEST = 0.2, 4
# An angle's error that grows at least as fast as this power of time does not come from the initial
# conditions. For the error of a rate, the limit is one less.
_LEAST_POWER = 1.5
# The effect of a force is assumed to grow at most with this power of the initial speed. Terms of
# the equations grow with its square, and errors of integrators with a power a few times as high.
_HIGHEST_POWER = 8
# Until the fastest mode has decayed, it makes the power of time in the error of an angle seem lower
# by up to 1/2. This value is larger, for a margin: a power is rounded up if its fractional part
# exceeds 1 - 0.75, so 2.3 counts as 3.
_LESS = 0.75
# At first, the error of an angle grows like a power of time. Powers above this one are reported as
# this one.
_HIGHEST_REPORTED = 3
# Columns whose errors show a force along the direction of motion.
_ALONG = ("forward_speed", "kinetic_energy")


@dataclass(frozen=True, slots=True)
class WorkFromStart(Evidence):
    """From the first row on the kinetic energy changes, although gravity does no work there.

    Attributes
    ----------
    powers, forces
        By maneuver number: the initial rate of change of the kinetic energy [W], and the force
        along the motion with this power [N]. If the file has no kinetic energy, they are computed
        from the speed.
    """

    powers: Mapping[int, float]
    forces: Mapping[int, float]

    only_describes = True
    code = "work_from_start"
    severity = Severity.WARNING

    def message(self) -> str:
        each = ", ".join(f"{x:.3g} W in maneuver {n}" for n, x in self.powers.items())
        forces = ", ".join(f"{x:.3g} N" for x in self.forces.values())
        return (
            f"From the first row on, the kinetic energy changes at a rate of {each}, although "
            f"gravity does no work there. A force of {forces} along the motion would cause this: "
            "drag, wind, a slope or a drive. If a smaller step reduces the rate, the integrator "
            "causes it"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "powers": {str(n): x for n, x in self.powers.items()},
            "forces": {str(n): x for n, x in self.forces.items()},
        }


@dataclass(frozen=True, slots=True)
class NoForceAlong(Evidence):
    """In the first rows a wrong forward speed is right, so no force acts along the motion there.

    Attributes
    ----------
    time
        End of these rows [s].
    forces
        By maneuver number: a constant force that would change the speed until this time by as much
        as the error or its resolution limit [N].
    """

    time: float
    forces: Mapping[int, float]

    only_describes = True
    code = "no_force_along"

    def message(self) -> str:
        largest = max(self.forces.values())
        return (
            f"In the first {self.time:.3g} s the forward speed shows no force along the motion "
            f"above {largest:.1g} N (drag, friction, a slope or a drive). The speed becomes wrong "
            "later, as it does if roll and steer are wrong. Their columns show more"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"time": self.time, "forces": {str(n): x for n, x in self.forces.items()}}


@dataclass(frozen=True, slots=True)
class Unsymmetric(Evidence):
    """An error begins alike in two maneuvers, although their initial roll rates differ greatly.

    Attributes
    ----------
    key
    small, large
        The numbers of the maneuvers with the small and the large initial roll rate.
    times
        Ratio of the error in `large` to the error in `small`.
    """

    key: str
    small: int
    large: int
    times: float

    only_describes = True
    code = "unsymmetric"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"In the first rows, the error of {self.key} is only {self.times:.2g} times as large "
            f"in maneuver {self.large} as in maneuver {self.small}, which has a far smaller roll "
            "rate. Look for an asymmetry (mass, axis, torque, wind, slope) or constant friction"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": [self.small, self.large], "times": self.times}


@dataclass(frozen=True, slots=True)
class BeginsAs(Evidence):
    """The error of angles, or of rates, begins in proportion to a power of the time.

    Attributes
    ----------
    keys : tuple of str
        Either angles or rates.
    order
        The power in the error of an angle; that of its rate is lower by 1. 1 indicates a wrong
        initial rate, wrong times or an integrator; 2 a force or a wrong initial speed; 3 a force
        that is zero at the start. Higher powers count as 3.
    maneuvers
    is_alone
        True if the file has no other column of roll and steer, which would show whether the motion
        or only the output is wrong.
    """

    keys: tuple[str, ...]
    order: int
    maneuvers: tuple[int, ...]
    is_alone: bool = False

    only_describes = True
    code = "begins_as"
    severity = Severity.WARNING

    def message(self) -> str:
        kind = "rate" if self.keys[0].endswith("rate") else "angle"
        power = ("the time", "the square of the time", "the cube of the time")[
            self.order - 1 - (kind == "rate")
        ]
        higher = ", or to a higher power of it" if self.order == _HIGHEST_REPORTED else ""
        rates = " or ".join(key.replace("angle", "rate") for key in self.keys)
        why = {
            1: (
                f"a wrong initial {rates}, wrong times, or a stiff force that acts within the "
                "first rows"
            ),
            2: "a wrong parameter, force or term that acts from the first row on, or a wrong "
            "initial speed",
            3: "a wrong parameter, force or term that has no effect while the bicycle is upright "
            "and straight, or that acts only later",
        }[self.order]
        many = len(self.keys) > 1
        if kind == "rate" and self.order < _HIGHEST_REPORTED:
            why += ", or the integrator"
        if self.is_alone:
            why += (
                ". The file has no other column of roll and steer, so the motion may also be right "
                f"and only the {kind} computed wrongly"
            )
        return (
            f"In the first rows of {maneuvers(self.maneuvers)}, the error{'s' * many} of "
            f"{' and '.join(self.keys)} grow{'s' * (not many)} in proportion to {power}"
            f"{higher}. Typical causes: {why}"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.keys[0], "columns": list(self.keys)}
        return {**where, "maneuvers": list(self.maneuvers), "order": self.order}


def beginnings(report: Report) -> Iterator[Evidence]:
    """Yield what the first rows show: work, asymmetry, and how errors of roll and steer begin."""
    work = (*_work(report.maneuvers),)
    yield from work or _no_force_along(report)
    yield from _unsymmetric(report.maneuvers)
    yield from _powers(report.maneuvers)


def _given(m: ManeuverScore, key: str) -> float:
    """Return the given initial value of a column [SI]."""
    return float(m.part.reference.rows[key][0])


def _error(c: ColumnScore) -> tuple[Array, Array] | None:
    """Return the times and the errors of a column in the rows of the beginning.

    None if there are too few rows, the first row is wrong or not at t = 0, or the digits hide
    errors in the second half of the beginning.
    """
    first = c.trace.time <= _BEGINNING
    time, error = c.trace.time[first], c.trace.error[first]
    if np.sum(first) <= _FEWEST or time[0] != 0.0:
        return None
    floor = floor_of(c)
    late = time >= time[-1] / 2.0
    if np.ptp(time[late]) == 0.0:
        return None
    is_shown = np.min(np.abs(error[late])) > CLEARLY * floor and abs(error[0]) <= floor
    return (time, error) if is_shown else None


def _work(maneuvers: Sequence[ManeuverScore]) -> Iterator[WorkFromStart]:
    """Yield the initial rate of change of the kinetic energy [W], if all maneuvers show it.

    The speed shows it, too: at the start the kinetic energy is nearly that of the forward motion.
    """
    powers: dict[int, float] = {}
    forces: dict[int, float] = {}
    for m in maneuvers:
        along = {c.key: c for c in m.compared if c.key in _ALONG}
        speed = _given(m, "forward_speed")
        if not along or not speed:
            continue
        key = "kinetic_energy" if "kinetic_energy" in along else "forward_speed"
        if (slope := _slope(along[key])) is None:
            return
        forces[m.maneuver] = slope / speed if key == "kinetic_energy" else _mass(m) * slope
        powers[m.maneuver] = forces[m.maneuver] * speed
    if powers:
        yield WorkFromStart(powers, forces)


def _mass(m: ManeuverScore) -> float:
    """Return the mass of a body with the initial kinetic energy and the initial speed [kg]."""
    return 2.0 * _given(m, "kinetic_energy") / _given(m, "forward_speed") ** 2


def _no_force_along(report: Report) -> Iterator[NoForceAlong]:
    """Yield the largest force along the motion that the first rows of a wrong speed allow [N].

    Only for a file without columns of roll and steer, which would show more. The force must be
    smaller by the factor `BY_FAR` than one that changes the speed by as much as its largest error.
    """
    forces = {}
    for m in report.maneuvers:
        c = next((c for c in m.compared if c.key == "forward_speed" and c.values), None)
        if c is None or any(c.key in LATERAL for c in m.columns) or c.trace.time[0] != 0.0:
            return
        first = c.trace.time <= _BEGINNING
        if np.sum(first) <= _FEWEST or not _is_wrong(c):
            continue
        error, time = np.abs(c.trace.error), c.trace.time
        slope = max(float(np.max(error[first])), floor_of(c)) / float(time[first][-1])
        if BY_FAR * slope < float(np.max(error)) / float(time[-1]):
            forces[m.maneuver] = _mass(m) * slope
    if forces:
        yield NoForceAlong(_BEGINNING, forces)


def _slope(c: ColumnScore) -> float | None:
    """Return the initial slope of a column's error; None if the error is hidden or not straight.

    The error of a method of order 1 is not straight: with implicit Euler's method and a step of
    0.002 s, its slope changes by 10 %.
    """
    if (shown := _error(c)) is None:
        return None
    time, error = shown
    middle = int(np.searchsorted(time, time[-1] / 2.0))
    early = float(error[middle] / time[middle])
    late = float((error[-1] - error[middle]) / (time[-1] - time[middle]))
    return early if BY_FAR * abs(late - early) < abs(early) else None


def _unsymmetric(maneuvers: Sequence[ManeuverScore]) -> Iterator[Unsymmetric]:
    """Yield an error of similar size in two maneuvers whose roll rates differ greatly."""
    pairs = [
        sorted(pair, key=lambda m: abs(_given(m, "roll_rate")))
        for pair in combinations(maneuvers, 2)
    ]
    # Begin with pairs of maneuvers of similar speed, because the effect of a force depends on the
    # speed.
    pairs.sort(key=lambda pair: abs(np.diff([_given(m, "forward_speed") for m in pair])[0]))
    for small, large in pairs:
        slow, fast = (abs(_given(m, "roll_rate")) for m in (small, large))
        # Skip the pair if the different speeds could change the effect of a force as much as the
        # different roll rates do.
        first, second = sorted(_given(m, "forward_speed") for m in (small, large))
        is_slower = AS_GOOD * slow * second**_HIGHEST_POWER < fast * first**_HIGHEST_POWER
        if not fast or not is_slower:
            continue
        theirs = {c.key: c for c in large.compared}
        for c in small.compared:
            if c.key not in LATERAL or c.key not in theirs:
                continue
            one, other = _error(c), _error(theirs[c.key])
            if one is None or other is None:
                continue
            (time, error), beside = one, np.interp(one[0], *other)
            late = time >= time[-1] / 2.0
            times = np.abs(beside[late] / error[late])
            middle = int(np.argmax(late))
            growth = np.log(abs(error[-1] / error[middle])) / np.log(time[-1] / time[middle])
            least = _LEAST_POWER - c.key.endswith("rate")
            if 1.0 / AS_GOOD < np.min(times) <= np.max(times) < AS_GOOD and growth > least:
                yield Unsymmetric(c.key, small.maneuver, large.maneuver, float(np.median(times)))
                return


def _powers(maneuvers: Sequence[ManeuverScore]) -> Iterator[BeginsAs]:
    """Yield the smallest exponent p of all maneuvers, if the error of an angle begins as t^p.

    The evidence is about all maneuvers that show a power. A rate without its angle shows it, too:
    its error begins as the derivative of the angle's. An angle or a rate that the output computes
    wrongly does not count.
    """
    lateral = {c.key for m in maneuvers for c in m.columns if c.key in LATERAL}
    keys = {key for key in lateral if ANGLE_OF.get(key) not in lateral}
    found: dict[str, tuple[int, tuple[int, ...]]] = {}
    for key in sorted(keys):
        each = {m.maneuver: order for m in maneuvers for c in m.columns
                if c.key == key and _is_wrong(c) and _is_of_motion(m, c)
                and (order := _power(c)) is not None}  # fmt: skip
        # If the power is 1 in one maneuver and higher in another, the evidence is unclear and not
        # reported. A late error is not reported either if the speed is wrong from the first rows
        # on.
        is_late = bool(each) and min(each.values()) == _HIGHEST_REPORTED
        is_clear = each and (min(each.values()) > 1 or max(each.values()) == 1)
        if is_clear and not (is_late and _speed_is_wrong_at_once(maneuvers)):
            found[key] = min(each.values()), tuple(each)
    for (order, numbers, _), alike in grouped(
        ((*x, key in ANGLE_OF), key) for key, x in found.items()
    ).items():
        yield BeginsAs(tuple(alike), order, numbers, is_alone=len(lateral) == 1)


def _speed_is_wrong_at_once(maneuvers: Sequence[ManeuverScore]) -> bool:
    """True if the error of a speed or a kinetic energy grows faster than the late one of an angle.

    Then a force acts along the motion from the first rows on.
    """
    columns = (c for m in maneuvers for c in m.columns if c.key in _ALONG and _is_wrong(c))
    return any(power < _HIGHEST_REPORTED for c in columns if (power := _power(c)) is not None)


def _is_of_motion(m: ManeuverScore, c: ColumnScore) -> bool:
    """False if another column of roll and steer is better by far than an angle.

    Roll and steer are coupled, so a wrong motion is wrong in all of these columns: with the
    mistakes of the library, the error of an angle is at most 37 times as large as another.
    """
    others = [x.error for x in m.compared if x.key in LATERAL and x.key != c.key]
    return c.error <= BY_FAR * max(others, default=c.error)


def _is_wrong(c: ColumnScore) -> bool:
    """True if a column's error would be visible in a plot; few integrators make such errors."""
    return c.error > TOLERANCE


def _power(c: ColumnScore) -> int | None:
    """Return the power of time with which an error begins to grow; None if the rows hide it.

    For a rate, return the power of the error of its angle.
    """
    time, error = c.trace.time, np.abs(c.trace.error)
    floor = floor_of(c)
    if time[0] != 0.0 or error[0] > floor:
        return None
    shown = np.flatnonzero(error > CLEARLY * floor)
    if not len(shown) or not 0.0 < time[shown[0]] <= FASTEST_MODE:
        return None
    first = int(shown[0])
    later = int(np.searchsorted(time, 2.0 * time[first] * (1.0 - 1.0 / BY_FAR)))
    if later >= len(time) or later == first or not error[later] > error[first]:
        return None
    power = np.log(error[later] / error[first]) / np.log(time[later] / time[first])
    order = int(np.ceil(power - 1.0 + _LESS)) + (c.key in ANGLE_OF)
    return min(order, _HIGHEST_REPORTED) or None
