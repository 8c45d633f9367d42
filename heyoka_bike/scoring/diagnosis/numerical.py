"""Numerical causes, where no mistake of the model explains a file: what its error looks like."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import HALF
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.findings import Finding, Severity, info, warning
from heyoka_bike.scoring.judge.single_precision import single_precision
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.report import ManeuverScore, Report

# A correct file's error is its floor; sums and conversions may double it.
_AT_FLOOR = 2.0
# Fewer rows show no shape.
_FEW_ROWS = 10
# Tenths of the run may go the other way by this part of the whole change of the energy.
_BACK = 0.02
# Noise of velocities hardly shows in the angles, their integrals; that of output does.
_IN_RATES = 10.0
# Fourth differences leave nothing of a smooth error and all of what jumps. Of white noise they are
# so many times as large as the noise: sqrt(1+16+36+16+1).
_GAIN = 70**0.5
_FEWEST = 100
# Noise of so many floors is not that of the digits written.
_SHOWN = 10.0
# Correlation from row to row, above which nothing jumps.
_SMOOTH = 0.5
# Parts of the error: what shows at all, and what noise of iterations must be; Exudyn's with tight
# ones is below 2e-4, with loose ones above 5e-3.
_SEEN = 1e-4
_NOISE = 2e-3
# Correlation one and two rows on, of what alternates.
_ALTERNATES = 0.95
# More than this part of the error is noise where all of it jumps.
_MOSTLY = 0.3
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


@dataclass(frozen=True, slots=True)
class _Roughness:
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
    far = [_error_in_scales(c) > HALF for m in report.maneuvers for c in m.columns if c.values]
    if 2 * sum(far) >= len(far):
        return (_too_far(),)
    worst = max(_error_in_scales(c) for m in report.maneuvers for c in m.columns)
    if worst > _BLOWN_UP:
        return (_blown_up(report, worst),)
    if worst < ROUNDING:
        return (_rounding(worst),)
    single = next(single_precision(report), None)
    if single is not None and worst < _OF_SINGLE:
        return (single,)
    if max(m.rows for m in report.maneuvers) < _FEW_ROWS:
        return (info("cannot_tell", "So few rows do not show what the error looks like"),)
    found = (*_energy(report), *_rough(report)) or (_smooth(),)
    if single is None:
        return found
    message = f"{single.message}. The error is far larger: another cause comes before this one"
    return *found, replace(single, message=message, severity=Severity.INFO)


def _error_in_scales(c: ColumnScore) -> float:
    return c.as_understood.measures.max_rel_error or 0.0


def _too_far() -> Finding:
    return info(
        TOO_FAR,
        "Half of the columns or more are off by half their own size, so that their error says "
        "nothing: look at the first rows, whether the columns are those of the benchmark, in its "
        "order and units, and at a run that is short",
    )


def _blown_up(report: Report, worst: float) -> Finding:
    every = ((m, c) for m in report.maneuvers for c in m.columns)
    m, c = next((m, c) for m, c in every if _error_in_scales(c) == worst)
    first = np.argmax(np.abs(c.trace.error) > 0.5 * np.max(np.abs(c.trace.reference)))
    time = float(c.trace.time[first])
    return warning(
        "blown_up",
        f"The motion blows up: {c.key} of maneuver {m.maneuver} is off by {worst:.2g} times its "
        f"size, and by half of it from {time:.3g} s on. Compare the rows before: what follows says "
        "nothing",
        maneuver=m.maneuver,
        column=c.key,
        time=time,
        max_rel_error=worst,
    )


def _smooth() -> Finding:
    return info(
        "smooth_error",
        "The error is that of steps, even or chosen by a tolerance, of a method that is not known "
        f"here, or of another model. Halve the step ({_BOTH_STEPS}), or divide the tolerance by "
        f"ten ({_BOTH_TOLERANCES}): the error of an integrator falls, by 2^p with a method of "
        "order p; that of another model stays the same curve; and noise of rounding or of "
        "iterations stays as large, but is another curve",
    )


def _rounding(worst: float) -> Finding:
    return info(
        "limited_by_rounding",
        f"The error is {worst:.1g} of the scale at the most: that is what rounding leaves of a run "
        "in binary64 arithmetic. If it does not fall with the tolerance or the step "
        f"({_BOTH_TOLERANCES}), it is the arithmetic, and not the model",
        max_rel_error=worst,
    )


_TRENDS = {
    -1.0: (
        "numerical_damping",
        "falls steadily{}. Either the model loses it, by a damper, drag, or a contact that slips "
        "or yields, or numerical damping does: with a smaller step or tolerance only the latter "
        "becomes less",
    ),
    1.0: (
        "energy_grows",
        "grows steadily{}, as with an explicit method of low order, or with a drive in the model: "
        "a smaller step helps against the former only",
    ),
}
"""By the sign of the change."""


def _energy(report: Report) -> Iterator[Finding]:
    """Energy that falls or grows steadily in every maneuver."""
    trends = {m.maneuver: _trend(m) for m in report.maneuvers}
    signs = {float(np.sign(t)) for t in trends.values()}
    if len(signs) == 1 and (sign := signs.pop()) in _TRENDS:
        code, words = _TRENDS[sign]
        said = words.format(" in every maneuver" if len(trends) > 1 else "")
        changes = {str(n): t for n, t in trends.items()}
        yield info(
            code,
            f"The mechanical energy {said}",
            maneuvers=list(trends),
            relative_change=changes,
        )


def _trend(m: ManeuverScore) -> float:
    """Relative change of the mechanical energy over the run if it is steady, otherwise 0."""
    energy = next((c for c in m.columns if c.key == "mechanical_energy"), None)
    if energy is None or energy.is_at_floor(_AT_FLOOR) or energy.values < 20:
        return 0.0
    means = np.array([np.mean(part) for part in np.array_split(energy.trace.error, 10)])
    change = float(means[-1] - means[0])
    back = float(np.min(np.diff(means) * np.sign(change)))
    if abs(change) <= 10 * (energy.floor or 0.0) or back < -_BACK * abs(change):
        return 0.0
    return change / float(np.max(np.abs(energy.trace.value)))


def _rough(report: Report) -> Iterator[Finding]:
    """Yield a finding on an error that jumps from row to row: iterations, or noise."""
    found = {(m.maneuver, c.key): _roughness(c) for m in report.maneuvers for c in m.columns}
    jumping = {
        place: r
        for place, r in found.items()
        if r is not None and r.at_one < _SMOOTH and r.part > _SEEN
    }
    columns = [f"{number}.{key}" for number, key in jumping]
    numbers = [m.maneuver for m in report.maneuvers]
    noisy = [r for r in jumping.values() if r.part > _MOSTLY and _is_white(r)]
    in_rates = [n for n in numbers if _in_rates(n, jumping)]
    ringing = [n for n in numbers if _rings(n, jumping)]
    if len(noisy) > len(found) / 2:
        yield info(
            "rough_error",
            "The error jumps from row to row like noise, far above the digits written, which no "
            "step size makes: look for single-precision numbers on the way, random terms, or a "
            "loose tolerance of the iterations",
            columns=columns,
        )
    elif 2 * len(ringing) > len(numbers):
        yield info(
            "step_ringing",
            "The velocities alternate from row to row, as the trapezoidal rule leaves them where "
            "nothing damps the highest frequency: accelerations that are consistent at the start, "
            "or a little numerical damping",
            maneuvers=ringing,
        )
    elif 2 * len(in_rates) > len(numbers):
        yield info(
            "iteration_noise",
            "The velocities jump from row to row, much more than the angles, as a loose tolerance "
            "of the Newton iterations in each step makes them, or impulses of a contact: tighten "
            "it until the energy's error is smooth (a smaller step does not help); if it stays "
            "rough, it is the contact or the friction, or, where the jumps are below 1e-8 of the "
            "scale, rounding divided by the step",
            maneuvers=in_rates,
        )


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
    return rate is not None and -rate.at_one > _ALTERNATES and rate.at_two > _ALTERNATES


def _roughness(c: ColumnScore) -> _Roughness | None:
    """Return the roughness of a column's error; None if it is not above the digits written."""
    if c.values < _FEWEST:
        return None
    fifths = np.array_split(np.diff(c.trace.error, 4) / _GAIN, 5)
    size = float(np.median([np.std(x) for x in fifths]))
    if size <= _SHOWN * (c.floor or 0.0):
        return None
    at_one, at_two = (float(np.median([_correlation(x, k) for x in fifths])) for k in (1, 2))
    return _Roughness(size / float(np.std(c.trace.error)), at_one, at_two)


def _correlation(x: Array, rows: int) -> float:
    a, b = x[:-rows], x[rows:]
    both = float(np.dot(a, a) * np.dot(b, b)) ** 0.5
    return float(np.dot(a, b)) / both if both else 0.0
