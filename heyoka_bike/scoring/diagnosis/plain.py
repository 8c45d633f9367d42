"""Findings that need no simulation.

A bicycle that falls over, rows that stand still, columns of another maneuver, a start that is
another one, and columns that are wrong beside a motion that is right: those of the benchmark, and
those beside it, for which no program is simulated. There the same number in every row, or the right
one times a factor or with another zero, is seen.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, LATERAL
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.findings import Finding, info, named, warning
from heyoka_bike.scoring.findings import maneuvers as of_maneuvers
from heyoka_bike.scoring.judge.own_definitions import RIGHT_MOTION, far_worse, is_far
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

_FEW_ROWS = 10
# Of the rows of two maneuvers, so many hold the same numbers.
_PART_OF_EQUAL_ROWS = 0.9
# Of the rows in each part of the run, so many are between others.
_BETWEEN, _PARTS_OF_RUN = 0.2, 4
# What a start may be off by, in parts of itself, and in what the digits tell.
_PART_OF_RIGHT_START, _FLOORS_OF_ROUNDING = 1e-6, 4.0
# Worse at all than others, and explained to a thirtieth, or a hundredth, by one number or two.
_WORSE, _NEARLY, _TIMES_WORSE_THAN_BEFORE = 10.0, 30.0, 100.0
# Of the rows, between which times are told, and times that are the same.
_MOST_ROWS, _SAME_TIME = (0.05, 0.95), 0.1
# So many columns tell the time: of correct programs one is left a sixth of the error, in one
# maneuver a thirtieth.
_OTHERS = 3
# Lying on the floor, the lowest that a bicycle gets: a lean of a quarter turn, and of its potential
# energy less than so much, as other units of the angle do not make it.
_LEAN_OF_LYING, _LEFT_OF_HEIGHT = np.pi / 2, 0.5
# ... and falls there from upright, by less than so much from row to row, as noise does not [rad].
_UPRIGHT, _STRIDE = 0.1, 1.0
_GIVEN = ("roll_rate", "forward_speed")
# An energy that is wrong makes the sum wrong.
_ENERGY_PARTS, _SUM = {"potential_energy", "kinetic_energy"}, "mechanical_energy"
_ADVICE = "look at how it is computed and written"
DEPARTS = "departs"
"""Code of the finding that the motion is right up to some row."""
FALLS = "falls_over"
"""Code of the finding that the bicycle falls over."""


@dataclass(frozen=True, slots=True)
class Scaled:
    """Values are a factor times the right ones, and an offset [SI]."""

    factor: float
    offset: float

    def says(self, unit: str) -> str:
        times = f"{self.factor:.6g} times the right one" if self.factor != 1.0 else "the right one"
        sign = "minus" if self.offset < 0 else "plus"
        return times + (f" {sign} {_in(abs(self.offset), unit)}" if self.offset else "")


def shown(report: Report) -> tuple[Finding, ...]:
    """Return what is seen at once, whatever else is found."""
    finders = (_falls_over, _standing_still, _between, _of_other_maneuvers, _other_starts)
    found = [found for finder in finders for found in finder(report.maneuvers)]
    known = {f.evidence.get("maneuver") for f in found}
    return (*found, *_departures([m for m in report.maneuvers if m.maneuver not in known]))


def _falls_over(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """A lean that grows to a quarter turn or more, where that of the reference does not."""
    times = {}
    for m in maneuvers:
        traces = {c.key: c.trace for c in m.columns if c.values == m.rows}
        if not {"roll_angle", "potential_energy"} <= traces.keys():
            continue
        roll, height = traces["roll_angle"], traces["potential_energy"]
        low = height.value < _LEFT_OF_HEIGHT * height.reference
        lies = (
            low & (np.abs(roll.value) > _LEAN_OF_LYING) & (np.abs(roll.reference) < _LEAN_OF_LYING)
        )
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
    """Last rows that repeat one another, in all columns or in some, of a motion that does not."""
    for m in maneuvers:
        whole = [c for c in m.columns if c.values == m.rows]
        still = {c.key: m.rows - _last_step(c) for c in whole}
        others = [c for c in whole if still[c.key] < _FEW_ROWS]
        standing = [c for c in whole if c not in others and _moves(c, 0)]
        held = [c for c in standing if _moves(c, -still[c.key])]
        if not held or any(_worst(c) > RIGHT_MOTION for c in others):
            continue
        shown = held if others else standing
        rows = min(still[c.key] for c in shown)
        time = float(held[0].trace.time[m.rows - rows])
        which = f"rows of {named([c.key for c in shown])}" if others else "rows"
        why = "they were" if others else "the motion ended there, and its last row was"
        yield warning(
            "rows_repeated",
            f"From {time:.6g} s on all {rows} {which} of maneuver {m.maneuver} hold the same "
            f"numbers: {why} written again",
            maneuver=m.maneuver,
            time=time,
            rows=rows,
            columns=[c.key for c in shown],
        )


def _last_step(c: ColumnScore) -> int:
    """The last row that is another one than the row before; 0 if none is."""
    return int(np.max(np.flatnonzero(np.diff(c.trace.value)) + 1, initial=0))


def _moves(c: ColumnScore, first: int) -> bool:
    """True if the right column moves, from a row on."""
    return float(np.ptp(c.trace.reference[first:])) > _WORSE * (c.floor or 0.0)


def _between(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """Rows held, or on straight lines between fewer rows, in all angles and rates."""
    for m in maneuvers:
        lateral = [c for c in m.columns if c.key in LATERAL and c.values == m.rows]
        for order, what in (
            (1, "repeat the row before"),
            (2, "are on straight lines between rows"),
        ):
            share = min((_flat(c, order) for c in lateral), default=0.0)
            if share > _BETWEEN:
                yield warning(
                    "rows_between",
                    f"At least {100 * share:.0f} % of the rows of maneuver {m.maneuver} {what}, "
                    "in all its angles and rates, as no motion does: rows of the integrator were "
                    "held or interpolated. Write its own rows, or its dense output at the times "
                    "asked for",
                    maneuver=m.maneuver,
                    order=order - 1,
                    share=share,
                )
                break


def _flat(c: ColumnScore, order: int) -> float:
    """Least share of rows without a step, or a bend, of those where the right motion has one.

    Until the last step, after which all stands still.
    """
    tiny = _FLOORS_OF_ROUNDING * 2.0**order * (c.floor or 0.0)
    rows = slice(_last_step(c) + 1)
    step = np.diff(c.trace.time[rows])
    # Two rows at one time have no slope.
    with np.errstate(all="ignore"):
        found, right = (
            np.abs(np.diff(x) if order == 1 else np.diff(np.diff(x) / step) * step[1:])
            for x in (c.trace.value[rows], c.trace.reference[rows])
        )
    moves = right > _WORSE * tiny
    # Between others it goes on by steps of any size; few digits make many of the same.
    if len(moves) < _FEW_ROWS or 2 * moves.sum() <= len(moves):
        return 0.0
    steps = np.round(found[moves & (found > np.median(right))] / (tiny or 1.0), 1)
    if 2 * len(np.unique(steps)) <= len(steps):
        return 0.0
    # In all parts of the run but one: a motion that dies away ends on a straight line.
    parts = np.array_split(found[moves] <= tiny, _PARTS_OF_RUN)
    return sorted(float(np.mean(x)) for x in parts)[1]


def _departures(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """A row from which on all is a hundred times farther off than in every row before."""
    for m in maneuvers:
        columns = _whole(m)
        if not columns:
            continue
        error = np.max([np.abs(c.trace.error) / c.scale for c in columns], axis=0)
        off = np.maximum(error, max(ROUNDING, *((c.floor or 0.0) / c.scale for c in columns)))
        before = np.maximum.accumulate(off)[:-1]
        jumps = np.flatnonzero(off[1:] > _TIMES_WORSE_THAN_BEFORE * before)
        row = next((int(i) + 1 for i in jumps if i >= _FEW_ROWS), 0)
        if not row or before[row - 1] > RIGHT_MOTION:
            continue
        right, time = before[row - 1], columns[0].trace.time
        end = int(np.flatnonzero(off > _TIMES_WORSE_THAN_BEFORE * right)[-1]) + 1
        is_back = m.rows - end >= _FEW_ROWS
        ahead, relief = _ahead(columns, slice(row, None))
        is_shifted = relief > _NEARLY
        if is_back:
            what = f"to {time[end - 1]:.6g} s. All rows after these are right: look at these alone"
        elif is_shifted:
            why = "left out" if ahead > 0.0 else "made twice"
            when = _later(float(ahead))
            what = f"on, where it is the right motion {when}: a row or a step was {why}"
        else:
            what = (
                "on. A mistake in the model or at the start is seen from the first rows on: look "
                "at what happens there, such as an event, an input or an impulse that sets in, or "
                "a restart from rounded numbers"
            )
        yield warning(
            DEPARTS,
            f"Maneuver {m.maneuver} is right to {right:.1g} of the scales until "
            f"{time[row - 1]:.6g} s, and off by {off[row]:.2g} from {time[row]:.6g} s {what}",
            maneuver=m.maneuver,
            time=float(time[row]),
            before=float(right),
            after=float(off[row]),
            shift=float(ahead) if is_shifted and not is_back else None,
        )


def other_times(report: Report) -> Finding | None:
    """Rows that are the right motion at other times than those that are written."""
    found, relief = {}, []
    for m in report.maneuvers:
        columns = _whole(m)
        if len(columns) < _OTHERS or m.rows <= _FEW_ROWS:
            return None
        ahead, left = _ahead(columns, slice(None), axis=0)
        relief.append(left)
        found[str(m.maneuver)] = tuple(np.quantile(ahead, _MOST_ROWS).tolist())
    if not (max(relief) > _TIMES_WORSE_THAN_BEFORE and np.exp(np.mean(np.log(relief))) > _NEARLY):
        return None
    least, most = min(x for x, _ in found.values()), max(x for _, x in found.values())
    is_one = most - least < _SAME_TIME * abs(most + least)
    when = _later((least + most) / 2) if is_one else f"{_later(least)} to {_later(most)}"
    return warning(
        "other_times",
        f"Each row is the right motion, but at another time, {when} than is written. Look at how "
        "the times are written, and at when a row is: before or after the step, at the time asked "
        "for or at the step next to it",
        ahead=found,
        relief=relief,
    )


def _whole(m: ManeuverScore) -> list[ColumnScore]:
    """Columns with a value in every row, whose definition is known."""
    return [c for c in m.columns if c.values == m.rows and c.is_known and c.scale]


def _ahead(
    columns: Sequence[ColumnScore], rows: slice, axis: int | None = None
) -> tuple[Array, float]:
    """Time by which rows are ahead of those written, and the factor by which it lets errors fall.

    One time for all rows, or along axis 0 that of each [s]; to second order.
    """
    error = np.array([c.trace.error / c.scale for c in columns])
    right = np.array([c.trace.reference / c.scale for c in columns])
    # Two rows at one time have no slope, and then no time is found.
    with np.errstate(all="ignore"):
        slope = np.gradient(right, columns[0].trace.time, axis=1)
        bend = np.gradient(slope, columns[0].trace.time, axis=1)[:, rows]
        error, slope, ahead = error[:, rows], slope[:, rows], np.zeros(())
        for _ in range(3):
            way = slope + ahead / 2.0 * bend
            ahead = np.sum(error * way, axis) / np.sum(way**2, axis)
        return ahead, float(np.divide(rms(error.ravel()), rms((error - ahead * way).ravel())))


def _later(seconds: float) -> str:
    return f"{abs(seconds):.3g} s {'later' if seconds > 0.0 else 'earlier'}"


def _of_other_maneuvers(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """Columns that are the same numbers in two maneuvers, though these differ."""
    for i, m in enumerate(maneuvers):
        for other in maneuvers[:i]:
            theirs = {c.key: c for c in other.columns}
            same = [c.key for c in m.columns if c.key in theirs and _are_same(c, theirs[c.key])]
            if not same:
                continue
            right, worse = sorted((m, other), key=lambda x: max(_worst(x[key]) for key in same))
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
    return float(np.mean(a.value[:n] == b.value[:n])) > _PART_OF_EQUAL_ROWS


def _worst(c: ColumnScore) -> float:
    return c.as_understood.measures.max_rel_error or 0.0


def _other_starts(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """First rows with another roll rate or speed than the maneuver is given."""
    for m in maneuvers:
        for c in m.columns:
            if c.key not in _GIVEN or not c.values or not c.is_known or c.trace.time[0] != 0.0:
                continue
            given = float(c.trace.reference[0])
            here, off = float(c.trace.value[0]), abs(float(c.trace.error[0]))
            if off > max(_PART_OF_RIGHT_START * abs(given), _FLOORS_OF_ROUNDING * (c.floor or 0.0)):
                unit = c.unit.replace(" s-1", "/s")
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
    apart = {key for keys, _ in each.values() for key in keys}
    if not apart or any(not keys and limit > RIGHT_MOTION for keys, limit in each.values()):
        return None
    with_sum = ""
    if _SUM in apart and apart & _ENERGY_PARTS:
        apart.remove(_SUM)
        with_sum = ", and mechanical_energy with it"
    wrong = {key: places for key, places in report.by_column().items() if key in apart}
    found = {
        key: [m.maneuver for m, c in places if is_far(c, each[m.maneuver][1], _WORSE)]
        for key, places in wrong.items()
    }
    only = ", ".join(
        key if len(numbers) == len(each) else f"{key} of {of_maneuvers(numbers)}"
        for key, numbers in found.items()
    )
    fits = {key: fit for key, places in wrong.items() if (fit := scaled([c for _, c in places]))}
    rest = max(limit for _, limit in each.values())
    scales = "".join(f": {key} is {fit.says(wrong[key][0][1].unit)}" for key, fit in fits.items())
    are, these = ("is", "this column is") if len(found) == 1 else ("are", "these columns are")
    return warning(
        "columns_apart",
        f"Only {only} {are} wrong{with_sum}{scales}. All other columns are right to {rest:.1g} of "
        "their scales, so neither the integrator nor the equations are to blame. Look at how "
        f"{these} computed and written",
        columns=found,
        max_rel_error_of_others=rest,
        factors={key: fit.factor for key, fit in fits.items()},
    )


def beside(report: Report, left_out: Collection[str] = ()) -> tuple[Finding, ...]:
    """Return findings about the columns that are not the benchmark's and not right.

    Parameters
    ----------
    left_out
        Keys of columns of unknown meaning; those are not held to be right, and only named here if
        a factor or an offset explains them.
    """
    found: list[Finding] = []
    others = []
    for key, places in report.by_column().items():
        wrong = [
            (m, c) for m, c in places if not (c.is_right or c.is_at_floor(_FLOORS_OF_ROUNDING))
        ]
        if key in BENCHMARK_COLUMNS or not wrong:
            continue
        if all(_is_alone(m, c, left_out) for m, c in wrong):
            columns = {m.maneuver: c for m, c in wrong}
            found += _wrong_alone(key, columns, is_unknown=key in left_out)
        elif key not in left_out:
            others.append(key)
    if others:
        found.append(
            info(
                "not_diagnosed",
                f"{named(others)}: not right either, and not diagnosed, as programs with mistakes "
                "are simulated for the benchmark's columns only; begin with those",
                columns=others,
            )
        )
    return tuple(found)


def _is_alone(m: ManeuverScore, c: ColumnScore, left_out: Collection[str]) -> bool:
    """True if the benchmark's columns of the maneuver are right, and this one far from that."""
    right = [x for x in m.columns if x.values and x.key in BENCHMARK_COLUMNS]
    errors = [x.max_rel_error or 0.0 for x in right if x.key not in left_out]
    limit = max(errors, default=1.0)
    return limit < RIGHT_MOTION and is_far(c, limit, _WORSE)


def _wrong_alone(
    key: str, columns: Mapping[int, ColumnScore], *, is_unknown: bool
) -> Iterator[Finding]:
    """Yield the finding about a column that is wrong alone, by the number of the maneuver."""
    worst = max(c.max_rel_error or 0.0 for c in columns.values())
    alone = "while the benchmark's columns here are right"
    unit = next(iter(columns.values())).unit
    # The number in every row, where the right one moves.
    held = [float(c.trace.value[0]) for c in columns.values()
            if not np.ptp(c.trace.value) and np.ptp(c.trace.reference)]  # fmt: skip
    fit = scaled([*columns.values()])
    evidence: dict[str, object] = {}
    if len(held) == len(columns):
        numbers = " / ".join(_in(x, unit) for x in dict.fromkeys(held))
        said = f"holds the same number in every row, {numbers}, {alone}: "
        said += "it was not computed, or not written"
        evidence = {"constant": held}
    elif fit:
        said = f"is {fit.says(unit)}, {alone}: {_ADVICE}"
        evidence = {"factor": fit.factor, "offset": fit.offset}
    elif is_unknown:
        return
    else:
        said = (
            f"is wrong by up to {worst:.2g} of its scale, {alone}, and neither a factor nor an "
            f"offset explains it: {_ADVICE}. Programs with mistakes are simulated for the "
            "benchmark's columns only"
        )
    where = f"{key} of maneuver {', '.join(map(str, columns))}"
    evidence = {"column": key, "maneuvers": [*columns], "max_rel_error": worst, **evidence}
    yield warning("column_beside", f"{where} {said}", **evidence)


def _in(x: float, unit: str) -> str:
    return f"{x:.6g}" + ("" if unit == "1" else " " + unit.replace(" s-1", "/s"))


def scaled(columns: Sequence[ColumnScore]) -> Scaled | None:
    """The factor, the offset or both, the same in all maneuvers, that explain a column."""
    sizes = np.concatenate([np.full(c.values, rms(c.trace.reference) or 1.0) for c in columns])
    value = np.concatenate([c.trace.value for c in columns]) / sizes
    right = np.concatenate([c.trace.reference for c in columns]) / sizes
    both = np.column_stack([right, 1.0 / sizes])

    def solved(matrix: Array, goal: Array) -> list[float]:
        return [float(x) for x in np.linalg.lstsq(matrix, goal, rcond=None)[0]]

    found = [Scaled(solved(both[:, :1], value)[0], 0.0)]
    found.append(Scaled(1.0, solved(both[:, 1:], value - right)[0]))
    found.append(Scaled(*solved(both, value)))
    for count, fit in zip((1, 1, 2), found, strict=True):
        if len(value) > count and all(_explains(fit, c) for c in columns):
            return fit
    return None


def _explains(fit: Scaled, c: ColumnScore) -> bool:
    left = c.trace.value - fit.factor * c.trace.reference - fit.offset
    return _TIMES_WORSE_THAN_BEFORE * rms(left) < rms(c.trace.error)
