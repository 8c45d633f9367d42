"""What the files of a set hold, maneuver by maneuver, as far as they can be used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.motion.trajectory import Certificate, Trajectory
from heyoka_bike.reference.layout import CANDIDATE, CERTIFICATE, HDF5, MOTION, TEXT_50
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.texts import TextFile

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
        What the manifest says it is.
    files : mapping
        What the files that are whole and built as they should be have of it, by name; its texts by
        `TEXT` and `TEXT_50`, whatever the names of their files; and `BOUNDS`.
    """

    number: int
    bicycle: Bicycle
    maneuver: Maneuver
    files: Mapping[str, Any]

    @property
    def reference(self) -> ReferenceManeuver:
        """Rows and dense output."""
        found: ReferenceManeuver = self.files[HDF5]
        return found

    @property
    def motion(self) -> ReferenceManeuver:
        """The whole motion."""
        found: ReferenceManeuver = self.files[MOTION]
        return found

    @property
    def run(self) -> Trajectory:
        """The candidate."""
        found: Trajectory = self.files[CANDIDATE]
        return found

    @property
    def entry(self) -> Mapping[str, Any]:
        """What certificate.json says of it."""
        found: Mapping[str, Any] = self.files[CERTIFICATE]
        return found

    @property
    def long_text(self) -> Text | None:
        """The text with 50 digits, if it is whole."""
        return self.files.get(TEXT_50)

    @property
    def certificate(self) -> Certificate:
        """The stated bounds of the candidate; those of the interval hold on every piece."""
        found: Certificate = self.files[BOUNDS]
        return found

    def name_of(self, kind: str) -> str:
        """Name of a file: that of a text may say which maneuver it holds."""
        content = self.files.get(kind)
        return content.file.name if isinstance(content, Text) else kind

    def at(self, name: str, row: int) -> str:
        """Where a value is, in words."""
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
