"""Matrices, eigenvalues, weave and capsize speed of the linearised bicycle.

Linearise the nonlinear model about upright straight running, M q'' + v C1 q' + (g K0 + v^2 K2) q =
0 with q = (roll, steer), and print the matrices, the eigenvalues over speed, and the speeds between
which it is stable.

example: heyoka-bike linear --digits 30 --speeds 4:6:0.5
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands.options import add_bicycle, add_command, add_format
from heyoka_bike.commands.printing import complain, print_blocks
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.registry import addition

if TYPE_CHECKING:
    from heyoka_bike.bicycle.stability.linear import Linearisation
    from heyoka_bike.showing.document import Block

_MAX_SPEEDS = 10_001

_UNITS = {"M": "kg m^2", "C1": "kg m", "K0": "kg m", "K2": "kg"}

_Spectrum = Sequence[tuple[Fraction, Sequence[Any]]]


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = add_command(subparsers, run, __doc__)
    p.add_argument(
        "--digits",
        type=int,
        default=15,
        metavar="N",
        help="significant decimal digits, 5 to 1000 (default 15)",
    )
    add_bicycle(p)
    p.add_argument(
        "--speeds",
        default="0:10:1",
        metavar="LIST",
        help="speeds of the eigenvalues [m/s], 0,4.6,8 or first:last:step (default 0:10:1)",
    )
    p.add_argument(
        "--uncertainty",
        nargs="?",
        const="1",
        metavar="SIGMAS",
        help="prove between which speeds weave and capsize lie if every parameter may be so many "
        "of its standard deviations off (default 1), and where all such bicycles are stable",
    )
    add_format(p, ("table", "json"), default="table")


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.bicycle.parameters import read_bicycle
    from heyoka_bike.bicycle.stability.linear import MAX_DIGITS, MIN_DIGITS, linearise
    from heyoka_bike.system.resources import find_input

    if not MIN_DIGITS <= args.digits <= MAX_DIGITS:
        raise InputError(f"--digits: found {args.digits}, expected {MIN_DIGITS} to {MAX_DIGITS}")
    speeds = parse_speeds(args.speeds)
    bicycle = read_bicycle(find_input("bicycles", args.bicycle))
    for warning in bicycle.warnings:
        complain(f"warning: {bicycle.name}: {warning}")
    box = None
    if args.uncertainty is not None:
        box = addition("uncertain_stability")(bicycle, args.uncertainty, args.digits)
    linear = linearise(bicycle, args.digits)
    spectrum = [(v, linear.eigenvalues(v)) for v in speeds]
    if args.format == "json":
        document: dict[str, object] = {"bicycle": bicycle.name, **_as_json(linear, spectrum)}
        if box is not None:
            document["uncertainty"] = box.as_json()
        print(json.dumps(document, indent=2))
    else:
        print(bicycle.name)
        print("M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 with q = (roll, steer)")
        print(f"g = {_text(linear.g, linear.digits)} N/kg", end="\n\n")
        print_blocks(*_blocks(linear, spectrum), *(() if box is None else box.blocks()))
    return Exit.OK


def parse_speeds(text: str) -> list[Fraction]:
    """Speeds [m/s] of a list such as ``0,4.6,8`` or of ``first:last:step``.

    A range ends at the last speed if a whole number of steps leads there, else before it.

    Raises
    ------
    InputError
        The text is neither, or names more than 10001 speeds.
    """
    if ":" not in text:
        return [_speed(part) for part in text.split(",")]
    parts = [_speed(part) for part in text.split(":")]
    if len(parts) != 3:
        raise InputError(f"--speeds: found '{text}', expected first:last:step")
    first, last, step = parts
    if step <= 0 or last < first:
        raise InputError(
            f"--speeds: found '{text}', expected a positive step and a last speed not below the "
            "first"
        )
    steps = (last - first) // step
    if steps >= _MAX_SPEEDS:
        raise InputError(f"--speeds: found {steps + 1} speeds, expected at most {_MAX_SPEEDS}")
    return [first + i * step for i in range(steps + 1)]


def _speed(text: str) -> Fraction:
    from heyoka_bike.numbers.exact import Exact

    try:
        return Exact.parse(text).fraction()
    except ValueError:
        raise InputError(
            f"--speeds: found '{text.strip()}', expected numbers such as 0,4.6,8 or a range such "
            "as 0:10:0.5"
        ) from None


def _text(x: Any, digits: int) -> str:
    """Decimal text with all digits, zeros at the end included; zero itself is 0."""
    import mpmath

    return str(mpmath.nstr(x, digits, strip_zeros=False)) if x else "0"


def _speed_text(v: Fraction, digits: int) -> str:
    """Decimal text of a given speed: exact where that is not long."""
    import mpmath

    if v.denominator == 1:
        return str(v)
    with mpmath.workdps(digits + 20):
        return str(mpmath.nstr(mpmath.mpf(v.numerator) / v.denominator, digits + 10))


def _as_json(linear: Linearisation, spectrum: _Spectrum) -> dict[str, object]:
    """Every number as a decimal string."""

    def text(x: Any) -> str:
        return _text(x, linear.digits)

    return {
        "digits": linear.digits,
        "g": text(linear.g),
        **{name: [[text(x) for x in row] for row in getattr(linear, name)] for name in _UNITS},
        "eigenvalues": [
            {
                "speed": _speed_text(v, linear.digits),
                "eigenvalues": [{"re": text(s.real), "im": text(s.imag)} for s in values],
            }
            for v, values in spectrum
        ],
        "weave": [{"speed": text(v), "frequency": text(w)} for v, w in linear.weave_speeds],
        "capsize": [{"speed": text(v)} for v in linear.capsize_speeds],
        "double_roots": [{"speed": text(v), "eigenvalue": text(s)} for v, s in linear.double_roots],
        "stable_ranges": [
            {"from": text(low), "to": None if high is None else text(high)}
            for low, high in linear.stable_ranges
        ],
    }


def _blocks(linear: Linearisation, spectrum: _Spectrum) -> tuple[Block, ...]:
    """The linearisation and its spectrum as tables."""
    from heyoka_bike.showing.document import TableBlock

    def text(x: Any) -> str:
        return _text(x, linear.digits)

    matrices = [
        ["" if i else f"{name} [{unit}]", equation, *map(text, getattr(linear, name)[i])]
        for name, unit in _UNITS.items()
        for i, equation in enumerate(("roll", "steer"))
    ]
    eigenvalues = [
        ["" if i else _speed_text(v, linear.digits), text(s.real), text(s.imag)]
        for v, values in spectrum
        for i, s in enumerate(values)
    ]
    heading = ("speed [m/s]", "eigenvalue, real part [1/s]", "imaginary part [rad/s]")
    critical = (
        (("weave speed [m/s]", "weave frequency [rad/s]"), linear.weave_speeds),
        (("capsize speed [m/s]",), [(v,) for v in linear.capsize_speeds]),
        (("double root, speed [m/s]", "double root, eigenvalue [1/s]"), linear.double_roots),
        (("stable from [m/s]", "stable to [m/s]"), linear.stable_ranges),
    )
    rows = [
        [quantity, "no end" if x is None else text(x)]
        for quantities, found in critical
        for values in found
        for quantity, x in zip(quantities, values, strict=True)
    ]
    rows += [[quantities[0], "none"] for quantities, found in critical if not found]
    return (
        TableBlock(("matrix", "equation", "of roll", "of steer"), matrices, left=2, group=2),
        TableBlock(heading, eigenvalues, group=4),
        TableBlock(("critical speeds", "value"), rows),
    )
