"""Scoring: compare a result file with the reference, at the file's own times.

`score` is the pipeline. `alignment` finds the maneuvers and the rows that can be compared,
`definitions` interprets the columns, `measures` computes their errors and the rounding errors of
their digits, and `judge` derives evidence from these numbers. The outcome is a `report.Report`;
`verdict` decides whether it is right.
"""

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from heyoka_bike.numbers.double import Array, Double, add, median, with_usual_errors
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring import measures
from heyoka_bike.scoring.alignment import SUMMED, Alignment, Part, align, merge, stated_number
from heyoka_bike.scoring.definitions import Understanding, Understandings, plain, understand
from heyoka_bike.scoring.evidence.as_compared import ManeuverNamedOtherwise
from heyoka_bike.scoring.judge import judged
from heyoka_bike.scoring.judge.energy_sum import energy_sum
from heyoka_bike.scoring.judge.rates import RATES, from_derivative
from heyoka_bike.scoring.judge.unfilled import without_unfilled
from heyoka_bike.scoring.measures import errors, is_small, largest_errors, rounding
from heyoka_bike.scoring.reading.given import results_of, words
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.recognition import ZEROED
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.requirements import check
from heyoka_bike.scoring.scores import (
    Alternative,
    ColumnScore,
    Consistency,
    ManeuverScore,
    Reading,
    Trace,
)
from heyoka_bike.scoring.verdict import meets_limit

# Rounding a correct value once or twice changes it by at most this many times half the unit of its
# last digit.
_ROUNDED = 2.0


@with_usual_errors
def score(
    results: Any = None,
    reference: Reference | str | PathLike[str] | None = None,
    require: str | Sequence[str] = (),
    *,
    maneuver: int | None = None,
    columns: str | Sequence[str] | None = None,
    **named: Any,
) -> Report:
    """Compare results with the reference, as the command ``heyoka-bike score`` does.

    Parameters
    ----------
    results
        The path of a file, an array, a mapping of columns, a data frame or anything else that
        `read_results` accepts or returns; a list of files with different maneuvers of one run; or a
        mapping from maneuver numbers to any of these. With named columns, the times [s]:
        ``score(t, roll_angle=phi, maneuver=2)``.
    reference
        The result of `load_reference`, or the folder of a dataset; by default the published one.
    require
        A requirement such as ``"2.roll_angle.scd >= 6"``, or several, see `requirements`.
    maneuver
        Number of the maneuver if the results contain only one; by default it is recognised.
    columns
        Names of the columns in order, if they have neither the benchmark's order nor its names.
    named
        Columns by name.

    Returns
    -------
    Report
        Errors in SI units at the rows' own times, with the definition, sign, unit and zero that fit
        each column best. Nothing is interpolated; the reference is extrapolated by at most a few
        milliseconds beyond its end, see `ReferenceManeuver.reach`.

    Raises
    ------
    InputError
        The results or a requirement cannot be read, or a maneuver occurs twice or is not in the
        reference.
    NothingScoredError
        Nothing can be compared.
    """
    known = load_reference(reference)
    several = results_of(results, len(known), maneuver=maneuver, columns=columns, named=named)
    return scored(aligned(several, known), known, require)


def aligned(results: Sequence[Results], reference: Reference) -> Alignment:
    """Align the results of one run with the reference, and leave out columns never filled in."""
    files = [_aligned_file(r, reference) for r in results]
    return merge(_with_names(files, results, reference))


def _with_names(
    files: Sequence[Alignment], results: Sequence[Results], reference: Reference
) -> Sequence[Alignment]:
    """Return the aligned files of one run, no two of them with the same maneuver if possible.

    If two files have rows of the same maneuver, and all files state their maneuver, in their rows
    or in their names, each file gets the maneuver that it states.
    """
    held = [part.number for a in files for part in a.parts]
    if len({*held}) == len(held) or None in (stated_number(r, reference) for r in results):
        return files

    def with_name(file: Alignment, written: Results) -> Alignment:
        wrong = next((x for x in file.seen if isinstance(x, ManeuverNamedOtherwise)), None)
        if wrong is None:
            return file
        rows = (replace(written.maneuvers[0], maneuver=wrong.named),)
        seen = (*written.seen, replace(wrong, maneuver=wrong.named))
        return _aligned_file(replace(written, maneuvers=rows, seen=seen), reference)

    return [with_name(*x) for x in zip(files, results, strict=True)]


def _aligned_file(results: Results, reference: Reference) -> Alignment:
    return without_unfilled(align(results, reference))


def scored(
    alignment: Alignment,
    reference: Reference,
    require: str | Sequence[str] = (),
    understood: Understandings | None = None,
) -> Report:
    """Return the report of aligned results, with the given interpretation or the best one."""
    taken = understand(alignment.parts) if understood is None else understood
    taken = _with_exact_zero(taken, alignment.parts)

    def score_part(part: Part) -> ManeuverScore:
        return _score_maneuver(part, taken, reference.most_apart)

    if all(is_small(part) for part in alignment.parts):
        maneuvers = tuple(map(score_part, alignment.parts))
    else:
        from concurrent.futures import ThreadPoolExecutor

        from heyoka_bike.system.parallel import processors

        # During operations on long arrays, NumPy releases the interpreter's lock, so threads run in
        # parallel.
        with ThreadPoolExecutor(processors()) as pool:
            maneuvers = tuple(pool.map(score_part, alignment.parts))
    found = judged(
        Report(
            dataset_version=reference.dataset_version,
            bicycle=reference.bicycle,
            file=alignment.file,
            maneuvers=maneuvers,
            seen=alignment.seen,
            reference_sha256=reference.content_sha256,
        )
    )
    asked = [require] if isinstance(require, str) else words(require, "require")
    return replace(found, requirements=check(asked, found))


def scored_rows(report: Report, parts: Sequence[Part], reference: Reference) -> Report:
    """Return the report of changed rows of the same file, for example corrected ones."""
    return scored(Alignment(report.file, tuple(parts), ()), reference)


def _score_maneuver(part: Part, understood: Understandings, most_apart: float) -> ManeuverScore:
    # List the columns in the order of the benchmark. A column without a usable value has no
    # interpretation.
    columns = tuple(
        _score_column(part, key, understood.get(key) or plain(key))
        for key in part.reference.definitions
        if key in part.values
    )
    steps = np.diff(part.time) + np.diff(part.time_lo)
    start, end, coverage, gap = _coverage(part, most_apart)
    found = ManeuverScore(
        maneuver=part.number,
        name=part.reference.name,
        rows=len(part.time),
        t_start=start,
        t_end=end,
        coverage=coverage,
        gap=gap,
        step=float(median(steps)) if len(steps) else None,
        performance=measures.performance(*_energy(part, understood, columns)),
        performance_limit=part.reference.performance_limit,
        consistency=_consistency(part, columns),
        columns=columns,
        part=part,
    )
    return replace(found, meets_limit=meets_limit(found))


def _consistency(part: Part, columns: Sequence[ColumnScore]) -> Consistency:
    """Return how well the energies add up, and how well rates are the derivatives of angles."""
    by_key = {c.key: c for c in columns if c.values and not c.missing}
    total, floor = energy_sum(by_key, has_rest=any("energy" in key for key in part.lo))
    rates = {key: from_derivative(part.reference, by_key, key) for key in RATES}
    return Consistency(
        energy_sum=total,
        energy_sum_floor=floor,
        roll_rate=rates["roll_rate"][0],
        steer_rate=rates["steer_rate"][0],
        contradicted=tuple(key for key, (_, is_contradicted) in rates.items() if is_contradicted),
    )


def _coverage(part: Part, most_apart: float) -> tuple[float, float, float, float]:
    """Return the first and the last complete time, the fraction covered, and the largest gap [s].

    Only rows with a value in every column count. Two rows cover the time between them if they are
    no farther apart than `most_apart` [s]: between rows that are farther apart, a wrong motion may
    remain unseen.
    """
    duration = float(part.reference.duration)
    complete = np.all([np.isfinite(v) for v in part.values.values()], axis=0)
    if not complete.any():
        return float(part.time[0]), float(part.time[-1]), 0.0, duration
    times = part.time[complete]
    steps = np.diff(times)
    covered = float(steps[steps <= most_apart * (1 + SUMMED)].sum()) / duration
    gap = float(np.diff(times, prepend=0.0, append=duration).max())
    # Steps that were added with rounding errors may end slightly before the end of the run, so
    # nearly complete coverage counts as complete.
    return float(times[0]), float(times[-1]), 1.0 if covered > 1 - SUMMED else covered, gap


def _energy(part: Part, understood: Understandings, columns: Sequence[ColumnScore]) -> Double:
    """Return the file's mechanical energy [J], or its potential plus kinetic energy, if any."""
    total, *parts = ("mechanical_energy", "potential_energy", "kinetic_energy")
    whole = {c.key for c in columns if not c.missing}
    keys = [total] if any(c.key == total for c in columns) else parts
    if not whole.issuperset(keys):
        return np.empty(0), np.empty(0)
    energy, *more = (understood[key].exactly_in_si(part.written(key)) for key in keys)
    return add(energy, more[0]) if more else energy


def _score_column(part: Part, key: str, u: Understanding) -> ColumnScore:
    """Return the score of a column in its best definition, in the default and in all others."""
    values, error, trace, reading = _read_as(part, key, u)
    others = [c for c in part.reference.definitions[key] if c is not u.column]
    far = largest_errors(part, values, [c.name for c in others]) if others else []
    half, floor = rounding(part, key, u.unit)
    return ColumnScore(
        key=key,
        unit=u.column.unit,
        as_written=reading if u.is_plain() else _read_as(part, key, plain(key))[-1],
        as_understood=reading,
        floor=floor,
        alternatives=tuple(
            Alternative(c.definition, x if len(trace.time) else None, u.odds.get(c.definition))
            for c, x in zip(others, far, strict=True)
        ),
        indistinguishable=u.indistinguishable,
        growth=measures.growth(trace.time, trace.error, float(part.reference.duration)),
        values=len(trace.time),
        missing=int(np.count_nonzero(~np.isfinite(part.values[key]))),
        trace=trace,
        scale=part.reference.scale(u.column.name),
        unexplained=float(np.fmax.reduce(np.abs(error) - half, initial=0.0)),
        resolution=float(np.max(half)),
        none_odds=u.none,
    )


def _with_exact_zero(understood: Understandings, parts: Sequence[Part]) -> Understandings:
    """Return the interpretations with the zero of the energies to all digits of the file."""
    key = next((k for k in ZEROED if k in understood), "")
    u = understood.get(key)
    if u is None or not u.offset:
        return understood
    intervals: list[tuple[float, float, float]] = []
    for part in parts:
        if key not in part.values:
            continue
        error = errors(part, u.exactly_in_si(part.written(key)), u.column.name)
        error = error[np.isfinite(error)]
        if not len(error):
            continue
        last_digit = rounding(part, key, u.unit)[1] or 0.0
        if key not in part.lo:
            last_digit = max(last_digit, float(np.spacing(part.reference.scale(key))) / 2)
        # If the zero is right, errors of the motion are zero in the first row, and rounding errors
        # are symmetric about zero.
        amid, spread, reach = float(error[0]), float(np.ptp(error)) / 2, last_digit
        if spread <= _ROUNDED * last_digit:
            amid = float(np.max(error) + np.min(error)) / 2
            reach = max(last_digit - spread, 0.0)
        intervals.append((max(last_digit, spread), amid - reach, amid + reach))
    # Intersect the intervals, beginning with the smallest errors. Skip intervals that contradict
    # the previous ones.
    low, high = -np.inf, np.inf
    for _, least, most in sorted(intervals):
        if max(low, least) <= min(high, most):
            low, high = max(low, least), min(high, most)
    rest = (low + high) / 2 if intervals else 0.0
    return {
        k: replace(v, offset_lo=v.offset_lo + rest) if v.offset == u.offset else v
        for k, v in understood.items()
    }


def _read_as(part: Part, key: str, u: Understanding) -> tuple[Array, Array, Trace, Reading]:
    """Return a column in SI units, its error, the finite rows of both, and their measures."""
    values = u.exactly_in_si(part.written(key))
    error = errors(part, values, u.column.name)
    good = np.isfinite(error)
    trace = Trace(part.time[good], values[0][good], error[good])
    scale = part.reference.scale(u.column.name)
    reading = Reading(
        definition=u.column.definition,
        sign=u.sign,
        unit=u.unit,
        offset=u.offset + u.offset_lo,
        measures=measures.measures(trace.time, trace.error, trace.reference, scale),
    )
    return values[0], error, trace, reading
