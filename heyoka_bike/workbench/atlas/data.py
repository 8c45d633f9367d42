"""The data of an atlas: long-term behaviour at each point of a grid, and basin boundary.

The quantities are those of `VARIABLES`. How each is decided is in `fates`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from heyoka_bike.bicycle.parameters import PARAMETERS, START, STATE_INPUTS, Bicycle, Parameter
from heyoka_bike.numbers.double import Array

UNDECIDED, UPRIGHT, CYCLE, LIFTS, FALLS, WEAVES = range(6)
FATES: Mapping[str, str] = {
    "undecided": "not decided within the time limit",
    "upright": "converges to steady straight running, both wheels pressed to the floor",
    "cycle": "approaches a limit cycle, both wheels pressed to the floor",
    "lifts": "a wheel would have to be pulled to the floor, but the motion of the model recovers",
    "falls": "the handlebar turns by a right angle, or the equations reach a singularity",
    "weaves": "weaves without repeating itself until the time limit, both wheels pressed",
}
"""Classes of long-term behaviour: name and meaning, in the order of their numbers."""

NO_WHEEL, REAR, FRONT = range(3)
WHEELS = ("none", "rear", "front")
"""The wheel that leaves the floor first; the position is the stored number."""


@dataclass(frozen=True, slots=True)
class Variable:
    """A quantity stored in the atlas.

    Attributes
    ----------
    long_name, unit
        Name in words, and unit in UDUNITS spelling.
    dtype
        NumPy's name of the stored type.
    flags : tuple of str
        Meanings of the values 0, 1, ... of a categorical quantity.
    """

    long_name: str
    unit: str
    dtype: str = "float64"
    flags: tuple[str, ...] = ()


VARIABLES: Mapping[str, Variable] = {
    "fate": Variable("long-term behaviour", "1", "int8", tuple(FATES)),
    "fate_time": Variable("time of settling or of the fall, or else the time limit", "s"),
    "lift_time": Variable("first time that a wheel would have to be pulled to the floor", "s"),
    "lift_wheel": Variable("wheel that leaves the floor first", "1", "int8", WHEELS),
    "final_speed": Variable("final speed, the mean speed of a motion that weaves", "m s-1"),
    "largest_lean": Variable("largest magnitude of the roll angle up to fate_time", "rad"),
    "largest_steer": Variable("largest magnitude of the steer angle up to fate_time", "rad"),
    "condition": Variable(
        "largest factor by which a small initial error is magnified within 10 s", "1"
    ),
}
"""The quantities by name; NaN stands for a missing value."""


@dataclass(frozen=True, slots=True)
class GridAxis:
    """An axis of the grid: a quantity and its values.

    Attributes
    ----------
    name
        A name of `START`, or the symbol of a parameter.
    values : ndarray
        Increasing values in the unit of the axis; each point is exactly this binary64 number.
    """

    name: str
    values: Array

    @property
    def unit(self) -> str:
        """The unit of the values, as files of maneuvers and bicycles spell it."""
        return self._parameter.unit

    @property
    def long_name(self) -> str:
        """The description of the quantity in words."""
        return self._parameter.description

    @property
    def title(self) -> str:
        """Title of the axis in a map: ``initial speed``, or the description of a parameter."""
        return f"initial {self.name.replace('_', ' ')}" if self.name in START else self.long_name

    @property
    def _parameter(self) -> Parameter:
        return (STATE_INPUTS if self.name in START else PARAMETERS)[self.name]


@dataclass(frozen=True, slots=True)
class Edge:
    """The boundary between motions that fall and motions that do not, along the second axis.

    Attributes
    ----------
    at : ndarray, shape (changes,)
        Values on the first axis, which need not be points of the grid.
    stays, falls : ndarray, shape (changes,)
        Neighbouring binary64 numbers on the second axis: the motion at `stays` does not fall, the
        motion at `falls` does.
    """

    at: Array = field(default_factory=lambda: np.empty(0))
    stays: Array = field(default_factory=lambda: np.empty(0))
    falls: Array = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, slots=True)
class Atlas:
    """Long-term behaviour of a bicycle at each point of a grid.

    Attributes
    ----------
    bicycle : Bicycle
        The bicycle; a parameter that is an axis takes its values from the axis.
    axes : tuple of GridAxis
        The two axes.
    start : mapping
        Initial values that are not on an axis [SI], by the names of `START`.
    variables : mapping
        Arrays of shape (points of the first axis, points of the second), named as in `VARIABLES`.
    edge : Edge
    provenance : mapping
        Versions, code and limits used to make the atlas, as text.
    """

    bicycle: Bicycle
    axes: tuple[GridAxis, GridAxis]
    start: Mapping[str, float]
    variables: Mapping[str, Array]
    edge: Edge
    provenance: Mapping[str, str]

    @property
    def shape(self) -> tuple[int, int]:
        """The numbers of grid points along the two axes."""
        return len(self.axes[0].values), len(self.axes[1].values)
