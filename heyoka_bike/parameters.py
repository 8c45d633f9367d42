"""Bicycles and maneuvers: read from TOML, checked, and held as exact numbers.

A bicycle file has a table ``[parameters]`` with one entry for each of the 26 parameters of the
Carvallo-Whipple bicycle, named as in Meijaard, Papadopoulos, Ruina and Schwab (2007),
doi:10.1098/rspa.2007.1857; a maneuver file has one ``[[maneuver]]`` table for each initial state.
A value is a decimal string or an expression such as ``"pi/10"``, alone or in a table
``{ value = "0.3", unit = "m", source = "..." }``.

Axes: x forward, y to the right, z down, origin at the rear contact point, bicycle upright and
straight. Inertia values are matrix elements about the body's own centre of mass.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

from heyoka_bike.errors import InputError
from heyoka_bike.exact import ZERO, Exact


@dataclass(frozen=True, slots=True)
class Parameter:
    """What a parameter is: its meaning and SI unit, and the range the model allows."""

    description: str
    unit: str
    positive: bool = False
    nonnegative: bool = False


def _body(letter: str, what: str) -> dict[str, Parameter]:
    return {
        f"x{letter}": Parameter(f"forward position of the centre of mass of the {what}", "m"),
        f"z{letter}": Parameter(f"downward position of the centre of mass of the {what}", "m"),
        f"m{letter}": Parameter(f"mass of the {what}", "kg", nonnegative=True),
        f"I{letter}xx": Parameter(f"roll inertia of the {what}", "kg m^2", nonnegative=True),
        f"I{letter}yy": Parameter(f"pitch inertia of the {what}", "kg m^2", nonnegative=True),
        f"I{letter}zz": Parameter(f"yaw inertia of the {what}", "kg m^2", nonnegative=True),
        f"I{letter}xz": Parameter(f"inertia matrix element xz of the {what}", "kg m^2"),
    }


def _wheel(letter: str, what: str) -> dict[str, Parameter]:
    return {
        f"r{letter}": Parameter(f"radius of the {what}", "m", positive=True),
        f"m{letter}": Parameter(f"mass of the {what}", "kg", nonnegative=True),
        f"I{letter}xx": Parameter(f"diametral inertia of the {what}", "kg m^2", nonnegative=True),
        f"I{letter}yy": Parameter(f"axial inertia of the {what}", "kg m^2", nonnegative=True),
    }


PARAMETERS: Mapping[str, Parameter] = {
    "w": Parameter("wheel base", "m", positive=True),
    "c": Parameter("trail", "m"),
    "lam": Parameter("steer axis tilt from the vertical", "rad"),
    "g": Parameter("gravity", "N/kg", nonnegative=True),
    **_wheel("R", "rear wheel"),
    **_body("B", "rear frame with rider"),
    **_body("H", "front fork and handlebar"),
    **_wheel("F", "front wheel"),
}
"""The 26 parameters by symbol."""

STATE_INPUTS: Mapping[str, Parameter] = {
    "speed": Parameter("speed of the rear hub along the heading", "m/s"),
    "roll_rate": Parameter("rate of the lean of the rear wheel plane, right positive", "rad/s"),
    "roll": Parameter("lean of the rear wheel plane, right positive", "rad"),
    "steer": Parameter("steer angle, right positive", "rad"),
    "steer_rate": Parameter("steer rate, right positive", "rad/s"),
    "duration": Parameter("length of the run", "s", positive=True),
    "spacing": Parameter("time between two rows", "s", positive=True),
}
"""What a maneuver says; speed, roll_rate, duration and spacing are required."""

_REQUIRED = ("speed", "roll_rate", "duration", "spacing")
_MAX_ROWS = 1_000_001


@dataclass(frozen=True)
class Bicycle:
    """A Carvallo-Whipple bicycle in exact numbers, SI units.

    Attributes
    ----------
    name : str
    values : mapping
        `Exact` by symbol (see `PARAMETERS`).
    warnings : tuple of str
        What is unusual but usable, such as an inertia matrix that no real body has.
    """

    name: str
    values: Mapping[str, Exact]
    warnings: tuple[str, ...] = field(default=(), compare=False)

    def __getitem__(self, symbol: str) -> Exact:
        return self.values[symbol]

    def replace(self, **changes: Exact) -> Bicycle:
        """A copy with some parameters changed, checked again."""
        unknown = set(changes) - set(PARAMETERS)
        if unknown:
            raise InputError(f"unknown parameter '{min(unknown)}'")
        return _checked_bicycle(self.name, {**self.values, **changes}, _Source.nowhere())


@dataclass(frozen=True)
class Maneuver:
    """An initial state and a time grid, in exact numbers.

    The pitch is not an input: it follows from roll and steer, both wheels touching the floor. The
    rates not given (yaw, pitch, wheels) follow from rolling without slip.
    """

    name: str
    speed: Exact
    roll_rate: Exact
    duration: Fraction
    spacing: Fraction
    roll: Exact = ZERO
    steer: Exact = ZERO
    steer_rate: Exact = ZERO

    @property
    def rows(self) -> int:
        """Number of output rows, both ends included."""
        return int(self.duration / self.spacing) + 1

    def time(self, row: int) -> Fraction:
        """Time of a row [s], exactly."""
        return row * self.spacing

    @property
    def is_straight(self) -> bool:
        """Upright, straight and without lateral rate: the motion is steady by symmetry."""
        return all(x.is_zero for x in (self.roll, self.roll_rate, self.steer, self.steer_rate))


def read_bicycle(path: str | Path) -> Bicycle:
    """Read a bicycle from a TOML file.

    Raises
    ------
    InputError
        With file, line and column: not readable, not TOML, a parameter missing, unknown, given
        twice, not a number, in another unit, or outside the model's range.
    """
    source = _Source.load(path)
    source.refuse_unknown(source.tree, {"name", "source", "sources", "parameters"}, ())
    table = source.table(source.tree, "parameters", ())
    source.refuse_unknown(table, set(PARAMETERS), ("parameters",))
    values = {}
    for symbol, parameter in PARAMETERS.items():
        if symbol not in table:
            raise source.error(
                f"parameter '{symbol}' ({parameter.description}) is missing", ("parameters",)
            )
        values[symbol] = source.value(table[symbol], parameter, ("parameters", symbol))
    return _checked_bicycle(source.name(), values, source)


def read_maneuvers(path: str | Path) -> tuple[Maneuver, ...]:
    """Read the maneuvers of a TOML file, in the order of the file.

    Raises
    ------
    InputError
        With file, line and column, as for `read_bicycle`.
    """
    source = _Source.load(path)
    source.refuse_unknown(source.tree, {"name", "source", "sources", "maneuver"}, ())
    tables = source.tree.get("maneuver")
    if not isinstance(tables, list) or not tables or not all(isinstance(t, dict) for t in tables):
        raise source.error("found no [[maneuver]] table, expected at least one", ("maneuver",))
    maneuvers = tuple(_read_maneuver(source, t, i) for i, t in enumerate(tables))
    names: dict[str, int] = {}
    for i, m in enumerate(maneuvers):
        if m.name in names:
            raise source.error(
                f"name '{m.name}' is already that of maneuver {names[m.name] + 1}",
                ("maneuver", i, "name"),
            )
        names[m.name] = i
    return maneuvers


def _read_maneuver(source: _Source, table: dict[str, Any], index: int) -> Maneuver:
    where = ("maneuver", index)
    source.refuse_unknown(table, {"name", "source", *STATE_INPUTS}, where)
    missing = [key for key in _REQUIRED if key not in table]
    if missing:
        raise source.error(f"'{missing[0]}' is missing in maneuver {index + 1}", where)
    values = {
        key: source.value(table[key], parameter, (*where, key))
        for key, parameter in STATE_INPUTS.items()
        if key in table
    }
    for key in ("duration", "spacing"):
        if not values[key].is_rational:
            raise source.error(
                f"{key}: found {values[key]}, expected a rational number", (*where, key)
            )
    duration, spacing = values["duration"].rational, values["spacing"].rational
    steps = duration / spacing
    if steps.denominator != 1:
        raise source.error(
            f"duration {float(duration):g} s is not a whole number of spacings "
            f"of {float(spacing):g} s",
            (*where, "duration"),
        )
    if steps + 1 > _MAX_ROWS:
        raise source.error(
            f"found {int(steps) + 1} rows, expected at most {_MAX_ROWS}", (*where, "spacing")
        )
    roll = values.get("roll", ZERO)
    if abs(float(roll)) >= 1.5707:
        raise source.error(
            f"roll: found {float(roll):g} rad, expected less than pi/2 either way", (*where, "roll")
        )
    name = table.get("name", f"maneuver {index + 1}")
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        raise source.error("name: expected a line of text", (*where, "name"))
    return Maneuver(
        name=name, speed=values["speed"], roll_rate=values["roll_rate"],
        duration=duration, spacing=spacing, roll=roll,
        steer=values.get("steer", ZERO), steer_rate=values.get("steer_rate", ZERO),
    )  # fmt: skip


def _checked_bicycle(name: str, values: Mapping[str, Exact], source: _Source) -> Bicycle:
    for symbol, x in values.items():
        parameter = PARAMETERS[symbol]
        low = (parameter.positive and float(x) <= 0) or (parameter.nonnegative and float(x) < 0)
        if low:
            bound = "a positive number" if parameter.positive else "zero or more"
            raise source.error(
                f"{symbol} ({parameter.description}): found {float(x):g} {parameter.unit}, "
                f"expected {bound}",
                ("parameters", symbol),
            )
        if symbol != "lam" and not x.is_rational:
            raise source.error(
                f"{symbol}: found {x}, expected a rational number (pi is for angles)",
                ("parameters", symbol),
            )
    if abs(float(values["lam"])) >= 1.5707:
        raise source.error(
            f"lam (steer axis tilt): found {float(values['lam']):g} rad, "
            "expected less than pi/2 either way",
            ("parameters", "lam"),
        )
    for a, b, what in (("mR", "mB", "rear"), ("mH", "mF", "front")):
        if values[a].rational + values[b].rational == 0:
            raise source.error(
                f"the {what} assembly has no mass ({a} + {b} = 0)", ("parameters", b)
            )
    return Bicycle(name=name, values=dict(values), warnings=tuple(_inertia_warnings(values)))


def _inertia_warnings(values: Mapping[str, Exact]) -> Iterator[str]:
    """What no body of positive density can have: allowed, because idealised bicycles need it."""
    for letter in "BH":
        xx, yy, zz, xz = (values[f"I{letter}{ij}"].rational for ij in ("xx", "yy", "zz", "xz"))
        if xx * zz < xz * xz:
            yield f"inertia matrix of {letter} is not positive semidefinite"
        elif xx * zz == xz * xz or yy == 0:
            yield f"inertia matrix of {letter} is only semidefinite"
        # Principal moments p <= q in the xz plane: p + yy >= q, and yy <= p + q.
        elif yy > xx + zz or (xx - zz) ** 2 + 4 * xz**2 > yy**2:
            yield f"moments of inertia of {letter} violate the triangle inequality"
    for letter in "RF":
        xx, yy = (values[f"I{letter}{ij}"].rational for ij in ("xx", "yy"))
        if xx == 0 or yy == 0:
            yield f"inertia matrix of {letter} is only semidefinite"
        elif yy > 2 * xx:
            yield f"moments of inertia of {letter} violate the triangle inequality"


class _Source:
    """A parsed TOML file that knows where its entries stand, for error messages."""

    def __init__(self, path: str | None, text: str, tree: dict[str, Any]) -> None:
        self.path = path
        self.text = text
        self.tree = tree

    @classmethod
    def nowhere(cls) -> _Source:
        return cls(None, "", {})

    @classmethod
    def load(cls, path: str | Path) -> _Source:
        try:
            raw = Path(path).read_bytes()
        except OSError as e:
            raise InputError(f"cannot be read: {e.strerror or e}", file=path) from None
        try:
            text = raw.decode("utf-8-sig").replace("\r\n", "\n")
        except UnicodeDecodeError as e:
            line = raw[: e.start].count(b"\n") + 1
            raise InputError(
                f"found byte 0x{raw[e.start]:02x}, expected UTF-8 text", file=path, line=line
            ) from None
        try:
            # Unquoted decimals keep their text: nothing here becomes a binary float.
            return cls(str(path), text, tomllib.loads(text, parse_float=str))
        except (tomllib.TOMLDecodeError, RecursionError, ValueError) as e:
            what = str(e)
            at = re.search(r"\(at line (\d+), column (\d+)\)", what)
            reason = what[: at.start()].strip() if at else what.partition(" (at ")[0]
            raise InputError(
                f"is not valid TOML: {reason}",
                file=path,
                line=int(at[1]) if at else text.count("\n") + 1,
                column=int(at[2]) if at else None,
            ) from None

    def name(self) -> str:
        name = self.tree.get("name")
        if not isinstance(name, str) or not name.strip() or not name.isprintable():
            raise self.error('expected a line name = "..." at the top', ("name",))
        return name

    def table(self, tree: dict[str, Any], key: str, where: tuple[Any, ...]) -> dict[str, Any]:
        table = tree.get(key)
        if not isinstance(table, dict):
            raise self.error(f"found no table [{key}]", (*where, key))
        return table

    def refuse_unknown(self, tree: dict[str, Any], known: set[str], where: tuple[Any, ...]) -> None:
        for key in tree:
            if key not in known:
                raise self.error(
                    f"unknown entry '{key}', expected one of: {', '.join(sorted(known))}",
                    (*where, key),
                )

    def value(self, entry: object, parameter: Parameter, where: tuple[Any, ...]) -> Exact:
        key = where[-1]
        if isinstance(entry, dict):
            self.refuse_unknown(entry, {"value", "unit", "symbol", "source", "name"}, where)
            unit = entry.get("unit", parameter.unit)
            if unit != parameter.unit:
                raise self.error(f"{key}: found unit '{unit}', expected '{parameter.unit}'", where)
            if "value" not in entry:
                raise self.error(f"{key}: found a table without 'value'", where)
            entry = entry["value"]
        if isinstance(entry, bool) or not isinstance(entry, int | str):
            raise self.error(
                f"{key}: found {type(entry).__name__}, expected a number as a decimal string",
                where,
            )
        try:
            exact = Exact.parse(str(entry))
        except ValueError as e:
            raise self.error(f"{key}: {e}", where) from None
        if (parameter.positive and float(exact) <= 0) or (
            parameter.nonnegative and float(exact) < 0
        ):
            bound = "a positive number" if parameter.positive else "zero or more"
            raise self.error(
                f"{key} ({parameter.description}): found {float(exact):g} {parameter.unit}, "
                f"expected {bound}",
                where,
            )
        return exact

    def error(self, message: str, where: tuple[Any, ...]) -> InputError:
        line, column = self._locate(where)
        return InputError(message, file=self.path, line=line, column=column)

    def _locate(self, where: tuple[Any, ...]) -> tuple[int | None, int | None]:
        """Line and column of an entry: of its value where found, else of the table around it."""
        table: tuple[Any, ...] = ()
        counts: dict[str, int] = {}
        best: tuple[int | None, int | None] = (None, None)
        for number, line in enumerate(self.text.split("\n"), start=1):
            header = re.match(r"\s*\[(\[?)\s*([\w.\"-]+)\s*\]", line)
            if header:
                name = header[2].strip('"')
                if header[1]:
                    counts[name] = counts.get(name, -1) + 1
                    table = (name, counts[name])
                else:
                    table = tuple(name.split("."))
                if table == where[: len(table)] and table:
                    best = (number, line.index("[") + 1)
                continue
            entry = re.match(r"\s*\"?([\w-]+)\"?\s*=\s*", line)
            if entry and (*table, entry[1]) == where[: len(table) + 1]:
                return number, entry.end() + 1
        return best
