"""Time maneuver 2 at equal accuracy, compared with other integrators.

Measure the time of maneuver 2 with all rows of all eight columns: this package's fast simulation,
heyoka in binary64 and binary128, DOPRI5, DOP853 and RK4 in C (if there is a compiler), SciPy,
SUNDIALS and Exudyn. Each runs at three accuracies: the loosest tolerance that keeps eq. (1) of the
benchmark under 1e-3 percent, the loosest with a state error under 1e-12, and roundoff. SciPy,
scikit-sundae and Exudyn come with pip install "heyoka_bike[bench,peers]". With -o NAME.png, .svg or
.pdf a figure of time over error is written, and the table is printed.

example: heyoka-bike bench --format json -o bench.json
"""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from heyoka_bike.commands import options
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.system.console import has_colors, stage_bar
from heyoka_bike.workbench.style import FORMATS, render

_MAX_RUNS = 10_000
_DEFAULT_RUNS, _QUICK_RUNS = 30, 5


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = options.add_command(subparsers, run, __doc__)
    said = f"timed runs of each code; slow codes get fewer (default {_DEFAULT_RUNS})"
    options.add_arguments(p, {"--runs N": said}, runs={"type": int})
    p.add_argument(
        "--format", choices=("table", "json"), default="table", help="output format (default table)"
    )
    what = {
        "-o --output FILE": "file to write; a name ending in .png, .svg or .pdf gives a figure",
        "--all": "also time all three maneuvers, ensembles, the first result of a new process, "
        "and, at 34 and 70 digits, mpmath, a Taylor method in ball arithmetic and C with "
        "libquadmath (about ten minutes)",
        "--costs": "also measure how the time grows with the digits, up to 1000, and with the "
        "duration, up to 10,000 s (about ten minutes)",
        "--quick": f"skip codes that are slow to build; {_QUICK_RUNS} runs by default",
        "--reference DIR": "folder of a reference dataset of the benchmark (default: the published "
        "one)",
    }
    options.add_arguments(p, what)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.bicycle.parameters import benchmark
    from heyoka_bike.system.files import write_output
    from heyoka_bike.workbench.bench import summary
    from heyoka_bike.workbench.bench.problem import benchmark_problem, judged

    runs = args.runs if args.runs is not None else _QUICK_RUNS if args.quick else _DEFAULT_RUNS
    if not 1 <= runs <= _MAX_RUNS:
        raise InputError(f"--runs: found {runs}, expected 1 to {_MAX_RUNS}")
    _check_output(args.output)
    figure_format = _figure_format(args.output)
    main = benchmark_problem(args.reference, judged())
    numbers = range(1, len(benchmark()[1]) + 1) if args.all else ()
    every = [benchmark_problem(args.reference, n) for n in numbers]
    with stage_bar() as progress:
        document = summary.measure(
            main, every, runs, progress, is_quick=args.quick,
            with_points=figure_format is not None or args.all, with_costs=args.costs,
            folder=args.reference,
        )  # fmt: skip
    is_shown = args.output is None or figure_format is not None
    if args.format == "json":
        text = json.dumps(document, indent=2, allow_nan=False) + "\n"
    else:
        text = summary.as_text(document, is_shown and has_colors(sys.stdout.isatty()))
    if figure_format is not None:
        title = f"{main.maneuver.name}, {main.maneuver.rows} rows, {document['machine']['cpu']}"
        figure = summary.draw(document["work_precision"], title)
        write_output(Path(args.output), render(figure, figure_format))
    if is_shown:
        sys.stdout.write(text)
    else:
        write_output(Path(args.output), text.encode())
    return Exit.OK


def _figure_format(output: str | None) -> str | None:
    """Return the format of a figure, from the suffix of its file; None if it is not a figure."""
    suffix = Path(output or "").suffix[1:].lower()
    return suffix if suffix in FORMATS else None


def _check_output(output: str | None) -> None:
    """Raise an error before the measurements if the output cannot be written."""
    if output is None:
        return
    path = Path(output)
    if path.is_dir():
        raise InputError("cannot be written: is a folder, expected a file", file=path)
    if not path.parent.is_dir():
        raise InputError("cannot be written: its folder does not exist", file=path)
