"""The result of checking a table of single instants, as data."""

from dataclasses import dataclass
from typing import ClassVar

from heyoka_bike.bicycle.instant_columns import InstantLevel
from heyoka_bike.display import Displayed


@dataclass(frozen=True, slots=True)
class CheckedColumn:
    """A column beside what it should be.

    Attributes
    ----------
    key, unit
        Its name, and its SI unit.
    values, missing, wrong
        Numbers of values, of those that are not finite, and of those that are off.
    max_error
        Largest difference over 1 + abs(expected), SI units.
    state, place
        Of the worst value: the number of its state, None for one of the user's own; its row.
    found, expected
        The worst value, and what it should be [SI].
    """

    key: str
    unit: str
    values: int
    missing: int
    wrong: int
    max_error: float
    state: int | None
    place: str
    found: float
    expected: float


@dataclass(frozen=True, slots=True)
class CheckedLevel:
    """The columns of a level.

    Attributes
    ----------
    level : InstantLevel
    columns : tuple of CheckedColumn
        The worst first.
    """

    level: InstantLevel
    columns: tuple[CheckedColumn, ...]

    @property
    def passed(self) -> bool | None:
        """True if all columns are right; None if there are none."""
        return None if not self.columns else not any(c.wrong for c in self.columns)


@dataclass(frozen=True, slots=True)
class Explained:
    """A parameter whose other value makes a table right.

    Attributes
    ----------
    symbol, unit
    value, right
        That of the table, and that of the bicycle [SI].
    """

    symbol: str
    unit: str
    value: float
    right: float


@dataclass(frozen=True, repr=False)
class CheckedTable(Displayed):
    """The result of checking a table of instants.

    Attributes
    ----------
    path
        Name of the file.
    bicycle
        Name of the bicycle.
    states
        Number of rows.
    is_own
        True if the states are those of the table, not known ones.
    tolerance
    levels : tuple of CheckedLevel
        All of them, in their order.
    left_out : tuple of str
        Names of columns that are not known.
    explained : tuple of Explained
        Single parameters with other values of which every value is right down to the first level
        that fails.
    """

    path: str
    bicycle: str
    states: int
    is_own: bool
    tolerance: float
    levels: tuple[CheckedLevel, ...]
    left_out: tuple[str, ...]
    explained: tuple[Explained, ...] = ()

    _view: ClassVar[str] = "check"

    @property
    def failed(self) -> CheckedLevel | None:
        """The first level that fails."""
        return next((x for x in self.levels if x.passed is False), None)

    @property
    def passed(self) -> bool:
        """True if no level fails."""
        return self.failed is None
