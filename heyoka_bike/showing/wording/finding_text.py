"""Make findings from evidence, and select their sentences."""

from collections.abc import Iterable, Sequence

from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.contradictions import StoppedEarly
from heyoka_bike.scoring.findings import Finding, Severity


def findings(evidence: Iterable[Evidence]) -> tuple[Finding, ...]:
    """Return a finding for each piece of evidence, in the same order."""
    return tuple(e.finding() for e in evidence)


def sentences(found: Iterable[Finding]) -> list[str]:
    """Return the message of each finding."""
    return [f.message for f in found]


def warnings(found: Iterable[Finding]) -> list[str]:
    """Return the messages of the findings that are warnings."""
    return sentences(f for f in found if f.severity == Severity.WARNING)


def cause(diagnosis: Sequence[Finding]) -> str:
    """Return the first message of a diagnosis that names a cause, or else its first message.

    The result is empty if the diagnosis is empty.
    """
    causes = [f for f in diagnosis if f.code not in ("no_mistake_found", StoppedEarly.code)]
    return next(iter(sentences(causes or diagnosis)), "")
