"""What is found out about a reference folder, as data: its files, checks, and digits that agree."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from heyoka_bike.reference.verification.checks import Check, Tally, all_passed
from heyoka_bike.reference.verification.contents import StoredManeuver

SCHEMA_VERSION = 1
"""Of the JSON report."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """How a rerun of a maneuver compares with what is published.

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
    """What was found out about a folder.

    Attributes
    ----------
    folder : str
    dataset_version : str or None
        None if the manifest is not usable.
    checks : tuple of Check
    parts : tuple of StoredManeuver
        The maneuvers, as far as there are files of them.
    agreements : tuple of Agreement
        How integrating again compares, if that was asked for.
    """

    folder: str
    dataset_version: str | None
    checks: tuple[Check, ...]
    parts: tuple[StoredManeuver, ...] = ()
    agreements: tuple[Agreement, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
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
