"""Bicycles and maneuvers: read from TOML, checked, and stored as exact numbers.

A bicycle file has a table ``[parameters]`` with one entry for each of the 26 parameters of the
Carvallo-Whipple bicycle, named as in Meijaard, Papadopoulos, Ruina and Schwab (2007),
doi:10.1098/rspa.2007.1857; a maneuver file has one ``[[maneuver]]`` table for each initial state.
A value is a decimal string or an expression such as ``"pi/10"``, alone or in a table
``{ value = "0.3", unit = "m", source = "..." }``. The unit may be any of the same kind (``mm``,
``deg``, ``kg mm^2``); the default is the SI unit. A bare TOML number is read as exactly the decimal
that is written. In a bicycle's table, ``uncertainty = "0.002"`` next to the value is its standard
deviation; no motion depends on it.

Axes: x forward, y to the right, z down, origin at the rear contact point, bicycle upright and
straight. Inertia values are matrix elements about the body's own centre of mass.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.toml_source import TomlSource, Where, kind
from heyoka_bike.errors import InputError, quoted, unknown_word
from heyoka_bike.numbers.exact import ZERO, Exact
from heyoka_bike.numbers.unit import factor
from heyoka_bike.system.resources import (
    benchmark_bicycle,
    benchmark_maneuvers,
    collection,
    find_input,
)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter: its meaning and SI unit, and the range the model allows.

    Attributes
    ----------
    description, unit
        Meaning and SI unit of the parameter.
    expected
        Range of valid values, a key of `_RANGES`; empty for any number.
    takes_pi
        True if the value may contain pi; a value without pi is stored as a `Fraction`.
    """

    description: str
    unit: str
    expected: str = ""
    takes_pi: bool = False


_POSITIVE, _NONNEGATIVE = "a positive number", "zero or more"
_HALF, _TURN = "less than pi/2 either way", "less than pi either way"


def _is_within(x: Exact, half_turns: Fraction) -> bool:
    return (
        (x + Exact(Fraction(0), half_turns)).sign > 0 > (x + Exact(Fraction(0), -half_turns)).sign
    )


# For each description of a range: the condition on the value, which is evaluated exactly.
_RANGES: Mapping[str, Callable[[Exact], bool]] = {
    "": lambda x: True,
    _POSITIVE: lambda x: x.sign > 0,
    _NONNEGATIVE: lambda x: x.sign >= 0,
    _HALF: lambda x: _is_within(x, Fraction(1, 2)),
    _TURN: lambda x: _is_within(x, Fraction(1)),
}


def _body(letter: str, what: str) -> dict[str, Parameter]:
    return {
        f"x{letter}": Parameter(f"forward position of the centre of mass of the {what}", "m"),
        f"z{letter}": Parameter(f"downward position of the centre of mass of the {what}", "m"),
        f"m{letter}": Parameter(f"mass of the {what}", "kg", _NONNEGATIVE),
        f"I{letter}xx": Parameter(f"roll inertia of the {what}", "kg m^2", _NONNEGATIVE),
        f"I{letter}yy": Parameter(f"pitch inertia of the {what}", "kg m^2", _NONNEGATIVE),
        f"I{letter}zz": Parameter(f"yaw inertia of the {what}", "kg m^2", _NONNEGATIVE),
        f"I{letter}xz": Parameter(f"inertia matrix element xz of the {what}", "kg m^2"),
    }


def _wheel(letter: str, what: str) -> dict[str, Parameter]:
    return {
        f"r{letter}": Parameter(f"radius of the {what}", "m", _POSITIVE),
        f"m{letter}": Parameter(f"mass of the {what}", "kg", _NONNEGATIVE),
        f"I{letter}xx": Parameter(f"diametral inertia of the {what}", "kg m^2", _NONNEGATIVE),
        f"I{letter}yy": Parameter(f"axial inertia of the {what}", "kg m^2", _NONNEGATIVE),
    }


PARAMETERS: Mapping[str, Parameter] = {
    "w": Parameter("wheel base", "m", _POSITIVE),
    "c": Parameter("trail", "m"),
    "lam": Parameter("steer axis tilt from the vertical", "rad", _HALF, takes_pi=True),
    "g": Parameter("gravity", "N/kg", _NONNEGATIVE),
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
    "roll": Parameter("lean of the rear wheel plane, right positive", "rad", _HALF, takes_pi=True),
    "steer": Parameter("steer angle, right positive", "rad", _TURN, takes_pi=True),
    "steer_rate": Parameter("steer rate, right positive", "rad/s", takes_pi=True),
    "duration": Parameter("length of the run", "s", _POSITIVE),
    "spacing": Parameter("time between two rows", "s", _POSITIVE),
}
"""The entries of a maneuver; speed, roll_rate, duration and spacing are required."""

PERFORMANCE_LIMIT = Parameter("upper limit on eq. (1) of the benchmark", "%", _POSITIVE)
"""An optional entry of a maneuver: the limit on eq. (1) of the benchmark, which does not affect the
motion."""

START = ("roll", "steer", "roll_rate", "steer_rate", "speed")
"""Initial conditions: the entries of a maneuver that describe the state at t = 0."""

_REQUIRED_OF_MANEUVER = ("speed", "roll_rate", "duration", "spacing")
_LIMIT = "performance_limit"
MAX_ROWS = 1_000_001
_TOP = {"name", "source", "sources"}
_KEYS_OF_ENTRY = {"value", "unit", "symbol", "source", "name"}


@dataclass(frozen=True)
class Bicycle:
    """A Carvallo-Whipple bicycle in exact numbers, SI units.

    Attributes
    ----------
    name : str
    values : mapping
        `Exact` by symbol (see `PARAMETERS`).
    warnings : tuple of str
        Unusual but usable values, such as an inertia matrix that no real body has.
    uncertainties : mapping
        Standard deviations by symbol, for values whose source states one. The bicycle is defined by
        its values alone.
    """

    name: str
    values: Mapping[str, Exact]
    warnings: tuple[str, ...] = field(default=(), compare=False)
    uncertainties: Mapping[str, Exact] = field(default_factory=dict, compare=False)

    @classmethod
    def parse(cls, name: str, texts: Mapping[str, str]) -> Bicycle:
        """Construct a bicycle from exact texts by symbol, as in `Reference.parameters`."""
        return cls(name, {symbol: Exact.parse(texts[symbol]) for symbol in PARAMETERS})

    def __getitem__(self, symbol: str) -> Exact:
        try:
            return self.values[symbol]
        except (KeyError, TypeError):
            said = unknown_word(symbol, list(self.values), "parameter ")
            raise KeyError(said) from None

    def replace(self, **changes: Exact) -> Bicycle:
        """Return a checked copy with some parameters changed; new values have no uncertainty."""
        # Untyped callers may pass any object.
        given: Mapping[str, object] = changes
        for symbol, x in given.items():
            if symbol not in PARAMETERS:
                raise InputError(
                    f"found unknown parameter {quoted(symbol)}, expected one of PARAMETERS"
                )
            if not isinstance(x, Exact) or not x.is_moderate:
                found = "a magnitude out of range" if isinstance(x, Exact) else type(x).__name__
                raise InputError(
                    f"{symbol}: found {found}, expected an Exact that is zero or between 1e-300 "
                    "and 1e300 in magnitude"
                )
        kept = {s: u for s, u in self.uncertainties.items() if s not in changes}
        return _checked_bicycle(self.name, {**self.values, **changes}, kept, TomlSource())


@dataclass(frozen=True)
class Maneuver:
    """An initial state and a time grid, in exact numbers.

    The pitch is not an input: it follows from roll and steer, both wheels touching the floor. The
    remaining rates (yaw, pitch, wheels) follow from rolling without slip.

    Attributes
    ----------
    name : str
    speed, roll_rate : Exact
        Initial forward speed [m/s] and roll rate [rad/s].
    duration, spacing : Fraction
        Time of the last row, and time between rows [s].
    roll, steer : Exact
        Initial angles [rad], positive to the right.
    steer_rate : Exact
        Initial steer rate [rad/s].
    performance_limit : Fraction or None
        Upper limit for eq. (1) of the benchmark [%], if it judges this maneuver. Maneuvers that
        differ only in this limit describe the same motion and compare equal.
    """

    name: str
    speed: Exact
    roll_rate: Exact
    duration: Fraction
    spacing: Fraction
    roll: Exact = ZERO
    steer: Exact = ZERO
    steer_rate: Exact = ZERO
    performance_limit: Fraction | None = field(default=None, compare=False)

    @classmethod
    def parse(cls, name: str, texts: Mapping[str, str]) -> Maneuver:
        """Construct a maneuver from exact texts, as in `ReferenceManeuver.inputs`."""
        values: dict[str, Any] = {key: Exact.parse(texts[key]) for key in STATE_INPUTS}
        duration, spacing = values.pop("duration"), values.pop("spacing")
        return cls(name, **values, duration=duration.fraction(), spacing=spacing.fraction())

    @property
    def rows(self) -> int:
        """Number of output rows, both ends included."""
        return int(self.duration / self.spacing) + 1

    def time(self, row: int) -> Fraction:
        """Return the exact time of a row [s]."""
        return row * self.spacing

    @property
    def is_straight(self) -> bool:
        """True if the bicycle starts upright, straight and without lateral rates."""
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
        The file is not readable or not valid TOML, or a parameter is missing, unknown, given twice,
        not a number, in a wrong unit, or outside the model's range. The error names the file and
        the key.
    """
    source = TomlSource.load(path)
    source.refuse_unknown(source.tree, _TOP | {"parameters"}, ())
    table = source.table("parameters")
    needed = {symbol: parameter.description for symbol, parameter in PARAMETERS.items()}
    source.refuse_unknown(table, PARAMETERS, ("parameters",), needed)
    values, uncertainties = {}, {}
    for symbol, parameter in PARAMETERS.items():
        entry, where = table[symbol], ("parameters", symbol)
        known = _KEYS_OF_ENTRY | {"uncertainty"}
        values[symbol], uncertainty = _read_value(source, entry, parameter, where, known)
        if uncertainty is not None:
            uncertainties[symbol] = uncertainty
    if "name" not in source.tree:
        raise source.error('found no name of the bicycle, expected name = "..." at the top')
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
        Maneuvers in the order of the file.

    Raises
    ------
    InputError
        As in `read_bicycle`; or two maneuvers have the same name.
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
                f"found {quoted(m.name)}, already the name of maneuver {first[m.name] + 1}, "
                "expected different names",
                ("maneuver", i, "name"),
            )
        first[m.name] = i
    return maneuvers


@cache
def benchmark() -> tuple[Bicycle, tuple[Maneuver, ...]]:
    """Return the benchmark's bicycle and its three maneuvers."""
    return read_bicycle(benchmark_bicycle()), read_maneuvers(benchmark_maneuvers())


Given = Bicycle | str | Path
"""A bicycle, the name of a bicycle of the collection, or the path of a TOML file."""


def read_inputs(
    bicycle: Given, maneuvers: Sequence[Maneuver] | str | Path | None
) -> tuple[Bicycle, Sequence[Maneuver]]:
    """Return a bicycle and its maneuvers, reading files where needed.

    Parameters
    ----------
    bicycle
    maneuvers
        Maneuvers, or their name or file; by default those of the bicycle's name, or the
        benchmark's.

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
    """Return bicycle and maneuvers as exact text, for the manifest and the files' attributes."""
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


def describe_limits(maneuvers: Iterable[Maneuver]) -> dict[str, str]:
    """Return limits of eq. (1) [%] as exact text, by maneuver number, for the manifest."""
    limits = ((str(n), m.performance_limit) for n, m in enumerate(maneuvers, 1))
    return {number: str(limit) for number, limit in limits if limit is not None}


def _read_maneuver(source: TomlSource, table: dict[str, Any], index: int) -> Maneuver:
    where = ("maneuver", index)
    needed = {key: STATE_INPUTS[key].description for key in _REQUIRED_OF_MANEUVER}
    known = {"name", "source", _LIMIT, *STATE_INPUTS}
    source.refuse_unknown(table, known, where, needed)
    values = {
        key: _read_value(source, table[key], parameter, (*where, key), _KEYS_OF_ENTRY)[0]
        for key, parameter in STATE_INPUTS.items()
        if key in table
    }
    for key, x in values.items():
        _check_range(source, x, STATE_INPUTS[key], (*where, key))
    duration, spacing = values["duration"].rational, values["spacing"].rational
    steps = duration / spacing
    if steps.denominator != 1:
        raise source.error(
            f"found {_show(values['duration'])} s, "
            f"expected a multiple of the spacing, {_show(values['spacing'])} s",
            (*where, "duration"),
        )
    if steps + 1 > MAX_ROWS:
        raise source.error(
            f"found more than {MAX_ROWS} rows, expected a longer spacing",
            (*where, "spacing"),
        )
    name = f"maneuver {index + 1}"
    if "name" in table:
        name = source.line_of_text(table, "name", where)
    if "source" in table:
        source.line_of_text(table, "source", where, limit=1000)
    limit = None
    if _LIMIT in table:
        x, _ = _read_value(
            source, table[_LIMIT], PERFORMANCE_LIMIT, (*where, _LIMIT), _KEYS_OF_ENTRY
        )
        _check_range(source, x, PERFORMANCE_LIMIT, (*where, _LIMIT))
        limit = x.rational
    start = {key: x for key, x in values.items() if key in START}
    return Maneuver(name, **start, duration=duration, spacing=spacing, performance_limit=limit)


def _read_value(
    source: TomlSource, entry: object, parameter: Parameter, where: Where, known: Collection[str]
) -> tuple[Exact, Exact | None]:
    """Read a number, alone or in a table with its unit; also return the standard deviation."""
    if not isinstance(entry, dict):
        return source.number(entry, where), None
    source.refuse_unknown(entry, known, where)
    if "value" not in entry:
        raise source.error("found a table without 'value', expected an entry 'value'", where)
    for note in ("name", "symbol", "source"):
        if note in entry:
            source.line_of_text(entry, note, where, limit=1000)
    unit = entry.get("unit", parameter.unit)
    size = factor(unit, parameter.unit) if isinstance(unit, str) else None
    # Accept % here, because the table of units lacks it: a percentage is not a unit of a quantity.
    size = Exact(Fraction(1)) if unit == parameter.unit == "%" else size
    if size is None:
        found = f"unit {quoted(unit)}" if isinstance(unit, str) else f"{kind(unit)} as unit"
        raise source.error(f"found {found}, expected '{parameter.unit}'", where)

    def in_si(name: str) -> Exact:
        at = (*where, name)
        x = source.number(entry[name], at)
        if not (x.is_rational or size.is_rational):
            message = f"found {_show(x)} {unit}, expected a number without pi"
            raise source.error(message, at)
        if not (found := x * size).is_moderate:
            raise source.error(
                f"found {_show(x)} {unit}, expected zero or a magnitude between 1e-300 and 1e300 "
                "in SI units",
                at,
            )
        return found

    value = in_si("value")
    if "uncertainty" not in entry:
        return value, None
    x = in_si("uncertainty")
    expected = ""
    if not x.is_rational and not parameter.takes_pi:
        expected = ", expected a number without pi"
    elif x.sign < 0:
        expected = f" {parameter.unit}, expected zero or more"
    if expected:
        raise source.error(f"found {_show(x)}{expected}", (*where, "uncertainty"))
    return value, x


def _check_range(source: TomlSource, x: Exact, parameter: Parameter, where: Where) -> None:
    """Raise an error if the model cannot use the value."""
    if not x.is_rational and not parameter.takes_pi:
        raise source.error(f"found {_show(x)}, expected a number without pi", where)
    if not _RANGES[parameter.expected](x):
        found = f"found {_show(x)} {parameter.unit}, expected {parameter.expected}"
        raise source.error(found, where, about=parameter.description)


def _show(x: Exact) -> str:
    return f"{float(x):.15g}"


def _checked_bicycle(
    name: str, values: Mapping[str, Exact], uncertainties: Mapping[str, Exact], source: TomlSource
) -> Bicycle:
    for symbol, x in values.items():
        _check_range(source, x, PARAMETERS[symbol], ("parameters", symbol))
    for a, b, what in (("mR", "mB", "rear"), ("mH", "mF", "front")):
        if values[a].is_zero and values[b].is_zero:
            raise source.error(
                f"found 0 kg, and 0 kg for {a} too, expected at least one of them above zero: the "
                f"{what} assembly needs a mass",
                ("parameters", b),
            )
    for letter in "BH":
        xx, _, zz, xz = _inertia(values, letter)
        if xx * zz < xz * xz:
            raise source.error(
                f"found {_show(Exact(xz))} kg m^2, expected at most the square root "
                f"of I{letter}xx I{letter}zz in magnitude, as in every inertia matrix",
                ("parameters", f"I{letter}xz"),
            )
    warnings = tuple(_inertia_warnings(values))
    return Bicycle(name, dict(values), warnings, dict(uncertainties))


def _inertia(values: Mapping[str, Exact], letter: str) -> tuple[Fraction, ...]:
    return tuple(values[f"I{letter}{ij}"].rational for ij in ("xx", "yy", "zz", "xz"))


def _inertia_warnings(values: Mapping[str, Exact]) -> Iterator[str]:
    """Yield a warning for inertias that no solid body has; idealised bicycles need them."""
    for letter in "BH":
        xx, yy, zz, xz = _inertia(values, letter)
        if xx * zz == xz * xz or yy == 0:
            yield f"inertia matrix of {letter} is only semidefinite"
        # Triangle inequalities of yy and the principal moments p <= q in the xz plane, namely
        # q <= p + yy, and yy <= p + q.
        if yy > xx + zz or (xx - zz) ** 2 + 4 * xz**2 > yy**2:
            yield f"moments of inertia of {letter} violate the triangle inequality"
    for letter in "RF":
        xx, yy = (values[f"I{letter}{ij}"].rational for ij in ("xx", "yy"))
        if xx == 0 or yy == 0:
            yield f"inertia matrix of {letter} is only semidefinite"
        if yy > 2 * xx:
            yield f"moments of inertia of {letter} violate the triangle inequality"
