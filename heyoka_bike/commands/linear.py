"""Matrices, eigenvalues, weave and capsize speed of the linearised bicycle.

Linearise the model about upright straight running: M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 with q =
(roll, steer). Print the matrices, the eigenvalues at the given speeds, the weave and capsize
speeds, and the speed ranges in which the bicycle is stable.

example: heyoka-bike linear --digits 30 --speeds 4:6:0.5
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands import options
from heyoka_bike.commands.printing import print_blocks
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.system.log import complain

if TYPE_CHECKING:
    from heyoka_bike.bicycle.parameters import Bicycle
    from heyoka_bike.bicycle.stability.linear import Linearisation
    from heyoka_bike.showing.document import Block

_MAX_SPEEDS = 10_001

_UNITS_OF_MATRICES = {"M": "kg m^2", "C1": "kg m", "K0": "kg m", "K2": "kg"}

_CRITICAL = {
    "weave": ("weave speed [m/s]", "weave frequency [rad/s]"),
    "capsize": ("capsize speed [m/s]",),
    "double_roots": ("double root, speed [m/s]", "double root, eigenvalue [1/s]"),
    "stable_ranges": ("stable from [m/s]", "stable to [m/s]"),
}
"""Headings of the critical speeds, by their key in JSON."""

_Document = dict[str, Any]


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = options.add_command(subparsers, run, __doc__)
    said = {
        "--digits N": "significant decimal digits, 5 to 1000 (default 15)",
        **options.BICYCLE,
        "--speeds LIST 0:10:1": "speeds at which to compute eigenvalues [m/s]: a list such as "
        "0,4.6,8, or first:last:step (default 0:10:1)",
        "--uncertainty SIGMAS": "prove bounds on the weave and capsize speeds of all bicycles "
        "whose parameters lie within SIGMAS standard deviations (default 1), and the speeds at "
        "which all of them are stable",
    }
    digits, sigmas = {"type": int, "default": 15}, {"nargs": "?", "const": "1"}
    options.add_arguments(p, said, digits=digits, uncertainty=sigmas)
    options.add_format(p, ("table", "json"))


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
        from heyoka_bike.workbench.boxes.box import uncertain_stability

        box = uncertain_stability(bicycle, args.uncertainty, args.digits)
    found = _document(bicycle, linearise(bicycle, args.digits), speeds)
    if args.format == "json":
        found |= {} if box is None else {"uncertainty": box.as_json()}
        print(json.dumps(found, indent=2))
    else:
        print(bicycle.name)
        print("M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 with q = (roll, steer)")
        print(f"g = {found['g']} N/kg", end="\n\n")
        print_blocks(*_blocks(found), *(() if box is None else box.blocks()))
    return Exit.OK


def parse_speeds(text: str) -> list[Fraction]:
    """Return the speeds [m/s] of a list such as ``0,4.6,8`` or of a range ``first:last:step``.

    A range includes its last speed if a whole number of steps leads there.

    Raises
    ------
    InputError
        The text is neither a list nor a range, or a range has more than 10001 speeds.
    """
    if ":" not in text:
        return [_speed(part) for part in text.split(",")]
    parts = [_speed(part) for part in text.split(":")]
    if len(parts) != 3:
        raise InputError(f"--speeds: found '{text}', expected first:last:step")
    first, last, step = parts
    if step <= 0 or last < first:
        raise InputError(
            f"--speeds: found '{text}', expected a positive step and a last speed that is at least "
            "the first"
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
    """Return a number as a decimal with all digits, including trailing zeros; zero is ``0``."""
    import mpmath

    return str(mpmath.nstr(x, digits, strip_zeros=False)) if x else "0"


def _speed_text(v: Fraction, digits: int) -> str:
    """Return a given speed as a decimal: exact if it is whole, else with 10 more digits."""
    import mpmath

    if v.denominator == 1:
        return str(v)
    with mpmath.workdps(digits + 20):
        return str(mpmath.nstr(mpmath.mpf(v.numerator) / v.denominator, digits + 10))


def _document(bicycle: Bicycle, linear: Linearisation, speeds: Sequence[Fraction]) -> _Document:
    """Return the linearisation, and its eigenvalues [1/s] at speeds [m/s], as decimal texts."""

    def text(x: Any) -> str:
        return _text(x, linear.digits)

    return {
        "bicycle": bicycle.name,
        "digits": linear.digits,
        "g": text(linear.g),
        **{
            name: [[text(x) for x in row] for row in getattr(linear, name)]
            for name in _UNITS_OF_MATRICES
        },
        "eigenvalues": [
            {
                "speed": _speed_text(v, linear.digits),
                "eigenvalues": [
                    {"re": text(s.real), "im": text(s.imag)} for s in linear.eigenvalues(v)
                ],
            }
            for v in speeds
        ],
        "weave": [{"speed": text(v), "frequency": text(w)} for v, w in linear.weave_speeds],
        "capsize": [{"speed": text(v)} for v in linear.capsize_speeds],
        "double_roots": [{"speed": text(v), "eigenvalue": text(s)} for v, s in linear.double_roots],
        "stable_ranges": [
            {"from": text(low), "to": None if high is None else text(high)}
            for low, high in linear.stable_ranges
        ],
    }


def _blocks(found: _Document) -> tuple[Block, ...]:
    """Return the document as tables."""
    from heyoka_bike.showing.document import TableBlock

    matrices = [
        ["" if i else f"{name} [{unit}]", equation, *found[name][i]]
        for name, unit in _UNITS_OF_MATRICES.items()
        for i, equation in enumerate(("roll", "steer"))
    ]
    eigenvalues = [
        ["" if i else at["speed"], s["re"], s["im"]]
        for at in found["eigenvalues"]
        for i, s in enumerate(at["eigenvalues"])
    ]
    heading = ("speed [m/s]", "eigenvalue, real part [1/s]", "imaginary part [rad/s]")
    rows = [
        [quantity, value or "no end"]
        for key, quantities in _CRITICAL.items()
        for values in found[key]
        for quantity, value in zip(quantities, values.values(), strict=True)
    ]
    rows += [[quantities[0], "none"] for key, quantities in _CRITICAL.items() if not found[key]]
    return (
        TableBlock(("matrix", "equation", "of roll", "of steer"), matrices, left=2, group=2),
        TableBlock(heading, eigenvalues, group=4),
        TableBlock(("critical speeds", "value"), rows),
    )
