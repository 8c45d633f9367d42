"""A diagnosis in words: ranked findings, each with its evidence, and "cannot tell" where so."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import floor, log10
from typing import Any

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.display import shown_by
from heyoka_bike.reference.structure import UNKNOWNS
from heyoka_bike.scoring.diagnosis import UNITS_BESIDE, numerical, plain
from heyoka_bike.scoring.diagnosis.claims import left_over
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS, Hypothesis
from heyoka_bike.scoring.diagnosis.explain import Diagnosis
from heyoka_bike.scoring.diagnosis.mistakes.linearised import CODE as LINEARISED
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES
from heyoka_bike.scoring.diagnosis.programs.program import Found, Mistake
from heyoka_bike.scoring.diagnosis.residual.methods import CLOCK
from heyoka_bike.scoring.diagnosis.residual.observed import STATE
from heyoka_bike.scoring.diagnosis.residual.residual import Residual
from heyoka_bike.scoring.evidence import (
    AnotherStart,
    ColumnOfAnotherManeuver,
    Departs,
    Evidence,
    FallsOver,
    RowsBetween,
    RowsRepeated,
    SmoothError,
)
from heyoka_bike.scoring.explanation import Explanation
from heyoka_bike.scoring.findings import Finding, info, warning
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

NOTHING_WRONG = "nothing_to_explain"
"""Code of the finding that all that is diagnosed is right."""

# A correct file's error is its floor; sums and conversions make it a few times that.
_FLOORS_OF_ROUNDING = 4.0
# What is seen at once and is the whole cause.
_EXPLAIN = (RowsRepeated, RowsBetween, ColumnOfAnotherManeuver, Departs)
# In which columns a start is written, and the part of a change by which a first row may miss what
# is given and still have it.
_COLUMN_OF_START = {f"initial_{name}": key for name, key in zip(START, STATE, strict=True)}
_AS_GIVEN = 0.1
_UNIT_OF_VALUE = {**UNKNOWNS, **{name: force.unit for name, force in FORCES.items()}}
# Of a value, in parts of it.
_LEAST_UNCERTAINTY_SHOWN = 1e-6
# What remains below this part of a column's size is not worth a word: six digits are right.
_REST_WORTH_A_WORD = 1e-6
# Of the bicycle [m]: a wheel's radius.
_LENGTH = 0.3
# A part of a term that is all of it.
_WHOLE = 0.02
_COUNTS = {1: "One parameter explains", 2: "Two parameters explain", 3: "Three parameters explain"}
_OF_FORCES = (
    "The benchmark has no force but gravity, and all terms of the equations of motion: check what "
    "your program applies beside gravity, by default or in its joints"
)
_OF_STARTS = (
    ". Where rolling does not allow a start, the nearest velocities in kinetic energy are taken, "
    "as an impulse of the constraint forces leaves them"
)


def findings(diagnosis: Diagnosis, report: Report) -> tuple[Finding, ...]:
    """Say what explains the file, or what its error looks like if nothing does."""
    columns = [(m, c) for places in report.by_column().values() for m, c in places]
    if 2 * sum(not c.trace.value.any() for _, c in columns) > len(columns):
        return (warning("cannot_tell", "Most columns hold nothing but zeros"),)
    units = _units_beside(diagnosis.units)
    if diagnosis.classes and diagnosis.classes[0][0].codes == (LINEARISED,):
        return (_linearised(diagnosis.classes[0][0]), *units)
    seen = plain.shown(report)
    first = _said_of(seen)
    falls = _said_of(x for x in seen if isinstance(x, FallsOver))
    departs = {x.maneuver for x in seen if isinstance(x, Departs)}
    if departs and departs >= {
        m.maneuver for m, c in columns if not c.is_at_floor(_FLOORS_OF_ROUNDING)
    }:
        # What is wrong in the model or at the start is wrong from the start.
        return first
    if diagnosis.classes:
        # A start that is named as a mistake is not named again, and a fall follows from its cause.
        named = _said_of(x for x in seen if not isinstance(x, FallsOver | AnotherStart))
        said = (
            _cause(rank, hypotheses, report, diagnosis.causes)
            for rank, hypotheses in enumerate(diagnosis.classes[: WEIGHTS.most_said], 1)
        )
        return (*named, *said, *units, *falls)
    if any(isinstance(x, _EXPLAIN) for x in seen):
        return first
    if not diagnosis.is_whole:
        # What follows is concluded from that nothing else explains the file.
        until_then = [*_until_then(diagnosis.likeliest)] or [*_direction(diagnosis.causes)]
        return (*first, *until_then)
    times = plain.other_times(report)
    if times is not None:
        return _said_of((times,))
    # Nothing about the motion where it is right.
    apart = plain.columns_apart(report)
    whole = _method(diagnosis.causes) if apart is None else _said_of((apart,))[0]
    nothing = _no_mistake(diagnosis, columns)
    if whole is not None:
        return *first, whole, nothing
    forces = [*_direction(diagnosis.causes), *_unexplained(diagnosis.causes)]
    if falls:
        return *forces, *first
    causes = numerical.causes(report)
    shape = _said_of(e for e in causes if not (forces and isinstance(e, SmoothError)))
    return *forces, *first, nothing, *shape


def _said_of(seen: Iterable[Evidence]) -> tuple[Finding, ...]:
    """What is said of evidence."""
    return tuple(map(shown_by("sayings").finding, seen))


def is_right(report: Report) -> bool:
    """True if every column is as right as its digits can tell."""
    return all(
        c.is_at_floor(_FLOORS_OF_ROUNDING) for m in report.maneuvers for c in m.columns if c.values
    )


def _units_beside(units: Mapping[str, str]) -> list[Finding]:
    """Say that beside the motion that explains the file its units are others than were scored."""
    if not units:
        return []
    said = " and ".join(shown_by("sayings").in_units(units))
    message = (
        f"By that motion the file has {said}: the score, which knows the right motion only, "
        "took other units, and its errors are too large. A unit in a heading, or in --columns "
        "(roll_angle_deg), decides it"
    )
    return [info(UNITS_BESIDE, message, units=dict(units))]


def nothing_wrong(which: str) -> Finding:
    """Columns that are right."""
    return info(NOTHING_WRONG, f"{which} is as right as the digits written can tell")


def explanation(diagnosis: Diagnosis, found: Sequence[Finding]) -> Explanation | None:
    """The first of the findings, with its curves."""
    if not diagnosis.curves or found[0].code not in ("mistake", "parameters", LINEARISED):
        return None
    return Explanation(found[0].message, diagnosis.curves)


def _until_then(h: Hypothesis | None) -> Iterator[Finding]:
    """Name what was the likeliest when the search was stopped, as such and no more."""
    if h is not None:
        text = (
            f"The likeliest cause until then: {_said(h.mistakes)}. Simulated with this, the error "
            f"falls by a factor of {h.relief:.1g}"
        )
        yield info("likeliest_until_then", text, mistakes=list(h.codes), **_evidence(h))


def _linearised(found: Hypothesis) -> Finding:
    """The equations are linear: no mistake."""
    unknown = list(dict.fromkeys(key for n, key in found.floors if (n, key) not in found.after))
    # Energies of linear motions, if they are written at all, tell less of the integrator.
    lateral = {k: x for k, x in found.after.items() if k[1] in LATERAL} or found.after
    (number, worst), left = max(lateral.items(), key=lambda x: x[1])
    rest = "Nothing else is wrong"
    if left > _REST_WORTH_A_WORD:
        rest = (
            f"An error remains, typically {100 * left:.2g} % of the size of {worst} of maneuver "
            f"{number} and less in roll and steer elsewhere; it can be the integrator's: try a "
            "smaller step or tolerance"
        )
    if unknown:
        rest += (
            f". Not compared: {', '.join(unknown)}, as programs of linear equations compute "
            "energies in several ways"
        )
    return info(
        LINEARISED,
        "These are motions of the linearised equations, at constant speed: compared with those, "
        f"the typical error is smaller by a factor of {found.relief:.2g}. The benchmark asks for "
        f"the nonlinear equations. {rest}",
        **_evidence(found),
    )


def _method(causes: Residual | None) -> Finding | None:
    """The integrator that makes the error."""
    methods = [m for m in causes.methods if m.says != CLOCK] if causes else []
    if not methods:
        return None
    names = " or ".join(f"{m.says} with a step of {m.step:.3g} s" for m in methods)
    relief = methods[0].relief
    text = f"Of the methods known here the first error term of {names} is the nearest"
    if relief > WEIGHTS.explains:
        text = f"To its first term the error is that of {names}; other methods can share this term"
    return info(
        "integrator",
        f"{text}. What the file leaves of the exact equations, in the rates of the angles and in "
        f"the accelerations, falls by a factor of {relief:.2g} with it. Take a smaller step, or a "
        "method of higher order",
        methods=[{"method": m.says, "step": m.step} for m in methods],
        relief=relief,
    )


def _direction(causes: Residual | None) -> Iterator[Finding]:
    """Name the cause that explains nearly all of the residual, but not the whole run."""
    best = causes.best if causes else None
    if best is not None:
        more = (
            ". This is its first order; what is left can be the next one"
            if _is_of_next_order(best)
            else ""
        )
        yield info(
            "direction",
            f"Nearly explained by this: {_said(best.mistakes)}. What disagrees with the exact "
            f"equations falls by a factor of {best.relief:.2g} with it{more}",
            mistakes=list(best.codes),
            relief=best.relief,
        )


def _unexplained(causes: Residual | None) -> Iterator[Finding]:
    """Say that there is a force or a term which nothing explains, alone or beside the best."""
    if causes is None or not causes.is_open or causes.is_blown_up:
        return
    best = causes.best
    if best is not None and _is_of_next_order(best):
        return
    what = (
        "A force or a term is missing, or one too many, or constraints drift, slip or yield, and "
        "it is none of the causes known here"
        if best is None
        else "What is left has another cause, a force or a term that is none of those known here"
    )
    shares = causes.shares
    yield warning(
        "term_unexplained",
        f"{what}. The file's own roll acceleration is off from the exact equations by "
        f"{_part(shares['roll'])}, its steer acceleration by {_part(shares['steer'])}. An "
        f"integrator would leave {causes.above:.2g} times less, by the slopes of the angles. "
        f"As a generalised force it acts most in the equation of {causes.acts_in}: look there "
        "first, and at what acts beside gravity",
        shares=shares,
        acts_in=causes.acts_in,
        above=causes.above,
    )


def _is_of_next_order(best: Hypothesis) -> bool:
    """True if what is left can be the next order of a force whose law is the first order only.

    That is smaller by the coefficient in parts of a length of the bicycle, a wheel's radius.
    """
    orders = [
        abs(x.value) / _LENGTH
        for x in best.found
        if x.name in FORCES and FORCES[x.name].is_first_order
    ]
    return bool(orders) and 1.0 / best.relief < max(orders)


def _said(mistakes: Sequence[Mistake]) -> str:
    return ", and ".join(_changed(m.found) if m.found else m.says for m in mistakes)


def _part(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 2.0 else f"{share:.2g} times its size"


def _of_scale(error: float) -> str:
    return f"{100 * error:.2g} % of its scale" if error < 2.0 else f"{error:.2g} times its scale"


def _cause(
    rank: int, hypotheses: Sequence[Hypothesis], report: Report, causes: Residual | None
) -> Finding:
    """Mistakes, or the fewest parameters, forces or starts, that explain the file."""
    first, *others = hypotheses
    said = _said(first.mistakes)
    if first.found:
        said = f"{_COUNTS.get(len(first.found), 'These explain')} it: {said}"
    rest = left_over(first)
    begins = ("" if rank == 1 else "or, less likely: ") + ("" if rest is None else "looks like: ")
    text = f"{begins}{said}"
    text = f"{text[0].upper()}{text[1:]}. {_evidence_of(first, causes)}"
    if rest is not None:
        number, key = rest
        text += (
            f". Something else is there: {key} of maneuver {number} is still off, typically by "
            f"{_of_scale(first.after[rest])}"
        )
    text = f"{text}. {_advice(first, report)}"
    if others:
        same = "; or ".join(_said(h.mistakes) for h in others[: WEIGHTS.most_said])
        text += f". The file cannot tell this from {same}"
    made = warning if rank == 1 else info
    if first.found:
        changes = [[_as_evidence(x) for x in h.found] for h in hypotheses if h.found]
        numbers = {"rank": rank, "gain": first.gain, "relief": first.relief}
        return made("parameters", text, **numbers, changes=changes, is_all=rest is None)
    codes, *alike = [list(h.codes) for h in hypotheses]
    return made(
        "mistake",
        text,
        rank=rank,
        mistakes=codes,
        **_evidence(first),
        indistinguishable=alike,
        is_all=rest is None,
    )


def _evidence_of(h: Hypothesis, causes: Residual | None) -> str:
    """Say how much is explained, by whole runs and in which equation."""
    said = f"Simulated with this, the error falls by a factor of {h.relief:.1g}"
    if causes is None or all(m.kind != "model" for m in h.mistakes):
        return said
    relief = causes.relief(h.mistakes)
    where = max(causes.shares, key=causes.shares.__getitem__)
    if relief > WEIGHTS.explains:
        said += (
            f". The file's own {where} acceleration is off from the exact equations by "
            f"{_part(causes.shares[where])}; with this, {relief:.1g} times less"
        )
    return said


def _advice(h: Hypothesis, report: Report) -> str:
    """Say what to look at."""
    if any(x.name in FORCES for x in h.found):
        return _OF_FORCES
    if as_given := [key for x in h.found if (key := _written_as_given(x, report))]:
        return (
            f"But the first row has {' and '.join(as_given)} as given: the motion is another "
            "from the second row on, so look at the first step, not at the input"
        )
    text = "Check " + ", and ".join(dict.fromkeys(m.check for m in h.mistakes))
    is_of_start = not h.found and any(m.kind == "start" for m in h.mistakes)
    return text + (_OF_STARTS if is_of_start else "")


def _written_as_given(x: Found, report: Report) -> str:
    """Name the column whose first row has the start that is given, not the one that is fitted."""
    key = _COLUMN_OF_START.get(x.name, "")
    for m, c in report.by_column().get(key, ()):
        is_small = abs(float(c.trace.error[0])) < _AS_GIVEN * abs(x.value - x.right)
        if m.maneuver == x.maneuver and c.trace.time[0] == 0.0 and is_small:
            return f"{key} of maneuver {x.maneuver}"
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


def _no_mistake(
    diagnosis: Diagnosis, columns: Sequence[tuple[ManeuverScore, ColumnScore]]
) -> Finding:
    worst, where = max(
        (c.as_understood.measures.max_rel_error or 0.0, f"{c.key} of maneuver {m.maneuver}")
        for m, c in columns
    )
    text = (
        f"No usual mistake explains the difference, alone or with another: {diagnosis.tried} such "
        f"programs were tried. The largest error is {worst:.2g} of the scale, {where}"
    )
    seen = diagnosis.causes
    if seen is not None and seen.is_shown and seen.is_met:
        text += ". The equations of motion show no changed parameter, force or initial condition"
    return info("no_mistake_found", text, tried=diagnosis.tried, max_rel_error=worst)
