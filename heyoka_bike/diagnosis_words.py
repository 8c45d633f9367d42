"""A diagnosis in words: ranked findings, each with its evidence, and "cannot tell" where so."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from heyoka_bike.diagnosis import Diagnosis, Hypothesis
from heyoka_bike.findings import Finding, Severity
from heyoka_bike.report import ColumnScore, ManeuverScore, Report

# Classes of hypotheses worth a sentence.
_MOST = 3
# Neighbouring errors of white noise differ by sqrt(2) of their size, those of a smooth error by
# next to nothing; halfway is called rough.
_ROUGH = 0.7
# A correct file's error is its floor; sums and conversions may double it.
_AT_FLOOR = 2.0


def findings(diagnosis: Diagnosis, report: Report) -> tuple[Finding, ...]:
    """What explains the file, or what its error looks like if nothing does."""
    columns = [(m, c) for m in report.maneuvers for c in m.columns if c.values]
    if all(c.is_at_floor(_AT_FLOOR) for _, c in columns):
        return (
            Finding(
                "nothing_to_explain",
                "every column is as right as the digits written can tell",
            ),
        )
    if not diagnosis.classes:
        return (_no_mistake(diagnosis, columns), *_numerical(report))
    return tuple(
        _explained(rank, hypotheses)
        for rank, hypotheses in enumerate(diagnosis.classes[:_MOST], start=1)
    )


def _explained(rank: int, hypotheses: Sequence[Hypothesis]) -> Finding:
    first, *others = hypotheses
    says = ", and ".join(m.says for m in first.mistakes)
    text = (
        f"{'' if rank == 1 else 'or, less likely, '}{says}: simulated so, the typical error is "
        f"smaller by a factor of {first.relief:.2g} in what this changes; check "
        + ", and ".join(dict.fromkeys(m.check for m in first.mistakes))
    )
    if others:
        text += "; the file cannot tell this from " + "; or ".join(
            ", and ".join(m.says for m in h.mistakes) for h in others[:_MOST]
        )
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


def _evidence(typical: Any) -> dict[str, float]:
    return {f"{maneuver}.{key}": value for (maneuver, key), value in typical.items()}


def _no_mistake(
    diagnosis: Diagnosis, columns: Sequence[tuple[ManeuverScore, ColumnScore]]
) -> Finding:
    worst, where = max(
        (c.as_understood.measures.max_rel_error or 0.0, f"{c.key} of maneuver {m.maneuver}")
        for m, c in columns
    )
    return Finding(
        "no_mistake_found",
        f"None of {diagnosis.tried} usual mistakes, alone or two together, explains the difference "
        f"(largest {worst:.2g} of the scale, {where})",
        evidence={"tried": diagnosis.tried, "max_rel_error": worst},
    )


def _numerical(report: Report) -> tuple[Finding, ...]:
    """What the error looks like, where no mistake explains it."""
    rough = [
        f"{m.maneuver}.{c.key}"
        for m in report.maneuvers
        for c in m.columns
        if c.values > 10 and not c.is_at_floor(_AT_FLOOR) and _roughness(c) > _ROUGH
    ]
    falling = [m.maneuver for m in report.maneuvers if _falls_steadily(m)]
    if falling and len(falling) == len(report.maneuvers):
        return (
            Finding(
                "numerical_damping",
                "The mechanical energy falls steadily in every maneuver, as numerical damping "
                "makes it: an integrator or a setting with less damping, or a smaller step",
                evidence={"maneuvers": falling},
            ),
        )
    total = sum(len(m.columns) for m in report.maneuvers)
    if len(rough) > total / 2:
        return (
            Finding(
                "rough_error",
                "The error jumps from row to row, as a loose tolerance of the Newton iterations or "
                "few digits make it, not a step size",
                evidence={"columns": rough},
            ),
        )
    return (
        Finding(
            "smooth_error",
            "The error is smooth, as the step size or tolerance of an integrator makes it; to be "
            "sure, halve the step and score both files together: the error of a method of order p "
            "falls by 2^p, that of a wrong model stays",
        ),
    )


def _roughness(c: ColumnScore) -> float:
    """Root mean square of the error's differences over that of the error."""
    error = c.trace.error
    size = float(np.sqrt(np.mean(error**2)))
    return float(np.sqrt(np.mean(np.diff(error) ** 2))) / size if size else 0.0


def _falls_steadily(m: ManeuverScore) -> bool:
    """Whether the mechanical energy is lower in each tenth of the run than in the one before."""
    energy = next((c for c in m.columns if c.key == "mechanical_energy"), None)
    if energy is None or energy.is_at_floor(_AT_FLOOR) or energy.values < 20:
        return False
    means = [float(np.mean(part)) for part in np.array_split(energy.trace.value, 10)]
    drop = means[0] - means[-1]
    return bool(np.all(np.diff(means) < 0)) and drop > 10 * (energy.floor or 0.0)
