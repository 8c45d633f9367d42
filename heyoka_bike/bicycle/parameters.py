"""Bicycles and maneuvers: read from TOML, checked, and held as exact numbers.

A bicycle file has a table ``[parameters]`` with one entry for each of the 26 parameters of the
Carvallo-Whipple bicycle, named as in Meijaard, Papadopoulos, Ruina and Schwab (2007),
doi:10.1098/rspa.2007.1857; a maneuver file has one ``[[maneuver]]`` table for each initial state.
A value is a decimal string or an expression such as ``"pi/10"``, alone or in a table
``{ value = "0.3", unit = "m", source = "..." }``. A bare TOML number is taken as the decimal that
is written there. In a bicycle's table ``uncertainty = "0.002"`` beside the value is its standard
deviation; no motion depends on it.

Axes: x forward, y to the right, z down, origin at the rear contact point, bicycle upright and
straight. Inertia values are matrix elements about the body's own centre of mass.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.toml_source import TomlSource, Where, kind
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.exact import ZERO, Exact
from heyoka_bike.system.resources import (
    benchmark_bicycle,
    benchmark_maneuvers,
    collection,
    find_input,
)


@dataclass(frozen=True, slots=True)
class Parameter:
    """What a parameter is: its meaning and SI unit, and the range the model allows.

    Attributes
    ----------
    description, unit
        Its meaning and SI unit.
    positive, nonnegative
        Whether it must be more than zero, or zero or more.
    takes_pi
        Whether it may contain pi; what does not is held as a `Fraction`.
    half_turns
        It must be less than this multiple of pi either way.
    """

    description: str
    unit: str
    positive: bool = False
    nonnegative: bool = False
    takes_pi: bool = False
    half_turns: Fraction | None = None


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


_HALF = Fraction(1, 2)

PARAMETERS: Mapping[str, Parameter] = {
    "w": Parameter("wheel base", "m", positive=True),
    "c": Parameter("trail", "m"),
    "lam": Parameter("steer axis tilt from the vertical", "rad", takes_pi=True, half_turns=_HALF),
    "g": Parameter("gravity", "N/kg", nonnegative=True),
    **_wheel("R", "rear wheel"),
    **_body("B", "rear frame with rider"),
    **_body("H", "front fork and handlebar"),
    **_wheel("F", "front wheel"),
}
"""The 26 parameters by symbol."""

STATE_INPUTS: Mapping[str, Parameter] = {
    "speed": Parameter("speed of the rear hub along the heading", "m/s", takes_pi=True),
    "roll_rate": Parameter(
        "rate of the lean of the rear wheel plane, right positive", "rad/s", takes_pi=True
    ),
    "roll": Parameter(
        "lean of the rear wheel plane, right positive", "rad", takes_pi=True, half_turns=_HALF
    ),
    "steer": Parameter("steer angle, right positive", "rad", takes_pi=True, half_turns=Fraction(1)),
    "steer_rate": Parameter("steer rate, right positive", "rad/s", takes_pi=True),
    "duration": Parameter("length of the run", "s", positive=True),
    "spacing": Parameter("time between two rows", "s", positive=True),
}
"""What a maneuver says; speed, roll_rate, duration and spacing are required."""

START = ("roll", "steer", "roll_rate", "steer_rate", "speed")
"""The start: what a maneuver says of the state at t = 0."""

_REQUIRED = ("speed", "roll_rate", "duration", "spacing")
MAX_ROWS = 1_000_001
_TOP = {"name", "source", "sources"}
_ENTRY = {"value", "unit", "symbol", "source", "name"}


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
    uncertainties : mapping
        Standard deviations by symbol, of those values whose source gives one. The bicycle is
        defined by its values alone.
    """

    name: str
    values: Mapping[str, Exact]
    warnings: tuple[str, ...] = field(default=(), compare=False)
    uncertainties: Mapping[str, Exact] = field(default_factory=dict, compare=False)

    @classmethod
    def parse(cls, name: str, texts: Mapping[str, str]) -> Bicycle:
        """The bicycle of exact texts by symbol, as in `Reference.parameters`."""
        return cls(name, {symbol: Exact.parse(texts[symbol]) for symbol in PARAMETERS})

    def __getitem__(self, symbol: str) -> Exact:
        return self.values[symbol]

    def replace(self, **changes: Exact) -> Bicycle:
        """A copy with some parameters changed, checked again; they have no uncertainty."""
        # Callers without a type checker give anything.
        given: Mapping[str, object] = changes
        for symbol, x in given.items():
            if symbol not in PARAMETERS:
                raise InputError(
                    f"found unknown parameter {quoted(symbol)}, expected one of PARAMETERS"
                )
            if not isinstance(x, Exact) or not x.is_moderate:
                found = "a magnitude out of range" if isinstance(x, Exact) else type(x).__name__
                raise InputError(
                    f"{symbol}: found {found}, expected an Exact, zero or from 1e-300 to 1e300"
                )
        kept = {s: u for s, u in self.uncertainties.items() if s not in changes}
        return _checked_bicycle(self.name, {**self.values, **changes}, kept, TomlSource())


@dataclass(frozen=True)
class Maneuver:
    """An initial state and a time grid, in exact numbers.

    The pitch is not an input: it follows from roll and steer, both wheels touching the floor. The
    rates not given (yaw, pitch, wheels) follow from rolling without slip.

    Attributes
    ----------
    name : str
    speed, roll_rate : Exact
        Forward speed [m/s] and rate of the roll [rad/s] at the start.
    duration, spacing : Fraction
        Time of the last row, and between rows [s].
    roll, steer : Exact
        Angles at the start [rad], positive to the right.
    steer_rate : Exact
        Rate of the steer at the start [rad/s].
    """

    name: str
    speed: Exact
    roll_rate: Exact
    duration: Fraction
    spacing: Fraction
    roll: Exact = ZERO
    steer: Exact = ZERO
    steer_rate: Exact = ZERO

    @classmethod
    def parse(cls, name: str, texts: Mapping[str, str]) -> Maneuver:
        """The maneuver of exact texts, as in `ReferenceManeuver.inputs`."""
        values = {key: Exact.parse(texts[key]) for key in STATE_INPUTS}
        duration, spacing = values.pop("duration"), values.pop("spacing")
        return cls(name, **values, duration=duration.fraction(), spacing=spacing.fraction())

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

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Bicycle

    Raises
    ------
    InputError
        With file, line and column: not readable, not TOML, a parameter missing, unknown, given
        twice, not a number, in another unit, or outside the model's range.
    """
    source = TomlSource.load(path)
    source.refuse_unknown(source.tree, _TOP | {"parameters"}, ())
    table = source.table(source.tree, "parameters", ())
    source.refuse_unknown(table, PARAMETERS, ("parameters",))
    values, uncertainties = {}, {}
    for symbol, parameter in PARAMETERS.items():
        if symbol not in table:
            raise source.error(
                f"found no entry '{symbol}', expected one ({parameter.description})",
                ("parameters",),
            )
        entry, where = table[symbol], ("parameters", symbol)
        values[symbol] = _read_value(source, entry, parameter, where, _ENTRY | {"uncertainty"})
        if isinstance(entry, dict) and "uncertainty" in entry:
            uncertainties[symbol] = _read_uncertainty(source, entry, parameter, where)
    if "name" not in source.tree:
        raise source.error('found no name of the bicycle, expected name = "..." at the top', ())
    name = source.line_of_text(source.tree, "name", ())
    return _checked_bicycle(name, values, uncertainties, source)


def read_maneuvers(path: str | Path) -> tuple[Maneuver, ...]:
    """Read the maneuvers of a TOML file.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    tuple of Maneuver
        In the order of the file.

    Raises
    ------
    InputError
        With file, line and column, as for `read_bicycle`.
    """
    source = TomlSource.load(path)
    source.refuse_unknown(source.tree, _TOP | {"maneuver"}, ())
    if "name" in source.tree:
        source.line_of_text(source.tree, "name", ())
    tables = source.tables("maneuver")
    maneuvers = tuple(_read_maneuver(source, t, i) for i, t in enumerate(tables))
    first: dict[str, int] = {}
    for i, m in enumerate(maneuvers):
        if m.name in first:
            raise source.error(
                f"name: found {quoted(m.name)}, already that of maneuver {first[m.name] + 1}, "
                "expected different names",
                ("maneuver", i, "name"),
            )
        first[m.name] = i
    return maneuvers


@cache
def benchmark() -> tuple[Bicycle, tuple[Maneuver, ...]]:
    """The bicycle of the benchmark and its three maneuvers."""
    return read_bicycle(benchmark_bicycle()), read_maneuvers(benchmark_maneuvers())


Given = Bicycle | str | Path
"""A bicycle, the name of one of the collection, or a TOML file."""


def read_inputs(
    bicycle: Given, maneuvers: Sequence[Maneuver] | str | Path | None
) -> tuple[Bicycle, Sequence[Maneuver]]:
    """A bicycle and its maneuvers, as given or from their files.

    Parameters
    ----------
    bicycle
    maneuvers
        The same; by default those of the bicycle's name, or the benchmark's.

    Raises
    ------
    InputError
        A file cannot be read, or there is no maneuver.
    """
    own = "benchmark"
    if not isinstance(bicycle, Bicycle):
        own = str(bicycle) if str(bicycle) in collection("maneuvers") else own
        bicycle = read_bicycle(find_input("bicycles", str(bicycle)))
    asked = own if maneuvers is None else maneuvers
    if isinstance(asked, str | Path):
        asked = read_maneuvers(find_input("maneuvers", str(asked)))
    if not asked:
        raise InputError("maneuvers: found none, expected one or more")
    return bicycle, asked


def describe_inputs(bicycle: Bicycle, maneuvers: Iterable[Maneuver]) -> dict[str, Any]:
    """Bicycle and maneuvers as exact text, for the manifest and the files' attributes."""
    return {
        "bicycle": {
            "name": bicycle.name,
            "parameters": {symbol: str(bicycle[symbol]) for symbol in PARAMETERS},
        },
        "maneuvers": [
            {"name": m.name, **{key: str(getattr(m, key)) for key in STATE_INPUTS}}
            for m in maneuvers
        ],
    }


def _read_maneuver(source: TomlSource, table: dict[str, Any], index: int) -> Maneuver:
    where = ("maneuver", index)
    source.refuse_unknown(table, {"name", "source", *STATE_INPUTS}, where)
    for key in _REQUIRED:
        if key not in table:
            raise source.error(
                f"found no entry '{key}' in maneuver {index + 1}, "
                f"expected one ({STATE_INPUTS[key].description})",
                where,
            )
    values = {
        key: _read_value(source, table[key], parameter, (*where, key))
        for key, parameter in STATE_INPUTS.items()
        if key in table
    }
    for key, x in values.items():
        _check_range(source, key, x, STATE_INPUTS[key], (*where, key))
    duration, spacing = values["duration"].rational, values["spacing"].rational
    steps = duration / spacing
    if steps.denominator != 1:
        raise source.error(
            f"duration: found {_show(values['duration'])} s, "
            f"expected a whole number of spacings of {_show(values['spacing'])} s",
            (*where, "duration"),
        )
    if steps + 1 > MAX_ROWS:
        raise source.error(
            f"spacing: found more than {MAX_ROWS} rows, expected a longer spacing",
            (*where, "spacing"),
        )
    name = f"maneuver {index + 1}"
    if "name" in table:
        name = source.line_of_text(table, "name", where)
    if "source" in table:
        source.line_of_text(table, "source", where, limit=1000)
    return Maneuver(
        name=name, speed=values["speed"], roll_rate=values["roll_rate"],
        duration=duration, spacing=spacing, roll=values.get("roll", ZERO),
        steer=values.get("steer", ZERO), steer_rate=values.get("steer_rate", ZERO),
    )  # fmt: skip


def _read_value(
    source: TomlSource,
    entry: object,
    parameter: Parameter,
    where: Where,
    known: Collection[str] = _ENTRY,
) -> Exact:
    """A number, alone or in a table with its unit."""
    key = where[-1]
    if isinstance(entry, dict):
        source.refuse_unknown(entry, known, where)
        if "value" not in entry:
            raise source.error(f"{key}: found a table without 'value', expected one", where)
        for note in ("name", "symbol", "source"):
            if note in entry:
                source.line_of_text(entry, note, where, limit=1000)
        unit = entry.get("unit", parameter.unit)
        if unit != parameter.unit:
            found = f"unit {quoted(unit)}" if isinstance(unit, str) else f"{kind(unit)} as unit"
            raise source.error(
                f"{key}: found {found}, expected '{parameter.unit}'", (*where, "unit")
            )
        entry, where = entry["value"], (*where, "value")
    return _number(source, str(key), entry, where)


def _read_uncertainty(
    source: TomlSource, entry: dict[str, Any], parameter: Parameter, where: Where
) -> Exact:
    """The standard deviation beside a value, in its unit."""
    what, where = f"uncertainty of {where[-1]}", (*where, "uncertainty")
    x = _number(source, what, entry["uncertainty"], where)
    if not x.is_rational and not parameter.takes_pi:
        raise source.error(f"{what}: found {_show(x)}, expected a number without pi", where)
    if x.sign < 0:
        raise source.error(
            f"{what}: found {_show(x)} {parameter.unit}, expected zero or more", where
        )
    return x


def _number(source: TomlSource, key: str, entry: object, where: Where) -> Exact:
    if isinstance(entry, bool) or not isinstance(entry, int | str):
        raise source.error(
            f"{key}: found {kind(entry)}, expected a number as a decimal string", where
        )
    try:
        return Exact.parse(str(entry))
    except ValueError as e:
        raise source.error(f"{key}: {e}", where) from None


def _check_range(
    source: TomlSource, symbol: str, x: Exact, parameter: Parameter, where: Where
) -> None:
    """Refuse what the model cannot use; the comparisons are exact."""
    expected = ""
    if not x.is_rational and not parameter.takes_pi:
        raise source.error(
            f"{symbol}: found {_show(x)}, expected a number without pi", (*where, "value")
        )
    if parameter.positive and x.sign <= 0:
        expected = "a positive number"
    elif parameter.nonnegative and x.sign < 0:
        expected = "zero or more"
    elif parameter.half_turns is not None:
        limit = parameter.half_turns
        below = Exact(x.rational, x.pi_multiple - limit).sign < 0
        above = Exact(x.rational, x.pi_multiple + limit).sign > 0
        if not (below and above):
            expected = f"less than {'pi' if limit == 1 else 'pi/2'} either way"
    if expected:
        raise source.error(
            f"{symbol} ({parameter.description}): found {_show(x)} {parameter.unit}, "
            f"expected {expected}",
            (*where, "value"),
        )


def _show(x: Exact) -> str:
    return f"{float(x):.15g}"


def _checked_bicycle(
    name: str, values: Mapping[str, Exact], uncertainties: Mapping[str, Exact], source: TomlSource
) -> Bicycle:
    for symbol, x in values.items():
        _check_range(source, symbol, x, PARAMETERS[symbol], ("parameters", symbol))
    for a, b, what in (("mR", "mB", "rear"), ("mH", "mF", "front")):
        if values[a].is_zero and values[b].is_zero:
            raise source.error(
                f"{a} and {b}: found 0 kg for both, expected a {what} assembly with mass",
                ("parameters", b, "value"),
            )
    for letter in "BH":
        xx, _, zz, xz = _inertia(values, letter)
        if xx * zz < xz * xz:
            raise source.error(
                f"I{letter}xz: found {_show(Exact(xz))} kg m^2, expected at most the square root "
                f"of I{letter}xx I{letter}zz in magnitude, as in every inertia matrix",
                ("parameters", f"I{letter}xz", "value"),
            )
    warnings = tuple(_inertia_warnings(values))
    return Bicycle(name, dict(values), warnings, dict(uncertainties))


def _inertia(values: Mapping[str, Exact], letter: str) -> tuple[Fraction, ...]:
    return tuple(values[f"I{letter}{ij}"].rational for ij in ("xx", "yy", "zz", "xz"))


def _inertia_warnings(values: Mapping[str, Exact]) -> Iterator[str]:
    """What no solid body has: allowed, because idealised bicycles need it."""
    for letter in "BH":
        xx, yy, zz, xz = _inertia(values, letter)
        if xx * zz == xz * xz or yy == 0:
            yield f"inertia matrix of {letter} is only semidefinite"
        # Principal moments p <= q in the xz plane: p + yy >= q, and yy <= p + q.
        if yy > xx + zz or (xx - zz) ** 2 + 4 * xz**2 > yy**2:
            yield f"moments of inertia of {letter} violate the triangle inequality"
    for letter in "RF":
        xx, yy = (values[f"I{letter}{ij}"].rational for ij in ("xx", "yy"))
        if xx == 0 or yy == 0:
            yield f"inertia matrix of {letter} is only semidefinite"
        if yy > 2 * xx:
            yield f"moments of inertia of {letter} violate the triangle inequality"
