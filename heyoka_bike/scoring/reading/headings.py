"""What the columns of a result file are: by their names, or by their place."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.scoring.findings import Finding, Severity

TIME = "time"

Fail = Callable[[str], InputError]
"""Makes the error for a message, with the file and the line of the names."""

_ALIASES: Mapping[str, tuple[str, ...]] = {
    TIME: ("t", "times", "timestamp", "sec", "seconds", "simulationtime"),
    "roll_angle": ("roll", "phi", "lean", "leanangle"),
    "roll_rate": (
        "rollangularvelocity", "rollvelocity", "angularrollvelocity", "phidot", "dphi", "phid",
        "leanrate", "leanangularvelocity", "rolldot",
    ),
    "forward_speed": ("speed", "velocity", "v", "forwardvelocity"),
    "potential_energy": ("potential", "epot", "ep", "pe", "u"),
    "kinetic_energy": ("kinetic", "ekin", "ek", "ke"),
    "mechanical_energy": ("mechanical", "energy", "total", "totalenergy", "emech", "etot", "e"),
    "steer_angle": ("steer", "steering", "steeringangle", "delta"),
    "steer_rate": (
        "steerangularvelocity", "steeringangularvelocity", "steervelocity", "steeringvelocity",
        "steeringrate", "angularsteervelocity", "deltadot", "ddelta", "deltad", "steerdot",
    ),
    "pitch": ("pitchangle",),
    "yaw": ("yawangle", "heading", "headingangle", "psi"),
    "yaw_rate": ("yawangularvelocity", "yawvelocity", "headingrate", "psidot", "dpsi", "yawdot"),
}  # fmt: skip
_KEYS: Mapping[str, str] = {
    **{key.replace("_", ""): key for key in (TIME, *COMPARED)},
    **{alias: key for key, aliases in _ALIASES.items() for alias in aliases},
}
# Mechanics writes T and V for the energies, and t and v for time and speed.
_CAPITALS: Mapping[str, tuple[str, str]] = {
    "T": ("t", "kinetic_energy"),
    "V": ("v", "potential_energy"),
}

_MANEUVER = r"(?:m|man|maneuver|manoeuvre)"
_BRACKETS = re.compile(r"\[([^\]]*)\]|\(([^)]*)\)|\{([^}]*)\}")
_ONE = re.compile(r"[\[({]\s*1\s*[\])}]")
_NUMBERED = re.compile(rf"[\s_-]*{_MANEUVER}?[\s_-]*([0-9]{{1,3}})\s*")
_BREAKS = re.compile(r"[\s_.:/-]+")
_PREFIX = re.compile(rf"{_MANEUVER}_?([0-9]{{1,3}})_(.+)")
_SUFFIX = re.compile(rf"(.+?)_?(?:{_MANEUVER}_?)?([0-9]{{1,3}})")
_GROUP = re.compile(rf"{_MANEUVER}_?([0-9]{{1,3}})")
# The names of a message; more would not be read.
_SHOWN = 8


@dataclass(frozen=True, slots=True)
class Layout:
    """Which column is what.

    Attributes
    ----------
    time : int
        Index of the column of times.
    maneuvers : mapping of (int or None) to mapping of str to int
        Index of each column, by number of the maneuver (None if that is not told) and key.
    findings : tuple of Finding
    """

    time: int
    maneuvers: Mapping[int | None, Mapping[str, int]]
    findings: tuple[Finding, ...] = ()


def recognise(name: str, *, one_is_a_unit: bool = True) -> tuple[str, int | None] | None:
    """Key of the column that a name means, and number of the maneuver if it has one.

    Case, blanks, hyphens and underscores do not matter, nor does a unit in brackets; there 1 is
    that of a column without dimension, or the first maneuver.
    """
    if one_is_a_unit and _ONE.search(name):
        found = recognise(_ONE.sub("", name))
        if found and found[0] != TIME and COMPARED[found[0]][0].unit == "1":
            return found
    plain = _BREAKS.sub("_", _BRACKETS.sub(_number_in_brackets, name.lower())).strip("_\"'")
    number = None
    if match := _PREFIX.fullmatch(plain):
        number, plain = int(match[1]), match[2]
    elif plain.replace("_", "") not in _KEYS and (match := _SUFFIX.fullmatch(plain)):
        plain, number = match[1], int(match[2])
    key = _KEYS.get(plain.replace("_", ""))
    if key is None or (key == TIME and number is not None):
        return None
    return key, number


def group_number(name: str) -> int | None:
    """Number in the name of a group of columns (``maneuver_2``), if it is one."""
    match = _GROUP.fullmatch(_BREAKS.sub("_", name.lower()))
    return int(match[1]) if match else None


def are_names(names: Sequence[str]) -> bool:
    """Whether the names have the time and another column that is known."""
    known = {found[0] for name in names if (found := recognise(name))}
    return TIME in known and len(known) > 1


def left_out(names: Sequence[str]) -> Finding:
    """That columns of unknown names are not used."""
    return Finding(
        "columns_left_out",
        f"Columns of other names are left out: {listed(names)}.",
        Severity.INFO,
        {"names": [quoted(name)[1:-1] for name in names[:100]], "count": len(names)},
    )


def listed(names: Sequence[str]) -> str:
    """The names in quotes, not too many of them."""
    shown = ", ".join(quoted(name) for name in names[:_SHOWN])
    more = len(names) - _SHOWN
    return f"{shown} and {more} more" if more > 0 else shown


def layout(
    names: Sequence[str] | None, width: int, count: int, maneuver: int | None, fail: Fail,
    *, ordered: bool = True,
) -> Layout:  # fmt: skip
    """Find out which column is what.

    Names decide if they are all known; else the place does, if there are 9 or 1 + 8 count columns;
    else those names that are known.

    Parameters
    ----------
    names
        Names of the columns, None if there are none.
    width
        Number of columns.
    count
        Number of maneuvers of the reference.
    maneuver
        Number of the maneuver of columns that do not tell.
    fail
        Makes the error for a message.
    ordered
        Whether the place of a column means anything.

    Raises
    ------
    InputError
        The columns cannot be told, or one is there twice.
    """
    alone = 1 if maneuver is None and count == 1 else maneuver
    found = [] if names is None else _known(names, count)
    # The benchmark's order has no place for what is not of the benchmark.
    is_beyond = any(f and f[0] not in (TIME, *BENCHMARK_COLUMNS) for f in found)
    is_named = any(f and f[0] == TIME for f in found) and sum(f is not None for f in found) > 1
    places = _by_place(width, count, alone) if ordered else None
    if names is not None and is_named and (places is None or None not in found or is_beyond):
        return _by_name(names, found, alone, fail)
    if places is not None:
        return places if names is None else _with_names_unused(places, names, found)
    both = " or ".join(str(n) for n in sorted({9, 1 + 8 * count}))
    if not ordered:
        shown = listed(names or ())
        raise fail(
            f"found {shown or 'nothing'}, expected arrays named time, "
            f"{', '.join(BENCHMARK_COLUMNS)}, or one array of {both} columns"
        )
    named = f" named {listed(names)}" if names else ""
    raise fail(
        f"found {width} columns{named}, expected {both}, or a line of column names such as time, "
        "roll_angle, roll_rate"
    )


def _known(names: Sequence[str], count: int) -> list[tuple[str, int | None] | None]:
    # With other numbers in brackets, all of them are maneuvers.
    brackets = [b for name in names for match in _BRACKETS.finditer(name) for b in match.groups()]
    are_numbers = any(b and b.strip().isdecimal() and int(b) != 1 for b in brackets)
    found = [recognise(name, one_is_a_unit=not are_numbers) for name in names]
    plain = [name.strip() for name in names]
    for i, name in enumerate(plain):
        if name in _CAPITALS and _CAPITALS[name][0] in plain:
            found[i] = _CAPITALS[name][1], None
    found = _from_one(found, count)
    # The eight names once for each maneuver mean the maneuvers in order.
    if not any(f and f[1] is not None for f in found):
        seen: dict[str, int] = {}
        for f in found:
            if f:
                seen[f[0]] = seen.get(f[0], 0) + 1
        times = {n for key, n in seen.items() if key != TIME}
        if count > 1 and times == {count} and seen.get(TIME) == 1:
            turn: dict[str, int] = {}
            for i, f in enumerate(found):
                if f and f[0] != TIME:
                    turn[f[0]] = turn.get(f[0], 0) + 1
                    found[i] = f[0], turn[f[0]]
        return found
    # Beside numbered columns one without a number tells nothing, and no reference has others.
    return [
        f if f is None or f[0] == TIME or (f[1] is not None and 1 <= f[1] <= count) else None
        for f in found
    ]


def _from_one(
    found: list[tuple[str, int | None] | None], count: int
) -> list[tuple[str, int | None] | None]:
    """The same with numbers from 1, where those of every column are from 0.

    Instead of 0 the first of all may have none: so pandas makes equal names differ.
    """
    numbers: dict[str, set[int | None]] = {}
    for f in found:
        if f and f[0] != TIME:
            numbers.setdefault(f[0], set()).add(f[1])
    are_from_zero = all(0 in n for n in numbers.values())
    are_of_pandas = count > 1 and all(n == {None, *range(1, count)} for n in numbers.values())
    if not numbers or not (are_from_zero or are_of_pandas):
        return found
    return [f if f is None or f[0] == TIME else (f[0], (f[1] or 0) + 1) for f in found]


def _by_place(width: int, count: int, alone: int | None) -> Layout | None:
    if width == 1 + 8 * count and count > 1:
        numbers: list[int | None] = list(range(1, count + 1))
    elif width == 9:
        numbers = [alone]
    else:
        return None
    return Layout(
        0,
        {
            number: {key: 1 + 8 * i + k for k, key in enumerate(BENCHMARK_COLUMNS)}
            for i, number in enumerate(numbers)
        },
    )


def _by_name(
    names: Sequence[str], found: Sequence[tuple[str, int | None] | None], alone: int | None,
    fail: Fail,
) -> Layout:  # fmt: skip
    first: dict[tuple[str, int | None], int] = {}
    unknown = []
    for i, f in enumerate(found):
        if f is None:
            unknown.append(names[i])
        elif f in first:
            raise fail(
                f"found {quoted(names[first[f]])} and {quoted(names[i])}, expected one column of "
                f"{f[0].replace('_', ' ')}{'' if f[1] is None else f' for maneuver {f[1]}'}"
            )
        else:
            first[f] = i
    maneuvers: dict[int | None, dict[str, int]] = {}
    for (key, number), i in first.items():
        if key != TIME:
            maneuvers.setdefault(alone if number is None else number, {})[key] = i
    if alone is not None and (others := set(maneuvers) - {alone}) and len(maneuvers) == 1:
        raise fail(f"found columns of maneuver {others.pop()}, expected maneuver {alone}")
    findings = (left_out(unknown),) if unknown else ()
    return Layout(first[TIME, None], maneuvers, findings)


def _with_names_unused(
    places: Layout, names: Sequence[str], found: Sequence[tuple[str, int | None] | None]
) -> Layout:
    """Say so if a name that is known contradicts the place of its column."""
    meant = {places.time: TIME}
    for columns in places.maneuvers.values():
        meant |= {i: key for key, i in columns.items()}
    wrong = [i for i, f in enumerate(found) if f is not None and f[0] != meant.get(i)]
    unknown = [names[i] for i, f in enumerate(found) if f is None]
    if not wrong:
        return places
    finding = Finding(
        "names_not_used",
        f"Not all column names are known ({listed(unknown)}), so the columns are taken in the "
        f"benchmark's order, although column {wrong[0] + 1} is named {quoted(names[wrong[0]])}.",
        Severity.WARNING,
        {"columns": [i + 1 for i in wrong], "unknown": [quoted(n)[1:-1] for n in unknown[:100]]},
    )
    return Layout(places.time, places.maneuvers, (finding,))


def _number_in_brackets(match: re.Match[str]) -> str:
    content = next(part for part in match.groups() if part is not None)
    number = _NUMBERED.fullmatch(content)
    return f"_{number[1]}" if number else ""
