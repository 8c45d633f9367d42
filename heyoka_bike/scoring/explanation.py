"""What explains a file, for its figure: a sentence, and the error before and after."""

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
        Absolute error against the reference, and against what explains the file [unit].
    """

    maneuver: int
    key: str
    unit: str
    time: Array
    before: Array
    after: Array


@dataclass(frozen=True, eq=False, slots=True)
class Explanation:
    """The first of what a diagnosis found, for the figure; its words are among the findings.

    Attributes
    ----------
    says
        One sentence without a full stop.
    curves : tuple of Curve
        In each maneuver the column that it explains best.
    """

    says: str
    curves: tuple[Curve, ...]
