"""Scoring: a result file against the reference, at the file's own times.

`score` is the pipeline: `alignment` finds the maneuvers and the rows that can be compared,
`understanding` what the columns mean, `measures` how far they are from the reference, and
`consistency` how well the file agrees with itself. The outcome is one `report.Report`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from heyoka_bike import measures
from heyoka_bike.alignment import Alignment, Part, align, merge
from heyoka_bike.chebyshev import Array, Double, two_sum
from heyoka_bike.columns import DEFINITIONS
from heyoka_bike.consistency import consistency
from heyoka_bike.explain import explain
from heyoka_bike.manifest import CUSTOM
from heyoka_bike.reference import Reference, ReferenceManeuver, Values, load_reference
from heyoka_bike.report import (
    Alternative,
    ColumnScore,
    FileInfo,
    ManeuverScore,
    Reading,
    Report,
    Trace,
)
from heyoka_bike.requirements import check
from heyoka_bike.results import Results
from heyoka_bike.understanding import Understanding, plain, understand
from heyoka_bike.units import factor, to_si

# The benchmark judges maneuver 2, by eq. (1) below 1e-3 %.
_JUDGED: Mapping[int, float] = {2: 1e-3}

# Up to this many values hi + lo of the reference is always evaluated, and by one thread.
_FEW = 100_000
# The plain evaluation is good to 1e-15 of the scale: an error above this is right to 0.1 % with it.
_PLAIN_WILL_DO = 1e-12


def score(
    results: Results | Sequence[Results],
    reference: Reference | None = None,
    require: Sequence[str] = (),
) -> Report:
    """Compare results with the reference.

    Parameters
    ----------
    results
        From `reading.read_results`; several if they hold different maneuvers of one run.
    reference
        From `load_reference`; the published one by default.
    require
        Requirements such as ``"2.roll_angle.scd >= 6"``, see `requirements`.

    Returns
    -------
    Report
        Errors in SI units at the rows' own times, with the definition, sign, unit and zero that
        each column turned out to have. Nothing is extrapolated or interpolated.

    Raises
    ------
    InputError
        A maneuver that the reference does not have or that comes twice, or a requirement that
        cannot be read.
    NothingScoredError
        Nothing can be compared.
    """
    known = load_reference() if reference is None else reference
    several = [results] if isinstance(results, Results) else list(results)
    alignment = merge([align(r, known) for r in several])
    return report(alignment, understand(alignment.parts), known, require)


def report(
    alignment: Alignment,
    understood: Mapping[str, Understanding],
    reference: Reference,
    require: Sequence[str] = (),
) -> Report:
    """The report of aligned results, with their columns taken as understood."""
    benchmark = reference.dataset_version != CUSTOM

    def score_part(part: Part) -> ManeuverScore:
        return _score_maneuver(part, understood, _JUDGED.get(part.number) if benchmark else None)

    if all(_is_small(part) for part in alignment.parts):
        maneuvers = tuple(map(score_part, alignment.parts))
    else:
        from concurrent.futures import ThreadPoolExecutor

        # NumPy computes on long arrays outside the interpreter's lock.
        with ThreadPoolExecutor() as pool:
            maneuvers = tuple(pool.map(score_part, alignment.parts))
    found = Report(
        dataset_version=reference.dataset_version,
        bicycle=reference.bicycle,
        file=FileInfo(
            path=alignment.path,
            format=alignment.format,
            rows=alignment.rows,
            t_start=alignment.t_start,
            t_end=alignment.t_end,
            significant_digits=alignment.significant_digits,
        ),
        maneuvers=maneuvers,
        findings=alignment.findings,
    )
    found = replace(found, findings=alignment.findings + explain(found))
    return replace(found, requirements=tuple(check(text, found) for text in require))


def _score_maneuver(
    part: Part, understood: Mapping[str, Understanding], limit: float | None
) -> ManeuverScore:
    keys = [key for key in DEFINITIONS if key in part.values]
    names = [understood[key].column.name for key in keys]
    names += [key for key in keys if key not in names]
    exact = part.reference.evaluate((part.time, part.time_lo), names) if _is_small(part) else None
    columns = tuple(_score_column(part, key, understood[key], exact) for key in keys)
    steps = np.diff(part.time)
    duration = float(part.reference.duration)
    start, end = float(part.time[0]), float(part.time[-1])
    return ManeuverScore(
        maneuver=part.number,
        name=part.reference.name,
        rows=len(part.time),
        t_start=start,
        t_end=end,
        coverage=(end - start) / duration,
        step=float(np.median(steps)) if len(steps) else None,
        performance=measures.performance(_energy(columns)),
        performance_limit=limit,
        consistency=consistency(part, columns),
        columns=columns,
    )


def _is_small(part: Part) -> bool:
    return len(part.time) * len(part.values) <= _FEW


def _energy(columns: Sequence[ColumnScore]) -> Array:
    """The file's own mechanical energy [J], or the sum of its parts."""
    traces = {c.key: c.trace for c in columns}
    if "mechanical_energy" in traces:
        return traces["mechanical_energy"].value
    potential, kinetic = traces.get("potential_energy"), traces.get("kinetic_energy")
    if potential is None or kinetic is None or len(potential.value) != len(kinetic.value):
        return np.empty(0)
    return potential.value + kinetic.value


def _score_column(part: Part, key: str, u: Understanding, exact: Values | None) -> ColumnScore:
    written = part.values[key]
    good = np.isfinite(written)
    rest = part.lo.get(key)
    values: Double = (written[good], np.zeros(int(good.sum())) if rest is None else rest[good])
    time: Double = (part.time[good], part.time_lo[good])
    duration = float(part.reference.duration)
    si = _as_understood(values, u)

    def compare(values: Double, name: str) -> tuple[Array, Array]:
        """The reference at the times, and the values minus it."""
        if exact is not None:
            return _difference(values, (exact[name][good], exact.lo[name][good]))
        return _compare(part.reference, time, values, name)

    reference, error = compare(si, u.column.name)
    understood = _reading(part.reference, time, error, reference, u)
    as_written = plain(key)
    if u.is_plain():
        written_reading = understood
    else:
        expected, difference = compare(values, as_written.column.name)
        written_reading = _reading(part.reference, time, difference, expected, as_written)
    others = [c for c in DEFINITIONS[key] if c is not u.column]
    near = part.reference.approximate(time[0], [c.name for c in others]) if others else {}
    return ColumnScore(
        key=key,
        unit=u.column.unit,
        as_written=written_reading,
        as_understood=understood,
        floor=_floor(part, key, written[good], u),
        alternatives=tuple(
            Alternative(
                c.definition,
                float(np.max(np.abs(si[0] - near[c.name]))) if len(si[0]) else None,
            )
            for c in others
        ),
        indistinguishable=u.indistinguishable,
        growth=measures.growth(time[0], error, duration),
        values=int(good.sum()),
        missing=int((~good).sum()),
        trace=Trace(time=time[0], value=si[0], reference=reference, error=error),
    )


def _as_understood(values: Double, u: Understanding) -> Double:
    hi, lo = to_si(values, u.unit)
    if u.sign < 0:
        hi, lo = -hi, -lo
    if not u.offset:
        return hi, lo
    hi, rest = two_sum(hi, np.full_like(hi, -u.offset))
    return two_sum(hi, rest + lo)


def _compare(
    reference: ReferenceManeuver, time: Double, values: Double, name: str
) -> tuple[Array, Array]:
    """The reference at many times, and the values minus it; hi + lo only if that is needed."""
    plain_values = reference.approximate(time[0], [name])[name]
    error = values[0] - plain_values
    if not len(error) or np.max(np.abs(error)) > _PLAIN_WILL_DO * _scale(reference, name):
        return plain_values, error
    found = reference.evaluate(time, name)
    return _difference(values, (found[name], found.lo[name]))


def _difference(values: Double, exact: Double) -> tuple[Array, Array]:
    difference, rest = two_sum(values[0], -exact[0])
    return exact[0], difference + (rest + (values[1] - exact[1]))


def _reading(
    reference: ReferenceManeuver, time: Double, error: Array, expected: Array, u: Understanding
) -> Reading:
    return Reading(
        definition=u.column.definition,
        sign=u.sign,
        unit=u.unit,
        offset=u.offset,
        measures=measures.measures(time[0], error, expected, _scale(reference, u.column.name)),
    )


def _scale(reference: ReferenceManeuver, name: str) -> float:
    """Largest absolute value over the run, at its rows."""
    return float(np.max(np.abs(reference.rows[name])))


def _floor(part: Part, key: str, values: Array, u: Understanding) -> float | None:
    """Largest error that correctly rounded values at correctly rounded times may have [SI]."""
    quantum = part.quantum.get(key)
    if quantum is None or not len(values):
        return None
    floor = float(np.max(quantum.at(values))) / 2 * factor(u.unit)[0]
    times = part.quantum.get("time")
    if times is None or times.base != 10 or _is_even(part.time):
        return floor
    # Uneven times are rounded to the digits written, too.
    rows = part.reference.rows[u.column.name]
    steepest = float(np.max(np.abs(np.diff(rows) / np.diff(part.reference.time))))
    return floor + steepest * float(np.max(times.at(part.time))) / 2


def _is_even(time: Array) -> bool:
    """Whether the times are multiples of one step, so that no digit of them is missing."""
    steps = np.diff(time)
    steps = steps[steps > 0]
    if not len(steps):
        return True
    multiples = time / np.min(steps)
    return bool(np.max(np.abs(multiples - np.rint(multiples))) < 1e-6)
