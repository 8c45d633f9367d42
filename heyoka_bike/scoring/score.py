"""Scoring: a result file against the reference, at the file's own times.

`score` is the pipeline: `alignment` finds the maneuvers and the rows that can be compared,
`definitions` what the columns mean, `measures` how far they are from the reference, and
`consistency` how well the file agrees with itself. The outcome is one `report.Report`.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from heyoka_bike.numbers.double import Array, Double, add, median, two_sum
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.reference.manifest import CUSTOM
from heyoka_bike.scoring import measures
from heyoka_bike.scoring.alignment import SUMMED, Alignment, Part, align, merge
from heyoka_bike.scoring.column_score import Alternative, ColumnScore, Reading, Trace
from heyoka_bike.scoring.comparison import Candidate, errors, is_small, largest_errors
from heyoka_bike.scoring.conclusions import explain
from heyoka_bike.scoring.consistency import consistency
from heyoka_bike.scoring.definitions import Understanding, plain, understand
from heyoka_bike.scoring.reading.given import results_of, words
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.report import ManeuverScore, Report
from heyoka_bike.scoring.requirements import check
from heyoka_bike.scoring.unfilled import without_unfilled
from heyoka_bike.scoring.units import factor, to_si
from heyoka_bike.scoring.unknown import unknown_columns

# The benchmark judges maneuver 2, by eq. (1) below 1e-3 %.
_JUDGED: Mapping[int, float] = {2: 1e-3}
# Correct values that were rounded once or twice are apart by up to this many last digits.
_ROUNDED = 4.0
# A last row at the end of the run, or one at an event, does not make the others uneven.
_FEW_ODD = 0.02


def score(
    results: Any = None,
    reference: Reference | str | PathLike[str] | None = None,
    require: str | Sequence[str] = (),
    *,
    maneuver: int | None = None,
    columns: str | Sequence[str] | None = None,
    **named: Any,
) -> Report:
    """Compare results with the reference, as the command of this name does.

    Parameters
    ----------
    results
        The path of a file, an array, a mapping of columns, a data frame or whatever else
        `read_results` takes, or what it returned; a list of files that hold different maneuvers of
        one run; a mapping of maneuvers' numbers to any of these. The times [s] if columns are
        named: ``score(t, roll_angle=phi, maneuver=2)``.
    reference
        From `load_reference`, or the folder of a set; the published one by default.
    require
        A requirement such as ``"2.roll_angle.scd >= 6"``, or several, see `requirements`.
    maneuver
        Number of the maneuver of results that hold one; by default it is recognised.
    columns
        What the columns are, in their order, if they are not the benchmark's nor named so.
    named
        Columns by name.

    Returns
    -------
    Report
        Errors in SI units at the rows' own times, with the definition, sign, unit and zero that
        each column turned out to have. Nothing is extrapolated or interpolated.

    Raises
    ------
    InputError
        Results that cannot be read, a maneuver that the reference does not have or that comes
        twice, or a requirement that cannot be read.
    NothingScoredError
        Nothing can be compared.
    """
    known = load_reference(reference)
    several = results_of(results, len(known), maneuver=maneuver, columns=columns, named=named)
    return scored(aligned(several, known), known, require)


def aligned(results: Sequence[Results], reference: Reference) -> Alignment:
    """Results of one run beside the reference, without columns that were never filled in."""
    return merge([without_unfilled(align(r, reference)) for r in results])


def scored(
    alignment: Alignment,
    reference: Reference,
    require: str | Sequence[str] = (),
    understood: Mapping[str, Understanding] | None = None,
) -> Report:
    """The report of aligned results, with their columns as understood or as they fit best."""
    benchmark = reference.dataset_version != CUSTOM
    taken = understand(alignment.parts) if understood is None else understood
    taken = _with_exact_zero(taken, alignment.parts)

    def score_part(part: Part) -> ManeuverScore:
        return _score_maneuver(part, taken, _JUDGED.get(part.number) if benchmark else None)

    if all(is_small(part) for part in alignment.parts):
        maneuvers = tuple(map(score_part, alignment.parts))
    else:
        from concurrent.futures import ThreadPoolExecutor

        from heyoka_bike.system.parallel import processors

        # NumPy computes on long arrays outside the interpreter's lock.
        with ThreadPoolExecutor(processors()) as pool:
            maneuvers = tuple(pool.map(score_part, alignment.parts))
    unknown = unknown_columns(maneuvers)
    maneuvers = tuple(_without_meaning(m, unknown) for m in maneuvers)
    found = Report(
        dataset_version=reference.dataset_version,
        bicycle=reference.bicycle,
        file=alignment.file,
        maneuvers=maneuvers,
        findings=alignment.findings,
        reference_sha256=reference.content_sha256,
    )
    found = replace(found, findings=alignment.findings + explain(found))
    asked = [require] if isinstance(require, str) else words(require, "require")
    return replace(found, requirements=tuple(check(text, found) for text in asked))


def _score_maneuver(
    part: Part, understood: Mapping[str, Understanding], limit: float | None
) -> ManeuverScore:
    columns = _score_columns(part, understood)
    steps = np.diff(part.time) + np.diff(part.time_lo)
    start, end, coverage, gap = _coverage(part)
    return ManeuverScore(
        maneuver=part.number,
        name=part.reference.name,
        rows=len(part.time),
        t_start=start,
        t_end=end,
        coverage=coverage,
        gap=gap,
        step=float(median(steps)) if len(steps) else None,
        performance=measures.performance(*_energy(part, understood, columns)),
        performance_limit=limit,
        consistency=consistency(part, columns),
        columns=columns,
        part=part,
    )


def _without_meaning(m: ManeuverScore, unknown: Collection[str]) -> ManeuverScore:
    if not unknown:
        return m
    return replace(m, columns=tuple(replace(c, is_known=c.key not in unknown) for c in m.columns))


def _coverage(part: Part) -> tuple[float, float, float, float]:
    """First and last time with a value in every column, the part of the run covered, and the gap.

    Two rows cover what is between them if they are no farther apart than the longest piece of the
    reference's dense output: over more than that a motion may do anything unseen.
    """
    duration = float(part.reference.duration)
    complete = np.all([np.isfinite(v) for v in part.values.values()], axis=0)
    if not complete.any():
        return float(part.time[0]), float(part.time[-1]), 0.0, duration
    times = part.time[complete]
    steps = np.diff(times)
    longest = float(np.diff(part.reference.dense.breaks).max())
    covered = float(steps[steps <= longest * (1 + SUMMED)].sum()) / duration
    gap = float(np.diff(times, prepend=0.0, append=duration).max())
    # Summed steps end a last digit or so beside the end.
    return float(times[0]), float(times[-1]), 1.0 if covered > 1 - SUMMED else covered, gap


def _energy(
    part: Part, understood: Mapping[str, Understanding], columns: Sequence[ColumnScore]
) -> Double:
    """The file's own mechanical energy [J], or the sum of its parts; empty without."""
    total, *parts = ("mechanical_energy", "potential_energy", "kinetic_energy")
    whole = {c.key for c in columns if not c.missing}
    keys = [total] if any(c.key == total for c in columns) else parts
    if not whole.issuperset(keys):
        return np.empty(0), np.empty(0)
    energy, *more = (_as_understood(_double(part, key), understood[key]) for key in keys)
    return add(energy, more[0]) if more else energy


def _score_columns(part: Part, understood: Mapping[str, Understanding]) -> tuple[ColumnScore, ...]:
    """Verdicts on the columns, in the benchmark's order."""
    definitions = part.reference.definitions
    keys = [key for key in definitions if key in part.values]
    # Without a usable value nothing is understood of a column.
    understood = {key: understood.get(key) or plain(key) for key in keys}
    written = {key: _double(part, key) for key in keys}
    si = {key: _as_understood(written[key], understood[key]) for key in keys}
    best = [Candidate(si[key], understood[key].column.name) for key in keys]
    moved = [key for key in keys if not understood[key].is_plain()]
    as_written = [Candidate(written[key], key) for key in moved]
    found = errors(part, best + as_written)
    of_written = dict(zip(moved, found[len(best) :], strict=True))
    others = [(key, c) for key in keys for c in definitions[key] if c is not understood[key].column]
    far = largest_errors(part, [Candidate(si[key], c.name) for key, c in others])
    alternatives: dict[str, list[Alternative]] = {key: [] for key in keys}
    for (key, c), distance in zip(others, far, strict=True):
        has_values = bool(np.isfinite(written[key][0]).any())
        odds = understood[key].odds.get(c.definition)
        found_far = distance if has_values else None
        alternatives[key].append(Alternative(c.definition, found_far, odds))
    scores, late = [], _late(part)
    for key, candidate, error in zip(keys, best, found, strict=False):
        u = understood[key]
        missing = int(np.count_nonzero(~np.isfinite(part.values[key])))
        trace = _trace(part.time, candidate.values[0], error)
        reading = _reading(part, trace, u)
        plain_reading = reading
        if key in of_written:
            plain_trace = _trace(part.time, written[key][0], of_written[key])
            plain_reading = _reading(part, plain_trace, plain(key))
        scores.append(
            ColumnScore(
                key=key,
                unit=u.column.unit,
                as_written=plain_reading,
                as_understood=reading,
                floor=_floor(part, key, u, late),
                alternatives=tuple(alternatives[key]),
                indistinguishable=u.indistinguishable,
                growth=measures.growth(trace.time, trace.error, float(part.reference.duration)),
                values=len(trace.time),
                missing=missing,
                trace=trace,
            )
        )
    return tuple(scores)


def _with_exact_zero(
    understood: Mapping[str, Understanding], parts: Sequence[Part]
) -> Mapping[str, Understanding]:
    """The zero of the energies to all digits of the file, where they have another one."""
    key = "potential_energy"
    u = understood.get(key)
    if u is None or not u.offset:
        return understood
    left = []
    for part in parts:
        if key not in part.values:
            continue
        candidate = Candidate(_as_understood(_double(part, key), u), u.column.name)
        (error,) = errors(part, [candidate])
        error = error[np.isfinite(error)]
        if not len(error):
            continue
        # Errors of the motion begin at nothing with it; those of rounding are nothing on average.
        last_digit = _floor(part, key, u, _late(part)) or 0.0
        if key not in part.lo:
            last_digit = max(last_digit, float(np.spacing(part.reference.scale(key))))
        is_rounding = np.ptp(error) <= _ROUNDED * last_digit
        found = float(np.mean(error)) if is_rounding else float(error[0])
        left.append((float(median(np.abs(error - found))), found))
    rest = min(left)[1] if left else 0.0
    return {
        k: replace(v, offset_lo=v.offset_lo + rest) if v.offset == u.offset else v
        for k, v in understood.items()
    }


def _double(part: Part, key: str) -> Double:
    """A written column as hi + lo, the latter often nothing."""
    hi = part.values[key]
    rest = part.lo.get(key)
    return hi, np.broadcast_to(0.0, hi.shape) if rest is None else rest


def _trace(time: Array, values: Array, error: Array) -> Trace:
    """What is finite of a column."""
    good = np.isfinite(error)
    if good.all():
        return Trace(time, values, error)
    return Trace(time[good], values[good], error[good])


def _as_understood(values: Double, u: Understanding) -> Double:
    hi, lo = to_si(values, u.unit)
    if u.sign < 0:
        hi, lo = -hi, -lo
    if not u.offset:
        return hi, lo
    hi, rest = two_sum(hi, np.full_like(hi, -u.offset))
    return two_sum(hi, rest + (lo - u.offset_lo))


def _reading(part: Part, trace: Trace, u: Understanding) -> Reading:
    size = part.reference.scale(u.column.name)
    return Reading(
        definition=u.column.definition,
        sign=u.sign,
        unit=u.unit,
        offset=u.offset + u.offset_lo,
        measures=measures.measures(trace.time, trace.error, trace.reference, size),
    )


def _floor(part: Part, key: str, u: Understanding, late: float) -> float | None:
    """Largest error that rounded values at times that are so late [s] may have [SI]."""
    quantum = part.quantum.get(key)
    largest = np.fmax.reduce(np.abs(part.values[key]), initial=-1.0)
    if quantum is None or largest < 0:
        return None
    # Neighbouring numbers are farthest apart where they are largest.
    floor = float(quantum.at(np.array([largest]))[0]) / 2 * factor(u.unit)[0]
    if not late:
        return floor
    rows = part.reference.rows[u.column.name]
    return floor + late * float(np.max(np.abs(np.diff(rows) / np.diff(part.reference.time))))


def _late(part: Part) -> float:
    """How far times that are rounded to the digits written may be off [s]; even ones are not."""
    times = part.quantum.get("time")
    if times is None or times.base != 10 or _is_even(part.time):
        return 0.0
    return float(np.max(times.at(part.time))) / 2


def _is_even(time: Array) -> bool:
    """Whether all rows but a few are evenly spaced, so that no digit of the times is missing."""
    steps = np.diff(time)
    usual = float(median(steps)) if len(steps) else 0.0
    if usual <= 0.0:
        return True
    multiples = (time - time[0]) / usual
    odd = np.abs(multiples - np.rint(multiples)) > 1e-6
    return bool(np.mean(odd) < _FEW_ODD)
