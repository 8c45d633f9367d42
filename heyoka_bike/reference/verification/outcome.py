"""Checks, the counting that leads to their outcomes, and the contents of a set by maneuver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Generic, TypeVar

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.reference.layout import CANDIDATE, CERTIFICATE, HDF5, MOTION, TEXT_50, TextFile
from heyoka_bike.reference.load import ReferenceManeuver

T = TypeVar("T")


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

    def counts(self, holds: bool, what: str, size: float = 0.0) -> None:
        """Count a value, of which so much was measured; `what` is wrong with it unless it holds."""
        self.values += 1
        self.largest = max(self.largest, abs(size))
        if not holds:
            self.fail(what)

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


def all_passed(checks: Sequence[Check]) -> bool:
    """True if no check failed; one that was not made does not count."""
    return all(c.passed is not False for c in checks)


BOUNDS = "bounds of the candidate"
"""Among the files of a part: what the certificate states about the candidate, if they agree."""


@dataclass(frozen=True, slots=True)
class Text:
    """A text file: its numbers as they are written, by maneuver and column."""

    file: TextFile
    columns: Mapping[tuple[int, str], tuple[str, ...]]


class _Content(Generic[T]):
    """What a maneuver has of a file, as an attribute of it."""

    def __init__(self, kind: str) -> None:
        self.kind = kind

    def __get__(self, part: StoredManeuver, owner: type) -> T:
        content: T = part.files[self.kind]
        return content


@dataclass(frozen=True, slots=True)
class StoredManeuver:
    """One maneuver of a set.

    Attributes
    ----------
    number : int
        From 1.
    bicycle, maneuver
        As stated in the manifest.
    files : mapping
        Its contents in the intact and well-formed files, by the names of these; its texts by
        `TEXT` and `TEXT_50`, whatever the names of their files; and `BOUNDS`.
    """

    number: int
    bicycle: Bicycle
    maneuver: Maneuver
    files: Mapping[str, Any]

    # Each needs its file: rows and dense output, the whole motion, the candidate, the entry in
    # certificate.json, and the stated bounds; those of the interval hold on every piece.
    reference = _Content[ReferenceManeuver](HDF5)
    motion = _Content[ReferenceManeuver](MOTION)
    run = _Content[Trajectory](CANDIDATE)
    entry = _Content[Mapping[str, Any]](CERTIFICATE)
    certificate = _Content[Certificate](BOUNDS)

    @property
    def long_text(self) -> Text | None:
        """The text with 50 digits, if it is whole."""
        return self.files.get(TEXT_50)

    def name_of(self, kind: str) -> str:
        """Name of a file: that of a text may say which maneuver it holds."""
        content = self.files.get(kind)
        return content.file.name if isinstance(content, Text) else kind

    def at(self, name: str, row: int) -> str:
        """Return the place of a value in words."""
        return f"{self.maneuver.name}: {name}, row {row}"


SCHEMA_VERSION = 1
"""Of the JSON report."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """Agreement of a rerun of a maneuver with the published numbers.

    Attributes
    ----------
    maneuver, precision : str
    published, candidate : mapping of str to float
        Agreeing digits by column: -log10 of the largest difference over the rows, relative to the
        largest value of the column; at most the digits of the shorter of the two runs.
    promised : mapping of str to float
        Digits that have to agree with what is published.
    tally : Tally
        Values compared, and those that are farther apart than they can be.
    steps : int
    seconds : float
        Wall time of the integration.
    """

    maneuver: str
    precision: str
    published: Mapping[str, float]
    candidate: Mapping[str, float]
    promised: Mapping[str, float]
    tally: Tally
    steps: int
    seconds: float

    def check(self) -> Check:
        """The agreement as a check."""
        worst = min(self.published, key=self.published.__getitem__)
        message = (
            f"{self.maneuver}, {self.precision}: {self.published[worst]:.1f} digits of {worst} "
            f"agree, {min(self.candidate.values()):.1f} with the candidate"
        )
        return self.tally.done(
            message, maneuver=self.maneuver, precision=self.precision, steps=self.steps,
            seconds=round(self.seconds, 3), digits=dict(self.published),
            digits_of_candidate=dict(self.candidate), digits_promised=dict(self.promised),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Verification:
    """Result of verifying a folder.

    Attributes
    ----------
    folder : str
    dataset_version : str or None
        None if the manifest is not usable.
    checks : tuple of Check
    parts : tuple of StoredManeuver
        The maneuvers, as far as there are files of them.
    agreements : tuple of Agreement
        Agreement with reruns, if these were asked for.
    """

    folder: str
    dataset_version: str | None
    checks: tuple[Check, ...]
    parts: tuple[StoredManeuver, ...] = ()
    agreements: tuple[Agreement, ...] = ()

    @property
    def passed(self) -> bool:
        """True if no check failed."""
        return all_passed(self.checks)

    def as_dict(self) -> dict[str, Any]:
        """The report as JSON values; keys may be added, not changed, within a schema version."""
        return {
            "schema_version": SCHEMA_VERSION,
            "dataset_version": self.dataset_version,
            "folder": self.folder,
            "passed": self.passed,
            "checks": [asdict(c) for c in self.checks],
        }
