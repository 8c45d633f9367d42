"""Base class of evidence: a code, a severity, values, and the sentence made from them.

Evidence describes one observation about a result file by numbers, complete names and places.
`verdict` and `requirements` use its class and its fields. Its sentence is only for people: no
decision depends on it.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from heyoka_bike.scoring.findings import Finding, Severity

MAX_LOG10_ODDS = 6
"""Decimal logarithm of the largest odds in a sentence."""

Errors = tuple[float | None, ...]
"""The largest absolute error of a column in each maneuver that contains it [SI unit]; None if the
column has no value there."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """Base class of all evidence.

    Attributes
    ----------
    file
        The file that shows the evidence, if a run consists of several; otherwise empty.
    """

    file: str = ""

    only_describes = False
    """True for evidence that describes an error without naming its cause."""

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
        """Return the code, the sentence and the numbers; the name of `file` begins the sentence."""
        found = self._finding()
        if not self.file:
            return found
        return replace(found, message=f"{self.file}: {found.message}")

    def _finding(self) -> Finding:
        return Finding(self.code, self.message(), self.severity, self.numbers())

    def lost(self, compared: Collection[str]) -> Iterable["LostColumn"]:
        """Return the columns of the result that were not compared because of this evidence.

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
        Its complete name in the file; a column without a name has its place (``2.roll_angle``).
    key
        Key of the known column that it is, or of the one with the most similar name; None if no
        known column has such a name.
    maneuver
        Number of its maneuver; None if the maneuver is unknown, or if the column belongs to all.
    """

    name: str
    key: str | None = None
    maneuver: int | None = None


@dataclass(frozen=True, slots=True)
class Odds:
    """Odds of the definition of a column against the likeliest other definition.

    Attributes
    ----------
    log10
        Decimal logarithm of the odds.
    against
        The other definition; None stands for every definition unknown to the package.
    """

    log10: float
    against: str | None
