"""Numerical causes, where no mistake of the model explains a file: what its error looks like."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.alignment import HALF
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.diagnosis.numerical.height import Heights
from heyoka_bike.scoring.diagnosis.numerical.roughness import (
    SMOOTH,
    Roughness,
    interpolation,
    roughness,
)
from heyoka_bike.scoring.diagnosis.numerical.step_order import Order, order_of
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.judge.single_precision import single_precision
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.report import ManeuverScore, Report

# A correct file's error is its floor; sums and conversions may double it.
_AT_FLOOR = 2.0
# Fewer rows show no shape.
_FEW_ROWS = 10
# An error that one would like to reach, of the scale.
_WANTED = 1e-6
# Tenths of the run may go the other way by this part of the whole change of the energy.
_BACK = 0.02
# What a bicycle may float by unseen [m]. Its centre of mass is a metre high: a smaller part of the
# error, in scales, is not made by that.
_NOTICED = 1e-9
_OF_ERROR = 0.01
# Heights that are neither rounding nor a small part of what the potential energy is wrong by.
_ABOVE_FLOOR = 10.0
_COUNTS = 0.05
# A sunken wheel stays where it is, but for the first fifth of the run, in which it settles.
_STEADY = 0.2
# A drift is larger later than in the first fifth, and on one side of the floor: what oscillates
# about it, with the motion, is not more than the drift.
_GROWN = 1.5
_ONE_WAY = 0.4
# Noise of velocities hardly shows in the angles, their integrals; that of output does.
_IN_RATES = 10.0
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


# Of the scale: what single-precision arithmetic leaves of a run, whose steps add up.
_OF_SINGLE = 1e-5
# An order whose errors leave less than so many times what those of the best one leave may be it.
_CLEARLY = 2.0
TOO_FAR = "too_far"
"""Code of the finding that hardly anything of the motion is left."""
# How to see what falls.
_BOTH_STEPS = "heyoka-bike score A B --step 0.01,0.005"
_BOTH_TOLERANCES = "heyoka-bike score A B --tolerance 1e-8,1e-9"


def findings(report: Report, reference: Reference) -> tuple[Finding, ...]:
    """What numerical causes the error has; at least one finding, if only that it is smooth."""
    far = [_error_in_scales(c) > HALF for m in report.maneuvers for c in m.columns if c.values]
    if 2 * sum(far) >= len(far):
        return (_too_far(),)
    worst = max(_error_in_scales(c) for m in report.maneuvers for c in m.columns)
    if worst < ROUNDING:
        return (_rounding(worst),)
    single = next(single_precision(report), None)
    if single is not None and worst < _OF_SINGLE:
        return (single,)
    if max(m.rows for m in report.maneuvers) < _FEW_ROWS:
        return (Finding("cannot_tell", "So few rows do not show what the error looks like"),)
    order = order_of(report, reference)
    floor = tuple(_height(report, reference))
    if any(f.code == "wheels_sink_in" for f in floor):
        # The contact's own vibrations and losses would be taken for those of an integrator.
        return floor
    found = (
        *(() if order is None else (_of_order(order, report),)),
        # What a method in the state's own coordinates does to the energy says nothing more.
        *(_energy(report, order) if order is None or order.constrained else ()),
        *_rough(report, order),
        *floor,
    ) or (_smooth(),)
    return found if single is None else (*found, _not_alone(single, worst))


def _not_alone(single: Finding, worst: float) -> Finding:
    """That single precision is no cause of an error that is far larger than it makes."""
    return replace(
        single,
        message=f"{single.message}. It leaves errors of some {_OF_SINGLE:g} of the scale at most; "
        f"{worst:.1g} is another's",
        severity=Severity.INFO,
    )


def _of_order(order: Order, report: Report) -> Finding:
    worst = max(_error_in_scales(c) for m in report.maneuvers for c in m.columns)
    # Contact and friction that yield make errors of other orders that look like those of multibody
    # methods.
    is_sure = not order.constrained
    rivals = [p for p, left in order.others.items() if left < _CLEARLY * order.left]
    most, others = (100 * (1 - x) for x in (order.left, min(order.others.values())))
    about = " or ".join(map(str, (order.order, *rivals)))
    text = (
        f"This {'is' if is_sure else 'looks like'} integration error of order about {about}: "
        f"the errors of a {order.method} method of order {order.order} explain {most:.0f} % of it, "
        f"those of other orders at most {others:.0f} %; halve the step and it "
        f"{'falls' if is_sure else 'should fall'} to about "
        + " or ".join(f"1/{2**p}" for p in (order.order, *rivals))
    )
    smaller = (worst / _WANTED) ** (1 / order.order)
    if not is_sure:
        text += (
            f". Two runs tell ({_BOTH_STEPS}): an engine whose contact or constraints yield may be "
            "of order 1 and look like this"
        )
    elif smaller > 1 and not rivals:
        times = float(f"{smaller:.2g}")
        text += f"; an error of 1e-6 of the scale needs a step about {times:g} times smaller"
    return Finding(
        "step_size_error",
        text,
        evidence={
            "order": order.order,
            "method": order.method,
            "remaining": order.left,
            "remaining_of_other_orders": {str(p): x for p, x in order.others.items()},
            "max_rel_error": worst,
            "step_ratio": smaller,
        },
    )


def _error_in_scales(c: ColumnScore) -> float:
    return c.as_understood.measures.max_rel_error or 0.0


def _too_far() -> Finding:
    return Finding(
        TOO_FAR,
        "Half of the columns or more are off by half their own size, so that their error says "
        "nothing: look at the first rows, whether the columns are those of the benchmark, in its "
        "order and units, and at a run that is short",
    )


def _smooth() -> Finding:
    return Finding(
        "smooth_error",
        "The error is smooth, as the step size or tolerance of an integrator makes it, or another "
        f"model: its shape does not tell. Halve the step ({_BOTH_STEPS}), or divide the tolerance "
        f"by ten ({_BOTH_TOLERANCES}): the error of an integrator falls, by 2^p with a method of "
        "order p; that of another model stays the same curve; and noise of rounding or of "
        "iterations stays as large, but is another curve",
    )


def _rounding(worst: float) -> Finding:
    return Finding(
        "limited_by_rounding",
        f"The error is {worst:.1g} of the scale at the most: that is what rounding leaves of a run "
        "in binary64 arithmetic. If it does not fall with the tolerance or the step "
        f"({_BOTH_TOLERANCES}), it is the arithmetic, and not the model",
        evidence={"max_rel_error": worst},
    )


def _energy(report: Report, order: Order | None) -> Iterator[Finding]:
    """Energy that falls or grows steadily in every maneuver."""
    trends = [_trend(m) for m in report.maneuvers]
    numbers = [m.maneuver for m in report.maneuvers]
    everywhere = " in every maneuver" if len(numbers) > 1 else ""
    changes = {str(n): t for n, t in zip(numbers, trends, strict=True)}
    evidence = {"maneuvers": numbers, "relative_change": changes}
    if trends and all(t < 0 for t in trends):
        yield Finding(
            "numerical_damping",
            f"The mechanical energy falls steadily{everywhere}. Either the model loses it, by a "
            "damper, drag, or a contact that slips or yields, or numerical damping does: with a "
            f"smaller step or tolerance only the latter becomes less.{_less_damping(order)}",
            evidence=evidence,
        )
    if trends and all(t > 0 for t in trends):
        yield Finding(
            "energy_grows",
            f"The mechanical energy grows steadily{everywhere}, as with an explicit method of low "
            "order, or with a drive in the model: a smaller step helps against the former only",
            evidence=evidence,
        )


def _less_damping(order: Order | None) -> str:
    """What to do against damping; only implicit methods have a setting for it."""
    if order is not None and order.constrained:
        return " In generalised-alpha methods a spectral radius nearer to 1 damps less"
    return ""


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


def _rough(report: Report, order: Order | None) -> Iterator[Finding]:
    """What jumps from row to row: interpolation, iterations, noise, or steps of varying size."""
    between = [interpolation(m) for m in report.maneuvers]
    first = next((b for b in between if b is not None), None)
    if first is not None and 2 * between.count(first) > len(between):
        spacing = report.maneuvers[0].step or 0.0
        kind = "straight lines" if first.degree == 1 else "cubics"
        yield Finding(
            "interpolated_output",
            f"Every {first.rows} rows, {first.rows * spacing:.6g} s, the error is that of a step; "
            f"the rows between are interpolated by {kind}, which adds to it: write rows at the "
            "steps, or use an interpolation of the order of the method",
            evidence={"rows": first.rows, "first": first.first, "degree": first.degree},
        )
        return
    found = {(m.maneuver, c.key): roughness(c) for m in report.maneuvers for c in m.columns}
    jumping = {
        place: r
        for place, r in found.items()
        if r is not None and r.at_one < SMOOTH and r.part > _SEEN
    }
    evidence = {"columns": [f"{number}.{key}" for number, key in jumping]}
    numbers = [m.maneuver for m in report.maneuvers]
    noisy = [r for r in jumping.values() if r.part > _MOSTLY and _is_white(r)]
    in_rates = [n for n in numbers if _in_rates(n, jumping)]
    ringing = [n for n in numbers if _rings(n, jumping)]
    if len(noisy) > len(found) / 2:
        yield Finding(
            "rough_error",
            "The error jumps from row to row like noise, far above the digits written, which no "
            "step size makes: look for single-precision numbers on the way, random terms, or a "
            "loose tolerance of the iterations",
            evidence=evidence,
        )
    elif 2 * len(ringing) > len(numbers):
        yield Finding(
            "step_ringing",
            "The velocities alternate from row to row, as the trapezoidal rule leaves them where "
            "nothing damps the highest frequency: accelerations that are consistent at the start, "
            "or a little numerical damping",
            evidence={"maneuvers": ringing},
        )
    elif 2 * len(in_rates) > len(numbers):
        yield Finding(
            "iteration_noise",
            "The velocities jump from row to row, much more than the angles, as a loose tolerance "
            "of the Newton iterations in each step makes them, or impulses of a contact: tighten "
            "it until the energy's error is smooth (a smaller step does not help); if it stays "
            "rough, it is the contact or the friction, or, where the jumps are below 1e-8 of the "
            "scale, rounding divided by the step",
            evidence={"maneuvers": in_rates},
        )
    elif order is None and len(jumping) > len(found) / 2:
        yield Finding(
            "steps_of_varying_size",
            "The error is rough between steps of varying size, as an integrator with a tolerance "
            "and rows between its steps makes it; this says no order: divide the tolerance by "
            f"ten, and score both ({_BOTH_TOLERANCES})",
            evidence=evidence,
        )


def _is_white(r: Roughness) -> bool:
    return abs(r.at_one - _WHITE[0]) < _SCATTER and abs(r.at_two - _WHITE[1]) < 2 * _SCATTER


def _in_rates(number: int, jumping: Mapping[tuple[int, str], Roughness]) -> bool:
    """Whether both rates of a maneuver jump, much more than their angles."""
    for kind in ("roll", "steer"):
        angle, rate = (jumping.get((number, f"{kind}_{x}")) for x in ("angle", "rate"))
        if rate is None or rate.at_one >= 0 or rate.part < _NOISE:
            return False
        if angle is not None and rate.part < _IN_RATES * angle.part:
            return False
    return True


def _rings(number: int, jumping: Mapping[tuple[int, str], Roughness]) -> bool:
    """Whether the steer rate of a maneuver alternates from row to row."""
    rate = jumping.get((number, "steer_rate"))
    return rate is not None and -rate.at_one > _ALTERNATES and rate.at_two > _ALTERNATES


def _height(report: Report, reference: Reference) -> Iterator[Finding]:
    """Wheels that sink in or leave the floor."""
    heights = Heights(reference)
    sunken, drifts = [], []
    for m in report.maneuvers:
        found = heights.of(m)
        if found is None:
            return
        time, height, floor = found
        wrong = next(c for c in m.columns if c.key == "potential_energy").trace.error
        # A wrong weight or zero is there from the start; so is what is said of no start.
        starts = time[0] == 0.0 and abs(height[0]) <= _ABOVE_FLOOR * floor
        size = rms(height)
        seen = _OF_ERROR * max(map(_error_in_scales, m.columns))
        counts = size > max(
            _NOTICED, seen, _ABOVE_FLOOR * floor, _COUNTS * rms(wrong) / heights.weight
        )
        fifths = np.array_split(height, 5)
        clear = starts and counts
        sunken.append(_settled(fifths) if clear else 0.0)
        drifts.append(float(np.max(np.abs(height))) if clear and _grows(fifths) else 0.0)
    numbers = [m.maneuver for m in report.maneuvers]
    if sunken and max(sunken) < 0 and min(sunken) > (1 + _STEADY) * max(sunken):
        yield Finding(
            "wheels_sink_in",
            f"The bicycle stands {-float(np.mean(sunken)):.2g} m too low for its roll and steer, "
            "after it has settled, as contact by penalty springs makes it, or one that tolerates "
            "some depth: a stiffer contact, or a constraint instead",
            evidence={"maneuvers": numbers, "height": sunken},
        )
    elif drifts and 2 * sum(d > 0 for d in drifts) > len(drifts):
        yield Finding(
            "height_drifts",
            f"The centre of mass is up to {max(drifts):.2g} m from where wheels on the floor have "
            "it, by potential energy, roll and steer: the positions drift from their constraints, "
            "as where only velocities are constrained or the pitch is integrated; project the "
            "positions, stabilise them, or take a smaller step",
            evidence={"maneuvers": numbers, "height": drifts},
        )


def _settled(fifths: Sequence[Array]) -> float:
    """Where the height settles below the floor, 0 if it does not."""
    later = np.concatenate(fifths[1:])
    mean = float(np.mean(later))
    return mean if mean < 0 and np.std(later) < _STEADY * -mean else 0.0


def _grows(fifths: Sequence[Array]) -> bool:
    """Whether the height moves one way from the floor: neither to and fro nor all at once."""
    first, *later = (rms(x) for x in fifths)
    means = np.array([np.mean(x) for x in fifths])
    one_way = bool(np.all(means[1:] * means[-1] > 0))
    return one_way and max(later) > _GROWN * first and abs(np.sum(means)) > _ONE_WAY * sum(later)
