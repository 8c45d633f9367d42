"""``heyoka-bike bench``: how long maneuver 2 takes at equal accuracy, next to other codes."""

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

    from heyoka_bike.bench.problem import Problem
    from heyoka_bike.bench.race import Point, Progress, Timing
    from heyoka_bike.motion.trajectory import Trajectory

SCHEMA_VERSION = 1
MANEUVER, MANEUVERS = 2, (1, 2, 3)
ALL = "all maneuvers"
MAX_RUNS = 10_000
_RUNS, _QUICK_RUNS = 30, 5
_WIDTH = 170


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = subparsers.add_parser(
        "bench",
        help="time maneuver 2 at equal accuracy, next to other integrators",
        description=(
            "Time maneuver 2 with all rows of all eight columns: this package's fast path, heyoka "
            "in binary64 and binary128, DOPRI5, DOP853 and RK4 in C (built here if there is a "
            "compiler), SciPy, SUNDIALS and Exudyn, each at the loosest tolerance that keeps the "
            "benchmark's eq. (1) under 1e-3 percent, at the loosest with a state error under "
            "1e-12, and at roundoff. SciPy, scikit-sundae and Exudyn come with "
            'pip install "heyoka_bike[bench,peers]". With -o NAME.png, .svg or .pdf a figure of '
            "time over error is written, and the table is printed."
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
    p.add_argument("-o", "--output", metavar="FILE", help="write to a file; a figure if it ends so")
    p.add_argument(
        "--all",
        action="store_true",
        help="all three maneuvers as well; ensembles, the first result of a new process, and at 34 "
        "and 70 digits mpmath and a Taylor method in ball arithmetic (about ten minutes)",
    )
    p.add_argument(
        "--costs",
        action="store_true",
        help="how the time grows with the digits, up to 1000, and with the duration, up to "
        "10,000 s (about ten minutes)",
    )
    p.add_argument(
        "--quick",
        action="store_true",
        help=f"leave out what is slow to build; {_QUICK_RUNS} runs by default",
    )
    p.add_argument(
        "--reference",
        metavar="DIR",
        help="folder of a reference set of the benchmark (default: the published one)",
    )
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.bench.race import bench, work_precision
    from heyoka_bike.system.files import write_output
    from heyoka_bike.system.machine import machine

    runs = args.runs if args.runs is not None else _QUICK_RUNS if args.quick else _RUNS
    if not 1 <= runs <= MAX_RUNS:
        raise InputError(f"--runs: found {runs}, expected 1 to {MAX_RUNS}")
    _check_output(args.output)
    figure_format = _figure_format(args.output)
    main = _problem(args.reference, MANEUVER)
    tasks = {main.maneuver.name: [main]}
    if args.all:
        tasks[ALL] = [_problem(args.reference, n) for n in MANEUVERS]
    with _progress() as progress:
        results = []
        for name, chosen in tasks.items():
            lines = bench(chosen, runs, is_quick=args.quick, progress=progress)
            results += [_result(line, lines, name) for line in lines]
        document = {
            "schema_version": SCHEMA_VERSION,
            "maneuver": main.maneuver.name,
            "rows": main.maneuver.rows,
            "runs": runs,
            "quick": args.quick,
            "machine": machine(),
            "versions": _versions(),
            "results": results,
        }
        if figure_format is not None or args.all:
            document["work_precision"] = [_point(x) for x in work_precision(main, progress)]
        if args.all:
            document |= _fast(progress) | {"precise": _precise(args.reference, progress)}
        if args.costs:
            document |= _costs(main, args.reference, progress)
    text = _json(document) if args.format == "json" else _table(document, _is_shown(args.output))
    if figure_format is not None:
        from heyoka_bike.bench.figure import draw
        from heyoka_bike.showing.figures.style import render

        title = f"{main.maneuver.name}, {main.maneuver.rows} rows, {document['machine']['cpu']}"
        figure = draw(document["work_precision"], title)
        write_output(Path(args.output), render(figure, figure_format))
    if args.output is None or figure_format is not None:
        sys.stdout.write(text)
    else:
        write_output(Path(args.output), text.encode())
    return Exit.OK


def _figure_format(output: str | None) -> str | None:
    """Format of a figure to be written, None if it is none."""
    from heyoka_bike.showing.figures.style import FORMATS

    suffix = Path(output or "").suffix[1:].lower()
    return suffix if suffix in FORMATS else None


def _is_shown(output: str | None) -> bool:
    return output is None or _figure_format(output) is not None


def _fast(progress: Progress) -> dict[str, Any]:
    """What the fast path does besides one maneuver."""
    from heyoka_bike.bench.batches import first_result, throughput, together

    progress("three maneuvers at once", 0.0)
    at_once = [
        {"accuracy": x.accuracy, "min_ms": 1e3 * x.together, "alone_ms": [1e3 * t for t in x.alone]}
        for x in together()
    ]
    progress("ensembles", 0.3)
    ensembles = [
        {"accuracy": x.accuracy, "threads": n, "motions_per_second": rate}
        for x in throughput()
        for n, rate in x.motions_per_second.items()
    ]
    progress("first result of a new process", 0.7)
    first = first_result()
    return {
        "together": at_once,
        "ensembles": ensembles,
        "first_result": {
            "import_heyoka_s": first.importing,
            "without_cache_s": first.without_cache,
            "with_cache_s": first.with_cache,
        },
    }


def _precise(folder: str | None, progress: Progress) -> list[dict[str, Any]]:
    """The codes that go beyond binary64."""
    from dataclasses import asdict

    from heyoka_bike.bench.precise import precise

    progress("34 and 70 digits", 0.0)
    return [asdict(x) for x in precise(_published(folder))]


def _published(folder: str | None) -> Trajectory:
    from heyoka_bike.reference.proof.candidate import read_candidate
    from heyoka_bike.system.resources import reference_folder

    return read_candidate(reference_folder() if folder is None else folder)[MANEUVER - 1]


def _costs(problem: Problem, folder: str | None, progress: Progress) -> dict[str, Any]:
    """How the time grows with the duration and with the digits."""
    from dataclasses import asdict

    from heyoka_bike.bench.batches import long_runs
    from heyoka_bike.bench.precise import costs

    progress("long runs", 0.0)
    durations = [asdict(x) for x in long_runs(problem.bicycle, problem.maneuver)]
    progress("up to 1000 digits", 0.1)
    digits = [asdict(x) for x in costs(_published(folder))]
    return {"durations": durations, "digits": digits}


def _problem(folder: str | None, number: int) -> Problem:
    """A maneuver of the benchmark, with its reference."""
    from heyoka_bike.bench.problem import Problem
    from heyoka_bike.bicycle.parameters import (
        PARAMETERS,
        STATE_INPUTS,
        read_bicycle,
        read_maneuvers,
    )
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers

    reference = load_reference(folder)
    bicycle = read_bicycle(benchmark_bicycle())
    maneuver = read_maneuvers(benchmark_maneuvers())[number - 1]
    inputs = {key: str(getattr(maneuver, key)) for key in STATE_INPUTS}
    if (
        number not in reference
        or dict(reference[number].inputs) != inputs
        or dict(reference.parameters) != {symbol: str(bicycle[symbol]) for symbol in PARAMETERS}
    ):
        raise InputError(
            f"{folder}: found a reference of other inputs, expected {maneuver.name} of the "
            f"{bicycle.name}"
        )
    return Problem(bicycle, maneuver, reference[number])


def _point(x: Point) -> dict[str, Any]:
    return {
        "code": x.code.name,
        "precision": x.code.precision,
        "tolerance": x.tolerance,
        "min_ms": 1e3 * x.time,
        "performance_percent": x.performance,
        "max_state_error": x.error,
    }


def _result(line: Timing, lines: Sequence[Timing], maneuver: str) -> dict[str, Any]:
    """A line of the report; what is unknown is None."""
    from statistics import median

    from heyoka_bike.bench.problem import Trial

    result: dict[str, Any] = {
        "maneuver": maneuver,
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
        unknown = ("min_ms", "median_ms", "cold_ms", "ratio_to_fastest")
        return result | dict.fromkeys(unknown)
    group = (x for x in lines if x.times and x.accuracy_class == line.accuracy_class)
    fastest = min(min(x.times) for x in group)
    return result | {
        "min_ms": 1e3 * min(line.times),
        "median_ms": 1e3 * median(line.times),
        "cold_ms": 1e3 * median(line.cold),
        "ratio_to_fastest": min(line.times) / fastest,
    }


def _json(document: Mapping[str, Any]) -> str:
    import json

    return json.dumps(document, indent=2, allow_nan=False) + "\n"


def _table(document: Mapping[str, Any], is_shown: bool) -> str:
    """The report as text, coloured only when it is shown on a terminal."""
    from heyoka_bike.bench.compiled import FLAGS
    from heyoka_bike.bench.race import CLASSES

    console = _console(is_shown)
    with console.capture() as capture:
        for maneuver in dict.fromkeys(x["maneuver"] for x in document["results"]):
            for name, title in CLASSES.items():
                chosen = [
                    x
                    for x in document["results"]
                    if (x["maneuver"], x["class"]) == (maneuver, name)
                ]
                _print_class(console, f"{maneuver}: {title}", chosen)
        _print_fast(console, document)
        machine, versions = document["machine"], document["versions"]
        notes = (
            f"{document['rows']} rows of all eight columns; times of one run, building excluded; "
            f"the codes of a class in turns, {document['runs']} times each, a slow one fewer times",
            "min, median: after runs of the same code; cold: the processor's caches filled with "
            "something else before",
            "ratio: of the shortest time, to the fastest of the class",
            "state error: the largest over the rows of roll and steer [rad], their rates [rad/s] "
            "and the forward speed [m/s]",
            "tolerance: heyoka_bike's is about the error of a step; of C RK4 and Exudyn it is the "
            "step [s]; else relative and absolute (SciPy's relative one at least 2.2e-14)",
            f"C: {' '.join(FLAGS)}",
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
        "median [ms]", "cold [ms]", "eq. (1) [%]", "state error", "ratio",
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
            f"{x['cold_ms']:.3f}",
            f"{x['performance_percent']:.1e}", f"{x['max_state_error']:.1e}",
            f"{x['ratio_to_fastest']:.1f}",
        )  # fmt: skip
    console.print(title, markup=False, highlight=False)
    console.print(view)


def _print_fast(console: Console, document: Mapping[str, Any]) -> None:
    """What the fast path does besides one maneuver, where that was measured."""
    lines = [
        f"three maneuvers at once, accuracy {x['accuracy']}: {x['min_ms']:.3f} ms, "
        f"one by one {', '.join(f'{t:.3f}' for t in x['alone_ms'])} ms"
        for x in document.get("together", ())
    ]
    lines += [
        f"ensemble, accuracy {x['accuracy']}, {x['threads']} threads: "
        f"{x['motions_per_second']:.0f} motions of 10 s per second"
        for x in document.get("ensembles", ())
    ]
    if "first_result" in document:
        first = document["first_result"]
        lines.append(
            f"first result of a new process: {first['without_cache_s']:.2f} s without a cache, "
            f"{first['with_cache_s']:.2f} s with it, after {first['import_heyoka_s']:.2f} s of "
            "importing heyoka"
        )
    lines += [
        f"{x['code']}, {x['digits']:.0f} digits: {x['seconds']:.3g} s, error {x['error']:.0e} "
        f"(measured over {x['measured_over']:.2g} s)"
        for x in document.get("precise", ())
    ]
    lines += [
        f"{x['duration']} s at accuracy {x['accuracy']}: {1e3 * x['time']:.3g} ms, {x['steps']} "
        f"steps, eq. (1) {x['performance']:.1e} %, error at the end {x['error']:.0e}"
        for x in document.get("durations", ())
    ]
    lines += [
        f"{x['digits']:.0f} digits: order {x['order']}, {x['seconds_per_step']:.3g} s a step, "
        f"{x['seconds']:.3g} s for the maneuver ({x['steps']} steps timed)"
        for x in document.get("digits", ())
    ]
    for line in lines:
        console.print(line, markup=False, highlight=False)


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
    for name in ("heyoka_bike", "heyoka", "scipy", "scikit-sundae", "exudyn", "numpy"):
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
