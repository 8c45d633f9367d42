"""Checks, the tallies that determine their outcomes, and the contents of a dataset by maneuver."""

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
        None if the check was not made, because another check failed or a package is missing.
    file
        Name of the checked file.
    message
        The measured value, or the first difference found; one line.
    evidence
        Numbers of the check as finite JSON values; ``values`` is the number of checked values.
    """

    check: str
    passed: bool | None
    file: str
    message: str
    evidence: Mapping[str, Any] = field(default_factory=dict)


@dataclass(slots=True)
class Tally:
    """Number of values that a check has examined, and number of those that are wrong.

    Attributes
    ----------
    check, file
        As in `Check`.
    values, failures
        Number of checked values, and number of wrong values.
    first
        Description of the first failure.
    largest
        Largest measured size, if all measured sizes are of one kind.
    """

    check: str
    file: str
    values: int = 0
    failures: int = 0
    first: str = ""
    largest: float = 0.0

    def counts(self, holds: bool, what: str, size: float = 0.0) -> None:
        """Count one checked value and its size; unless it holds, record the failure `what`."""
        self.values += 1
        self.largest = max(self.largest, abs(size))
        if not holds:
            self.fail(what)

    def fail(self, what: str) -> None:
        """Count a failure and keep the description of the first one."""
        self.first = self.first or what
        self.failures += 1

    def joined(self, other: Tally) -> Tally:
        """Return the sum of two tallies; failures of this one come first."""
        return Tally(
            self.check, self.file, self.values + other.values, self.failures + other.failures,
            self.first or other.first, max(self.largest, other.largest),
        )  # fmt: skip

    def done(self, message: str, **evidence: Any) -> Check:
        """Return the finished check; its text is `message` if there was no failure."""
        if self.failures > 1:
            message = f"{self.first} (and {self.failures - 1} more)"
        elif self.failures:
            message = self.first
        return Check(
            self.check, not self.failures, self.file, message,
            {"values": self.values, "failures": self.failures, **evidence},
        )  # fmt: skip


def all_passed(checks: Sequence[Check]) -> bool:
    """True if no check failed; checks that were not made are ignored."""
    return all(c.passed is not False for c in checks)


BOUNDS = "bounds of the candidate"
"""Key in `StoredManeuver.files` of the bounds that the certificate states for the candidate."""


@dataclass(frozen=True, slots=True)
class Text:
    """The entries of a text file as they are written, by maneuver and column."""

    file: TextFile
    columns: Mapping[tuple[int, str], tuple[str, ...]]


class _Content(Generic[T]):
    """Descriptor that returns the content of one file of a maneuver."""

    def __init__(self, kind: str) -> None:
        self.kind = kind

    def __get__(self, part: StoredManeuver, owner: type) -> T:
        content: T = part.files[self.kind]
        return content


@dataclass(frozen=True, slots=True)
class StoredManeuver:
    """One maneuver of a dataset.

    Attributes
    ----------
    number : int
        Number of the maneuver, from 1.
    bicycle, maneuver
        Inputs as stated in the manifest.
    files : mapping
        Contents of the maneuver in the undamaged, well-formed files, by file name. The texts have
        the keys `TEXT` and `TEXT_50`, whatever their files are called. `BOUNDS` is a key, too.
    """

    number: int
    bicycle: Bicycle
    maneuver: Maneuver
    files: Mapping[str, Any]

    # Contents of the files of a maneuver: rows and dense output, the whole motion, the candidate,
    # its entry in certificate.json, and the stated bounds (every piece gets the bound that is
    # stated for the whole run). Reading one of these attributes raises an error if its file is
    # missing.
    reference = _Content[ReferenceManeuver](HDF5)
    motion = _Content[ReferenceManeuver](MOTION)
    run = _Content[Trajectory](CANDIDATE)
    entry = _Content[Mapping[str, Any]](CERTIFICATE)
    certificate = _Content[Certificate](BOUNDS)

    @property
    def long_text(self) -> Text | None:
        """The text with 50 digits; None if it is missing or damaged."""
        return self.files.get(TEXT_50)

    def name_of(self, kind: str) -> str:
        """Return the name of a file; that of a text file may contain the maneuver's number."""
        content = self.files.get(kind)
        return content.file.name if isinstance(content, Text) else kind

    def at(self, name: str, row: int) -> str:
        """Return in words where a value is: its maneuver, column and row."""
        return f"{self.maneuver.name}: {name}, row {row}"


SCHEMA_VERSION = 1
"""Version of the JSON report."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """Digits to which a rerun of a maneuver agrees with the published numbers.

    Attributes
    ----------
    maneuver, precision : str
    published, candidate : mapping of str to float
        Agreeing digits by column: -log10 of the largest difference over the rows, relative to the
        largest value of the column; at most the digits of the shorter of the two runs.
    promised : mapping of str to float
        Digits that must agree with the published numbers.
    tally : Tally
        Count of compared values, and of differences that exceed their bound.
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
        """Return the agreement of the rerun as a check."""
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
    """Result of verifying the folder of a dataset.

    Attributes
    ----------
    folder : str
    dataset_version : str or None
        None if the manifest cannot be used.
    checks : tuple of Check
    parts : tuple of StoredManeuver
        The maneuvers with their undamaged files.
    agreements : tuple of Agreement
        Agreement with reruns, if these were requested.
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
        """Return the report as JSON values; a schema version may gain keys but not change them."""
        return {
            "schema_version": SCHEMA_VERSION,
            "dataset_version": self.dataset_version,
            "folder": self.folder,
            "passed": self.passed,
            "checks": [asdict(c) for c in self.checks],
        }
