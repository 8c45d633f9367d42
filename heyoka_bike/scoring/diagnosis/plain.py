"""Findings that need no simulation.

A bicycle that falls over, rows that stand still, columns of another maneuver, a start that is
another one, and columns that are wrong beside a motion that is right.
"""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.diagnosis.beside import scaled
from heyoka_bike.scoring.findings import Finding, warning
from heyoka_bike.scoring.findings import maneuvers as of_maneuvers
from heyoka_bike.scoring.judge.unknown import RIGHT, far_worse, is_far
from heyoka_bike.scoring.report import ManeuverScore, Report

_FEW_ROWS = 10
# Of the rows of two maneuvers, so many hold the same numbers.
_SAME = 0.9
# What a start may be off by, in parts of itself, and in what the digits tell.
_START, _AT_FLOOR = 1e-6, 4.0
# Worse at all, in the maneuvers where a column is not far worse.
_WORSE = 10.0
# Lying on the floor, the lowest that a bicycle gets: a lean of a quarter turn, and of its potential
# energy less than so much, as other units of the angle do not make it.
_LYING, _LEFT_OF_HEIGHT = np.pi / 2, 0.5
# ... and falls there from upright, by less than so much from row to row, as noise does not [rad].
_UPRIGHT, _STRIDE = 0.1, 1.0
_GIVEN = ("roll_rate", "forward_speed")
# An energy that is wrong makes the sum wrong.
_PARTS, _SUM = {"potential_energy", "kinetic_energy"}, "mechanical_energy"
FALLS = "falls_over"
"""Code of the finding that the bicycle falls over."""


def shown(report: Report) -> tuple[Finding, ...]:
    """Return what is seen at once, whatever else is found."""
    return (
        *_falls_over(report.maneuvers),
        *_standing_still(report.maneuvers),
        *_of_other_maneuvers(report.maneuvers),
        *_other_starts(report.maneuvers),
    )


def _falls_over(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """A lean that grows to a quarter turn or more, where that of the reference does not."""
    times = {}
    for m in maneuvers:
        traces = {c.key: c.trace for c in m.columns if c.values == m.rows}
        if not {"roll_angle", "potential_energy"} <= traces.keys():
            continue
        roll, height = traces["roll_angle"], traces["potential_energy"]
        low = height.value < _LEFT_OF_HEIGHT * height.reference
        lies = low & (np.abs(roll.value) > _LYING) & (np.abs(roll.reference) < _LYING)
        row = int(np.argmax(lies))
        way = np.abs(roll.value[: row + 1])
        if lies.any() and way[0] < _UPRIGHT and np.max(np.abs(np.diff(way))) < _STRIDE:
            times[m.maneuver] = float(roll.time[row])
    if times:
        said = " and ".join(f"at {t:.3g} s in maneuver {n}" for n, t in times.items())
        yield warning(
            FALLS,
            f"The bicycle falls over: its lean passes 90 degrees {said}. Compare the first tenths "
            "of a second: contact, friction or step there, for what follows is another motion",
            times={str(n): t for n, t in times.items()},
        )


def _standing_still(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """Last rows that repeat one another, of a motion that does not."""
    for m in maneuvers:
        columns = [c.trace for c in m.columns if c.values == m.rows and np.ptp(c.trace.reference)]
        if m.rows < _FEW_ROWS or not columns:
            continue
        moves = np.any([np.diff(c.value) != 0.0 for c in columns], axis=0)
        last = int(np.flatnonzero(moves)[-1]) + 1 if moves.any() else 0
        still = m.rows - last
        if still >= _FEW_ROWS and moves.any():
            time = float(columns[0].time[last])
            yield warning(
                "rows_repeated",
                f"From {time:.6g} s on all {still} rows of maneuver {m.maneuver} hold the same "
                "numbers: the motion ended there, and its last row was written again",
                maneuver=m.maneuver,
                time=time,
                rows=still,
            )


def _of_other_maneuvers(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """Columns that are the same numbers in two maneuvers, though these differ."""
    for i, m in enumerate(maneuvers):
        for other in maneuvers[:i]:
            theirs = {c.key: c for c in other.columns}
            same = [c.key for c in m.columns if c.key in theirs and _are_same(c, theirs[c.key])]
            if not same:
                continue
            worse = m if _worst(m, same) > _worst(other, same) else other
            right = other if worse is m else m
            yield warning(
                "column_of_another_maneuver",
                f"{', '.join(same)} of maneuver {worse.maneuver}: the same numbers as in maneuver "
                f"{right.maneuver}, where they belong",
                maneuver=worse.maneuver,
                of=right.maneuver,
                columns=same,
            )


def _are_same(one: ColumnScore, other: ColumnScore) -> bool:
    a, b = one.trace, other.trace
    n = min(len(a.value), len(b.value))
    if n < _FEW_ROWS or not np.ptp(a.value) or not np.ptp(a.reference[:n] - b.reference[:n]):
        return False
    return float(np.mean(a.value[:n] == b.value[:n])) > _SAME


def _worst(m: ManeuverScore, keys: Sequence[str]) -> float:
    return max(c.as_understood.measures.max_rel_error or 0.0 for c in m.columns if c.key in keys)


def _other_starts(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """First rows with another roll rate or speed than the maneuver is given."""
    for m in maneuvers:
        for c in m.columns:
            if c.key not in _GIVEN or not c.values or not c.is_known or c.trace.time[0] != 0.0:
                continue
            given = float(c.trace.reference[0])
            here, off = float(c.trace.value[0]), abs(float(c.trace.error[0]))
            if off > max(_START * abs(given), _AT_FLOOR * (c.floor or 0.0)):
                unit = {"rad s-1": "rad/s", "m s-1": "m/s"}.get(c.unit, c.unit)
                yield warning(
                    "another_start",
                    f"Maneuver {m.maneuver} begins with a {c.key.replace('_', ' ')} of "
                    f"{here:.9g} {unit} in its first row, where {given:.9g} is given",
                    maneuver=m.maneuver,
                    column=c.key,
                    found=here,
                    given=given,
                )


def columns_apart(report: Report) -> Finding | None:
    """Some columns are wrong, and all others show that the motion is right: look at those alone."""
    each = {m.maneuver: far_worse(m, [c.key for c in m.columns]) for m in report.maneuvers}
    apart = _apart(each)
    if not apart:
        return None
    with_sum = _SUM in apart and bool(apart & _PARTS)
    apart -= {_SUM} if with_sum else set()
    wrong = {key: places for key, places in report.by_column().items() if key in apart}
    found = {
        key: [m.maneuver for m, c in places if is_far(c, each[m.maneuver][1], _WORSE)]
        for key, places in wrong.items()
    }
    fits = {key: fit for key, places in wrong.items() if (fit := scaled([c for _, c in places]))}
    rest = max(limit for _, limit in each.values())
    scales = "".join(f": {key} is {fit.says(wrong[key][0][1].unit)}" for key, fit in fits.items())
    these = "this column is" if len(found) == 1 else "these columns are"
    return warning(
        "columns_apart",
        _only(found, len(each))
        + (", and mechanical_energy with it" if with_sum else "")
        + f"{scales}. All other columns are right to {rest:.1g} of their scales, so neither the "
        "integrator nor the equations are to blame. Look at how "
        f"{these} computed and written",
        columns=found,
        max_rel_error_of_others=rest,
        factors={key: fit.factor for key, fit in fits.items()},
    )


def _apart(each: Mapping[int, tuple[frozenset[str], float]]) -> set[str]:
    """Columns far worse than all others; none if the others of a maneuver are not right."""
    if any(not keys and limit > RIGHT for keys, limit in each.values()):
        return set()
    return {key for keys, _ in each.values() for key in keys}


def _only(found: Mapping[str, Sequence[int]], count: int) -> str:
    """The first words about wrong columns, by their maneuvers, of so many maneuvers in all."""
    only = ", ".join(
        key if len(numbers) == count else f"{key} of {of_maneuvers(numbers)}"
        for key, numbers in found.items()
    )
    return f"Only {only} {'is' if len(found) == 1 else 'are'} wrong"
