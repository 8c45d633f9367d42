"""``heyoka-bike generate``: integrate the maneuvers and write the reference files."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands.options import add_bicycle
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.system.console import print_table, progress_bars, table

if TYPE_CHECKING:
    from heyoka_bike.reference.making.tabulate import Table

_DIGITS = 70
_SHARES = {
    "integrate": 0.15, "certify": 0.25, "rows": 0.05, "dense": 0.1, "motion": 0.2, "vary": 0.25,
}  # fmt: skip


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = subparsers.add_parser(
        "generate",
        help="integrate the maneuvers and write the reference files",
        description=(
            "Integrate each maneuver with heyoka at high precision, prove how far the exact motion "
            "may be from the result, round every value correctly, and write the reference files: "
            "rows and dense output (HDF5), the 25-column text, the same with 50 digits, the "
            "candidate polynomials, the certificate, the sensitivities to all parameters, the "
            "whole motion with all forces, and a manifest. Files of equal content are "
            "left untouched; each is replaced atomically, the manifest last."
        ),
        epilog="example: heyoka-bike generate --bicycle pista --out my-reference",
    )
    p.add_argument(
        "--digits",
        type=int,
        default=_DIGITS,
        metavar="N",
        help="decimal digits of the integration, 65 to 1000 (default 70)",
    )
    add_bicycle(p)
    p.add_argument(
        "--maneuvers",
        metavar="NAME|FILE",
        help="maneuvers of the collection, or a TOML file (default: those of the bicycle's name, "
        "benchmark for a file)",
    )
    p.add_argument(
        "--until",
        metavar="WHEN",
        help="a time [s] in place of the maneuvers' durations, or 'fall': to the last row before a "
        "wheel leaves the floor or the model ends",
    )
    p.add_argument(
        "--after-ten-seconds",
        action="store_true",
        help="make after-ten-seconds.json instead, what is proved of the benchmark's motions after "
        "their ten seconds, with the candidates that 'certify --after-ten-seconds' starts from; "
        "five minutes",
    )
    p.add_argument(
        "--out",
        metavar="DIR",
        help="folder (default ./reference, or ./reference/after-ten-seconds)",
    )
    p.add_argument(
        "--force", action="store_true", help="replace a set of another version or of other inputs"
    )
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    if args.after_ten_seconds:
        return _after(args)
    from heyoka_bike.reference.making.generate import generate

    out = "reference" if args.out is None else args.out
    with progress_bars(_SHARES) as progress:
        made = generate(
            out,
            bicycle=args.bicycle,
            maneuvers=args.maneuvers or None,
            digits=args.digits,
            until=args.until,
            force=args.force,
            say=lambda text: print(f"heyoka-bike: {text}", file=sys.stderr),
            progress=progress,
        )
    _summary(made.tables)
    written = f"written: {', '.join(made.changed)}"
    what = written if made.changed else "already up to date, nothing written"
    print(f"{out}: dataset version {made.dataset_version}, {what}")
    return Exit.STOPPED_EARLY if any(end.is_early for end in made.endings) else Exit.OK


def _after(args: argparse.Namespace) -> int:
    """What follows the ten seconds of the benchmark, and of nothing else."""
    from heyoka_bike.reference.making.after_ten_seconds import generate_after

    given = {"--bicycle": args.bicycle != "benchmark", "--maneuvers": args.maneuvers,
             "--digits": args.digits != _DIGITS, "--until": args.until}  # fmt: skip
    for option, is_given in given.items():
        if is_given:
            raise InputError(
                f"{option}: found it beside --after-ten-seconds, expected it alone: that is about "
                "the benchmark"
            )
    out = "reference/after-ten-seconds" if args.out is None else args.out
    with progress_bars({"certify": 1.0}) as progress:
        changed = generate_after(out, progress=progress)
    what = f"written: {', '.join(changed)}" if changed else "already up to date, nothing written"
    print(f"{out}: {what}")
    return Exit.OK


def _summary(tables: Sequence[Table]) -> None:
    from heyoka_bike.numbers.rounding import decimal_above

    headings = (
        "maneuver", "steps", "order", "digits", "max |E - E0| / E0", "in 2^-p", "eq. (1) [%]",
        "certified bound", "CPU [s]",
    )  # fmt: skip
    rows = []
    for made in tables:
        run, drift = made.trajectory, made.drift
        rows.append((
            run.maneuver.name, str(run.steps), str(run.order), run.precision.split()[0],
            f"{drift.energy * 2.0**-run.bits:.1e}", f"{drift.energy:.2g}",
            f"{drift.performance:.1e}", decimal_above(made.certificate.worst), f"{made.cpu:.1f}",
        ))  # fmt: skip
    print_table(table(headings, rows, title="reference solution"))
