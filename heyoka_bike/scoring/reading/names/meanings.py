"""Find the meanings of the names in a file from all of them together.

The digit at the end of a name need not be the number of a maneuver: `u1` and `u2` are the speeds of
Kane's method, and `V2` is the potential energy of some body. So a number counts as that of a
maneuver only if the word before it is longer than a letter, if the numbers are those of all
maneuvers, or if the same number follows several letters with units. If most columns have no number,
the others count only after a word for maneuver.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.reading.names.heading import (
    TIME,
    Heading,
    Meaning,
    may_mean,
    parse_heading,
    without_maneuver,
)
from heyoka_bike.scoring.reading.names.heading_units import BRACKETS, quantities, split_unit

MaybeMeaning = Meaning | None
"""What a heading means; None if it is not known."""

_UNIT_OF_ENERGY = "J"
# For each capital letter with two meanings: the small letters whose presence changes its meaning,
# its meaning without them, and its meaning with them.
_CAPITALS: Mapping[str, tuple[str, str, str]] = {
    "V": ("vu", "forward_speed", "potential_energy"),
    "T": ("t", TIME, "kinetic_energy"),
}
_ENERGY_NAMES = frozenset({"T", "H", "kinetic_energy", "potential_energy", "mechanical_energy"})
_LETTER_OF_COORDINATES = "q"
# A name that is a single letter, perhaps with a number.
_LETTER = re.compile(r"\W*([^\W\d_])[\W_]*[0-9]*\W*")
_LETTER_AND_NUMBER = re.compile(r"([A-Za-z])_?([0-9]{1,3})")
IN_WORDS = re.compile(r"(?<![a-z])(?:m|man|maneuver|manoeuvre)[\s_.:-]*([0-9]{1,3})")


def meant_together(headings: Sequence[Heading], count: int) -> list[Heading]:
    """Determine the meanings of the headings of a file from all of them together.

    Parameters
    ----------
    headings
        The headings of all columns of the file.
    count
        Number of maneuvers of the reference.

    Returns
    -------
    list of Heading
        The headings with their maneuvers, if these are named. A key is None if it is not known, or
        if the meaning of the heading alone is impossible together with the others.
    """
    names = [heading.text for heading in headings]
    # If any name has a number other than 1 in brackets, all numbers in brackets are numbers of
    # maneuvers, and (1) is not a unit.
    brackets = [x[1:-1] for name in names for x in BRACKETS.findall(name)]
    if any(b.strip().isdecimal() and int(b) != 1 for b in brackets):
        headings = [parse_heading(name, one_is_a_unit=False) for name in names]
    found = _apart(names, _with_capitals(names, [h.meaning for h in headings]))
    found = _without_speeds(names, _from_one(found, count))
    found = _without_indices(names, found, count)
    if any(f and f[1] is not None for f in found):
        # If some columns have the number of a maneuver, a column without a number has no known
        # meaning, and neither has a column whose number is not that of a maneuver of the reference.
        numbers = range(1, count + 1)
        found = [f if f and (f[0] == TIME or f[1] in numbers) else None for f in found]
    else:
        found = _in_turn(names, found, count)
    return [with_meaning(h, f) for h, f in zip(headings, found, strict=True)]


def with_meaning(heading: Heading, found: MaybeMeaning) -> Heading:
    """Return the heading with another meaning."""
    key, maneuver = found or (None, None)
    return replace(heading, key=key, maneuver=maneuver)


def is_coordinate(name: str) -> bool:
    """True if a column of this name is a generalised coordinate q, whose speed is named u."""
    return letter_of(split_unit(name)[0]) == _LETTER_OF_COORDINATES


def letter_of(stem: str) -> str:
    """Return the letter of a name that is one letter, perhaps with a number; empty for a word."""
    match = _LETTER.fullmatch(stem)
    return match[1].lower() if match else ""


def _with_capitals(names: Sequence[str], found: list[MaybeMeaning]) -> list[MaybeMeaning]:
    """Return the meanings with T and V as energies, if the other names indicate this.

    They do if there are columns t, v or u, or if another column has the usual meaning of T or V,
    and there are other energies. Beside an energy, they may have a number: V1 and T1 beside E1.
    """
    split = [(stem.strip(), unit) for stem, unit in map(split_unit, names)]
    has_energy = any(f and f[0] in _ENERGY_NAMES for f in found)
    apart = [_without_number(stem, has_energy) for stem, _ in split]
    plain = [
        stem if unit is None else "" for (stem, _), (_, unit) in zip(apart, split, strict=True)
    ]
    others = [f for name, f in zip(plain, found, strict=True) if f and name not in _CAPITALS]
    meant = list(found)
    for name, (small, alone, energy) in _CAPITALS.items():
        is_second = (alone, None) in others and (energy, None) not in others
        words = {*plain, *(f[0] for f in meant if f)} - {name, energy}
        is_small = any(stem in [*small] for stem, _ in (*split, *apart))
        if is_small or (is_second and words & _ENERGY_NAMES):
            meant = [
                (energy, number) if x == name else f
                for x, (_, number), f in zip(plain, apart, meant, strict=True)
            ]
    return meant


def _without_number(stem: str, is_letter: bool) -> tuple[str, int | None]:
    """Return a name without its maneuver; with `is_letter` also a letter without its number."""
    match = _LETTER_AND_NUMBER.fullmatch(stem) if is_letter else None
    return (match[1], int(match[2])) if match else without_maneuver(stem)


def _apart(names: Sequence[str], found: list[MaybeMeaning]) -> list[MaybeMeaning]:
    """Give each ambiguous small letter a possible meaning that no other column has."""
    apart = list(found)
    for i, (name, f) in enumerate(zip(names, found, strict=True)):
        keys = may_mean(name)
        if f and f[0] in keys and apart.count(f) > 1 and name not in _CAPITALS:
            apart[i] = next(((k, f[1]) for k in keys if (k, f[1]) not in apart), f)
    return apart


def _from_one(found: list[MaybeMeaning], count: int) -> list[MaybeMeaning]:
    """Return the meanings with maneuvers counted from 1, if all columns count them from 0.

    The first maneuver may have no number instead of 0, because pandas distinguishes equal names
    this way.
    """
    numbers = grouped((key, number) for _, key, number in _known_columns(found)).values()
    are_from_zero = all(0 in n for n in numbers)
    are_of_pandas = count > 1 and all({*n} == {None, *range(1, count)} for n in numbers)
    if not (are_from_zero or are_of_pandas):
        return found
    return [f if f is None or f[0] == TIME else (f[0], (f[1] or 0) + 1) for f in found]


def _without_speeds(names: Sequence[str], found: list[MaybeMeaning]) -> list[MaybeMeaning]:
    """Remove the meaning of columns u without joules if there are coordinates q."""
    if not any(map(is_coordinate, names)):
        return found
    units = [split_unit(name) for name in names]
    are_speeds = [
        letter_of(x) == "u" and not (u and _UNIT_OF_ENERGY in quantities(u)) for x, u in units
    ]
    return [None if is_speed else f for f, is_speed in zip(found, are_speeds, strict=True)]


def _without_indices(
    names: Sequence[str], found: list[MaybeMeaning], count: int
) -> list[MaybeMeaning]:
    """Remove the meaning of columns whose numbers are not those of maneuvers."""
    every = set(range(1, count + 1)) if count > 1 else None
    stems = [split_unit(name)[0].lower() for name in names]
    columns = [
        (i, key, number, bool(letter_of(stems[i]))) for i, key, number in _known_columns(found)
    ]
    plain = {key for _, key, number, _ in columns if number is None}
    numbered = grouped(((key, x), (i, n)) for i, key, n, x in columns if n is not None)
    of_words = {n for _, _, n, is_letter in columns if n is not None and not is_letter}
    # If several names consist of a letter and the same number, and their units determine their
    # meanings, this number is that of the maneuver.
    units = [split_unit(names[i])[1] for i, *_ in columns]
    is_one = len({n for _, _, n, _ in columns}) == 1 and len(numbered) > 1 and None not in found
    is_one = is_one and None not in units
    kept = []
    for (_, is_letter), group in numbered.items():
        own = {n for _, n in group}
        # The number after a letter is that of a maneuver if the same numbers follow words, or if
        # the numbers after this letter are those of all maneuvers.
        if not is_letter or own <= of_words or (own == every and not plain) or is_one:
            kept.append(group)
    trusted = {i for group in kept for i, _ in group}
    are_most = every in [{n for _, n in group} for group in kept] or len(kept) > len(plain)
    if plain and not are_most and not any(IN_WORDS.search(stems[i]) for i in trusted):
        trusted = set()
    out = {i for group in numbered.values() for i, _ in group} - trusted
    return [None if i in out else f for i, f in enumerate(found)]


def _in_turn(names: Sequence[str], found: list[MaybeMeaning], count: int) -> list[MaybeMeaning]:
    """Number the columns of each name in order, if each name occurs once for each maneuver."""
    keys = [f[0] if f else None for f in found]
    named = {(key, name.strip(" \"'")) for key, name in zip(keys, names, strict=True)}
    times = {keys.count(key) for key, _ in named if key not in (None, TIME)}
    are_same = len({key for key, _ in named if key}) == sum(key is not None for key, _ in named)
    if count == 1 or times != {count} or keys.count(TIME) != 1 or not are_same:
        return found
    return [
        f if f is None or f[0] == TIME else (f[0], 1 + keys[:i].count(f[0]))
        for i, f in enumerate(found)
    ]


def _known_columns(found: Sequence[MaybeMeaning]) -> list[tuple[int, str, int | None]]:
    """Return the index, key and maneuver number of each known column except the time."""
    return [(i, *f) for i, f in enumerate(found) if f and f[0] != TIME]
