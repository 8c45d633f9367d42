"""Findings: what the numbers of a report mean, in words."""

from collections.abc import Collection, Iterator, Sequence
from math import floor

import numpy as np

from heyoka_bike.numbers.double import median
from heyoka_bike.scoring.alignment import MOST_SAMPLED, spread
from heyoka_bike.scoring.arithmetic import single_precision
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.conventions import ODD_SIGNS, conventions, odds
from heyoka_bike.scoring.findings import Finding, Severity, named
from heyoka_bike.scoring.measures import TOLERANCE
from heyoka_bike.scoring.report import ManeuverScore, Report
from heyoka_bike.scoring.signs import contradictions, opposed
from heyoka_bike.scoring.time_shift import time_shift

# Fewer digits than binary64 holds are worth mentioning where they are what limits the score.
_DIGITS_OF_BINARY64 = 15
# An error of this part of the scale is seen in a plot; the benchmark's measure may miss it.
_VISIBLE = 1e-2
# Rounding of written values explains up to this many times its bound: sums are rounded, too.
_ROUNDED = 4.0
# An error of up to this many floors is that of the digits written.
_LIMITED = 2.0
# Units differ by more than that, so that a column nearer than this tells its own.
_UNIT_TOLD = 0.05


def explain(report: Report) -> tuple[Finding, ...]:
    """What is worth saying about a report: its conventions, then in the order of its columns."""
    understood = tuple(_understood(report))
    contradicted = [key for f in understood if f.code in ODD_SIGNS for key in f.evidence["columns"]]
    general = conventions(report, contradicted)
    single = single_precision(report)
    return (
        *(() if general is None else (general,)),
        *understood,
        *_unknown(report),
        *_time_shift(report.maneuvers),
        *_coverage(report.maneuvers),
        *_performance(report.maneuvers),
        *_consistency(report.maneuvers),
        *_digits(report, single.evidence["columns"] if single else ()),
        *(() if single is None else (single,)),
    )


def _columns(report: Report) -> dict[str, list[tuple[ManeuverScore, ColumnScore]]]:
    found: dict[str, list[tuple[ManeuverScore, ColumnScore]]] = {}
    for m in report.maneuvers:
        for c in m.columns:
            if c.values:
                found.setdefault(c.key, []).append((m, c))
    return found


def _understood(report: Report) -> Iterator[Finding]:
    columns = _columns(report)
    signs = {}
    for key, scores in columns.items():
        understood, written = scores[0][1].as_understood, scores[0][1].as_written
        signs[key] = understood.sign
        evidence = {
            "column": key,
            "max_abs_error": [c.as_understood.measures.max_abs_error for _, c in scores],
            "max_abs_error_as_written": [c.as_written.measures.max_abs_error for _, c in scores],
        }
        errors = _errors(scores)
        if understood.definition != written.definition and scores[0][1].is_known:
            default = [
                next(a.max_abs_error for a in c.alternatives if a.definition == written.definition)
                for _, c in scores
            ]
            also = scores[0][1].indistinguishable
            sure = odds(scores[0][1])
            yield Finding(
                "definition",
                f"{key} is {understood.definition}{f', {sure}' if sure else ''}: errors {errors}, "
                f"against {_list(default)} for the default {written.definition}"
                + (f" (cannot be told apart from {', '.join(also)})" if also else ""),
                evidence={**evidence, "definition": understood.definition},
            )
        if understood.sign < 0:
            yield Finding(
                "sign",
                f"{key} has the other sign: errors {errors} with it turned round",
                evidence=evidence,
            )
        if understood.unit != written.unit:
            yield Finding(
                "unit",
                f"{key} is in {understood.unit}, not {written.unit}: errors {errors} in the latter",
                evidence={**evidence, "unit": understood.unit},
            )
        heading = scores[0][0].part.units.get(key, understood.unit)
        far = [c.as_understood.measures.max_rel_error for _, c in scores]
        if heading != understood.unit and all(x is not None and x < _UNIT_TOLD for x in far):
            yield Finding(
                "unit_contradicted",
                f"{key}: its heading says {heading}, but its values are in {understood.unit}. One "
                "of them is wrong; here they are taken as what they fit",
                Severity.WARNING,
                {"column": key, "named": heading, "unit": understood.unit},
            )
        if understood.offset:
            yield Finding(
                "offset",
                f"{key} has another zero, {understood.offset:+.9g} J: errors {errors} without that "
                "constant",
                evidence={**evidence, "offset": understood.offset},
            )
    told = {k: s for k, s in signs.items() if _has_sign(columns[k])}
    for keys in contradictions(told):
        if len(keys) == 2:
            what = f"{keys[0]} and {keys[1]} have opposite signs: one of them is turned round"
        else:
            what = f"{named(keys)} have signs that no axes give together: some are turned round"
            what += ", or they are of an inverse attitude" if "frame_" in keys[0] else ""
        yield Finding("signs_disagree", what, Severity.WARNING, {"columns": list(keys)})
    if keys := opposed(told):
        yield Finding(
            "senses_opposed",
            "roll and steer have opposite senses: roll is positive to the left, steer to the "
            "right. Right-handed axes give this only if one points backward and another down (with "
            "x forward and z up it is steer that turns round): if yours are not so, one of the two "
            "has a sign error",
            Severity.WARNING,
            {"columns": list(keys)},
        )


def _unknown(report: Report) -> Iterator[Finding]:
    """Columns whose definition is not known, of a motion that is right."""
    for key, scores in _columns(report).items():
        if scores[0][1].is_known:
            continue
        others = [
            c.as_understood.measures.scd
            for m in report.maneuvers
            for c in m.columns
            if c.is_known and c.as_understood.measures.scd is not None
        ]
        nearest = scores[0][1].as_understood.definition
        yield Finding(
            "definition_unknown",
            f"{key}: no definition that is known here gives this column; the other columns have "
            f"{floor(min(others))} digits or more, so the motion is right. The nearest definition "
            f"is {nearest}, with errors {_errors(scores)}. It is of another point or axis, or "
            "written wrongly: say what it is",
            Severity.WARNING,
            {
                "column": key,
                "nearest": nearest,
                "max_abs_error": [c.as_understood.measures.max_abs_error for _, c in scores],
                "digits_of_others": min(others),
            },
        )


def _time_shift(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    """Times that are off by a constant."""
    shift = time_shift([m.part for m in maneuvers])
    if shift is None:
        return
    first = all(abs(m.part.time[0] - shift) < (m.step or 0.0) / 10 for m in maneuvers)
    starts = f"; the first row, at {shift:.6g} s, holds the initial state" if first else ""
    yield Finding(
        "time_shifted",
        f"All times are {abs(shift):.9g} s too {'late' if shift > 0 else 'early'}: with that taken "
        f"{'off' if shift > 0 else 'into account'} the motion fits{starts}. The errors here are "
        "those at the times as written",
        Severity.WARNING,
        {"shift": shift},
    )


def _has_sign(scores: Sequence[tuple[ManeuverScore, ColumnScore]]) -> bool:
    """Whether most values are nearer to the reference than they would be with another sign."""
    for _, c in scores:
        some = spread(len(c.trace.time), MOST_SAMPLED)
        if median(np.abs(c.trace.error[some])) >= median(np.abs(c.trace.reference[some])):
            return False
    return True


def _coverage(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    said = set()
    for m in maneuvers:
        duration = float(m.part.reference.duration)
        slack = 1.5 * (m.step or 0.0) / duration
        ends = (m.t_start, m.t_end, m.gap)
        if (not m.coverage or m.coverage + 2 * slack < 1.0) and ends not in said:
            said.add(ends)
            which = [n.maneuver for n in maneuvers if (n.t_start, n.t_end, n.gap) == ends]
            rows = f"complete rows of maneuver {', '.join(map(str, which))}"
            what = f"{rows} cover {m.t_start:.6g} to {m.t_end:.6g} s only; the rest of the run is"
            if m.coverage < (m.t_end - m.t_start) / duration - slack or not m.coverage:
                what = f"{rows} are up to {m.gap:.3g} s apart; what the motion does meanwhile is"
            yield Finding(
                "coverage",
                f"{what} not judged",
                Severity.WARNING,
                {"maneuvers": which, "t_start": m.t_start, "t_end": m.t_end, "gap": m.gap},
            )


def _performance(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    limit = next((m.performance_limit for m in maneuvers if m.performance_limit), None)
    for m in maneuvers:
        if m.performance is None or limit is None or m.performance >= limit:
            continue
        wrong = {
            c.key: c.as_understood.measures.max_rel_error or 0.0
            for c in m.columns
            if c.is_known and not c.is_at_floor(_LIMITED)
        }
        key = max(wrong, key=wrong.__getitem__, default="")
        worst = wrong.get(key, 0.0)
        # Where the energy itself is wrong, it shows the error, but eq. (1) does not ask for it.
        if worst > _VISIBLE and wrong.get("mechanical_energy", 0.0) < _VISIBLE:
            yield Finding(
                "energy_hides_error",
                f"maneuver {m.maneuver}: eq. (1) is {m.performance:.2g} %, below {limit:g} %, and "
                f"yet {key} is wrong by {_percent(worst)} of its scale; energy alone does not "
                "show this error",
                Severity.WARNING,
                {
                    "maneuver": m.maneuver,
                    "performance": m.performance,
                    "column": key,
                    "max_rel_error": worst,
                },
            )


def _consistency(maneuvers: Sequence[ManeuverScore]) -> Iterator[Finding]:
    for m in maneuvers:
        total, floor = m.consistency.energy_sum, m.consistency.energy_sum_floor
        if total is not None and floor is not None and total > _ROUNDED * floor:
            yield Finding(
                "energy_sum",
                f"maneuver {m.maneuver}: potential plus kinetic energy differs from the mechanical "
                f"energy by up to {total:.2g} J; rounding explains {floor:.2g} J",
                Severity.WARNING,
                {"maneuver": m.maneuver, "energy_sum": total, "floor": floor},
            )
        for key in m.consistency.contradicted:
            found = getattr(m.consistency, key)
            rate = next((c for c in m.columns if c.key == key), None)
            if found is None or rate is None:
                continue
            scale = float(abs(rate.trace.reference).max())
            if found > TOLERANCE * scale:
                yield Finding(
                    "rate_is_not_the_derivative",
                    f"maneuver {m.maneuver}: {key} is not the derivative of its own angle, which "
                    f"is much better than it: {found:.2g} rad/s apart (root mean square)",
                    Severity.WARNING,
                    {"maneuver": m.maneuver, "column": key, "rms_difference": found},
                )


def _digits(report: Report, single: Collection[str]) -> Iterator[Finding]:
    """Where not the program but the digits it wrote limit the score, if not for their precision."""
    digits = report.file.significant_digits
    if digits is None or digits >= _DIGITS_OF_BINARY64:
        return
    limited = []
    for key, scores in _columns(report).items():
        if key not in single and all(c.is_at_floor(_LIMITED) for _, c in scores):
            limited.append(key)
    if limited:
        yield Finding(
            "digits_written",
            f"{named(limited)}: the error is that of the digits written ({digits} in the "
            "column with the fewest); write 17 to show what the program can do",
            evidence={"columns": limited, "significant_digits": digits},
        )


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %" if part >= 0.1 else f"{100 * part:.2g} %"


def _errors(scores: Sequence[tuple[ManeuverScore, ColumnScore]]) -> str:
    return _list([c.as_understood.measures.max_abs_error for _, c in scores])


def _list(errors: Sequence[float | None]) -> str:
    return " / ".join("-" if e is None else f"{e:.2g}" for e in errors)
