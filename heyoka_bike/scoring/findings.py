"""Findings: remarks about a result file, one record per remark, identical in all output formats."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any


class Severity(StrEnum):
    """How serious a finding is."""

    INFO = "info"
    """How the file was interpreted; nothing is wrong."""
    WARNING = "warning"
    """Part of the file could not be used, or it disagrees with itself."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One remark about a result file.

    Attributes
    ----------
    code
        Stable name, snake_case.
    message
        One or two sentences for people.
    severity
    evidence
        The numbers behind the message; JSON values only, finite.
    """

    code: str
    message: str
    severity: Severity = Severity.INFO
    evidence: Mapping[str, Any] = field(default_factory=dict)


def info(code: str, message: str, **evidence: Any) -> Finding:
    """Return a finding about how the file was interpreted."""
    return Finding(code, message, evidence=evidence)


def warning(code: str, message: str, **evidence: Any) -> Finding:
    """Return a finding about a part of the file that is not used or contradicts another part."""
    return Finding(code, message, Severity.WARNING, evidence)


def together(names: Sequence[str]) -> str:
    """List several things, as "a", "a and b" or "a, b and c"."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def maneuvers(numbers: Iterable[int]) -> str:
    """Return a list of maneuvers in words: ``maneuver 2``, ``maneuvers 1, 2 and 3``."""
    each = [*map(str, numbers)]
    return f"maneuver{'s' if len(each) > 1 else ''} {together(each)}"


def named(keys: Sequence[str], most: int = 8) -> str:
    """Return a list of at most `most` columns in words, with the number of the other columns."""
    more = len(keys) - most
    return ", ".join(keys[:most]) + (f" and {more} more" if more > 0 else "")
