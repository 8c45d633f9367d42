"""The report of a scored result file: evidence and measures, from which all output is made."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from heyoka_bike.display import IdentityMapping
from heyoka_bike.scoring import verdict
from heyoka_bike.scoring.evidence.base import Evidence, LostColumn
from heyoka_bike.scoring.evidence.contradictions import StoppedEarly
from heyoka_bike.scoring.explanation import Explanation
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.outcomes import Requirement
from heyoka_bike.scoring.scored import Scored
from heyoka_bike.scoring.scores import ManeuverScore, Place, Worst

if TYPE_CHECKING:
    from heyoka_bike.scoring.alignment import FileInfo


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Report(Scored, IdentityMapping[int, ManeuverScore]):
    """All results of scoring a file: ``report[2]["roll_angle"].scd``.

    Attributes
    ----------
    dataset_version
        Version of the reference.
    bicycle
        Name of the reference's bicycle.
    file : FileInfo
    maneuvers : tuple of ManeuverScore
    seen : tuple of Evidence
        How the file was interpreted, and what is unusual about it.
    requirements : tuple of Requirement
    diagnosis : tuple of Finding
        Causes of the errors, the likeliest first; empty without a diagnosis.
    explanation : Explanation or None
        The first cause, with its figure; None without a diagnosis, or if it found nothing.
    reference_sha256
        Hash of the reference's numbers, its ``content_sha256``; empty if unknown.
    """

    dataset_version: str
    bicycle: str
    file: FileInfo
    maneuvers: tuple[ManeuverScore, ...]
    seen: tuple[Evidence, ...]
    requirements: tuple[Requirement, ...] = ()
    diagnosis: tuple[Finding, ...] = ()
    explanation: Explanation | None = None
    reference_sha256: str = ""

    def __getitem__(self, number: int) -> ManeuverScore:
        for maneuver in self.maneuvers:
            if maneuver.maneuver == number:
                return maneuver
        raise KeyError(f"found maneuver {number!r}, expected one of {', '.join(map(str, self))}")

    def __iter__(self) -> Iterator[int]:
        return (maneuver.maneuver for maneuver in self.maneuvers)

    def __len__(self) -> int:
        return len(self.maneuvers)

    @property
    def worst(self) -> Worst | None:
        """The column with the fewest correct digits; None if nothing was compared."""
        found = (m.worst for m in self.maneuvers)
        return min((w for w in found if w), key=lambda w: w.scd, default=None)

    @property
    def places(self) -> list[Place]:
        """The columns with compared values, each with its maneuver."""
        return [(m, c) for m in self.maneuvers for c in m.compared]

    def by_column(self) -> dict[str, list[Place]]:
        """Return the places of each column by key: all maneuvers in which it was compared."""
        return grouped((c.key, (m, c)) for m, c in self.places)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Findings: a message for each piece of evidence, with its numbers."""
        return tuple(e.finding() for e in self.seen)

    @property
    def said(self) -> tuple[Finding, ...]:
        """All findings without duplicates, those of the diagnosis first."""
        return self.diagnosis + tuple(f for f in self.findings if f not in self.diagnosis)

    @property
    def passed(self) -> bool:
        """True if every requirement is met.

        Without requirements it is True, too, however wrong the file is; see `is_right`.
        """
        return all(r.met for r in self.requirements)

    @property
    def is_right(self) -> bool:
        """True if all eight columns are right over the whole run, in each maneuver of the file.

        Each has six correct digits and is written with as many, and no signs contradict each other.
        False for a file with fewer columns or less of the run, even if everything in it is right.
        """
        return verdict.is_right(self.grades, is_whole=self.is_whole)

    @property
    def grades(self) -> list[Grade]:
        """Grades of all columns; the worst of them is the grade of the file."""
        return [c.grade for m in self.maneuvers for c in m.columns]

    @property
    def is_whole(self) -> bool:
        """True if all eight columns were compared over the whole run, in each maneuver."""
        return verdict.is_whole(self.maneuvers, self.not_compared)

    @property
    def is_stopped_early(self) -> bool:
        """True if the diagnosis reached its time limit before every cause was tried."""
        return any(isinstance(x, StoppedEarly) for x in self.seen)

    @property
    def not_compared(self) -> tuple[LostColumn, ...]:
        """The columns of the result file that were not compared, for any reason."""
        return verdict.lost(self.seen, self.maneuvers)
