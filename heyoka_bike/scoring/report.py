"""The report of a scored result file: what was seen and measured, behind every output format."""

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
    """Everything that is known about a result file: ``report[2]["roll_angle"].scd``.

    Attributes
    ----------
    dataset_version
        Of the reference.
    bicycle
        Name of the reference's bicycle.
    file : FileInfo
    maneuvers : tuple of ManeuverScore
    seen : tuple of Evidence
        How the file was understood, and what is odd about it.
    requirements : tuple of Requirement
    diagnosis : tuple of Finding
        Why the file differs, the likeliest first; empty if that was not asked.
    explanation : Explanation or None
        Of a diagnosis, if it found something.
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
        """The columns of which values were compared, each with its maneuver."""
        return [(m, c) for m in self.maneuvers for c in m.compared]

    def by_column(self) -> dict[str, list[Place]]:
        """The columns of which values were compared, by key, in every maneuver that has them."""
        return grouped((c.key, (m, c)) for m, c in self.places)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What was seen, in words, with the numbers behind it."""
        return tuple(e.finding() for e in self.seen)

    @property
    def said(self) -> tuple[Finding, ...]:
        """All findings, those of the diagnosis first; none of them twice."""
        return self.diagnosis + tuple(f for f in self.findings if f not in self.diagnosis)

    @property
    def passed(self) -> bool:
        """True if every requirement is met: without any too, however wrong the file is.

        Whether it is right is said by `is_right`.
        """
        return all(r.met for r in self.requirements)

    @property
    def is_right(self) -> bool:
        """True if all eight columns are right over the whole run, in each maneuver of the file.

        Each has six correct digits and is written with as many, and no signs contradict each other.
        A file with fewer columns, or with less of the run, is right as far as it goes: False.
        """
        return verdict.is_right(self.grades, is_whole=self.is_whole)

    @property
    def grades(self) -> list[Grade]:
        """Grades of all columns; a file has the worst of them."""
        return [c.grade for m in self.maneuvers for c in m.columns]

    @property
    def is_whole(self) -> bool:
        """True if all eight columns were compared over the whole run, in each maneuver."""
        return verdict.is_whole(self.maneuvers, self.not_compared)

    @property
    def is_stopped_early(self) -> bool:
        """True if the time of the diagnosis was spent before every cause was tried."""
        return any(isinstance(x, StoppedEarly) for x in self.seen)

    @property
    def not_compared(self) -> tuple[LostColumn, ...]:
        """The columns of the result that were not compared, whatever the reason."""
        return verdict.lost(self.seen, self.maneuvers)
