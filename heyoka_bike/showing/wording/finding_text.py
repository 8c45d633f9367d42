"""Sentences of findings."""

from collections.abc import Iterable, Sequence

from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.contradictions import StoppedEarly
from heyoka_bike.scoring.findings import Finding, Severity


def findings(evidence: Iterable[Evidence]) -> tuple[Finding, ...]:
    """Return the findings of all evidence, in the same order."""
    return tuple(e.finding() for e in evidence)


def sentences(found: Iterable[Finding]) -> list[str]:
    """Return the sentences of findings."""
    return [f.message for f in found]


def warnings(found: Iterable[Finding]) -> list[str]:
    """Return the sentences of the findings that are warnings."""
    return sentences(f for f in found if f.severity == Severity.WARNING)


def cause(diagnosis: Sequence[Finding]) -> str:
    """Return the first sentence that names a cause, or else the first one; empty without any."""
    causes = [f for f in diagnosis if f.code not in ("no_mistake_found", StoppedEarly.code)]
    return next(iter(sentences(causes or diagnosis)), "")
