"""Outcomes of requirements, as values that `showing.wording.requirement_text` puts into words."""

from __future__ import annotations

from dataclasses import dataclass

from heyoka_bike.scoring.evidence.base import LostColumn
from heyoka_bike.scoring.evidence.column_meaning import SignContradiction
from heyoka_bike.scoring.verdict import DoesNotCount


@dataclass(frozen=True, slots=True)
class WorstValue:
    """The worst of the values to which a requirement refers.

    Attributes
    ----------
    value
        Infinite if the tolerance is never exceeded.
    maneuver, key
        The place of the value; the key is None for a metric of a whole maneuver.
    is_by_digits
        True if the digits written limit the value.
    """

    value: float
    maneuver: int
    key: str | None = None
    is_by_digits: bool = False


@dataclass(frozen=True, slots=True)
class NoSuchManeuver:
    """The file does not contain the required maneuver."""

    maneuver: int


@dataclass(frozen=True, slots=True)
class NoSuchColumn:
    """The file or the reference has no such column, or no column at all if the key is None."""

    key: str | None
    has_reference: bool = True


@dataclass(frozen=True, slots=True)
class LeftOut:
    """Columns of the result were not compared."""

    columns: tuple[LostColumn, ...]


@dataclass(frozen=True, slots=True)
class NeverFilledIn:
    """Columns of the result were never filled in."""

    columns: tuple[LostColumn, ...]


@dataclass(frozen=True, slots=True)
class ValuesMissing:
    """Some values of a column are not finite.

    Attributes
    ----------
    maneuver, key
    missing, values
        Number of values that are not finite, and of all values.
    """

    maneuver: int
    key: str
    missing: int
    values: int


@dataclass(frozen=True, slots=True)
class SignContradicted:
    """The sign of a column contradicts the signs of other columns."""

    maneuver: int
    contradiction: SignContradiction


@dataclass(frozen=True, slots=True)
class InPart:
    """The value suffices, but the requirement refers to more than was compared.

    Attributes
    ----------
    maneuvers
        Maneuvers without all columns, or without the whole run.
    columns
        Least number of columns that were compared in one of these maneuvers; None if all were.
    coverage
        Least fraction of the run that is covered, rounded down to thousandths; None if all is.
    """

    maneuvers: tuple[int, ...]
    columns: int | None
    coverage: float | None

    @property
    def enough(self) -> tuple[str, ...]:
        """Requirements such as ``coverage >= 0.9`` that would accept what was compared."""
        found = (("columns", self.columns), ("coverage", self.coverage))
        return tuple(f"{name} >= {least:g}" for name, least in found if least is not None)


@dataclass(frozen=True, slots=True)
class NothingCompared:
    """No value of a column could be compared, so a metric is undefined."""

    maneuver: int
    key: str
    metric: str


@dataclass(frozen=True, slots=True)
class EnergyDoesNotCount:
    """Eq. (1) of a maneuver does not count, for the given reason."""

    maneuver: int
    reason: DoesNotCount


Outcome = (
    WorstValue | NoSuchManeuver | NoSuchColumn | LeftOut | NeverFilledIn | ValuesMissing
    | SignContradicted | NothingCompared | EnergyDoesNotCount | InPart
)  # fmt: skip
"""Any outcome other than a `WorstValue` is a reason why the requirement is not met."""


@dataclass(frozen=True, slots=True)
class Requirement:
    """One requirement, as given with ``--require``, and its outcome.

    Attributes
    ----------
    text
        The requirement as given (``2.roll_angle.scd >= 6``).
    met
    found
        The worst value; None if there is none or it is infinite.
    outcome : Outcome
        The place of the worst value, or why the requirement cannot be met.
    parts : tuple of Requirement
        The same requirement on each column, or for metrics of maneuvers on each maneuver.
    """

    text: str
    met: bool
    found: float | None
    outcome: Outcome
    parts: tuple[Requirement, ...] = ()

    @property
    def message(self) -> str:
        """The outcome in one sentence."""
        from heyoka_bike.showing.wording import requirement_text

        return requirement_text.outcome(self.outcome)
