"""``heyoka-bike plot``: draw the maneuvers of a reference set."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heyoka_bike.errors import Exit, InputError

if TYPE_CHECKING:
    from heyoka_bike.reference import Reference

_DEFAULT_FOLDER = "figures"
_DEFAULT_FORMATS = ("png", "svg")


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = subparsers.add_parser(
        "plot",
        help="draw roll, steer, speed and energies of the reference",
        description=(
            "Draw each maneuver of a reference set: roll and steer angles and their rates, forward "
            "speed, and the energies over time (figures 2 to 4 of the benchmark). Needs "
            'matplotlib: pip install "heyoka_bike[plot]".'
        ),
        epilog="example: heyoka-bike plot --maneuver 2 -o maneuver-2.pdf",
    )
    p.add_argument(
        "reference",
        metavar="DIR",
        nargs="?",
        help="folder of the reference set (default: the published one)",
    )
    p.add_argument(
        "-o",
        "--output",
        metavar="FILE_OR_FOLDER",
        default=_DEFAULT_FOLDER,
        help="folder, or the file of a single maneuver, its format by the suffix "
        f"(default ./{_DEFAULT_FOLDER})",
    )
    p.add_argument(
        "--format",
        metavar="FORMAT",
        dest="formats",
        action="extend",
        nargs="+",
        help="one or more of png, svg, pdf (default png svg)",
    )
    p.add_argument("--maneuver", metavar="N", type=int, help="draw this one (default: all)")
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.plot import draw, save
    from heyoka_bike.reference import load_reference

    _check_formats(args)
    reference = load_reference(args.reference)
    numbers = _numbers(args, reference)
    paths = _paths(args, numbers)
    for number in numbers:
        figure = draw(reference[number])
        for path in paths[number]:
            save(figure, path)
            print(path)
    return Exit.OK


def _check_formats(args: argparse.Namespace) -> None:
    from heyoka_bike.plot import FORMATS

    for found in args.formats or ():
        if found not in FORMATS:
            raise InputError(
                f"--format: found '{found}', expected one or more of {', '.join(FORMATS)} "
                "(DIR goes before --format)"
            )


def _numbers(args: argparse.Namespace, reference: Reference) -> list[int]:
    if args.maneuver is None:
        return list(reference)
    if args.maneuver not in reference:
        raise InputError(f"--maneuver: found {args.maneuver}, expected 1 to {len(reference)}")
    return [args.maneuver]


def _paths(args: argparse.Namespace, numbers: list[int]) -> dict[int, list[Path]]:
    """Files to write for each maneuver."""
    from heyoka_bike.plot import FORMATS

    out = Path(args.output)
    if out.is_dir() or not out.suffix or args.output.endswith("/"):
        formats = dict.fromkeys(args.formats or _DEFAULT_FORMATS)
        return {n: [out / f"maneuver_{n}.{f}" for f in formats] for n in numbers}
    if out.suffix.removeprefix(".").lower() not in FORMATS:
        raise InputError(
            f"--output: found '{out.name}', expected a file ending in "
            f"{', '.join(f'.{f}' for f in FORMATS)}, or a folder (with a final / if it has a dot)"
        )
    if args.formats is not None:
        raise InputError("--format: expected only with a folder, a file's suffix is its format")
    if len(numbers) > 1:
        raise InputError(
            f"--output: found the file '{out.name}' for {len(numbers)} maneuvers, expected a "
            "folder, or --maneuver N"
        )
    return {numbers[0]: [out]}
