"""Scoring: a result file against the reference, at the file's own times.

`score` is the pipeline: `alignment` finds the maneuvers and the rows that can be compared,
`definitions` what the columns mean, `measures` their errors and what the digits written allow, and
`judge` the evidence that they hold. The outcome is one `report.Report`, of which `verdict` decides
what is right.
"""

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from typing import Any

import numpy as np

from heyoka_bike.numbers.double import Array, Double, add, median, with_usual_errors
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring import measures
from heyoka_bike.scoring.alignment import SUMMED, Alignment, Part, align, merge
from heyoka_bike.scoring.definitions import Understanding, Understandings, plain, understand
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

# Correct values that were rounded once or twice are off by up to this many times half a last digit.
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
        each column turned out to have. Nothing is interpolated, and nothing is extrapolated but a
        few milliseconds beyond the end, see `ReferenceManeuver.reach`.

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
    understood: Understandings | None = None,
) -> Report:
    """The report of aligned results, with their columns as understood or as they fit best."""
    taken = understand(alignment.parts) if understood is None else understood
    taken = _with_exact_zero(taken, alignment.parts)

    def score_part(part: Part) -> ManeuverScore:
        return _score_maneuver(part, taken, reference.most_apart)

    if all(is_small(part) for part in alignment.parts):
        maneuvers = tuple(map(score_part, alignment.parts))
    else:
        from concurrent.futures import ThreadPoolExecutor

        from heyoka_bike.system.parallel import processors

        # NumPy computes on long arrays outside the interpreter's lock.
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


def _score_maneuver(part: Part, understood: Understandings, most_apart: float) -> ManeuverScore:
    # In the benchmark's order; without a usable value nothing is understood of a column.
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
    """Sum of the energies, and rates against the derivatives of their own angles."""
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
    """First and last time with a value in every column, the part of the run covered, and the gap.

    Two rows cover the time between them if they are no farther apart than `most_apart` [s]: between
    rows that are farther apart, a wrong motion may remain unseen.
    """
    duration = float(part.reference.duration)
    complete = np.all([np.isfinite(v) for v in part.values.values()], axis=0)
    if not complete.any():
        return float(part.time[0]), float(part.time[-1]), 0.0, duration
    times = part.time[complete]
    steps = np.diff(times)
    covered = float(steps[steps <= most_apart * (1 + SUMMED)].sum()) / duration
    gap = float(np.diff(times, prepend=0.0, append=duration).max())
    # Summed steps end a last digit or so beside the end.
    return float(times[0]), float(times[-1]), 1.0 if covered > 1 - SUMMED else covered, gap


def _energy(part: Part, understood: Understandings, columns: Sequence[ColumnScore]) -> Double:
    """The file's own mechanical energy [J], or the sum of its parts; empty without."""
    total, *parts = ("mechanical_energy", "potential_energy", "kinetic_energy")
    whole = {c.key for c in columns if not c.missing}
    keys = [total] if any(c.key == total for c in columns) else parts
    if not whole.issuperset(keys):
        return np.empty(0), np.empty(0)
    energy, *more = (understood[key].exactly_in_si(part.written(key)) for key in keys)
    return add(energy, more[0]) if more else energy


def _score_column(part: Part, key: str, u: Understanding) -> ColumnScore:
    """Compare one column with the definition that it is taken as, with the default, and others."""
    values, error, trace, reading = _taken(part, key, u)
    others = [c for c in part.reference.definitions[key] if c is not u.column]
    far = largest_errors(part, values, [c.name for c in others]) if others else []
    half, floor = rounding(part, key, u.unit)
    return ColumnScore(
        key=key,
        unit=u.column.unit,
        as_written=reading if u.is_plain() else _taken(part, key, plain(key))[-1],
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
    """The zero of the energies to all digits of the file, where they have another one."""
    key = next((k for k in ZEROED if k in understood), "")
    u = understood.get(key)
    if u is None or not u.offset:
        return understood
    told: list[tuple[float, float, float]] = []
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
        # Errors of the motion begin at nothing with it; those of rounding are as large both ways.
        amid, spread, reach = float(error[0]), float(np.ptp(error)) / 2, last_digit
        if spread <= _ROUNDED * last_digit:
            amid = float(np.max(error) + np.min(error)) / 2
            reach = max(last_digit - spread, 0.0)
        told.append((max(last_digit, spread), amid - reach, amid + reach))
    # What the finest errors tell, and of it what the others allow.
    low, high = -np.inf, np.inf
    for _, least, most in sorted(told):
        if max(low, least) <= min(high, most):
            low, high = max(low, least), min(high, most)
    rest = (low + high) / 2 if told else 0.0
    return {
        k: replace(v, offset_lo=v.offset_lo + rest) if v.offset == u.offset else v
        for k, v in understood.items()
    }


def _taken(part: Part, key: str, u: Understanding) -> tuple[Array, Array, Trace, Reading]:
    """A column in SI units and its error, the finite ones of both, and what these measure."""
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
