"""``heyoka-bike generate``: integrate the maneuvers and write the reference files."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from heyoka_bike.errors import Exit, InputError, SingularMotionError

if TYPE_CHECKING:
    from heyoka_bike.parameters import Bicycle, Maneuver
    from heyoka_bike.table import Progress as Report
    from heyoka_bike.table import Table

MIN_DIGITS, MAX_DIGITS = 65, 1000


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = subparsers.add_parser(
        "generate",
        help="integrate the maneuvers and write the reference files",
        description=(
            "Integrate each maneuver with heyoka at high precision, round every value correctly, "
            "and write the reference files: rows and dense output (HDF5), the 25-column text, the "
            "same with 50 digits, the candidate polynomials, and a manifest. Files of equal "
            "content are left untouched; each is replaced atomically, the manifest last."
        ),
        epilog="example: heyoka-bike generate --bicycle my-bicycle.toml --out my-reference",
    )
    p.add_argument(
        "--digits",
        type=int,
        default=70,
        metavar="N",
        help=f"decimal digits of the integration, {MIN_DIGITS} to {MAX_DIGITS} (default 70)",
    )
    p.add_argument("--bicycle", metavar="FILE", help="TOML file of a bicycle (default: benchmark)")
    p.add_argument(
        "--maneuvers", metavar="FILE", help="TOML file of maneuvers (default: benchmark)"
    )
    p.add_argument("--out", metavar="DIR", default="reference", help="folder (default ./reference)")
    p.add_argument(
        "--force", action="store_true", help="replace a set of another version or of other inputs"
    )
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.dataset import check_overwrite, describe_inputs, write_dataset
    from heyoka_bike.manifest import CUSTOM, DATASET_VERSION
    from heyoka_bike.parameters import read_bicycle, read_maneuvers
    from heyoka_bike.resources import benchmark_bicycle, benchmark_maneuvers

    if not MIN_DIGITS <= args.digits <= MAX_DIGITS:
        raise InputError(f"--digits: found {args.digits}, expected {MIN_DIGITS} to {MAX_DIGITS}")
    bicycle = read_bicycle(args.bicycle or benchmark_bicycle())
    maneuvers = read_maneuvers(args.maneuvers or benchmark_maneuvers())
    for warning in bicycle.warnings:
        print(f"heyoka-bike: warning: {bicycle.name}: {warning}", file=sys.stderr)
    inputs = describe_inputs(bicycle, maneuvers)
    published = describe_inputs(
        read_bicycle(benchmark_bicycle()), read_maneuvers(benchmark_maneuvers())
    )
    dataset_version = DATASET_VERSION if inputs == published else CUSTOM
    check_overwrite(args.out, dataset_version, inputs, force=args.force)
    tables, seconds = [], []
    with _progress(maneuvers) as report:
        for i, maneuver in enumerate(maneuvers):
            start = time.perf_counter()
            tables.append(_tabulate(bicycle, maneuver, args.digits, report(i)))
            seconds.append(time.perf_counter() - start)
    changed = write_dataset(args.out, bicycle, tables, args.digits, dataset_version)
    _summary(tables, seconds)
    print(
        f"{args.out}: dataset version {dataset_version}, "
        + (f"written: {', '.join(changed)}" if changed else "already up to date, nothing written")
    )
    return Exit.OK


def _tabulate(bicycle: Bicycle, maneuver: Maneuver, digits: int, report: Report) -> Table:
    from heyoka_bike.table import tabulate

    try:
        return tabulate(bicycle, maneuver, digits, report)
    except SingularMotionError as e:
        raise SingularMotionError(
            f"{maneuver.name}: {e}; its duration is {float(maneuver.duration):g} s, nothing was "
            "written, expected a shorter duration",
            e.time,
        ) from None


@contextmanager
def _progress(maneuvers: tuple[Maneuver, ...]) -> Iterator[Any]:
    """A bar for each maneuver, on standard error; nothing when that is not a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    from heyoka_bike.table import STAGES

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[stage]:>9}"),
        TextColumn("{task.percentage:>3.0f} %"), TimeElapsedColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, disable=not console.is_terminal) as bars:
        tasks = [bars.add_task(m.name, total=None, start=False, stage="waiting") for m in maneuvers]

        def report(i: int) -> Callable[[str, float], None]:
            # Integrating is most of the work; the other two stages share the rest.
            weights = dict(zip(STAGES, ((0.0, 0.8), (0.8, 0.1), (0.9, 0.1)), strict=True))
            duration = float(maneuvers[i].duration)
            bars.update(tasks[i], total=1.0)
            bars.start_task(tasks[i])

            def update(stage: str, t: float) -> None:
                before, part = weights[stage]
                done = before + part * min(t / duration, 1.0)
                bars.update(tasks[i], completed=done, stage=stage)

            return update

        yield report


def _summary(tables: list[Table], seconds: list[float]) -> None:
    from rich.console import Console
    from rich.table import Table as RichTable

    view = RichTable(title="reference solution")
    headings = (
        "maneuver", "steps", "order", "digits", "max |E - E0| / E0", "in 2^-p",
        "eq. (1) [%]", "max contact gap [m]", "time [s]",
    )  # fmt: skip
    for heading in headings:
        view.add_column(heading, justify="left" if heading == "maneuver" else "right")
    for table, t in zip(tables, seconds, strict=True):
        run, drift = table.trajectory, table.drift
        view.add_row(
            run.maneuver.name, str(run.steps), str(run.order), run.precision.split()[0],
            f"{drift.energy * 2.0**-run.bits:.1e}", f"{drift.energy:.2g}",
            f"{drift.performance:.1e}", f"{drift.contact:.1e}", f"{t:.1f}",
        )  # fmt: skip
    console = Console()
    console.width = max(console.width, 110)
    console.print(view)
