"""Compare the results of another program with the reference.

Compare result files with the reference, at the times of the file. A file without column names has
25 columns in SI units (time, then for each maneuver roll angle, roll angular velocity, forward
speed, potential, kinetic and mechanical energy, steer angle, steer velocity), or 9 columns for one
maneuver. With a line of column names it may contain any of these columns and of those of motion.h5
(such as yaw, com_z, rear_normal_force). The report states the recognised definition, unit, sign and
zero of each column.

The formats are $formats, and each of them compressed with gzip. A text file may have any
separators, headers and comments. The name - is standard input.

Several files are compared side by side as different programs, unless they contain different
maneuvers of one run. With --step or --tolerance they are runs of one program, and the report shows
how its error decreases. A .toml file lists such runs with steps, tolerances and processor times.

examples:
  heyoka-bike score my-results.txt
  heyoka-bike score my-results.txt -o report.html --require 'scd >= 6'
  heyoka-bike score my-results.txt --details
  heyoka-bike score my-results.txt --format badge -o badge.json
  heyoka-bike score mine.txt theirs.txt --name Mine,Theirs -o both.html
  heyoka-bike score h0.01.txt h0.001.txt --step 0.01,0.001
  heyoka-bike score loose.txt tight.txt --tolerance 1e-10,1e-11

requirements: [maneuver.][column.]metric op number. Without a maneuver or a column, the worst
  maneuver or column counts. Metrics: scd, mescd, max_abs_error, rms_error, max_rel_error,
  time_to_tolerance, performance, columns, coverage, gap; op: < <= > >=. The exit code is 3 if a
  requirement is not met.
  A requirement needs all eight columns over the whole run in each maneuver of the file, unless
  'columns >= 5' or 'coverage >= 0.3' is required too. Definitions: docs/measures.md
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands import options
from heyoka_bike.commands.printing import print_text
from heyoka_bike.commands.result_files import STANDARD_INPUT, maneuvers_of, parse_budget, read
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.scoring.reading.formats import listed
from heyoka_bike.showing.formats.output import FORMATS, SUFFIXES, WIDTH, render
from heyoka_bike.system.console import has_colors, progress_bar
from heyoka_bike.system.log import complain

if TYPE_CHECKING:
    from heyoka_bike.reference.load import Reference
    from heyoka_bike.scoring.diagnosis.budget import Budget
    from heyoka_bike.scoring.report import Report
    from heyoka_bike.scoring.runs import Series

_ROWS_OPTION = "rows"


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    said = {"FILE...": "result files, or one list of runs"}
    known = listed("and", with_packages=True)
    p = options.add_command(subparsers, run, __doc__, said, formats=known)
    options.add_formats(
        p, FORMATS, "may be repeated (default: table, and for each -o the format of its suffix)"
    )
    how = {
        "-o --output FILE...": "write to this file, in the format of --format or of its suffix; "
        "may be repeated",
        "--summary": "print at most ten lines instead of the table: verdict, digits, conventions, "
        "next steps",
        "--details": "also print the errors of each maneuver; files written with -o always contain "
        "them",
        "--require EXPR...": "requirement such as 'scd >= 6' or '2.performance < 1e-3'; may be "
        "repeated",
        "--diagnose": "also diagnose why the file differs, and show the cause in the HTML report; "
        "see 'heyoka-bike diagnose'",
        **options.BUDGET,
        "--maneuver N": "number of the maneuver in a file that contains only one (default: "
        "recognised from the values and the file name); for several files, numbers separated by "
        "commas",
        **options.COLUMNS,
        "--step H": "step size of each file [s], separated by commas, or 'rows' if each step is "
        "one row; the files are then runs of one program",
        "--tolerance TOL": "solver tolerance of each file, separated by commas, for an adaptive "
        "step or for iterations; the files are then runs of one program",
        "--name NAME": "name of each file's program, separated by commas (default: the file "
        "names); files with the same name are different maneuvers of one program",
        "--cpu S": "processor time of the run in each file [s], separated by commas",
    }
    options.add_arguments(p, how | options.REFERENCE)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.scoring import requirements
    from heyoka_bike.scoring.series import score_files
    from heyoka_bike.showing.wording.origin_text import origin
    from heyoka_bike.showing.wording.run_text import reports
    from heyoka_bike.system.files import refuse_overwriting, write_output

    on_screen, written = _outputs(args)
    for text in args.require:
        requirements.parse(text)
    files, steps, tolerances, cpu = _inputs(args)
    budget = _budget(args)
    refuse_overwriting(files, [path for path, _ in written])
    reference = load_reference(args.reference)
    maneuvers = maneuvers_of(args.maneuver, len(files), reference)
    results = [
        read(f, m, reference, args.columns, args.max_bytes)
        for f, m in zip(files, maneuvers, strict=True)
    ]
    scored = score_files(
        results, reference, steps=steps, tolerances=tolerances, cpu=cpu, require=args.require,
        names=None if args.name is None else [name.strip() for name in args.name.split(",")],
        is_one_program=(args.step or args.tolerance) is not None or bool(_lists(args.file)),
    )  # fmt: skip
    if args.diagnose:
        scored = _diagnosed(scored, reference, budget)
    made = origin(args.words)
    for path, name in written:
        write_output(path, render(scored, name, made).encode())
    if on_screen is not None:
        is_terminal = sys.stdout.isatty()
        width, colors = None if is_terminal else WIDTH, has_colors(is_terminal)
        shown = render(
            scored, on_screen, made, width=width, has_colors=colors, has_details=args.details,
            written=[str(path) for path, _ in written],
        )  # fmt: skip
        print_text(shown)
    unmet = [(r, x) for r in reports(scored) for x in r.requirements if not x.met]
    for report, required in unmet:
        complain(f"{report.file.path}: required {required.text}, found {required.message}")
    if not scored.passed:
        return Exit.CHECK_FAILED
    is_early = any(report.is_stopped_early for report in reports(scored))
    return Exit.STOPPED_EARLY if is_early else Exit.OK


def _budget(args: argparse.Namespace) -> Budget:
    for name in ("budget", "thorough"):
        if getattr(args, name) and not args.diagnose:
            raise InputError(f"--{name} needs --diagnose")
    return parse_budget(args.budget, args.thorough)


def _diagnosed(scored: Report | Series, reference: Reference, budget: Budget) -> Report:
    from heyoka_bike.scoring.diagnosis.diagnose import diagnosed
    from heyoka_bike.scoring.runs import Series

    if isinstance(scored, Series):
        raise InputError(
            f"--diagnose: found {len(scored.runs)} runs, expected the files of one run"
        )
    with progress_bar("simulating mistakes") as progress:
        return diagnosed(scored, reference, progress, budget)


def _outputs(args: argparse.Namespace) -> tuple[str | None, list[tuple[Path, str]]]:
    """Return the format on standard output (None for no output) and each file with its format."""
    formats: list[str] = args.formats or []
    left = list(dict.fromkeys(formats))
    written = []
    unclear = []
    for output in args.output:
        path = Path(output)
        name = SUFFIXES.get(path.suffix.lower())
        if name is not None and (not formats or name in left):
            written.append((path, name))
            left = [f for f in left if f != name]
        else:
            unclear.append(path)
    for path in unclear:
        if not left:
            raise InputError(
                f"--output: found '{path.name}', expected a name ending in "
                f"{', '.join(SUFFIXES)}, or a --format for it"
            )
        # Write a table to a file only if no other format is left, so that the table remains on
        # standard output.
        name = next((f for f in left if f != "table"), left[0])
        left.remove(name)
        written.append((path, name))
    if args.summary and set(left) <= {"table"}:
        return "summary", written
    if args.summary:
        raise InputError(
            f"--summary and --format {left[0]} both go to standard output; write {left[0]} to a "
            "file with -o"
        )
    if not formats:
        return "table", written
    if len(left) > 1:
        raise InputError(
            f"--format: found {' and '.join(left)} for standard output, expected one; "
            "name files for the others with -o"
        )
    return (left[0] if left else None), written


_Numbers = list[float | None] | None


def _inputs(args: argparse.Namespace) -> tuple[list[str], _Numbers, _Numbers, _Numbers]:
    """Return the result files, and their step sizes [s], tolerances and processor times [s]."""
    if lists := _lists(args.file):
        from heyoka_bike.scoring.series import read_runs

        if len(args.file) > 1:
            raise InputError(
                f"found {len(args.file)} files, expected only the list of runs ({lists[0]})"
            )
        if any(x is not None for x in (args.step, args.tolerance, args.cpu)):
            raise InputError(
                "--step, --tolerance and --cpu cannot be combined with a list of runs; write the "
                "values into the list"
            )
        files, told = read_runs(lists[0])
        steps, tolerances, cpu = (x if any(x) else None for x in told.values())
        return [*map(str, files)], steps, tolerances, cpu
    if args.file.count(STANDARD_INPUT) > 1:
        raise InputError("found - (standard input) more than once, expected it once")
    steps = None if args.step == _ROWS_OPTION else _numbers("--step", args.step)
    tolerances = _numbers("--tolerance", args.tolerance)
    return args.file, steps, tolerances, _numbers("--cpu", args.cpu)


def _lists(files: Sequence[str]) -> list[str]:
    """Return the files that are lists of runs (TOML)."""
    return [f for f in files if f.lower().endswith(".toml")]


def _numbers(option: str, text: str | None) -> _Numbers:
    from heyoka_bike.numbers.exact import positive_numbers

    return None if text is None else list(positive_numbers(option, text))
