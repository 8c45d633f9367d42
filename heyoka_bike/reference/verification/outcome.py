"""Contents of a reference folder by maneuver, and the results of its verification."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any, cast

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.reference.layout import CANDIDATE, CERTIFICATE, HDF5, MOTION, TEXT_50, TextFile
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.verification.checks import Check, Tally, all_passed

BOUNDS = "bounds of the candidate"
"""Among the files of a part: what the certificate states about the candidate, if they agree."""


@dataclass(frozen=True, slots=True)
class Text:
    """A text file: its numbers as they are written, by maneuver and column."""

    file: TextFile
    columns: Mapping[tuple[int, str], tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class StoredManeuver:
    """One maneuver of a set. Each property needs its file.

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

    @property
    def reference(self) -> ReferenceManeuver:
        """Rows and dense output."""
        return cast(ReferenceManeuver, self.files[HDF5])

    @property
    def motion(self) -> ReferenceManeuver:
        """The whole motion."""
        return cast(ReferenceManeuver, self.files[MOTION])

    @property
    def run(self) -> Trajectory:
        """The candidate."""
        return cast(Trajectory, self.files[CANDIDATE])

    @property
    def entry(self) -> Mapping[str, Any]:
        """Its entry in certificate.json."""
        return cast(Mapping[str, Any], self.files[CERTIFICATE])

    @property
    def long_text(self) -> Text | None:
        """The text with 50 digits, if it is whole."""
        return self.files.get(TEXT_50)

    @property
    def certificate(self) -> Certificate:
        """The stated bounds of the candidate; those of the interval hold on every piece."""
        return cast(Certificate, self.files[BOUNDS])

    def name_of(self, kind: str) -> str:
        """Name of a file: that of a text may say which maneuver it holds."""
        content = self.files.get(kind)
        return content.file.name if isinstance(content, Text) else kind

    def at(self, name: str, row: int) -> str:
        """Return the place of a value in words."""
        return f"{self.maneuver.name}: {name}, row {row}"


def bounds_of(run: Trajectory, entry: Mapping[str, Any]) -> Certificate | None:
    """The bounds that a certificate states for a run; None if they are of other states."""
    states = entry["state_bounds"]
    if set(states) != set(run.states):
        return None
    interval, end = (
        tuple(Fraction(states[name][key]) for name in run.states) for key in ("interval", "end")
    )
    return Certificate(run.states, (interval,) * run.steps, end)


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
