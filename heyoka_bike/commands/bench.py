"""``heyoka-bike bench``: how long maneuver 2 takes at equal accuracy, next to SciPy."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from heyoka_bike.errors import Exit, InputError

if TYPE_CHECKING:
    from rich.console import Console

    from heyoka_bike.bench import Line, Problem, Progress

SCHEMA_VERSION = 1
MANEUVER = 2
MAX_RUNS = 10_000
_RUNS, _QUICK_RUNS = 30, 5
_WIDTH = 140


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = subparsers.add_parser(
        "bench",
        help="time maneuver 2 at equal accuracy, next to SciPy",
        description=(
            "Time maneuver 2 with all rows of output: heyoka in binary64 and binary128, and DOP853 "
            "and LSODA of SciPy on the same right-hand side, each at the loosest tolerance that "
            "keeps the benchmark's eq. (1) under 1e-3 percent, at the loosest with a state error "
            'under 1e-12, and at roundoff. SciPy comes with pip install "heyoka_bike[bench]".'
        ),
        epilog="example: heyoka-bike bench --format json -o bench.json",
    )
    p.add_argument(
        "--runs",
        metavar="N",
        type=int,
        help=f"timed runs of each code, fewer of a slow one (default {_RUNS})",
    )
    p.add_argument("--format", choices=("table", "json"), default="table", help="default: table")
    p.add_argument("-o", "--output", metavar="FILE", help="write to a file")
    p.add_argument(
        "--quick",
        action="store_true",
        help=f"leave out the unrolled heyoka, slow to build; {_QUICK_RUNS} runs by default",
    )
    p.add_argument(
        "--reference",
        metavar="DIR",
        help="folder of a reference set of the benchmark (default: the published one)",
    )
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.bench import bench
    from heyoka_bike.machine import machine
    from heyoka_bike.output_files import write_output

    runs = args.runs if args.runs is not None else _QUICK_RUNS if args.quick else _RUNS
    if not 1 <= runs <= MAX_RUNS:
        raise InputError(f"--runs: found {runs}, expected 1 to {MAX_RUNS}")
    _check_output(args.output)
    problem = _problem(args.reference)
    with _progress() as progress:
        lines = bench(problem, runs, is_quick=args.quick, progress=progress)
    document = {
        "schema_version": SCHEMA_VERSION,
        "maneuver": problem.maneuver.name,
        "rows": problem.maneuver.rows,
        "runs": runs,
        "quick": args.quick,
        "machine": machine(),
        "versions": _versions(),
        "results": [_result(line, lines) for line in lines],
    }
    text = _json(document) if args.format == "json" else _table(document, args.output is None)
    if args.output is None:
        sys.stdout.write(text)
    else:
        write_output(Path(args.output), text.encode())
    return Exit.OK


def _problem(folder: str | None) -> Problem:
    """Maneuver 2 of the benchmark, with its reference."""
    from heyoka_bike.bench import Problem
    from heyoka_bike.parameters import PARAMETERS, STATE_INPUTS, read_bicycle, read_maneuvers
    from heyoka_bike.reference import load_reference
    from heyoka_bike.resources import benchmark_bicycle, benchmark_maneuvers

    reference = load_reference(folder)
    bicycle = read_bicycle(benchmark_bicycle())
    maneuver = read_maneuvers(benchmark_maneuvers())[MANEUVER - 1]
    inputs = {key: str(getattr(maneuver, key)) for key in STATE_INPUTS}
    if (
        MANEUVER not in reference
        or dict(reference[MANEUVER].inputs) != inputs
        or dict(reference.parameters) != {symbol: str(bicycle[symbol]) for symbol in PARAMETERS}
    ):
        raise InputError(
            f"{folder}: found a reference of other inputs, expected {maneuver.name} of the "
            f"{bicycle.name}"
        )
    return Problem(bicycle, maneuver, reference[MANEUVER])


def _result(line: Line, lines: Sequence[Line]) -> dict[str, Any]:
    """A line of the report; what is unknown is None."""
    from statistics import median

    from heyoka_bike.bench import Trial

    result: dict[str, Any] = {
        "class": line.accuracy_class,
        "code": line.code.name,
        "precision": line.code.precision,
        "status": line.status,
    }
    t: Trial | None = line.trial
    result |= {
        "tolerance": t and t.tolerance,
        "order": t and t.order,
        "steps": t and t.count if line.code.counts == "steps" else None,
        "rhs_calls": t and t.count if line.code.counts == "rhs_calls" else None,
        "build_s": t and t.build,
        "performance_percent": t and t.performance,
        "max_state_error": t and t.error,
        "runs": len(line.times),
    }
    if not line.times:
        return result | {"min_ms": None, "median_ms": None, "ratio_to_fastest": None}
    group = (x for x in lines if x.times and x.accuracy_class == line.accuracy_class)
    fastest = min(min(x.times) for x in group)
    return result | {
        "min_ms": 1e3 * min(line.times),
        "median_ms": 1e3 * median(line.times),
        "ratio_to_fastest": min(line.times) / fastest,
    }


def _json(document: Mapping[str, Any]) -> str:
    import json

    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _table(document: Mapping[str, Any], is_shown: bool) -> str:
    """The report as text, coloured only when it is shown on a terminal."""
    from heyoka_bike.bench import CLASSES

    console = _console(is_shown)
    with console.capture() as capture:
        for name, title in CLASSES.items():
            _print_class(console, title, [x for x in document["results"] if x["class"] == name])
        machine, versions = document["machine"], document["versions"]
        notes = (
            f"{document['maneuver']} with {document['rows']} rows of output; times of one run, "
            f"building excluded; the codes of a class in turns, {document['runs']} times each, "
            "a slow one fewer times",
            "ratio: of the shortest time, to the fastest of the class",
            "state error: the largest over the rows of roll and steer [rad], their rates [rad/s] "
            "and the forward speed [m/s]",
            "SciPy: solve_ivp with rtol = atol = tolerance, but rtol at least 2.2e-14",
            f"machine: {machine['cpu']}, {machine['cores']} cores, {machine['system']}",
            "versions: " + ", ".join(f"{k} {v}" for k, v in versions.items()),
        )
        for note in notes:
            console.print(note, markup=False, highlight=False)
    return capture.get()


def _print_class(console: Console, title: str, results: Sequence[Mapping[str, Any]]) -> None:
    from rich.table import Table
    from rich.text import Text

    view = Table()
    headings = (
        "code", "precision", "tolerance", "count", "runs", "build [s]", "min [ms]",
        "median [ms]", "eq. (1) [%]", "state error", "ratio",
    )  # fmt: skip
    for heading in headings:
        justify: Literal["left", "right"] = "left" if heading in headings[:2] else "right"
        # As text: a heading alone would be read as markup, and its [s] taken for a style.
        view.add_column(Text(heading), justify=justify, no_wrap=True)
    for x in results:
        if x["status"] != "ok":
            view.add_row(x["code"], x["precision"], x["status"])
            continue
        count = f"{x['steps']} steps" if x["rhs_calls"] is None else f"{x['rhs_calls']} calls"
        view.add_row(
            x["code"], x["precision"], f"{x['tolerance']:.1e}", count, str(x["runs"]),
            f"{x['build_s']:.2f}", f"{x['min_ms']:.3f}", f"{x['median_ms']:.3f}",
            f"{x['performance_percent']:.1e}", f"{x['max_state_error']:.1e}",
            f"{x['ratio_to_fastest']:.1f}",
        )  # fmt: skip
    console.print(title, markup=False, highlight=False)
    console.print(view)


def _console(is_shown: bool) -> Console:
    from io import StringIO

    from rich.console import Console

    console = Console() if is_shown else Console(file=StringIO())
    console.width = max(console.width, _WIDTH)
    return console


def _versions() -> dict[str, str]:
    import platform
    from importlib.metadata import PackageNotFoundError, version

    found = {"python": platform.python_version()}
    for name in ("heyoka_bike", "heyoka", "scipy", "numpy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found


@contextmanager
def _progress() -> Iterator[Progress]:
    """A bar on standard error; nothing when that is not a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description:<38}"), BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"), TimeElapsedColumn(),
    )  # fmt: skip
    # Drawn only when told to: a thread that draws at its own times would disturb the timing.
    with Progress(
        *columns, console=console, disable=not console.is_terminal, auto_refresh=False
    ) as bars:
        task = bars.add_task("", total=1.0)

        def report(what: str, done: float) -> None:
            bars.update(task, description=what, completed=done, refresh=True)

        yield report


def _check_output(output: str | None) -> None:
    """Refuse what cannot be written before the work, not after it."""
    if output is None:
        return
    path = Path(output)
    if path.is_dir():
        raise InputError("cannot be written: is a folder, expected a file", file=path)
    if not path.parent.is_dir():
        raise InputError("cannot be written: its folder does not exist", file=path)
