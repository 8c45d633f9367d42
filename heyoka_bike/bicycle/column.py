"""A column: a quantity that is stored or compared, with its unit and its meaning."""

from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Column:
    """A stored quantity.

    Attributes
    ----------
    key
        Name of the column (``roll_angle``).
    definition
        Name of the definition, or of the axes or frame that it refers to. The first definition of a
        key is the default.
    unit
        SI unit, UDUNITS spelling.
    long_name, meaning, positive
        For people: full name, definition, and positive direction.
    default
        True if the key alone means this column.
    is_dense
        True if the column has Chebyshev pieces; if not, it follows from columns that have them.
    """

    key: str
    definition: str
    unit: str
    long_name: str
    meaning: str
    positive: str = ""
    default: bool = False
    is_dense: bool = True

    @property
    def name(self) -> str:
        """Name of the dataset: the key, followed by the definition for an alternate."""
        return self.key if self.default else f"{self.key}_{self.definition}"


def components(name: str, what: str, along: str, ahead: str = "forward") -> Iterator[list[str]]:
    """Yield name, long name and positive direction of a column, or of each component of a vector.

    Parameters
    ----------
    name, what
        Name and long name of the column or vector.
    along
        Axes of a vector, such as ``xyz``, or the positive direction of a column.
    ahead
        Positive direction along x.
    """
    if along not in ("xyz", "xy", "xz"):
        yield [name, what, along]
        return
    positive = {"x": ahead, "y": "to the right", "z": "down"}
    for axis in along:
        yield [f"{name}_{axis}", f"{what}, {axis}", positive[axis]]
