"""How an error begins: what the first rows show of forces, whatever the rest of the file does.

Every maneuver begins upright and straight. There gravity does no work, so the kinetic energy has no
slope; and the bicycle is symmetric, so what its roll rate makes of it is in proportion to that.
Both are exact at the start, and need one column and no simulation.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.error_shape import BeginsAs, Unsymmetric, WorkFromStart
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY
from heyoka_bike.scoring.recognition import FASTEST_MODE
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import floor_of
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# The beginning [s]: the bicycle still is nearly where it was. Rows that it must have.
_BEGINNING, _FEWEST = 0.2, 4
# An error that begins as this power of the time at least is none of the start.
_LEAST_POWER = 1.5
# Of the speed, with which something at the start is in proportion to the roll rate: terms of the
# equations have its square, and errors of integrators a few times that.
_HIGHEST_POWER = 8
# The power of the time is seen in the error of an angle until the fastest mode, which makes it
# appear less by up to a half, has decayed.
_LESS = 0.75
_HIGHEST_TOLD = 3


def beginnings(report: Report) -> Iterator[Evidence]:
    """What the first rows show: work that is done, what is not symmetric, and how angles begin."""
    yield from _work(report.maneuvers)
    yield from _unsymmetric(report.maneuvers)
    yield from _powers(report.maneuvers)


def _given(m: ManeuverScore, key: str) -> float:
    """What a maneuver is given at the start [SI]."""
    return float(m.part.reference.rows[key][0])


def _error(c: ColumnScore) -> tuple[Array, Array] | None:
    """Times and errors of the rows of the beginning; None if the digits hide some, or the start."""
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
    """A power that the kinetic energy of every maneuver begins to change with."""
    powers: dict[int, float] = {}
    forces: dict[int, float] = {}
    for m in maneuvers:
        c = next((c for c in m.columns if c.key == "kinetic_energy" and c.values), None)
        speed = _given(m, "forward_speed")
        if c is None or not speed:
            continue
        if (slope := _slope(c)) is None:
            return
        powers[m.maneuver], forces[m.maneuver] = slope, slope / speed
    if powers:
        yield WorkFromStart(powers, forces)


def _slope(c: ColumnScore) -> float | None:
    """With which the error of a column begins; None if it bends, or is hidden.

    That of a method of order 1 bends: implicit Euler's with 0.002 s by a tenth.
    """
    if (shown := _error(c)) is None:
        return None
    time, error = shown
    middle = int(np.searchsorted(time, time[-1] / 2.0))
    early = float(error[middle] / time[middle])
    late = float((error[-1] - error[middle]) / (time[-1] - time[middle]))
    return early if BY_FAR * abs(late - early) < abs(early) else None


def _unsymmetric(maneuvers: Sequence[ManeuverScore]) -> Iterator[Unsymmetric]:
    """Errors that are as large in two maneuvers, though the roll rate of one is far larger."""
    pairs = [
        sorted(pair, key=lambda m: abs(_given(m, "roll_rate")))
        for pair in combinations(maneuvers, 2)
    ]
    # Those of similar speeds first: what a force does depends on the speed.
    pairs.sort(key=lambda pair: abs(np.diff([_given(m, "forward_speed") for m in pair])[0]))
    for small, large in pairs:
        slow, fast = (abs(_given(m, "roll_rate")) for m in (small, large))
        # What differs with a power of the speed may differ as much.
        first, second = sorted(_given(m, "forward_speed") for m in (small, large))
        is_slower = AS_GOOD * slow * second**_HIGHEST_POWER < fast * first**_HIGHEST_POWER
        if not fast or not is_slower:
            continue
        theirs = {c.key: c for c in large.columns if c.values}
        for c in small.columns:
            if c.key not in LATERAL or c.key not in theirs or not c.values:
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
    """The power of the time with which an angle's error begins, the least of the maneuvers."""
    keys = {c.key for m in maneuvers for c in m.columns if c.key in LATERAL and c.unit == "rad"}
    found: dict[str, tuple[int, tuple[int, ...]]] = {}
    for key in sorted(keys):
        each = {m.maneuver: order for m in maneuvers for c in m.columns
                if c.key == key and _is_wrong(c) and (order := _power(c)) is not None}  # fmt: skip
        # What is a start in one and a force in another tells nothing.
        if each and (min(each.values()) > 1 or max(each.values()) == 1):
            found[key] = min(each.values()), tuple(each)
    for (order, numbers), alike in grouped((x, key) for key, x in found.items()).items():
        yield BeginsAs(tuple(alike), order, numbers)


def _is_wrong(c: ColumnScore) -> bool:
    """True if a column is off by what is seen in a plot: integrators are off by less."""
    return c.error > TOLERANCE


def _power(c: ColumnScore) -> int | None:
    """The power of the time with which a column's error begins; None if the rows do not show it."""
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
    return min(int(np.ceil(power - 1.0 + _LESS)), _HIGHEST_TOLD) or None
