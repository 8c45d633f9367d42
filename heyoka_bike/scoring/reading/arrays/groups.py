"""A group of arrays: the arrays in a part of a file, and the groups inside it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from heyoka_bike.errors import quoted
from heyoka_bike.scoring.reading.arrays.array_columns import read_array
from heyoka_bike.scoring.reading.arrays.objects import as_array, by_name
from heyoka_bike.scoring.reading.names.heading import group_number, is_time
from heyoka_bike.scoring.reading.names.paths import without_paths
from heyoka_bike.scoring.reading.request import Request

DEEPEST = 6
"""Maximum depth of nested groups (program, maneuver, part), because a group may contain itself."""

MOST_MEMBERS = 100_000
"""Maximum number of arrays and groups of a file, because a group may contain itself many times."""


class ArrayGroup:
    """The arrays in a part of a file, and the groups of arrays inside it.

    Parameters
    ----------
    members
        Arrays, and objects that `by_name` converts to groups, by name.
    request
        The request to read this part.

    Attributes
    ----------
    request : Request
    names : list of str
        Names of all members.
    arrays : dict of str to array
        Objects with a type and a shape.
    groups : dict of str to mapping
        The members of each group by name.
    times : dict of str to array
        The arrays whose name is that of times.

    Raises
    ------
    InputError
        There are too many members, or one is not an array.
    """

    def __init__(self, members: Mapping[str, Any], request: Request) -> None:
        if len(members) > MOST_MEMBERS:
            raise request.error(
                f"found {len(members)} arrays and groups, expected at most {MOST_MEMBERS}"
            )
        names = list(members) if request.known else without_paths(list(members))
        members = request.by_name(zip(names, members.values(), strict=True))
        self.request, self.names = request, names
        self.arrays: dict[str, Any] = {}
        self.groups: dict[str, Mapping[str, Any]] = {}
        for name, x in members.items():
            within = request.within(name)
            columns = by_name(x)
            if columns is None and (array := as_array(x, within)).dtype.names:
                records = read_array(array, within).ravel()
                columns = {field: records[field] for field in array.dtype.names}
            if columns is None:
                self.arrays[name] = array
            else:
                self.groups[name] = columns
        self.times = {name: x for name, x in self.arrays.items() if is_time(name)}

    def with_all_below(self) -> ArrayGroup:
        """Return one group with all arrays; arrays of inner groups are named by their paths."""

        def paths(members: Mapping[str, Any], depth: int) -> Iterator[tuple[str, Any]]:
            for name, x in members.items():
                inner = by_name(x) if depth < DEEPEST else None
                if inner is None:
                    yield name, x
                else:
                    yield from ((f"{name}.{n}", y) for n, y in paths(inner, depth + 1))

        flat = self.request.by_name(paths({**self.arrays, **self.groups}, 0))
        return ArrayGroup(flat, self.request)

    def of_maneuvers(self) -> list[ArrayGroup]:
        """Return the group of each maneuver; times that are stored once are added to each group.

        Raises
        ------
        InputError
            A maneuver occurs twice.
        """
        times = {n: x for n, x in self.arrays.items() if is_time(n.removesuffix("_lo"))}
        found: dict[int, ArrayGroup] = {}
        for name in self.names:
            number, x = group_number(name), self.arrays.get(name)
            if number is None or (x is not None and len(x.shape) != 2):
                continue
            if number in found:
                raise self.request.error(
                    f"found maneuver {number} a second time ({quoted(name)}), expected it once"
                )
            group = self.groups.get(name, {name if times else "": x})
            shared = {} if any(map(is_time, group)) else times
            found[number] = ArrayGroup({**shared, **group}, self.request.of_maneuver(number))
        return [found[number] for number in sorted(found)]


def is_vector(x: Any) -> bool:
    """True if an array is a single column or row; MATLAB has no one-dimensional arrays."""
    return len(x.shape) == 1 or (len(x.shape) == 2 and 1 in x.shape)


def length(x: Any) -> int:
    """Return the number of values of a column."""
    return max(x.shape, default=0)
