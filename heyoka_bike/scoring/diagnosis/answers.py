"""A diagnosis in words: ranked findings, each with its evidence, and "cannot tell" where so."""

from collections.abc import Iterator, Mapping, Sequence
from math import floor, log10
from typing import Any

from heyoka_bike.bicycle.columns import LATERAL
from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.errors import GENERATE
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.reference.sensitivities import UNKNOWNS
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.diagnosis import plain
from heyoka_bike.scoring.diagnosis.mistakes.linearised import CODE as LINEARISED
from heyoka_bike.scoring.diagnosis.numerical import causes as numerical
from heyoka_bike.scoring.diagnosis.programs.applied import FORCES
from heyoka_bike.scoring.diagnosis.ranking import Diagnosis, Hypothesis
from heyoka_bike.scoring.diagnosis.unknowns.estimation import Fit, Unknown
from heyoka_bike.scoring.findings import Finding, Severity
from heyoka_bike.scoring.judge.conventions import UNITS_BESIDE, in_units
from heyoka_bike.scoring.report import Explanation, ManeuverScore, Report

NOTHING_WRONG = "nothing_to_explain"
"""Code of the finding that all that is diagnosed is right."""

# Classes of hypotheses worth a sentence.
_MOST = 3
# A correct file's error is its floor; sums and conversions make it a few times that.
_AT_FLOOR = 4.0
# All parameters and starts together explain up to a factor of 80 of an integrator's error.
_ALL = 300.0
# Methods that all but conserve energy are wrong by up to 2000 times what they change of it.
_KEPT = 1e5
# What is seen at once and is the whole cause.
_EXPLAIN = ("falls_over", "rows_repeated", "column_of_another_maneuver")
# In which columns a start is written, and the part of a change by which a first row may miss what
# is given and still have it.
_STARTS = {"initial_roll": "roll_angle", "initial_steer": "steer_angle",
           "initial_roll_rate": "roll_rate", "initial_steer_rate": "steer_rate",
           "initial_speed": "forward_speed"}  # fmt: skip
_AS_GIVEN = 0.1
_UNITS = {**UNKNOWNS, **{name: force.unit for name, force in FORCES.items()}}
_OF_ANY_INTEGRATOR = ("smooth_error", "steps_of_varying_size")
_MOST_DECIMALS = 12
# What remains below this part of a column's size is not worth a word: six digits are right.
_SEEN = 1e-6
_COUNTS = {1: "One parameter explains", 2: "Two parameters explain", 3: "Three parameters explain"}


def findings(
    diagnosis: Diagnosis, report: Report, reference: Reference | None = None
) -> tuple[Finding, ...]:
    """What explains the file, or what its error looks like if nothing does.

    The reference is that of the report, by default the published one.
    """
    columns = [(m, c) for m in report.maneuvers for c in m.columns if c.values]
    if all(c.is_at_floor(_AT_FLOOR) for _, c in columns):
        return (nothing_wrong("every column"),)
    if 2 * sum(not c.trace.value.any() for _, c in columns) > len(columns):
        return (Finding("cannot_tell", "Most columns hold nothing but zeros", Severity.WARNING),)
    if diagnosis.classes and diagnosis.classes[0][0].codes == (LINEARISED,):
        return (_linearised(diagnosis.classes[0][0]), *_units_beside(diagnosis))
    fits = diagnosis.estimate.fits if diagnosis.estimate else ()
    found = [_fitted(diagnosis, report)] if fits and not diagnosis.unexplained else []
    found += [
        _explained(rank, hypotheses)
        for rank, hypotheses in enumerate(diagnosis.classes[: _MOST - len(found)], len(found) + 1)
    ]
    found += _units_beside(diagnosis) if found else []
    known = reference or load_reference()
    first = list(plain.shown(report, known))
    if found:
        # A start that is named as a mistake is not named again.
        first = [f for f in first if f.code != "another_start"]
    else:
        found += _without_cause(diagnosis, report, known, columns, first)
    if diagnosis.untried:
        found.append(_without_heyoka(diagnosis))
    return (*first, *found)


def _units_beside(diagnosis: Diagnosis) -> list[Finding]:
    """That beside the motion that explains the file its units are others than were scored."""
    if not diagnosis.units:
        return []
    said = " and ".join(in_units(diagnosis.units))
    return [
        Finding(
            UNITS_BESIDE,
            f"By that motion the file has {said}: the score, which knows the right "
            "motion only, took other units, and its errors are too large. A unit in a heading, or "
            "in --columns (roll_angle_deg), decides it",
            evidence={"units": dict(diagnosis.units)},
        )
    ]


def nothing_wrong(which: str) -> Finding:
    """Columns that are right."""
    return Finding(NOTHING_WRONG, f"{which} is as right as the digits written can tell")


def _without_cause(
    diagnosis: Diagnosis, report: Report, reference: Reference,
    columns: Sequence[tuple[ManeuverScore, ColumnScore]], shown: Sequence[Finding],
) -> list[Finding]:  # fmt: skip
    """What is left to say where neither a mistake nor a parameter explains the file."""
    if any(f.code in _EXPLAIN for f in shown):
        return []
    found = [_no_mistake(diagnosis, columns)]
    apart = plain.columns_apart(report)
    if apart is not None:
        # Nothing about the motion, which is right.
        return [apart, *found]
    shape = numerical.findings(report, reference)
    if not any(f.code == numerical.TOO_FAR for f in shape):
        # What has hardly anything of the motion left has no direction either.
        found += _towards(diagnosis)
    wrong_model = _not_the_integrator(diagnosis, columns)
    if any(f.code == "interpolated_output" for f in shape):
        wrong_model = []
    # Then neither a tolerance nor a smooth error says anything more.
    found += [f for f in shape if not (wrong_model and f.code in _OF_ANY_INTEGRATOR)]
    return found + wrong_model


def explanation(diagnosis: Diagnosis, found: Sequence[Finding]) -> Explanation | None:
    """The first of the findings, with its curves."""
    if not diagnosis.curves or found[0].code not in ("mistake", "parameters", LINEARISED):
        return None
    return Explanation(found[0].message, diagnosis.curves)


def _linearised(found: Hypothesis) -> Finding:
    """The equations are linear: no mistake."""
    unknown = list(dict.fromkeys(key for n, key in found.before if (n, key) not in found.after))
    # Energies of linear motions, if they are written at all, tell less of the integrator.
    lateral = {k: x for k, x in found.after.items() if k[1] in LATERAL} or found.after
    (number, worst), left = max(lateral.items(), key=lambda x: x[1])
    rest = "Nothing else is wrong"
    if left > _SEEN:
        rest = (
            f"An error remains, typically {100 * left:.2g} % of the size of {worst} of maneuver "
            f"{number} and less in roll and steer elsewhere; it can be the integrator's: try a "
            "smaller step or tolerance"
        )
    if unknown:
        rest += (
            f". Not compared: {', '.join(unknown)}, as programs of linear equations compute "
            "energies in several ways, and these are near none that is known here"
        )
    return Finding(
        LINEARISED,
        "These are motions of the linearised equations, at constant speed: compared with those, "
        f"the typical error is smaller by a factor of {found.relief:.2g}. The benchmark asks for "
        f"the nonlinear equations. {rest}",
        evidence={
            "gain": found.gain,
            "relief": found.relief,
            "before": _evidence(found.before),
            "after": _evidence(found.after),
        },
    )


def _towards(diagnosis: Diagnosis) -> list[Finding]:
    """What makes the error smaller, but leaves more of it than an integrator does."""
    fits = diagnosis.estimate.fits if diagnosis.estimate else ()
    fits = tuple(f for f in fits if _is_possible(f, diagnosis.values))
    if fits and diagnosis.unexplained:
        best = fits[0]
        says, relief, place = _changed(best, diagnosis.values), best.relief, diagnosis.unexplained
        evidence: dict[str, Any] = {"changes": _as_evidence(best, diagnosis.values)}
    elif diagnosis.towards:
        first = diagnosis.towards[0]
        lateral = {k: x for k, x in first.after.items() if k[1] in LATERAL} or first.after
        place = first.unexplained or max(lateral, key=lateral.__getitem__)
        says, relief = _said(first), first.relief
        evidence = {"mistakes": list(first.codes), "after": _evidence(first.after)}
    else:
        return []
    number, key = place
    text = (
        f"It goes in the direction of this, which does not explain it: {says}; the typical error "
        f"is smaller by a factor of {relief:.2g}, but {key} of maneuver {number} keeps more than "
        "an integrator leaves, by what the file shows of it elsewhere"
    )
    evidence |= {"relief": relief, "maneuver": number, "column": key}
    return [Finding("direction", text, evidence=evidence)]


def _is_possible(fit: Fit, values: Mapping[Unknown, float]) -> bool:
    """Whether masses, lengths and moments of inertia keep their signs."""
    return all(
        values[u] * (values[u] + change) > 0.0
        for u, change in fit.changes.items()
        if u[1] is None and u[0][0] in "mIrwg" and not u[0].endswith("xz")
    )


def _not_the_integrator(
    diagnosis: Diagnosis, columns: Sequence[tuple[ManeuverScore, ColumnScore]]
) -> list[Finding]:
    """A word if the energy of the file is kept far better than its motion is right."""
    level = diagnosis.energy_level
    worst = max((c.as_understood.measures.max_rel_error or 0.0 for _, c in columns
                 if c.key in LATERAL), default=0.0)  # fmt: skip
    if level is None or worst < _KEPT * level:
        return []
    return [
        Finding(
            "energy_is_kept",
            "No usual integrator makes this error: potential plus kinetic energy of the file is "
            f"constant to {level:.2g} of what they exchange, and roll or steer is wrong by "
            f"{worst:.2g} of its scale; look for it in the model, the start or what is written",
            evidence={"energy_level": level, "max_rel_error": worst},
        )
    ]


def _said(h: Hypothesis) -> str:
    return ", and ".join(m.says for m in h.mistakes)


def _explained(rank: int, hypotheses: Sequence[Hypothesis]) -> Finding:
    first, *others = hypotheses
    text = (
        f"{'' if rank == 1 else 'or, less likely, '}{_said(first)}: simulated so, the typical "
        f"error is smaller by a factor of {first.relief:.2g} in what this changes; check "
        + ", and ".join(dict.fromkeys(m.check for m in first.mistakes))
    )
    if any(m.kind == "start" for m in first.mistakes):
        text += (
            "; where rolling does not allow a start, the nearest velocities in kinetic energy are "
            "taken, as an impulse of the constraint forces leaves them"
        )
    if others:
        text += "; the file cannot tell this from " + "; or ".join(map(_said, others[:_MOST]))
    return Finding(
        "mistake",
        text[0].upper() + text[1:],
        Severity.WARNING if rank == 1 else Severity.INFO,
        {
            "rank": rank,
            "mistakes": list(first.codes),
            "gain": first.gain,
            "relief": first.relief,
            "before": _evidence(first.before),
            "after": _evidence(first.after),
            "indistinguishable": [list(h.codes) for h in others],
        },
    )


def _written_as_given(best: Fit, report: Report) -> Iterator[str]:
    """Columns whose first rows have the start that is given, not the one that is fitted."""
    columns = {(m.maneuver, c.key): c for m in report.maneuvers for c in m.columns if c.values}
    for (name, number), change in best.changes.items():
        key = _STARTS.get(name)
        if number is None or key is None or (number, key) not in columns:
            continue
        trace = columns[number, key].trace
        if trace.time[0] == 0.0 and abs(float(trace.error[0])) < _AS_GIVEN * abs(change):
            yield f"{key} of maneuver {number}"


def _fitted(diagnosis: Diagnosis, report: Report) -> Finding:
    """The fewest parameters that explain the file."""
    estimate = diagnosis.estimate
    assert estimate is not None
    best, *others = estimate.fits
    text = (
        f"{_COUNTS[len(best.changes)]} it: {_changed(best, diagnosis.values)}; with that, the "
        f"error is smaller by a factor of {best.relief:.2g} in what this changes"
    )
    if estimate.is_first_order:
        text += ", to first order"
    if any(name in FORCES for name, _ in best.changes):
        text += (
            "; the benchmark has no dampers, springs, drag or friction: check what your program "
            "applies beside gravity, by default or in its joints"
        )
    elif as_given := list(_written_as_given(best, report)):
        text += (
            f"; but the first row has {' and '.join(as_given)} as given: the motion is another "
            "from the second row on, so look at the first step, not at the input"
        )
    else:
        text += "; check " + ("it" if len(best.changes) == 1 else "them") + " in your input"
    if others:
        text += "; the file cannot tell this from " + "; or ".join(
            _changed(fit, diagnosis.values) for fit in others[:_MOST]
        )
    return Finding(
        "parameters",
        text,
        Severity.WARNING,
        {
            "rank": 1,
            "changes": [_as_evidence(fit, diagnosis.values) for fit in estimate.fits],
            "gain": best.gain,
            "relief": best.relief,
            "is_first_order": estimate.is_first_order,
            "singular_values": list(estimate.singular_values),
        },
    )


def _changed(fit: Fit, values: Mapping[Unknown, float]) -> str:
    parts = []
    for unknown, change in fit.changes.items():
        uncertain, before = fit.uncertain[unknown], values[unknown]
        # So many digits as the uncertainty allows, its first one among them.
        decimals = min(max(1, 1 - floor(log10(uncertain))), _MOST_DECIMALS) if uncertain else 1
        after = f"{before + change:.{decimals}f}".rstrip("0").rstrip(".")
        # What changes next to nothing of what is left is not known at all.
        within = f" (+- {uncertain:.1g})" if uncertain < abs(before) + abs(change) else ""
        parts.append(
            f"{_named(unknown)} is {after} {_UNITS[unknown[0]]}{within} instead of {before:.10g}"
        )
    return ", and ".join(parts)


def _named(unknown: Unknown) -> str:
    name, number = unknown
    if name in FORCES:
        return f"the {FORCES[name].says}"
    if number is None:
        return f"the {PARAMETERS[name].description} ({name})"
    return f"the {name.replace('_', ' ')} of maneuver {number}"


def _as_evidence(fit: Fit, values: Mapping[Unknown, float]) -> list[dict[str, Any]]:
    return [
        {
            "unknown": name,
            "maneuver": number,
            "value": values[name, number] + change,
            "uncertain": fit.uncertain[name, number],
            "instead_of": values[name, number],
            "unit": _UNITS[name],
        }
        for (name, number), change in fit.changes.items()
    ]


def _without_heyoka(diagnosis: Diagnosis) -> Finding:
    return Finding(
        "not_tried",
        f"heyoka is not installed: {diagnosis.untried} equations that lack a term were not tried, "
        f"nor forces, and parameters only as far as they change little ({GENERATE} on Linux, or "
        "conda install heyoka.py)",
        evidence={"untried": diagnosis.untried},
    )


def _evidence(typical: Any) -> dict[str, float]:
    return {f"{maneuver}.{key}": value for (maneuver, key), value in typical.items()}


def _no_mistake(
    diagnosis: Diagnosis, columns: Sequence[tuple[ManeuverScore, ColumnScore]]
) -> Finding:
    worst, where = max(
        (c.as_understood.measures.max_rel_error or 0.0, f"{c.key} of maneuver {m.maneuver}")
        for m, c in columns
    )
    text = (
        f"No usual mistake, alone or with another ({diagnosis.tried} such programs were tried), "
        f"explains the difference (largest {worst:.2g} of the scale, {where})"
    )
    evidence: dict[str, Any] = {"tried": diagnosis.tried, "max_rel_error": worst}
    estimate = diagnosis.estimate
    if estimate is not None:
        text += ", nor do one, two or three parameters or starts that differ"
        evidence["gain_of_all_parameters"] = estimate.gain_of_all
        evidence["singular_values"] = list(estimate.singular_values)
        if estimate.gain_of_all > _ALL:
            text += (
                "; more of them together would, by a factor of "
                f"{estimate.gain_of_all:.2g}, but the file cannot tell which"
            )
    return Finding("no_mistake_found", text, evidence=evidence)
