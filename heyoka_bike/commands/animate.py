"""``heyoka-bike animate``: a replay of the maneuvers, and of a result file beside them."""

from __future__ import annotations

import argparse
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from heyoka_bike.commands.options import add_reference
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.showing.replay import FORMATS, SUFFIXES
from heyoka_bike.system.console import progress_bar

_DEFAULT = "uncontrolled-bicycle"


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = subparsers.add_parser(
        "animate",
        help="replay the maneuvers in 3D, a result file beside the reference",
        description=(
            "Write a replay of the maneuvers: the bicycle in perspective with its tracks, and "
            "roll, steer, speed and energies over time. A result file (see 'heyoka-bike score') is "
            "laid over as a second, translucent bicycle. The page is one file that needs no "
            "network; .gif and .mp4 are for slides, of one maneuver, and need matplotlib (pip "
            'install "heyoka_bike[plot]"), .mp4 also ffmpeg.'
        ),
        epilog="examples:\n"
        "  heyoka-bike animate\n"
        "  heyoka-bike animate my-results.txt -o replay.html\n"
        "  heyoka-bike animate --maneuver 2 -o maneuver-2.gif\n",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    p.add_argument("file", metavar="FILE", nargs="?", help="result file; - is standard input")
    p.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help=f"file to write, its format by the suffix (default ./{_DEFAULT}.html)",
    )
    p.add_argument(
        "--format", metavar="FORMAT", choices=FORMATS, help=f"one of {', '.join(FORMATS)}"
    )
    p.add_argument(
        "--maneuver",
        metavar="N",
        help="show this one, which a file of one maneuver then holds (default: all; of a film: the "
        "first)",
    )
    add_reference(p)
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.commands.result_files import maneuvers_of
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.scoring.reading import read_results
    from heyoka_bike.showing.replay.animate import rendered
    from heyoka_bike.showing.replay.film import RATES
    from heyoka_bike.showing.replay.scenes import RATE, replay
    from heyoka_bike.system.files import refuse_overwriting, write_output

    path, file_format = _output(args)
    if args.file is not None:
        refuse_overwriting([args.file], [path])
    reference = load_reference(args.reference)
    (maneuver,) = maneuvers_of(args.maneuver, 1, reference)
    results = None
    if args.file is not None:
        results = read_results(args.file, maneuver=maneuver, count=len(reference))
    name = "standard input" if args.file == "-" else args.file or ""
    found = replay(reference, results, maneuver, RATES.get(file_format, RATE))
    with progress_bar("drawing frames") if file_format in RATES else nullcontext() as progress:
        data = rendered(found, file_format, name, progress)
    write_output(path, data)
    print(path)
    return Exit.OK


def _output(args: argparse.Namespace) -> tuple[Path, str]:
    """The file to write, and its format."""
    if args.output is None:
        chosen = args.format or FORMATS[0]
        return Path(f"{_DEFAULT}.{chosen}"), chosen
    path = Path(args.output)
    by_suffix = SUFFIXES.get(path.suffix.lower())
    if args.format is None and by_suffix is None:
        raise InputError(
            f"--output: found '{path.name}', expected a name ending in {', '.join(SUFFIXES)}"
        )
    if args.format is not None and by_suffix not in (None, args.format):
        raise InputError(f"--format: found {args.format} for the file '{path.name}'")
    return path, args.format or by_suffix or FORMATS[0]
