"""Draw the maneuvers, phase portraits, eigenvalues over speed, or an atlas.

Draw figures of a dataset. By default, one figure for each maneuver: roll and steer angles and their
rates, forward speed, and the energies over time. For the benchmark these are figures 2 to 4 of its
publication. Needs matplotlib: pip install "heyoka_bike[plot]".

figures:
$figures

examples:
  heyoka-bike plot --maneuver 2 -o maneuver-2.pdf
  heyoka-bike plot --figure phase -o phase.svg
  heyoka-bike plot --figure atlas benchmark.zarr -o atlas.svg
  heyoka-bike plot --figure atlas benchmark.zarr -o atlas.html

The page of an atlas (see 'heyoka-bike atlas') is a single file that needs no network. It shows a
map; a click on a point of the map computes the motion from there in the browser and replays it.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from heyoka_bike.commands import options
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.workbench.figures import ALL, ATLAS, DEFAULT, FIGURES, drawn, written
from heyoka_bike.workbench.style import FORMATS

_PAGES = (".html", ".htm")


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    width = max(map(len, FIGURES))
    about = {name: kind.about for name, kind in FIGURES.items()}
    about[ATLAS] = "map of the atlas in DIR; a name ending in .html writes its interactive page"
    listed = "\n".join(f"  {name:{width}}  {text}" for name, text in about.items())
    said = {
        "[DIR]": "folder of a dataset (default: the published one) or of an atlas",
        f"--figure NAME {DEFAULT}": f"figure to draw, see below, or {ALL} (default {DEFAULT})",
        "-o --output FILE_OR_FOLDER figures": "folder, or file for a single figure, whose suffix "
        "sets the format (default ./figures)",
    }
    p = options.add_command(subparsers, run, __doc__, said, figures=listed)
    options.lists(p, "figure", [*FIGURES, ATLAS, ALL])
    options.add_formats(p, FORMATS, "several may be given, after DIR (default png svg)", nargs="+")
    options.add_arguments(
        p, {"--maneuver N": "draw only this maneuver (default: all)"}, maneuver={"type": int}
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.system.files import write_output

    if args.figure == ATLAS:
        is_page = args.output.lower().endswith(_PAGES)
        if args.maneuver is not None:
            raise InputError(
                f"--maneuver cannot be used with {'the page of ' * is_page}an atlas, which has no "
                "maneuvers"
            )
        if args.dir is None:
            raise InputError("--figure atlas needs DIR, the folder of the atlas")
        if is_page:
            if args.formats is not None:
                raise InputError("--format cannot be used with the page of an atlas")
            from heyoka_bike.workbench.atlas.page.page import atlas_page

            write_output(Path(args.output), atlas_page(args.dir).encode())
            print(args.output)
            return Exit.OK
    every = drawn(args.figure, args.maneuver, args.dir, args.output, args.formats, dashes="--")
    for path in written(every):
        print(path)
    return Exit.OK
