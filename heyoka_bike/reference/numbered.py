"""What there is of every maneuver of a set, by its number."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

T = TypeVar("T")


class Numbered(Mapping[int, T]):
    """A mapping of the numbers of maneuvers; two are equal only if they are the same object.

    Attributes
    ----------
    maneuvers : tuple
        Number 1 goes first.
    """

    maneuvers: tuple[T, ...]

    def __getitem__(self, number: int) -> T:
        if number not in self:
            raise KeyError(f"found maneuver {number!r}, expected 1 to {len(self.maneuvers)}")
        return self.maneuvers[number - 1]

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def __contains__(self, number: object) -> bool:
        return isinstance(number, int) and 1 <= number <= len(self.maneuvers)

    def __iter__(self) -> Iterator[int]:
        return iter(range(1, len(self.maneuvers) + 1))

    def __len__(self) -> int:
        return len(self.maneuvers)
