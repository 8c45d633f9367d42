"""Numerical causes, where no mistake of the model explains a file: what its error looks like."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from heyoka_bike.display import shown_by
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import HALF
from heyoka_bike.scoring.findings import Finding, Severity, info
from heyoka_bike.scoring.judge.precision import single_precision
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

# A correct file's error is its floor; sums and conversions may double it.
_FLOORS_OF_DRIFT = 2.0
# Fewer rows show no shape.
_FEW_ROWS = 10
# Tenths of the run may go the other way by this part of the whole change of the energy.
_PART_THAT_GOES_BACK = 0.02
# Noise of velocities hardly shows in the angles, their integrals; that of output does.
_IN_RATES = 10.0
# Fourth differences leave nothing of a smooth error and all of what jumps. Of white noise they are
# so many times as large as the noise: sqrt(1+16+36+16+1).
_GAIN = 70**0.5
_FEWEST = 100
# Noise of so many floors is not that of the digits written.
_TIMES_ROUGHER = 10.0
# Correlation from row to row, above which nothing jumps.
_SMOOTH = 0.5
# Parts of the error: what shows at all, and what noise of iterations must be; Exudyn's with tight
# ones is below 2e-4, with loose ones above 5e-3.
_SMALLEST_TOLD = 1e-4
_NOISE = 2e-3
# Correlation one and two rows on, of what alternates.
_ALTERNATING_PART = 0.95
# More than this part of the error is noise where all of it jumps.
_PART_OF_ROWS_ROUGH = 0.3
# Of white noise, with the scatter of a thousand rows.
_WHITE = (-0.8, 0.4)
_SCATTER = 0.1


# Of the scale: ten times what single-precision arithmetic was seen to leave of a run, whose steps
# add up: 1e-5 with steps of 0.01 s, 9e-5 with steps of 0.001 s.
_OF_SINGLE = 1e-3
# Times its own size.
_BLOWN_UP = 10.0
TOO_FAR = "too_far"
"""Code of the finding that hardly anything of the motion is left."""
# How to see what falls.
_BOTH_STEPS = "heyoka-bike score A B --step 0.01,0.005"
_BOTH_TOLERANCES = "heyoka-bike score A B --tolerance 1e-8,1e-9"

_SENTENCES = {
    TOO_FAR: "Half of the columns or more are off by half their own size, so that their error says "
    "nothing: look at the first rows, whether the columns are those of the benchmark, in its order "
    "and units, and at a run that is short",
    "blown_up": "The motion blows up: {column} of maneuver {maneuver} is off by "
    "{max_rel_error:.2g} times its size, and by half of it from {time:.3g} s on. Compare the rows "
    "before: what follows says nothing",
    "limited_by_rounding": "The error is {max_rel_error:.1g} of the scale at the most: that is "
    "what rounding leaves of a run in binary64 arithmetic. If it does not fall with the tolerance "
    f"or the step ({_BOTH_TOLERANCES}), it is the arithmetic, and not the model",
    "cannot_tell": "So few rows do not show what the error looks like",
    "smooth_error": "The error is that of steps, even or chosen by a tolerance, of a method that "
    f"is not known here, or of another model. Halve the step ({_BOTH_STEPS}), or divide the "
    f"tolerance by ten ({_BOTH_TOLERANCES}): the error of an integrator falls, by 2^p with a "
    "method of order p; that of another model stays the same curve; and noise of rounding or of "
    "iterations stays as large, but is another curve",
    "numerical_damping": "The mechanical energy falls steadily{every}. Either the model loses it, "
    "by a damper, drag, or a contact that slips or yields, or numerical damping does: with a "
    "smaller step or tolerance only the latter becomes less",
    "energy_grows": "The mechanical energy grows steadily{every}, as with an explicit method of "
    "low order, or with a drive in the model: a smaller step helps against the former only",
    "rough_error": "The error jumps from row to row like noise, far above the digits written, "
    "which no step size makes: look for single-precision numbers on the way, random terms, or a "
    "loose tolerance of the iterations",
    "step_ringing": "The velocities alternate from row to row, as the trapezoidal rule leaves them "
    "where nothing damps the highest frequency: accelerations that are consistent at the start, or "
    "a little numerical damping",
    "iteration_noise": "The velocities jump from row to row, much more than the angles, as a loose "
    "tolerance of the Newton iterations in each step makes them, or impulses of a contact: tighten "
    "it until the energy's error is smooth (a smaller step does not help); if it stays rough, it "
    "is the contact or the friction, or, where the jumps are below 1e-8 of the scale, rounding "
    "divided by the step",
}
"""By the code of the finding, with the numbers of its evidence."""


class _Roughness(NamedTuple):
    """The part of a column's error that jumps from row to row, medians of the fifths of the run.

    A start that settles, or an event, is not in them.

    Attributes
    ----------
    part
        Size of what jumps, of that of the error.
    at_one, at_two
        Correlation of the fourth differences with themselves one and two rows on: near 1 of a
        smooth error, -0.8 and 0.4 of white noise, -1 and 1 of one that alternates.
    """

    part: float
    at_one: float
    at_two: float


def findings(report: Report) -> tuple[Finding, ...]:
    """Return the numerical causes of the error; at least that it is smooth."""
    columns = [(_error_in_scales(c), m, c) for m in report.maneuvers for c in m.columns]
    far = [error > HALF for error, _, c in columns if c.values]
    if 2 * sum(far) >= len(far):
        return (_said(TOO_FAR),)
    worst, m, c = max(columns, key=lambda x: x[0])
    if worst > _BLOWN_UP:
        first = np.argmax(np.abs(c.trace.error) > 0.5 * np.max(np.abs(c.trace.reference)))
        place = {"maneuver": m.maneuver, "column": c.key, "time": float(c.trace.time[first])}
        said = _said("blown_up", **place, max_rel_error=worst)
        return (replace(said, severity=Severity.WARNING),)
    if worst < ROUNDING:
        return (_said("limited_by_rounding", max_rel_error=worst),)
    single = _single(report)
    if single is not None and worst < _OF_SINGLE:
        return (single,)
    if max(m.rows for m in report.maneuvers) < _FEW_ROWS:
        return (_said("cannot_tell"),)
    found = (*_energy(report), *_rough(report)) or (_said("smooth_error"),)
    if single is None:
        return found
    message = f"{single.message}. The error is far larger: another cause comes before this one"
    return *found, replace(single, message=message, severity=Severity.INFO)


def _single(report: Report) -> Finding | None:
    """What is said of numbers of single precision."""
    seen = next(single_precision(report), None)
    if seen is None:
        return None
    found: Finding = shown_by("sayings").finding(seen)
    return found


def _said(code: str, **evidence: Any) -> Finding:
    return info(code, _SENTENCES[code].format(**evidence), **evidence)


def _error_in_scales(c: ColumnScore) -> float:
    return c.as_understood.measures.max_rel_error or 0.0


def _energy(report: Report) -> Iterator[Finding]:
    """Energy that falls or grows steadily in every maneuver."""
    changes = {str(m.maneuver): _trend(m) for m in report.maneuvers}
    if all(x < 0.0 for x in changes.values()) or all(x > 0.0 for x in changes.values()):
        code = "energy_grows" if max(changes.values()) > 0.0 else "numerical_damping"
        every = " in every maneuver" if len(changes) > 1 else ""
        numbers = [m.maneuver for m in report.maneuvers]
        message = _SENTENCES[code].format(every=every)
        yield info(code, message, maneuvers=numbers, relative_change=changes)


def _trend(m: ManeuverScore) -> float:
    """Relative change of the mechanical energy over the run if it is steady, otherwise 0."""
    energy = next((c for c in m.columns if c.key == "mechanical_energy"), None)
    if energy is None or energy.is_at_floor(_FLOORS_OF_DRIFT) or energy.values < 20:
        return 0.0
    means = np.array([np.mean(part) for part in np.array_split(energy.trace.error, 10)])
    change = float(means[-1] - means[0])
    back = float(np.min(np.diff(means) * np.sign(change)))
    if abs(change) <= 10 * (energy.floor or 0.0) or back < -_PART_THAT_GOES_BACK * abs(change):
        return 0.0
    return change / float(np.max(np.abs(energy.trace.value)))


def _rough(report: Report) -> Iterator[Finding]:
    """Yield a finding on an error that jumps from row to row: iterations, or noise."""
    found = {(m.maneuver, c.key): _roughness(c) for m in report.maneuvers for c in m.columns}
    jumping = {
        place: r
        for place, r in found.items()
        if r is not None and r.at_one < _SMOOTH and r.part > _SMALLEST_TOLD
    }
    numbers = [m.maneuver for m in report.maneuvers]
    noisy = [r for r in jumping.values() if r.part > _PART_OF_ROWS_ROUGH and _is_white(r)]
    in_rates = [n for n in numbers if _in_rates(n, jumping)]
    ringing = [n for n in numbers if _rings(n, jumping)]
    if len(noisy) > len(found) / 2:
        yield _said("rough_error", columns=[f"{number}.{key}" for number, key in jumping])
    elif 2 * len(ringing) > len(numbers):
        yield _said("step_ringing", maneuvers=ringing)
    elif 2 * len(in_rates) > len(numbers):
        yield _said("iteration_noise", maneuvers=in_rates)


def _is_white(r: _Roughness) -> bool:
    return abs(r.at_one - _WHITE[0]) < _SCATTER and abs(r.at_two - _WHITE[1]) < 2 * _SCATTER


def _in_rates(number: int, jumping: Mapping[tuple[int, str], _Roughness]) -> bool:
    """True if both rates of a maneuver jump, much more than their angles."""
    for kind in ("roll", "steer"):
        angle, rate = (jumping.get((number, f"{kind}_{x}")) for x in ("angle", "rate"))
        if rate is None or rate.at_one >= 0 or rate.part < _NOISE:
            return False
        if angle is not None and rate.part < _IN_RATES * angle.part:
            return False
    return True


def _rings(number: int, jumping: Mapping[tuple[int, str], _Roughness]) -> bool:
    """True if the steer rate of a maneuver alternates from row to row."""
    rate = jumping.get((number, "steer_rate"))
    return rate is not None and -rate.at_one > _ALTERNATING_PART and rate.at_two > _ALTERNATING_PART


def _roughness(c: ColumnScore) -> _Roughness | None:
    """Return the roughness of a column's error; None if it is not above the digits written."""
    if c.values < _FEWEST:
        return None
    fifths = np.array_split(np.diff(c.trace.error, 4) / _GAIN, 5)
    size = float(np.median([np.std(x) for x in fifths]))
    if size <= _TIMES_ROUGHER * (c.floor or 0.0):
        return None
    at_one, at_two = (float(np.median([_correlation(x, k) for x in fifths])) for k in (1, 2))
    return _Roughness(size / float(np.std(c.trace.error)), at_one, at_two)


def _correlation(x: Array, rows: int) -> float:
    a, b = x[:-rows], x[rows:]
    both = float(np.dot(a, a) * np.dot(b, b)) ** 0.5
    return float(np.dot(a, b)) / both if both else 0.0
