"""Check, score and rank the submissions in a folder.

Score every submission in a folder and rank them by true error, problem by problem (H1 to H4,
docs/harder-tier.md). A submission is a file NAME.toml next to its result files. It states program,
version, method, coordinates, precision, step or tolerance, processor time, machine, licence,
contact, and the path and sha256 of each file. A submission that breaks a rule (a changed file, a
missing row or maneuver) is rejected with one line; the others are still ranked.

examples:
  heyoka-bike leaderboard data/results
  heyoka-bike leaderboard data/results -o board.html --diagnose
  heyoka-bike leaderboard mine --reference sets/harder/longer --format json

exit code 3 if a submission is rejected. How to submit: docs/how-to/leaderboard.md
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from heyoka_bike.commands import options
from heyoka_bike.commands.printing import print_blocks, print_text
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.system.console import progress_bar
from heyoka_bike.system.log import complain

_FORMAT_OF_SUFFIX = {".json": "json", ".html": "html", ".htm": "html"}


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    said = {
        "FOLDER": "folder of submissions",
        "-o --output FILE": "file to write (.html or .json)",
    }
    p = options.add_command(subparsers, run, __doc__, said)
    options.add_format(
        p, ("table", "json", "html"), "default: table, or with -o the format of its suffix"
    )
    how = {
        "--reference DIR...": "folder of the dataset of H2, H3 or H4; may be repeated (that of H1 "
        "is included)",
        "--diagnose": "also diagnose each submission, as 'diagnose' does (about ten seconds each)",
    }
    options.add_arguments(p, how)
    options.add_workers(p)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    name = _format(args)
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.showing.document import html
    from heyoka_bike.showing.wording.origin_text import origin
    from heyoka_bike.system.files import write_output
    from heyoka_bike.workbench.leaderboard.document import document, render_json
    from heyoka_bike.workbench.leaderboard.ranking import leaderboard

    references = [load_reference(), *map(load_reference, args.reference)]
    with progress_bar("scoring") as progress:
        board = leaderboard(args.folder, references, progress, is_diagnosed=args.diagnose)
    found = document(board, origin(args.words))
    if name == "table":
        print_blocks(*found.blocks)
    else:
        said = render_json(board) if name == "json" else html.render(found)
        if args.output:
            write_output(Path(args.output), said.encode())
        else:
            print_text(said)
    for line in board.refused:
        complain(line)
    return Exit.CHECK_FAILED if board.refused else Exit.OK


def _format(args: argparse.Namespace) -> str:
    """Return the format of the output; without --format, the suffix of the file determines it."""
    if args.output is None:
        return args.format or "table"
    found = args.format or _FORMAT_OF_SUFFIX.get(Path(args.output).suffix.lower())
    if found in (None, "table"):
        raise InputError(
            f"--output: found '{Path(args.output).name}', expected a name ending in "
            f"{', '.join(_FORMAT_OF_SUFFIX)}, or --format json or html"
        )
    return str(found)
