"""``heyoka-bike generate``: integrate the maneuvers and write the reference files."""

from __future__ import annotations

import argparse
import sys
import time
from typing import TYPE_CHECKING, Any

from heyoka_bike.errors import Exit, InputError, SingularMotionError

if TYPE_CHECKING:
    from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
    from heyoka_bike.reference.making.tabulate import Progress as Report
    from heyoka_bike.reference.making.tabulate import Table

MIN_DIGITS, MAX_DIGITS = 65, 1000

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
        default=70,
        metavar="N",
        help=f"decimal digits of the integration, {MIN_DIGITS} to {MAX_DIGITS} (default 70)",
    )
    p.add_argument(
        "--bicycle",
        metavar="NAME|FILE",
        default="benchmark",
        help="a bicycle of the collection, or a TOML file (default: benchmark)",
    )
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
    p.add_argument("--out", metavar="DIR", default="reference", help="folder (default ./reference)")
    p.add_argument(
        "--force", action="store_true", help="replace a set of another version or of other inputs"
    )
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.bicycle.parameters import describe_inputs, read_bicycle, read_maneuvers
    from heyoka_bike.motion.endings import ending
    from heyoka_bike.motion.expressions import require_heyoka
    from heyoka_bike.reference.making.dataset import check_overwrite, write_dataset
    from heyoka_bike.reference.manifest import CUSTOM, DATASET_VERSION
    from heyoka_bike.system.parallel import progress_bars, side_by_side
    from heyoka_bike.system.resources import (
        benchmark_bicycle,
        benchmark_maneuvers,
        collection,
        find_input,
    )

    require_heyoka()
    if not args.out.strip():
        raise InputError("--out: found nothing, expected a folder")
    if not MIN_DIGITS <= args.digits <= MAX_DIGITS:
        raise InputError(f"--digits: found {args.digits}, expected {MIN_DIGITS} to {MAX_DIGITS}")
    bicycle = read_bicycle(find_input("bicycles", args.bicycle))
    own = args.bicycle if args.bicycle in collection("maneuvers") else "benchmark"
    asked = read_maneuvers(find_input("maneuvers", args.maneuvers or own))
    for warning in bicycle.warnings:
        print(f"heyoka-bike: warning: {bicycle.name}: {warning}", file=sys.stderr)
    endings = [ending(bicycle, m, args.until) for m in asked]
    for m, end in zip(asked, endings, strict=True):
        if end.said is not None:
            print(
                f"heyoka-bike: {'stopped early: ' if end.is_early else ''}{m.name}: {end.said}; "
                f"what is written ends at {float(end.maneuver.duration):g} s",
                file=sys.stderr,
            )
    maneuvers = [end.maneuver for end in endings]
    inputs = describe_inputs(bicycle, maneuvers)
    published = describe_inputs(
        read_bicycle(benchmark_bicycle()), read_maneuvers(benchmark_maneuvers())
    )
    dataset_version = DATASET_VERSION if inputs == published else CUSTOM
    check_overwrite(args.out, dataset_version, inputs, force=args.force)
    names, durations = zip(*((m.name, float(m.duration)) for m in maneuvers), strict=True)
    with progress_bars(names, durations, _SHARES) as report:
        jobs = [(bicycle, maneuver, args.digits) for maneuver in maneuvers]
        results = side_by_side(_tabulate, jobs, report)
    tables = [table for table, _ in results]
    changed = write_dataset(args.out, bicycle, tables, args.digits, dataset_version)
    _summary(results)
    print(
        f"{args.out}: dataset version {dataset_version}, "
        + (f"written: {', '.join(changed)}" if changed else "already up to date, nothing written")
    )
    return Exit.STOPPED_EARLY if any(end.is_early for end in endings) else Exit.OK


def _tabulate(
    bicycle: Bicycle, maneuver: Maneuver, digits: int, report: Report
) -> tuple[Table, float]:
    """The table of a maneuver, and the processor time it took [s]."""
    from heyoka_bike.reference.making.tabulate import tabulate

    start = time.process_time()
    try:
        table = tabulate(bicycle, maneuver, digits, report)
    except SingularMotionError as e:
        raise SingularMotionError(
            f"{maneuver.name}: {e}; its duration is {float(maneuver.duration):g} s, nothing was "
            "written, expected a shorter duration",
            e.time,
        ) from None
    return table, time.process_time() - start


def _summary(results: list[tuple[Table, float]]) -> None:
    from rich.console import Console
    from rich.table import Table as View
    from rich.text import Text

    from heyoka_bike.numbers.rounding import decimal_above

    view = View(title="reference solution")
    headings = (
        "maneuver", "steps", "order", "digits", "max |E - E0| / E0", "in 2^-p", "eq. (1) [%]",
        "certified bound", "CPU [s]",
    )  # fmt: skip
    for heading in headings:
        view.add_column(
            Text(heading), justify="left" if heading == "maneuver" else "right", no_wrap=True
        )
    for table, seconds in results:
        run, drift = table.trajectory, table.drift
        view.add_row(
            run.maneuver.name, str(run.steps), str(run.order), run.precision.split()[0],
            f"{drift.energy * 2.0**-run.bits:.1e}", f"{drift.energy:.2g}",
            f"{drift.performance:.1e}", decimal_above(table.certificate.worst), f"{seconds:.1f}",
        )  # fmt: skip
    console = Console()
    console.width = max(console.width, 120)
    console.print(view)
