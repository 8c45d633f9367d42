"""The text files of a set, and which maneuvers each holds."""

from collections.abc import Sequence
from dataclasses import dataclass

from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.reference.layout import TEXT, TEXT_50


@dataclass(frozen=True, slots=True)
class TextFile:
    """One of the text files of a set.

    Attributes
    ----------
    name : str
    numbers : tuple of int
        The maneuvers it holds, from 1.
    is_long : bool
        Whether its numbers have 50 digits.
    """

    name: str
    numbers: tuple[int, ...]
    is_long: bool


def text_files(maneuvers: Sequence[Maneuver]) -> tuple[TextFile, ...]:
    """The text files of a set: for all maneuvers, or one for each that has its own time grid."""
    numbers = tuple(range(1, len(maneuvers) + 1))
    both = ((TEXT, False), (TEXT_50, True))
    if len({(m.rows, m.spacing) for m in maneuvers}) == 1:
        return tuple(TextFile(name, numbers, is_long) for name, is_long in both)
    return tuple(
        TextFile(f"-{i}.".join(name.rsplit(".", 1)), (i,), is_long)
        for name, is_long in both
        for i in numbers
    )
