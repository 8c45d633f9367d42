"""``heyoka-bike leaderboard``: check, score and rank submissions."""

from __future__ import annotations

import argparse
import sys
import textwrap
from pathlib import Path
from typing import Any

from heyoka_bike.commands.options import add_workers
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.system.console import print_table, progress_bar, table

_FORMATS = ("table", "json", "html")
_WIDTH = 92  # as the pages of the documentation have room for
_SUFFIXES = {".json": "json", ".html": "html", ".htm": "html"}


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = subparsers.add_parser(
        "leaderboard",
        help="check, score and rank the submissions in a folder",
        description=(
            "Score every submission in a folder and rank them by true error, problem by problem "
            "(H1 to H4, docs/harder-tier.md). A submission is NAME.toml beside its result files: "
            "program, version, method, coordinates, precision, step or tolerance, processor time, "
            "machine, licence, contact, and path and sha256 of each file. What breaks a rule "
            "(a file that changed, a row or a maneuver that is missing) is refused with one line, "
            "and does not stop the others."
        ),
        epilog=(
            "examples:\n"
            "  heyoka-bike leaderboard data/results\n"
            "  heyoka-bike leaderboard data/results -o board.html --diagnose\n"
            "  heyoka-bike leaderboard mine --reference sets/harder/longer --format json\n"
            "\n"
            "exit code 3 if a submission is refused. How to submit: docs/how-to/leaderboard.md\n"
        ),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    p.add_argument("folder", metavar="FOLDER", help="folder of submissions")
    p.add_argument("-o", "--output", metavar="FILE", help="write to this file (.html or .json)")
    p.add_argument(
        "--format",
        metavar="FORMAT",
        choices=_FORMATS,
        help=f"one of {', '.join(_FORMATS)} (default: table)",
    )
    p.add_argument(
        "--reference",
        metavar="DIR",
        action="append",
        default=[],
        help="folder of a set of H2, H3 or H4; may be repeated (that of H1 is here)",
    )
    p.add_argument(
        "--diagnose",
        action="store_true",
        help="say of each what goes wrong, as 'diagnose' does (about ten seconds for each)",
    )
    add_workers(p)
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    name = _format(args)
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.scoring.leaderboard import leaderboard
    from heyoka_bike.showing.formats.leaderboard import render_html, render_json
    from heyoka_bike.showing.formats.origin import origin
    from heyoka_bike.system.files import write_output

    finish = {}
    if args.diagnose:
        from heyoka_bike.scoring.diagnosis.diagnose import diagnosed_elsewhere

        finish = {"finish": diagnosed_elsewhere}
    references = [load_reference(), *map(load_reference, args.reference)]
    with progress_bar("scoring") as progress:
        board = leaderboard(args.folder, references, progress, **finish)
    if name == "table":
        _print(board)
    else:
        text = render_json(board) if name == "json" else render_html(board, origin(args.words))
        if args.output:
            write_output(Path(args.output), text.encode())
        else:
            print(text, end="")
    for line in board.refused:
        print(f"heyoka-bike: {line}", file=sys.stderr)
    return Exit.CHECK_FAILED if board.refused else Exit.OK


def _format(args: argparse.Namespace) -> str:
    """Of the output; that of a file follows from its suffix."""
    if args.output is None:
        return args.format or "table"
    found = args.format or _SUFFIXES.get(Path(args.output).suffix.lower())
    if found in (None, "table"):
        raise InputError(
            f"--output: found '{Path(args.output).name}', expected a name ending in "
            f"{', '.join(_SUFFIXES)}, or --format json or html"
        )
    return str(found)


def _print(board: Any) -> None:
    from heyoka_bike.showing.formats.leaderboard import ABOUT, HEADINGS, WORDS, diagnosis, rows

    for problem, entries in board.entries.items():
        lines = rows(entries)
        print_table(table(HEADINGS, lines, title=problem, left=2, prose=WORDS), _WIDTH)
        for (place, *_), entry in zip(lines, entries, strict=True):
            if said := diagnosis(entry):
                print(textwrap.fill(f"{place}. {entry.submission.name}. {said}", _WIDTH))
    if board.entries:
        print(textwrap.fill(ABOUT, _WIDTH))
