"""What every class of evidence has: a code, a severity, values, and the sentence made from them.

Evidence is what was seen in a result file, as numbers, whole names and places. `verdict` and
`requirements` decide by its class and its fields. The sentence is for people: nothing is decided by
it.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from heyoka_bike.scoring.findings import Finding, Severity

MAX_LOG10_ODDS = 6
"""Decimal logarithm of the largest odds in a sentence."""

Errors = tuple[float | None, ...]

"""The largest absolute error of a column in each maneuver that has it [SI unit]; None without a
value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """Base of all evidence.

    Attributes
    ----------
    file
        The file in which it was seen, if a run consists of several; else empty.
    """

    file: str = ""

    @property
    def code(self) -> str:
        """Stable name of the finding, snake_case."""
        raise NotImplementedError

    @property
    def severity(self) -> Severity:
        """Importance of the finding."""
        return Severity.INFO

    def message(self) -> str:
        """Return one or two sentences for people."""
        raise NotImplementedError

    def numbers(self) -> Mapping[str, Any]:
        """Return the values behind the sentence, as JSON values."""
        return {}

    def finding(self) -> Finding:
        """Return code, sentence and numbers; the sentence names the file if there are several."""
        found = self._finding()
        if not self.file:
            return found
        return replace(found, message=f"{self.file}: {found.message}")

    def _finding(self) -> Finding:
        return Finding(self.code, self.message(), self.severity, self.numbers())

    def lost(self, compared: Collection[str]) -> Iterable["LostColumn"]:
        """Columns of the result that were not compared for this reason.

        Parameters
        ----------
        compared
            Keys of the columns that were compared, in any maneuver.
        """
        return ()


@dataclass(frozen=True, slots=True)
class LostColumn:
    """A column of a file that was not compared.

    Attributes
    ----------
    name
        Its name in the file, whole; of columns without names their place (``2.roll_angle``).
    key
        The column that it is, or whose name it is like; None if its name is like none.
    maneuver
        Number of the maneuver that it is of; None if that is not known, or if it is of all.
    """

    name: str
    key: str | None = None
    maneuver: int | None = None


@dataclass(frozen=True, slots=True)
class Odds:
    """Odds of the definition of a column against the likeliest other one.

    Attributes
    ----------
    log10
        Their decimal logarithm.
    against
        The other definition; None for all that are not known here.
    """

    log10: float
    against: str | None
