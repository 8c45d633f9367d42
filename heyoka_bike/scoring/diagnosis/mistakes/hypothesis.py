"""Mistakes as an explanation of a file."""

from collections.abc import Mapping
from dataclasses import dataclass

from heyoka_bike.scoring.diagnosis.programs.program import Found, Mistake
from heyoka_bike.scoring.diagnosis.remainder import Place


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """Mistakes, and how much of the difference they explain.

    Attributes
    ----------
    mistakes : tuple of Mistake
        None of them for the correct program.
    gain, relief
        Factor by which the typical error falls, geometric mean over all maneuvers and columns, and
        over those that the mistakes change.
    before, after : mapping of (int, str) to float
        Typical error of each maneuver and column, of the correct program and of this one, in
        scales of the column, over the same rows.
    contradicted : (int, str) or None
        Maneuver and column whose first row says the contrary.
    unexplained : (int, str) or None
        Maneuver and column that keep more than an integrator leaves, see `remainder`.
    """

    mistakes: tuple[Mistake, ...]
    gain: float
    relief: float
    before: Mapping[Place, float]
    after: Mapping[Place, float]
    contradicted: Place | None = None
    unexplained: Place | None = None

    @property
    def codes(self) -> tuple[str, ...]:
        """Codes of the mistakes."""
        return tuple(m.code for m in self.mistakes)

    @property
    def found(self) -> tuple[Found, ...]:
        """Values that were found in the file, if it is explained by nothing else."""
        each = [m.found for m in self.mistakes]
        return tuple(x for found in each for x in found) if all(each) else ()
