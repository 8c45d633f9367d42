"""Align a result file with the reference: its maneuvers, its columns, its rows within the run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import product
from math import log

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED, FREE_ZERO
from heyoka_bike.errors import InputError, NothingScoredError
from heyoka_bike.numbers.double import Array, fast_two_sum, median, two_sum
from heyoka_bike.reference.layout import MOTION
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.scoring.evidence.as_compared import (
    ManeuverGuessed,
    ManeuverNamedOtherwise,
    ManeuverRecognised,
    MeantByValues,
    NoReference,
    OtherManeuver,
    OtherOrder,
    RowsOutside,
    TimesInLargerUnit,
    TooLarge,
    WheelRate,
)
from heyoka_bike.scoring.evidence.as_read import TimesFromFirst, TimeUnitContradicted
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.free import with_all_turns, with_free_values
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.reading.names.heading import TIME, number_of_file
from heyoka_bike.scoring.reading.results import Results, Rows, renamed
from heyoka_bike.scoring.reading.times import in_seconds, in_unit
from heyoka_bike.scoring.recognition import Recognised, recognised
from heyoka_bike.scoring.units import factor, tried

SUMMED = 1e-10
"""Error of a time after summing a million steps in binary64, as a fraction of the duration."""

ROWS_COMPARED = 251
"""Number of rows per maneuver that distinguish two motions, because a run lasts 200 times the
fastest time constant."""

MOST_SAMPLED = 4001
"""Number of rows per maneuver that suffice to distinguish columns, units and maneuvers."""

# Error, relative to the scale of a column, above which the values do not show the column's
# quantity.
MEANINGLESS_ERROR = 0.5
# Values above this limit are read as NaN, because a product of two of them would overflow, and no
# program produces them on purpose. Values below the inverse of the limit are read as zero, because
# their products underflow.
_LARGEST_VALUE = 1e150
# Number per second of each unit of time that is shorter than a second, by name.
_SMALLER_UNITS = {"milliseconds": 1e3, "microseconds": 1e6, "nanoseconds": 1e9}
# Units of time that are larger than a second [s].
_LARGER_UNITS = {"minutes": 60.0, "hours": 3600.0}
# Fraction of the reference's duration that the times must span for their unit to be recognised.
_SHORTEST_RUN = 0.1
# Distance from a maneuver, relative to the scales of the columns, above which other maneuvers and
# other orders of the columns are tried.
_FAR_FROM_MANEUVER = 1.0 / CLEARLY
# If times begin later than this many durations of the run, they were read from a clock. Then the
# first time is subtracted from all of them.
_LONG_AGO = 1e5
# Times of a clock are recognised by this range of the seconds since 1970, the years 2001 to 2096.
# The second constant lists the units in which clocks count.
_TODAY = (1e9, 4e9)
_UNITS_OF_CLOCKS = ("s", "ms", "us", "ns")


@dataclass(frozen=True, slots=True)
class FileInfo:
    """The file that was scored.

    Attributes
    ----------
    path, format
    rows
        Rows of the longest maneuver, added up over files.
    t_start, t_end
        First and last time in the file [s].
    significant_digits
        Decimal digits of the column written with the fewest digits; None if unknown.
    """

    path: str
    format: str
    rows: int
    t_start: float
    t_end: float
    significant_digits: int | None


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Part(Rows):
    """The rows of one maneuver that are within the run of its reference.

    Attributes
    ----------
    maneuver
        Its number, from 1.
    reference : ReferenceManeuver
    """

    maneuver: int
    reference: ReferenceManeuver

    @property
    def number(self) -> int:
        """Number of the maneuver, from 1."""
        return self.maneuver

    def has_values(self) -> bool:
        """True if there is a finite number in any column."""
        return any(np.isfinite(v).any() for v in self.values.values())

    def within_run(self) -> Part:
        """Return the rows whose times are within the reference's run."""
        return self.at((self.time >= 0.0) & (self.time <= float(self.reference.duration)))

    def at_distinct_times(self) -> Part:
        """Return the rows without those that have the time of the row before, within rounding."""
        later = np.diff(self.time) > SUMMED * float(self.reference.duration)
        return self if later.all() else self.at(np.append(True, later))

    def sample(self) -> NDArray[np.intp]:
        """Return the indices of at most `MOST_SAMPLED` rows, evenly spaced."""
        return spread(len(self.time), MOST_SAMPLED)


@dataclass(frozen=True, eq=False, slots=True)
class Alignment:
    """A result file aligned with the reference."""

    file: FileInfo
    parts: tuple[Part, ...]
    seen: tuple[Evidence, ...]


def align(results: Results, reference: Reference) -> Alignment:
    """Align a result file with the reference.

    Raises
    ------
    InputError
        The file contains a maneuver that the reference does not have, or a maneuver twice.
    NothingScoredError
        No row of the file can be compared, or its maneuver cannot be recognised.
    """
    results, reference = _with_reference_columns(results, reference)
    results = _with_times_in_seconds(results, max(float(reference[n].duration) for n in reference))
    results = _with_meanings(results, reference)
    seen = list(results.seen)
    parts: list[Part] = []
    lost: list[Part] = []
    orders: dict[int, dict[str, str]] = {}
    numbers = _numbers(results, reference)
    for rows, (number, evidence) in zip(results.maneuvers, numbers, strict=True):
        seen += evidence
        if number not in reference:
            raise InputError(
                f"found maneuver {number}, expected 1 to {len(reference)}", file=results.path
            )
        if any(part.number == number for part in parts):
            raise InputError(f"found maneuver {number} twice, expected it once", file=results.path)
        part, outside = _rows_within_run(rows, number, reference[number])
        part, turning = _with_wheel_rate(part, reference)
        outside += turning
        if len(part.time):
            if order := _another_order(part):
                orders[number] = order
            else:
                outside += _evidence_of_other_maneuver(part, rows, reference)
            outside += _evidence_of_larger_unit(part)
        seen += [x for x in outside if x not in seen]
        (parts if len(part.time) else lost).append(part)
    if not any(part.has_values() for part in parts):
        raise NothingScoredError(_why_nothing(results, reference, bool(parts)))
    if lost:
        raise NothingScoredError(
            f"{results.path}: found no row of maneuver {lost[0].number} within its run, expected "
            "at least one"
        )
    seen += _evidence_of_other_orders(parts, orders, results)
    times = [rows.time for rows in results.maneuvers if len(rows.time)]
    return Alignment(
        file=FileInfo(
            path=results.path,
            format=results.format,
            rows=max(map(len, times)),
            t_start=float(min(t[0] for t in times)),
            t_end=float(max(t[-1] for t in times)),
            significant_digits=results.significant_digits,
        ),
        parts=tuple(sorted(parts, key=lambda p: p.number)),
        seen=with_all_turns(seen),
    )


def merge(alignments: Sequence[Alignment]) -> Alignment:
    """Merge the files of different maneuvers of one run.

    Raises
    ------
    InputError
        There are no files, or two contain the same maneuver.
    """
    held = [p.number for a in alignments for p in a.parts]
    if not held or len(set(held)) < len(held):
        found = f"maneuver {max(held, key=held.count)} twice" if held else "no results"
        raise InputError(f"found {found}, expected files of different maneuvers")
    if len(alignments) == 1:
        return alignments[0]
    files = [a.file for a in alignments]
    formats = list(dict.fromkeys(f.format for f in files))
    # All files that are arrays have the same name, so this name is listed once.
    paths = (
        dict.fromkeys(f.path for f in files) if formats == ["array"] else [f.path for f in files]
    )
    digits = [f.significant_digits for f in files if f.significant_digits is not None]
    return Alignment(
        file=FileInfo(
            path=", ".join(paths),
            format=", ".join(formats),
            rows=sum(f.rows for f in files),
            t_start=min(f.t_start for f in files),
            t_end=max(f.t_end for f in files),
            significant_digits=min(digits, default=None),
        ),
        parts=tuple(sorted((p for a in alignments for p in a.parts), key=lambda p: p.number)),
        seen=tuple(replace(x, file=a.file.path) for a in alignments for x in a.seen),
    )


def spread(count: int, most: int) -> NDArray[np.intp]:
    """Return at most `most` of the indices below `count`, evenly spaced."""
    if count <= most:
        return np.arange(count)
    return np.linspace(0, count - 1, most).astype(np.intp)


def are_even(time: Array, step: float) -> bool:
    """True if all times are whole numbers of steps, within a thousandth of a step."""
    if not step > 0.0:
        return False
    count = time / step
    return bool(np.max(np.abs(count - np.round(count)), initial=0.0) < TOLERANCE)


def even_step(time: Array) -> float | None:
    """Return the distance of evenly spaced times [s]; None if they are not evenly spaced."""
    step = float(np.ptp(time)) / (len(time) - 1) if len(time) > 1 else 0.0
    return step if are_even(time - time[0], step) else None


def _with_reference_columns(results: Results, reference: Reference) -> tuple[Results, Reference]:
    """Load the reference's columns for all results; leave out columns that the reference lacks."""
    written = {key for rows in results.maneuvers for key in rows.values}
    if written <= reference[1].definitions.keys():
        return results, reference
    whole = reference.with_motion()
    reference = whole or reference
    unknown = [key for key in COMPARED if key in written - reference[1].definitions.keys()]
    if not unknown:
        return results, reference
    known = written - set(unknown)
    lacks = "" if whole is not None else MOTION
    if not known:
        raise NothingScoredError(
            f"{results.path}: {', '.join(unknown)}: not compared, because the reference in "
            f"{reference.folder} has no {lacks or 'such columns'}"
        )
    lost = NoReference(tuple(unknown), str(reference.folder), lacks)
    maneuvers = tuple(rows.only(known) for rows in results.maneuvers)
    return replace(results, maneuvers=maneuvers, seen=(*results.seen, lost)), reference


def _with_times_in_seconds(results: Results, duration: float) -> Results:
    """Convert times in another unit, and times that a clock shows, to seconds from the start."""
    maneuvers, seen = [], list(results.seen)
    for rows in results.maneuvers:
        time = (rows.time, rows.time_lo)
        named = rows.units.get(TIME, "s")
        if named != "s" and len(rows.time) > 1:
            written = in_unit(time, named)
            span, as_written = (float(t[0][-1] - t[0][0]) for t in (time, written))
            if not _is_run(span, duration) and _is_run(as_written, duration):
                time = written
                seen.append(TimeUnitContradicted(named, as_written))
        if len(time[0]) and time[0][0] > _LONG_AGO * duration:
            first = float(time[0][0])
            hi, lo = two_sum(time[0], np.full(len(time[0]), -first))
            time = fast_two_sum(hi, lo + (time[1] - time[1][0]))
            unit = _unit_of_clock(first) if named == "s" else "s"
            seen.append(TimesFromFirst(first, unit))
            time = in_seconds(time, unit)
        maneuvers.append(replace(rows, time=time[0], time_lo=time[1]))
    return replace(results, maneuvers=tuple(maneuvers), seen=tuple(dict.fromkeys(seen)))


def _unit_of_clock(time: float) -> str:
    """Return the unit of a clock's time since 1970; seconds if it counts from another time."""
    of_today = (u for u in _UNITS_OF_CLOCKS if _TODAY[0] < time * factor(u)[0] < _TODAY[1])
    return next(of_today, "s")


def _is_run(span: float, duration: float) -> bool:
    """True if times span at least a tenth and at most ten times the run."""
    return _SHORTEST_RUN * duration <= span <= duration / _SHORTEST_RUN


def _with_meanings(results: Results, reference: Reference) -> Results:
    """Give columns with ambiguous names the meanings to which their values are nearest.

    The meanings of all these columns are chosen together. A column that is near to none of its
    meanings is left out, unless its name is the key of a benchmark column.
    """
    open_ = {key: keys for rows in results.maneuvers for key, keys in rows.may_be.items()}
    if not open_:
        return results
    taken = {key for rows in results.maneuvers for key in rows.values} - open_.keys()
    known = reference[1].definitions.keys() - taken
    # Distance of each ambiguous column from each of its possible meanings that no unambiguous
    # column has.
    far = {
        key: {
            k: _distance_from_meaning(results, reference, key, k)
            for k in dict.fromkeys((key, *keys))
            if k == key or k in known
        }
        for key, keys in open_.items()
    }
    # If several combinations are equally near, take the first of them: its meanings are those that
    # the names suggest.
    best = min(
        (c for c in product(*far.values()) if len(set(c)) == len(c)),
        key=lambda c: sum(log(near[k]) for near, k in zip(far.values(), c, strict=True)),
    )
    meant: dict[str, str | None] = {}
    seen = list(results.seen)
    for key, nearest in zip(far, best, strict=True):
        is_kept = far[key][nearest] < MEANINGLESS_ERROR or (
            nearest == key and key in BENCHMARK_COLUMNS
        )
        meant[key] = k = nearest if is_kept else None
        if k != key:
            seen.append(MeantByValues(k, tuple(open_[key])))
    maneuvers = tuple(renamed(rows, meant) for rows in results.maneuvers)
    return replace(results, maneuvers=maneuvers, seen=tuple(seen))


def _distance_from_meaning(results: Results, reference: Reference, key: str, meaning: str) -> float:
    """Return the distance of a column from one of its meanings, over all maneuvers of the file."""
    found: float = 1.0
    for rows in results.maneuvers:
        if key in rows.values:
            alone = renamed(rows.only({key}), {key: meaning})
            numbers = (n for n in reference if rows.maneuver in (None, n))
            away = (_distance(_rows_within_run(alone, n, reference[n])[0]) for n in numbers)
            found *= min(away, default=1.0)
    return float(found ** (1 / len(results.maneuvers)))


def _with_wheel_rate(part: Part, reference: Reference) -> tuple[Part, tuple[Evidence, ...]]:
    """Mark the speed as the rate of a wheel [rad/s] if its values fit that clearly better."""
    speed = part.only({"forward_speed"})
    own = _distance(speed) if speed.values else 0.0
    # The limit is below 7 %, because a wheel's rate in rad/s that is read as a speed in km/h is
    # wrong by only 7 %: a wheel with a radius of 0.3 m that turns at 1 rad/s rolls at 1.08 km/h.
    if own <= MEANINGLESS_ERROR / CLEARLY:
        return part, ()
    for name in ("rR", "rF"):
        radius = f"{float(Fraction(reference.parameters[name]))} m"
        units = {**part.units, "forward_speed": f"{radius} rad s-1"}
        if _distance(replace(speed, units=units)) < own / CLEARLY:
            return replace(part, units=units), (WheelRate(radius),)
    return part, ()


def _numbers(results: Results, reference: Reference) -> list[tuple[int, tuple[Evidence, ...]]]:
    """Return the maneuver of each block of rows, and evidence of how an unnamed one was recognised.

    A block that may belong to several maneuvers gets the one that the name of its file states, or
    else a maneuver that no other block has, if there is one.
    """
    found = {
        i: _recognised(results, rows, reference)
        for i, rows in enumerate(results.maneuvers)
        if rows.maneuver is None
    }
    if found and (named := stated_number(results, reference)) is not None:
        return [_with_name(found[0], named)]
    numbers = {
        i: rows.maneuver for i, rows in enumerate(results.maneuvers) if rows.maneuver is not None
    }
    numbers |= {i: x.maneuver for i, x in found.items() if not x.rivals}
    guessed: dict[int, Evidence] = {}
    # Begin with the blocks that have the fewest other possible maneuvers, because their maneuver is
    # the most certain.
    for i in sorted(found.keys() - numbers.keys(), key=lambda i: len(found[i].rivals)):
        possible = [found[i].maneuver, *found[i].rivals]
        free = [n for n in possible if n not in numbers.values()] or possible
        numbers[i] = free[0]
        if others := tuple(free[1:]):
            guessed[i] = ManeuverGuessed(free[0], others, _option(results, "maneuver", "N"))
    seen = {i: guessed.get(i, ManeuverRecognised(numbers[i])) for i in found}
    return [(numbers[i], (seen[i],) if i in seen else ()) for i in range(len(results.maneuvers))]


def stated_number(results: Results, reference: Reference) -> int | None:
    """Return the maneuver that a file states in its rows, or else in its name.

    Return None for arrays, files with several blocks of rows, and files that state no maneuver of
    the reference.
    """
    if len(results.maneuvers) > 1 or results.format == "array":
        return None
    rows, number = results.maneuvers[0], number_of_file(results.path)
    return rows.maneuver or (number if number in reference else None)


def _with_name(found: Recognised, named: int) -> tuple[int, tuple[Evidence, ...]]:
    """Return the maneuver in a file whose name states one, and evidence of how it was recognised.

    The name decides unless the values exclude it.
    """
    fits = (found.maneuver, *found.rivals)
    if named not in fits:
        return found.maneuver, (ManeuverNamedOtherwise(found.maneuver, named, fits),)
    return named, (ManeuverRecognised(named, is_by_name=bool(found.rivals)),)


def _recognised(results: Results, rows: Rows, reference: Reference) -> Recognised:
    """Recognise the maneuver of rows by their values.

    Raises
    ------
    NothingScoredError
        The rows are unlike every maneuver.
    """
    parts = _parts_of_every_maneuver(rows, reference)
    # A maneuver is considered only if most rows lie within its run.
    telling = {n: part for n, part in parts.items() if 2 * len(part.time) > len(rows.time)}
    found = recognised(telling)
    if found is None or found.apart[found.maneuver] >= _FAR_FROM_MANEUVER:
        orders = {n: order for n, part in parts.items() if (order := _another_order(part))}
        moved = {n: renamed(parts[n], order) for n, order in orders.items()}
        # The program's clock may have run before the motion began, so also try times that count
        # from the first row.
        began = {n: replace(part, time=part.time - part.time[0]) for n, part in telling.items()}
        others = (x for x in (found, recognised(moved), recognised(began)) if x is not None)
        found = min(others, key=lambda x: x.apart[x.maneuver], default=None)
    if found is not None and found.apart[found.maneuver] < MEANINGLESS_ERROR:
        return found
    hint = _unit_question(rows.time, max(float(reference[n].duration) for n in reference))
    larger = () if found is None else _evidence_of_larger_unit(parts[found.maneuver])
    hint = hint or "".join(f"; are the times in {x.unit}?" for x in larger)
    apart = {n: 1.0 if found is None else found.apart.get(n, 1.0) for n in parts}
    raise NothingScoredError(
        f"{results.path}: found columns unlike every maneuver (relative to the largest values, "
        "they typically differ by "
        + ", ".join(f"{x:.2g} from maneuver {n}" for n, x in sorted(apart.items()))
        + "), expected the columns of one maneuver; to choose it, use "
        + f"{_option(results, 'maneuver', 'N')}{hint}"
    )


def _option(results: Results, name: str, value: str) -> str:
    """Return how a user sets an option: a keyword for arrays, a command-line option for files."""
    return f"{name}={value}" if results.format == "array" else f"--{name} {value}"


def _not_zero_at_start(part: Part) -> list[str]:
    """Return the keys of columns with nonzero initial conditions; empty without a first row."""
    if not len(part.time) or part.time[0] != 0.0:
        return []
    reference = part.reference
    return [k for k in part.values if abs(reference[k][0]) > TOLERANCE * reference.scale(k)]


def _evidence_of_other_orders(
    parts: Sequence[Part], orders: Mapping[int, Mapping[str, str]], results: Results
) -> tuple[Evidence, ...]:
    """Return evidence that values clearly fit other columns, one item for each order of columns."""
    option = ""
    if all({*part.values} == {*BENCHMARK_COLUMNS} for part in parts):
        names = [
            f"m{part.number}_{meaning}" if len(parts) > 1 else meaning
            for part in parts
            for key in part.values
            for meaning in [orders.get(part.number, {}).get(key, key)]
        ]
        option = _option(results, "columns", f"time,{','.join(names)}")
    alike = grouped((tuple(order.values()), n) for n, order in orders.items())
    return tuple(
        OtherOrder(keys, option, tuple(numbers) if len(numbers) < len(parts) else ())
        for keys, numbers in alike.items()
    )


def _evidence_of_other_maneuver(
    part: Part, rows: Rows, reference: Reference
) -> tuple[Evidence, ...]:
    """Return evidence that the values clearly fit another maneuver."""
    if _distance(part) < TOLERANCE:
        return ()
    found = recognised(_parts_of_every_maneuver(rows, reference))
    if found is None or found.rivals or found.maneuver == part.number:
        return ()
    own = found.apart.get(part.number, 1.0)
    return (OtherManeuver(part.number, found.maneuver, found.apart[found.maneuver], own),)


def _another_order(part: Part) -> dict[str, str]:
    """Return the key that fits each column's values if columns are exchanged; else an empty dict.

    All rows are compared. If the motion is wrong later, only the first row is compared, in the
    columns with nonzero initial conditions.
    """
    few = part.only(BENCHMARK_COLUMNS).at(spread(len(part.time), ROWS_COMPARED))
    keys = list(few.values)
    if order := _permuted(few, keys, _FAR_FROM_MANEUVER):
        return order
    order = _permuted(few.at(spread(len(few.time), 1)), _not_zero_at_start(few), TOLERANCE)
    return {key: order.get(key, key) for key in keys} if order else {}


def _permuted(rows: Part, keys: Sequence[str], limit: float) -> dict[str, str]:
    """Return the key that each column's values fit within `limit` scales, if keys are exchanged."""
    expected = rows.reference.approximate(rows.time, list(keys))

    def far(key: str, meaning: str) -> float:
        away = _column_distance(rows, meaning, rows.values[key], expected[meaning])
        return 1.0 if away is None else away

    if all(far(key, key) < limit for key in keys):
        return {}
    order = {}
    for key in keys:
        away = {meaning: far(key, meaning) for meaning in keys}
        nearest = min(away, key=away.__getitem__)
        order[key] = nearest if away[nearest] < away[key] / CLEARLY else key
        if away[order[key]] >= limit:
            return {}
    is_moved = any(far(key, key) >= limit for key, meaning in order.items() if key != meaning)
    return order if is_moved and {*order.values()} == {*keys} else {}


def _distance(part: Part) -> float:
    """Return the geometric mean of the columns' distances from the maneuver, in scales."""
    pick = part.sample()
    names = [key for key in COMPARED if key in part.values]
    expected = part.reference.approximate(part.time[pick], names)
    away = [_column_distance(part, key, part.values[key][pick], expected[key]) for key in names]
    logs = [log(x) for x in away if x is not None]
    return float(np.exp(np.mean(logs))) if logs else 1.0


def _column_distance(part: Part, key: str, values: Array, expected: Array) -> float | None:
    """Return the distance of values from a column, in scales; None if nothing can be compared."""
    good = np.isfinite(values) & np.isfinite(expected)
    # Heights and normal forces hardly vary, so their variation, not their size, distinguishes the
    # maneuvers.
    rows = part.reference[key]
    scale = part.reference.scale(key) if key in BENCHMARK_COLUMNS else float(np.ptp(rows))
    if not good.any() or not scale:
        return None
    units = [factor(unit)[0] for unit in tried(COMPARED[key][0].unit, part.units.get(key))]
    taken = np.multiply.outer([*units, *(-u for u in units)], values[good])
    off = taken - expected[good]
    if key in FREE_ZERO:
        off -= off[:, :1]
    nearest = float(np.min(median(np.abs(off))))
    # Limit the relative distance to the range from the resolution of binary64 to 1. A distance of 1
    # means no resemblance.
    return float(np.clip(nearest / scale, np.finfo(np.float64).eps, 1.0))


def _parts_of_every_maneuver(rows: Rows, reference: Reference) -> dict[int, Part]:
    """Return the rows within the run of each maneuver, by its number."""
    return {n: _rows_within_run(rows, n, reference[n])[0] for n in reference}


def _rows_within_run(
    rows: Rows, number: int, reference: ReferenceManeuver
) -> tuple[Part, tuple[Evidence, ...]]:
    """Return the rows within the run, and evidence; sums of steps may slightly exceed its end."""
    end, hi = float(reference.duration), rows.time
    is_early = (hi < 0) | ((hi == 0) & (rows.time_lo < 0))
    keep = ~(is_early | (hi > reference.reach))
    seen: list[Evidence] = []
    if not keep.all():
        left_out = hi[~keep]
        ends = float(left_out.min()), float(left_out.max())
        seen.append(RowsOutside(len(left_out), *ends, end, _likely_smaller_unit(hi, end)))

    # If all rows are kept, do not copy them, because the file may be long.
    kept = rows if keep.all() else rows.at(keep)
    values = dict(kept.values)
    for key, written in kept.values.items():
        size = np.abs(written)
        too_large = size > _LARGEST_VALUE
        if count := int(too_large.sum()):
            values[key] = np.where(too_large, np.nan, written)
            seen.append(TooLarge(number, key, count))
        if (is_tiny := (size < 1.0 / _LARGEST_VALUE) & (written != 0.0)).any():
            values[key] = np.where(is_tiny, 0.0, values[key])
    named = vars(kept) | {"maneuver": number, "values": values}
    part, free = with_free_values(Part(**named, reference=reference), reference)
    return part, (*seen, *free)


def _evidence_of_larger_unit(part: Part) -> tuple[TimesInLargerUnit, ...]:
    """Return evidence that times have a larger unit: angles change far more than rates allow."""
    span, end = float(np.ptp(part.time)), float(part.reference.duration)
    units = {unit: size for unit, size in _LARGER_UNITS.items() if _is_whole_run(span * size, end)}
    if not units or max(_change_over_rate(part, kind) for kind in ("roll", "steer")) <= CLEARLY:
        return ()
    return tuple(TimesInLargerUnit(unit, size, span) for unit, size in units.items())


def _is_whole_run(span: float, duration: float) -> bool:
    """True if times span at least a tenth of the run, and at most the run within tolerance."""
    return _SHORTEST_RUN * duration <= span <= duration * (1.0 + TOLERANCE)


def _change_over_rate(part: Part, kind: str) -> float:
    """Return the total change of an angle divided by the integral of |rate|; 0 if unknown."""
    keys = (f"{kind}_angle", f"{kind}_rate")
    if not all(key in part.values for key in keys):
        return 0.0
    units = [factor(unit)[0] if (unit := part.units.get(key)) else 1.0 for key in keys]
    angle, rate = (part.values[key] * unit for key, unit in zip(keys, units, strict=True))
    good = np.isfinite(angle) & np.isfinite(rate)
    if not good.any():
        return 0.0
    time, size = part.time[good], np.abs(rate[good])
    off = size - np.abs(part.reference.approximate(time, keys[1:])[keys[1]])
    if median(np.abs(off)) < _FAR_FROM_MANEUVER * part.reference.scale(keys[1]):
        # The rate is right at the times as written. So the angle is in the wrong unit, not the
        # time.
        return 0.0
    added = float(np.sum(np.diff(time) * (size[1:] + size[:-1]) / 2))
    change = float(np.sum(np.abs(np.diff(angle[good]))))
    return change / added if added else 0.0


def _why_nothing(results: Results, reference: Reference, has_rows: bool) -> str:
    if has_rows:
        return f"{results.path}: found no finite value within the run, expected at least one"
    end = max(float(reference[n].duration) for n in reference)
    times = np.concatenate([rows.time for rows in results.maneuvers])
    if not len(times):
        return f"{results.path}: found no rows, expected at least one"
    return (
        f"{results.path}: found times from {times.min():.6g} to {times.max():.6g} s, expected "
        f"times within 0 to {end:g} s{_unit_question(times, end)}"
    )


def _unit_question(times: Array, end: float) -> str:
    """Return a question for the end of a message if most times seem to be in a smaller unit."""
    unit = _likely_smaller_unit(times, end)
    return f"; are the times in {unit}?" if unit else ""


def _likely_smaller_unit(times: Array, end: float) -> str | None:
    """Return the smaller unit that the times may have; None if few are late or no unit fits."""
    # Count late times instead of averaging: the mean of times near the largest double overflows.
    most_are_late = 2 * int((times > end).sum()) > len(times)
    # If the unit is right, the last time is between a tenth of the run and its end.
    parts = {unit: float(np.max(times)) / (size * end) for unit, size in _SMALLER_UNITS.items()}
    fitting = (unit for unit, part in parts.items() if _SHORTEST_RUN <= part <= 1 + SUMMED)
    return next(fitting, None) if most_are_late else None
