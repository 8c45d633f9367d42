"""The result of checking a table of single states, as data."""

from dataclasses import dataclass
from typing import ClassVar

from heyoka_bike.bicycle.instant_columns import InstantLevel
from heyoka_bike.display import Displayed


@dataclass(frozen=True, slots=True)
class CheckedColumn:
    """A column of a table, compared with the exact values.

    Attributes
    ----------
    key, unit
        Name and SI unit of the column.
    values, missing, wrong
        Number of finite values, of missing values, and of wrong values.
    max_error
        Largest difference divided by 1 + abs(expected), in SI units.
    state, place
        Place of the worst value: the number of its state, None for a user's own state; its row.
    found, expected
        The worst value, and the exact value [SI].
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
    """The columns of a table that belong to one level of the computation.

    Attributes
    ----------
    level : InstantLevel
    columns : tuple of CheckedColumn
        The columns, the worst first.
    """

    level: InstantLevel
    columns: tuple[CheckedColumn, ...]

    @property
    def passed(self) -> bool | None:
        """True if all columns of the level are right; None if the table has none of them."""
        return None if not self.columns else not any(c.wrong for c in self.columns)


@dataclass(frozen=True, slots=True)
class Explained:
    """A parameter whose wrong value explains the wrong values of a table.

    Attributes
    ----------
    symbol, unit
    value, right
        The value that explains the table, and the value of the bicycle [SI].
    """

    symbol: str
    unit: str
    value: float
    right: float


@dataclass(frozen=True, repr=False)
class CheckedTable(Displayed):
    """The result of checking a table of single states.

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
        All levels, in the order of the computation.
    left_out : tuple of str
        Names of columns that are not known.
    explained : tuple of Explained
        Parameters, each of which explains all values down to the first level that fails.
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
        """The first level that fails; None if no level fails."""
        return next((x for x in self.levels if x.passed is False), None)

    @property
    def passed(self) -> bool:
        """True if no level fails."""
        return self.failed is None
