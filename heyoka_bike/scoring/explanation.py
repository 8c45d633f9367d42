"""The explanation of a file's errors as a figure shows it: a sentence, and two error curves."""

from dataclasses import dataclass

from heyoka_bike.numbers.double import Array


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """The error of one column before and after an explanation.

    Attributes
    ----------
    maneuver, key, unit
    time : ndarray, shape (n,)
        [s]
    before, after : ndarray, shape (n,)
        Absolute error against the reference, and against the motion that explains the file [unit].
    """

    maneuver: int
    key: str
    unit: str
    time: Array
    before: Array
    after: Array


@dataclass(frozen=True, eq=False, slots=True)
class Explanation:
    """The first cause that a diagnosis found, for the figure; its text is among the findings.

    Attributes
    ----------
    says
        One sentence without a full stop.
    curves : tuple of Curve
        The column of each maneuver that the cause explains best.
    """

    says: str
    curves: tuple[Curve, ...]
