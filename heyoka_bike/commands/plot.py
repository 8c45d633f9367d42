"""``heyoka-bike plot``: draw the figures of a reference set."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from heyoka_bike.commands.options import lists
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.registry import addition
from heyoka_bike.showing.figures import ALL, ATLAS, DEFAULT, FIGURES, plates

_DEFAULT_FOLDER = "figures"
_PAGES = (".html", ".htm")


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    width = max(map(len, FIGURES))
    about = {name: kind.about for name, kind in FIGURES.items()}
    about[ATLAS] = "the map of an atlas (DIR), or with a name ending in .html its page"
    listed = "\n".join(f"  {name:{width}}  {text}" for name, text in about.items())
    p = subparsers.add_parser(
        "plot",
        help="draw the maneuvers, and figures of errors, definitions, stability and more",
        description=(
            "Draw figures of a reference set, by default each maneuver: roll and steer angles and\n"
            "their rates, forward speed, and the energies over time (figures 2 to 4 of the\n"
            'benchmark). Needs matplotlib: pip install "heyoka_bike[plot]".'
        ),
        epilog=(
            f"figures:\n{listed}\n\nexamples:\n"
            "  heyoka-bike plot --maneuver 2 -o maneuver-2.pdf\n"
            "  heyoka-bike plot --figure bicycle -o bicycle.svg\n"
            "  heyoka-bike plot --figure atlas benchmark.zarr -o atlas.svg\n"
            "  heyoka-bike plot --figure atlas benchmark.zarr -o atlas.html\n\n"
            "The page of an atlas (see 'heyoka-bike atlas') is one file that needs no network: a\n"
            "map, in which a start that is chosen opens its replay, computed there."
        ),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    p.add_argument(
        "reference",
        metavar="DIR",
        nargs="?",
        help="folder of the reference set (default: the published one), or of an atlas",
    )
    figure = p.add_argument(
        "--figure",
        metavar="NAME",
        default=DEFAULT,
        help=f"what to draw, see below, or {ALL} (default {DEFAULT})",
    )
    lists(figure, [*FIGURES, ATLAS, ALL])
    p.add_argument(
        "-o",
        "--output",
        metavar="FILE_OR_FOLDER",
        default=_DEFAULT_FOLDER,
        help="folder, or the file of a single figure, its format by the suffix "
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
    p.add_argument(
        "--maneuver",
        metavar="N",
        type=int,
        help="draw this one (default: all, in errors and definitions 1)",
    )
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    if args.figure == ATLAS:
        return _atlas(args)
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.showing.figures.style import save

    _check_formats(args)
    reference = load_reference(args.reference)
    chosen = plates(reference, args.figure, args.maneuver)
    paths = _paths(args, [plate.name for plate in chosen])
    for plate, files in zip(chosen, paths, strict=True):
        figure = plate.draw(reference)
        for path in files:
            save(figure, path)
            print(path)
    return Exit.OK


def _atlas(args: argparse.Namespace) -> int:
    """The map of an atlas, or its page."""
    from heyoka_bike.showing.figures.style import save
    from heyoka_bike.system.files import write_output

    is_page = args.output.lower().endswith(_PAGES)
    if args.maneuver is not None:
        raise InputError(f"--maneuver: expected none for {'the page of ' * is_page}an atlas")
    if args.reference is None:
        raise InputError("--figure: found atlas without one, expected its folder (DIR)")
    if is_page and args.formats is not None:
        raise InputError("--format: expected none for the page of an atlas")
    _check_formats(args)
    paths = [Path(args.output)] if is_page else _paths(args, [ATLAS])[0]
    if is_page:
        write_output(paths[0], addition("atlas_page")(args.reference).encode())
    else:
        figure = addition("atlas_figure")(args.reference)
        for path in paths:
            save(figure, path)
    for path in paths:
        print(path)
    return Exit.OK


def _check_formats(args: argparse.Namespace) -> None:
    from heyoka_bike.showing.figures.style import FORMATS

    for found in args.formats or ():
        if found not in FORMATS:
            raise InputError(
                f"--format: found '{found}', expected one or more of {', '.join(FORMATS)} "
                "(DIR goes before --format)"
            )


def _paths(args: argparse.Namespace, names: Sequence[str]) -> list[list[Path]]:
    """Files to write of each figure."""
    from heyoka_bike.showing.figures.plot import paths_of

    hint = ", or --maneuver N" if args.figure == DEFAULT else ""
    return paths_of(args.output, names, args.formats, option="--output", hint=hint)
