"""Checks and their outcomes: a record for each check, and the counting that leads to it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True, slots=True)
class Check:
    """The outcome of one check.

    Attributes
    ----------
    check
        Stable name, snake_case.
    passed
        None if it was not made, because of what another check found or for want of a package.
    file
        Name of the file that it is about.
    message
        The measured value, or the first difference found; one line.
    evidence
        The numbers behind it, JSON values only, finite; ``values`` is how many were looked at.
    """

    check: str
    passed: bool | None
    file: str
    message: str
    evidence: Mapping[str, Any] = field(default_factory=dict)


@dataclass(slots=True)
class Tally:
    """Counts the values that a check looks at and keeps the first that is wrong.

    Attributes
    ----------
    check, file
        As in `Check`.
    values, failures
        Numbers of values that were looked at, and of wrong ones.
    first
        The first that was wrong, in words.
    largest
        Largest of what was measured, if that is one kind of number.
    """

    check: str
    file: str
    values: int = 0
    failures: int = 0
    first: str = ""
    largest: float = 0.0

    def counts(self, holds: bool, size: float = 0.0) -> bool:
        """Count a value, of which so much was measured; whether it is as it should be."""
        self.values += 1
        self.largest = max(self.largest, abs(size))
        return holds

    def fail(self, what: str) -> None:
        """Note something wrong."""
        self.first = self.first or what
        self.failures += 1

    def joined(self, other: Tally) -> Tally:
        """Both together, this one first."""
        return Tally(
            self.check, self.file, self.values + other.values, self.failures + other.failures,
            self.first or other.first, max(self.largest, other.largest),
        )  # fmt: skip

    def done(self, message: str, **evidence: Any) -> Check:
        """The check, with `message` if nothing was wrong."""
        if self.failures > 1:
            message = f"{self.first} (and {self.failures - 1} more)"
        elif self.failures:
            message = self.first
        return Check(
            self.check, not self.failures, self.file, message,
            {"values": self.values, "failures": self.failures, **evidence},
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class NumberCheck:
    """Something to look at in the numbers of a maneuver.

    Attributes
    ----------
    look
        Called with a `StoredManeuver`, and a `Tally` for each of `tallies` in their order.
    needed : tuple of str
        Files without which nothing can be looked at.
    tallies : mapping of str to str
        Name of each check that comes of it, and the file that it is about.
    """

    look: Callable[..., None]
    needed: tuple[str, ...]
    tallies: Mapping[str, str]


def all_passed(checks: Sequence[Check]) -> bool:
    """True if no check failed; one that was not made does not count."""
    return all(c.passed is not False for c in checks)
