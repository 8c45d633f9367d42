"""The sentences about what a diagnosis found.

Other evidence makes its own sentences, see `scoring.evidence`.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import singledispatch
from math import floor, log10
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.reference.structure import UNKNOWNS
from heyoka_bike.scoring.diagnosis import found as seen
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS, Place
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES
from heyoka_bike.scoring.diagnosis.programs.program import Cause, Found
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import in_units
from heyoka_bike.scoring.findings import Finding, Severity, info, named, warning
from heyoka_bike.scoring.grades import TOLERANCE

_UNIT_OF_VALUE = {**UNKNOWNS, **{name: force.unit for name, force in FORCES.items()}}
# Of a value, in parts of it.
_LEAST_UNCERTAINTY_SHOWN = 1e-6
# What remains below this part of a column's size is not worth a word: six digits are right.
_REST_WORTH_A_WORD = 1e-6
# Of the range of a variable, where values of a law are said.
_PARTS_OF_RANGE = (1 / 64, 1 / 8, 1.0)
# A part of a term that is all of it.
_WHOLE = 0.02
_COUNTS = {1: "one parameter explains", 2: "two parameters explain", 3: "three parameters explain"}
_INERTIA = re.compile(r"I([BH])(xx|yy|zz|xz)")
_BODIES = {"B": "rear frame", "H": "fork"}
_OF_FORCES = (
    "The benchmark has no force but gravity, and all terms of the equations of motion: check what "
    "your program applies beside gravity, by default or in its joints"
)
_OF_STARTS = (
    ". Where rolling does not allow a start, the nearest velocities in kinetic energy are taken, "
    "as an impulse of the constraint forces leaves them"
)


@singledispatch
def finding(evidence: Evidence) -> Finding:
    """Return the code, the sentence and the numbers of evidence, also of what a diagnosis found."""
    return evidence.finding()


def findings(evidence: Iterable[Evidence]) -> tuple[Finding, ...]:
    """Return the findings of all evidence, in the same order."""
    return tuple(map(finding, evidence))


register = finding.register


@register
def _(e: seen.Explained) -> Finding:
    first, *others = e.hypotheses
    said = _said(first.mistakes)
    if first.found and e.rest is None:
        said = f"{_COUNTS.get(len(first.found), 'these explain')} it: {said}"
    said += _of_parts(first.found)
    begins = ("" if e.rank == 1 else "or, less likely: ") + (
        "" if e.rest is None else "looks like: "
    )
    text = f"{begins}{said}"
    text = f"{text[0].upper()}{text[1:]}. {_proof(e)}"
    if e.rest is not None:
        text += f". {_something_else(first, e.rest)}"
    if e.rivals:
        near = "; or ".join(_said(h.mistakes) for h in e.rivals)
        text += f". Nearly as much is explained by: {near}"
    text = f"{text}. {_advice(e)}"
    if others:
        same = "; or ".join(_said(h.mistakes) for h in others[: THRESHOLDS.max_answers])
        text += f". The file cannot tell this from {same}"
    if first.found:
        changes = [[_as_evidence(x) for x in h.found] for h in e.hypotheses if h.found]
        found = warning(
            "parameters",
            text,
            rank=e.rank,
            gain=first.gain,
            relief=first.relief,
            changes=changes,
            is_all=e.rest is None,
        )
    else:
        codes, *alike = [list(h.codes) for h in e.hypotheses]
        found = warning(
            "mistake",
            text,
            rank=e.rank,
            mistakes=codes,
            **_evidence(first),
            indistinguishable=alike,
            is_all=e.rest is None,
        )
    return found if e.rank == 1 else replace(found, severity=Severity.INFO)


@register
def _(e: seen.LinearMotion) -> Finding:
    number, worst = e.rest
    rest = "Nothing else is wrong"
    if e.left > _REST_WORTH_A_WORD:
        rest = (
            f"An error remains, typically {100 * e.left:.2g} % of the size of {worst} of maneuver "
            f"{number} and less in roll and steer elsewhere; it can be the integrator's: try a "
            "smaller step or tolerance"
        )
    if e.unknown:
        rest += (
            f". Not compared: {', '.join(e.unknown)}, as programs of linear equations compute "
            "energies in several ways"
        )
    said = (
        "These are motions of the linearised equations, at constant speed: compared with those, "
        f"the typical error is smaller by a factor of {e.hypothesis.relief:.2g}. The benchmark "
        f"asks for the nonlinear equations. {rest}"
    )
    return info("linearised", said, **_evidence(e.hypothesis))


@register
def _(e: seen.LikeliestUntilThen) -> Finding:
    h = e.hypothesis
    said = (
        f"The likeliest cause until then: {_said(h.mistakes)}. Simulated with this, the error "
        f"falls by a factor of {h.relief:.1g}"
    )
    return info("likeliest_until_then", said, mistakes=list(h.codes), **_evidence(h))


@register
def _(e: seen.Integrator) -> Finding:
    names = " or ".join(f"{m.says} with a step of {m.step:.3g} s" for m in e.methods)
    first = e.methods[0]
    said = (
        f"The error is that of a method of order {first.order}, as of {names}: what the "
        f"file leaves of the exact equations falls by a factor of {first.relief:.2g}. "
    )
    if not first.is_of_rows:
        said += "Rows are no whole number of such steps apart, so it is another method. "
    said += "Take a smaller step, or a method of higher order"
    if not e.is_explained:
        said = (
            f"Of the known methods {names} is the nearest, but explains a factor of "
            f"{first.relief:.2g} only. If a smaller step leaves the error as it is, it is another "
            "cause"
        )
    methods = [{"method": m.says, "step": m.step} for m in e.methods]
    return info("integrator", said, methods=methods, relief=first.relief)


@register
def _(e: seen.IntegratedBy) -> Finding:
    names = " or ".join(m.says for m in e.methods)
    h = e.hypothesis
    said = "The error is " if e.is_sure else "The nearest of the methods known here is "
    said += f"that of {names}" if e.is_sure else names
    said += f". Run here, it lets the error fall by a factor of {h.relief:.1g}. "
    if e.is_sure:
        said += "Nothing else is seen. " if e.rest is None else f"{_something_else(h, e.rest)}. "
        said += "Take a smaller step, or a method of higher order"
    else:
        said += (
            "In other coordinates it leaves another error. If a smaller step leaves the error as "
            "it is, it is another cause"
        )
    methods = [{"method": m.method, "step": m.step} for m in e.methods]
    return info("integrator", said, methods=methods, relief=h.relief)


@register
def _(e: seen.Direction) -> Finding:
    h = e.hypothesis
    said = (
        f"What is wrong acts nearly like this: {_said(h.mistakes)}. What disagrees with the exact "
        f"equations falls by a factor of {h.relief:.2g} with it"
    )
    return info("direction", said, mistakes=list(h.codes), relief=h.relief)


@register
def _(e: seen.ForceUnexplained) -> Finding:
    shares = e.left.shares
    what = (
        "What is left is more than an integrator's error: a higher order of this, or another cause"
        if e.is_beside
        else "A force or a term is missing or too many, or constraints drift, slip or yield; it is "
        "no cause that is known here"
    )
    said = (
        f"{what}. It acts most in the equation of {e.left.acts_in}: look there first. "
        f"Accelerations are off by {_part(shares['roll'])} (roll), {_part(shares['steer'])} (steer)"
    )
    if e.is_end:
        said += ". Two mistakes at once were not tried: --thorough, in Python thorough=True, does"
    return warning("term_unexplained", said, **_numbers_left(e.left))


@register
def _(e: seen.LeftOfEquations) -> Finding:
    off = ", ".join(f"{name} by {_part(share)}" for name, share in e.shares.items())
    said = (
        f"What the file leaves of the exact equations acts most in the equation of {e.acts_in}; "
        f"accelerations are off: {off}. "
    )
    said += (
        "An integrator leaves as much, a term of the model more"
        if e.may_be_explicit
        else f"That is {e.above:.2g} times what integrators leave in the rates, some 150 times"
    )
    return info("left_of_equations", said, **_numbers_left(e))


def _numbers_left(e: seen.LeftOfEquations) -> dict[str, object]:
    return {"shares": dict(e.shares), "acts_in": e.acts_in, "above": e.above}


@register
def _(e: seen.TorqueLaw) -> Finding:
    law = e.law
    of = dict(zip(law.places, law.values, strict=True))
    largest = max(of)
    unit = "rad/s" if law.variable.endswith("rate") else "rad"
    some = sorted({min(of, key=lambda x: abs(x - part * largest)) for part in _PARTS_OF_RANGE})
    where = "on the steer axis" if law.equation == "steer" else "that leans the bicycle"
    values = ", ".join(f"{of[x]:.3g} N m at {x:.2g} {unit}" for x in some)
    said = (
        f"A torque {where} is there, or missing, that depends on the {law.variable} alone: as an "
        f"odd function of it by its values, such as {values}, what disagrees with the exact "
        f"equations falls by a factor of {law.relief:.2g} in the half of the run in which these "
        "were not looked for"
    )
    if law.variable == f"{law.equation} rate" and all(of[x] < 0.0 for x in some):
        said += (
            ". It brakes: a friction. Look at what your program applies at this joint by default"
        )
    return warning(
        "torque_law",
        said,
        equation=law.equation,
        variable=law.variable,
        places=list(law.places),
        values=list(law.values),
        relief=law.relief,
    )


@register
def _(e: seen.NoCauseFound) -> Finding:
    said = (
        f"No usual mistake explains the difference: {e.tried} programs were tried. The largest "
        f"error is {e.max_rel_error:.2g} of the scale, {e.key} of maneuver {e.maneuver}"
    )
    if e.are_equations_met:
        said += ". The equations of motion are met"
    if e.closest:
        first = e.closest[0]
        said += (
            f". The closest is: {_said(first.mistakes)}. It explains a factor of "
            f"{first.relief:.2g} of what disagrees with the equations, and not all"
        )
    closest = [list(h.codes) for h in e.closest]
    numbers = {"tried": e.tried, "max_rel_error": e.max_rel_error, "closest": closest}
    return info("no_mistake_found", said, **numbers)


@register
def _(e: seen.UnitsBeside) -> Finding:
    units = " and ".join(in_units(e.units))
    said = (
        f"By that motion the file has {units}: the score, which knows the right motion only, took "
        "other units, and its errors are too large. A unit in a heading, or in --columns "
        "(roll_angle_deg), decides it"
    )
    return info("units_beside", said, units=dict(e.units))


@register
def _(e: seen.NothingWrong) -> Finding:
    which = f"{named(e.keys)}: each" if e.keys else "every column"
    if e.signs is None:
        said = f"{which} is as right as the digits written can tell"
        return info("nothing_to_explain", said)
    odd = finding(e.signs)
    said = f"{which} is right by itself, but {odd.message}"
    return Finding(odd.code, said, odd.severity, odd.evidence)


@register
def _(_: seen.MostlyZeros) -> Finding:
    return warning("cannot_tell", "Most columns hold nothing but zeros")


@register
def _(_: seen.NothingToDiagnose) -> Finding:
    said = (
        "the diagnosis looks at the benchmark's columns, and none of them has a value: "
        f"{', '.join(BENCHMARK_COLUMNS)}"
    )
    return warning("nothing_to_diagnose", said)


def _said(mistakes: Sequence[Cause]) -> str:
    return ", and ".join(_changed(m.found) if m.found else m.says for m in mistakes)


def _something_else(h: Hypothesis, rest: Place) -> str:
    number, key = rest
    return (
        f"Something else is there: {key} of maneuver {number} is still off, typically by "
        f"{_of_scale(h.after[rest])}"
    )


def _part(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 2.0 else f"{share:.2g} times its size"


def _of_scale(error: float) -> str:
    return f"{100 * error:.2g} % of its scale" if error < 2.0 else f"{error:.2g} times its scale"


def _proof(e: seen.Explained) -> str:
    """Say how much is explained, by whole runs and in which equation."""
    said = f"Simulated with this, the error falls by a factor of {e.hypotheses[0].relief:.1g}"
    if e.acceleration is not None:
        where, share, relief = e.acceleration
        said += (
            f". The file's own {where} acceleration is off from the exact equations by "
            f"{_part(share)}; with this, {relief:.1g} times less"
        )
    if e.rest is None and e.left:
        # An integrator's error is seldom seen in a plot.
        other = ", or another cause" if e.left > TOLERANCE else ""
        said += (
            f". What is left, typically {_of_scale(e.left)}, is the integrator's error, or what "
            f"this does not describe exactly{other}"
        )
    return said


def _advice(e: seen.Explained) -> str:
    """Say what to look at."""
    first = e.hypotheses[0]
    if any(x.name in FORCES for x in first.found):
        return _OF_FORCES
    if e.as_given:
        return (
            f"But the first row has {' and '.join(e.as_given)} as given: the motion is another "
            "from the second row on, so look at the first step, not at the input"
        )
    text = "Check " + ", and ".join(dict.fromkeys(m.check for m in first.mistakes))
    is_of_start = not first.found and any(m.kind == "start" for m in first.mistakes)
    return text + (_OF_STARTS if is_of_start else "")


def _of_parts(found: Sequence[Found]) -> str:
    """Describe the pattern in several wrong inertias of one body; empty if there is none."""
    told = {m[2]: x for x in found if (m := _INERTIA.fullmatch(x.name))}
    if len(told) < len(found) or not {"xx", "zz"} <= told.keys():
        return ""
    bodies = {x.name[1] for x in found}
    if len(bodies) > 1:
        return ""
    body = _BODIES[bodies.pop()]
    xx, zz = told["xx"], told["zz"]
    right = xx.right + zz.right
    if abs(xx.value + zz.value - right) < TOLERANCE * right:
        return f". The sum of both is right: the inertia of the {body}, or of a part, is turned"
    if all(x.value < x.right for axes, x in told.items() if axes != "xz"):
        return (
            f". All are too small, as if the inertias of the {body}'s parts were added without "
            "moving them to the common centre"
        )
    return ""


def _changed(found: Sequence[Found]) -> str:
    return ", and ".join(
        _as_part(x) if x.name in FORCES and FORCES[x.name].is_part else _as_value(x) for x in found
    )


def _as_part(x: Found) -> str:
    says = FORCES[x.name].says
    is_all_of_it = abs(x.value - 1.0) < _WHOLE
    times = "is missing" if is_all_of_it else f"is {1.0 - x.value:.4g} times what it should be"
    return f"the {says} {times}"


def _as_value(x: Found) -> str:
    # So many digits as the uncertainty allows, no more than anybody reads.
    size = max(abs(x.value), abs(x.right), abs(x.value - x.right))
    least = max(x.uncertain, _LEAST_UNCERTAINTY_SHOWN * size)
    decimals = max(1, -floor(log10(least))) if least else 1
    after = f"{round(x.value, decimals) + 0.0:.{decimals}f}".rstrip("0").rstrip(".")
    # What changes next to nothing of what is left is not known at all; a rounding is not said.
    is_known = _LEAST_UNCERTAINTY_SHOWN * size < x.uncertain < abs(x.right) + abs(x.value - x.right)
    within = f" (+- {x.uncertain:.1g})" if is_known else ""
    right = f"{round(x.right, 12) + 0.0:.10g}"
    return f"{_named(x)} is {after} {_UNIT_OF_VALUE[x.name]}{within} instead of {right}"


def _named(x: Found) -> str:
    if x.name in FORCES:
        return f"the {FORCES[x.name].says}"
    if x.maneuver is None:
        return f"the {PARAMETERS[x.name].description} ({x.name})"
    return f"the {x.name.replace('_', ' ')} of maneuver {x.maneuver}"


def _as_evidence(x: Found) -> dict[str, Any]:
    return {
        "unknown": x.name,
        "maneuver": x.maneuver,
        "value": x.value,
        "uncertain": x.uncertain,
        "instead_of": x.right,
        "unit": _UNIT_OF_VALUE[x.name],
    }


def _evidence(h: Hypothesis) -> dict[str, Any]:
    """The errors that a hypothesis leaves, and those before."""
    before, after = (
        {f"{maneuver}.{key}": x for (maneuver, key), x in typical.items()}
        for typical in (h.before, h.after)
    )
    return {"gain": h.gain, "relief": h.relief, "before": before, "after": after}
