"""Replay the maneuvers in 3D, with a result file next to the reference.

Write a web page that replays the maneuvers: the bicycle in perspective with its tracks, and roll,
steer, speed and energies over time. The motion in a result file (see 'heyoka-bike score') appears
as a second, translucent bicycle. The page is a single file and needs no network.

examples:
  heyoka-bike animate
  heyoka-bike animate my-results.txt -o replay.html
  heyoka-bike animate --maneuver 2 -o maneuver-2.html
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from heyoka_bike.commands import options
from heyoka_bike.errors import Exit

_DEFAULT = "uncontrolled-bicycle.html"


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    said = {
        "[FILE]": "result file; - is standard input",
        "-o --output FILE": f"HTML file to write (default ./{_DEFAULT})",
    }
    p = options.add_command(subparsers, run, __doc__, said)
    options.add_format(p, ("html",), "")
    which = (
        "show only this maneuver; also the maneuver in a file that contains only one (default: all)"
    )
    options.add_arguments(p, {"--maneuver N": which, **options.REFERENCE})


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.commands.result_files import maneuvers_of
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.scoring.reading.source import read_results
    from heyoka_bike.system.files import refuse_overwriting, write_output
    from heyoka_bike.workbench.replay.page import check_suffix, render
    from heyoka_bike.workbench.replay.scenes import replay

    path = Path(_DEFAULT if args.output is None else args.output)
    if args.format is None:
        check_suffix(path, "--output")
    if args.file is not None:
        refuse_overwriting([args.file], [path])
    reference = load_reference(args.reference)
    (maneuver,) = maneuvers_of(args.maneuver, 1, reference)
    results = None
    if args.file is not None:
        results = read_results(args.file, maneuver=maneuver, count=len(reference))
    name = "standard input" if args.file == "-" else args.file or ""
    write_output(path, render(replay(reference, results, maneuver), name).encode())
    print(path)
    return Exit.OK
