r"""Pack a result for the benchmark's collection.

Write the files that the IFToMM library requires into one .zip: a text file with the 25 columns, as
read in binary64, and the two numbers for the library's form (eq. (1) of maneuver 2, and the
processor time that you give). The archive also contains the correct digits of every maneuver and
the report. Nothing is sent. The result file is read as by 'score'. It must contain all three
maneuvers at the same times, in SI units.

example: heyoka-bike submit my-results.txt --program 'Mine 1.0, RK4, h = 0.001' --cpu 0.8 \
  --machine 'AMD EPYC 7763, 1 core'
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.commands import options
from heyoka_bike.commands.printing import print_text
from heyoka_bike.commands.result_files import maneuvers_of, read
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.system.log import complain

if TYPE_CHECKING:
    from heyoka_bike.scoring.reading.results import Results, Rows
    from heyoka_bike.scoring.report import Report

_FORM_OF_SUBMISSION = Template(
    Path(__file__).with_name("submission.txt").read_text(encoding="utf-8")
)


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = options.add_command(subparsers, run, __doc__, {"FILE": "result file"})
    p.add_argument("--program", required=True, help="name, version, method and step, in one line")
    p.add_argument("--cpu", metavar="S", required=True, help="processor time of the run [s]")
    p.add_argument("--machine", required=True, help="processor, compiler and options, in one line")
    output = {"-o --output ZIP submission.zip": "archive to write (default: submission.zip)"}
    options.add_arguments(p, options.COLUMNS | output)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.numbers.exact import positive_numbers
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.scoring.score import score
    from heyoka_bike.showing.formats.output import render
    from heyoka_bike.showing.wording.number_text import limit_words
    from heyoka_bike.showing.wording.origin_text import origin
    from heyoka_bike.system.files import refuse_overwriting, write_output

    (cpu,) = positive_numbers("--cpu", args.cpu)[:1]
    given = {"program": args.program, "machine": args.machine}
    for name, text in given.items():
        if not text.strip() or not text.isprintable():
            raise InputError(f"--{name}: expected one line of text")
    refuse_overwriting([args.file], [Path(args.output)])
    reference = load_reference()
    results = read(args.file, maneuvers_of(None, 1, reference)[0], reference, args.columns,
                   args.max_bytes)  # fmt: skip
    report = score([results], reference)
    (measured,) = reference.judged
    table = _text(results, report, tuple(reference))
    said = _said(report, measured, given, cpu)
    files = {
        "results.txt": table,
        "submission.txt": said,
        "report.html": render(report, "html", origin(args.words)),
    }
    write_output(Path(args.output), _packed(files))
    print_text(said)
    print(args.output)
    if not report[measured].meets_limit:
        limit = limit_words(reference[measured].performance_limit or 0.0)
        complain(f"{args.file}: eq. (1) of maneuver {measured} is not below {limit}")
        return Exit.CHECK_FAILED
    return Exit.OK


def _text(results: Results, report: Report, numbers: Sequence[int]) -> str:
    """Return the columns of these maneuvers in the benchmark's text format.

    Raises
    ------
    InputError
        A maneuver or column is missing, times differ, or a unit is not SI.
    """
    import numpy as np

    by_number = {
        m.maneuver: rows for m, rows in zip(report.maneuvers, results.maneuvers, strict=True)
    }
    if sorted(by_number) != list(numbers):
        said = f"found maneuvers {sorted(by_number)}, expected all of {list(numbers)}"
        raise InputError(said, file=results.path)
    parts: Sequence[Rows] = [by_number[n] for n in sorted(by_number)]
    for number, rows in zip(sorted(by_number), parts, strict=True):
        missing = [key for key in BENCHMARK_COLUMNS if key not in rows.values]
        if missing:
            said = f"maneuver {number}: the column {missing[0].replace('_', ' ')} is missing"
            raise InputError(said, file=results.path)
        if not np.array_equal(rows.time, parts[0].time):
            said = f"maneuver {number}: the times differ from those of maneuver 1"
            raise InputError(said, file=results.path)
        for key, column in report[number].items():
            if column.as_understood.unit != column.unit:
                said = f"found {key} in {column.as_understood.unit}, expected {column.unit}"
                raise InputError(f"maneuver {number}: {said}", file=results.path)
    columns = [parts[0].time, *(rows.values[key] for rows in parts for key in BENCHMARK_COLUMNS)]
    lines = (" ".join(repr(float(x)) for x in row) for row in zip(*columns, strict=True))
    return "\n".join(lines) + "\n"


def _said(report: Report, number: int, given: Mapping[str, str], cpu: float) -> str:
    """Return the form of a submission: eq. (1) of maneuver `number`, and the digits of all."""
    measured = report[number]
    digits = (
        f"maneuver {number}: "
        + (f"{m.worst.scd:.1f} ({m.worst.column})" if m.worst else "nothing compared")
        for number, m in report.items()
    )
    return _FORM_OF_SUBMISSION.substitute(
        given,
        measured=number,
        accuracy="unknown" if measured.performance is None else f"{measured.performance:.4g} %",
        cpu=f"{cpu:g}",
        digits="\n".join(digits),
        definitions="\n".join(f"{key}: {column.definition}" for key, column in measured.items()),
    )


def _packed(files: Mapping[str, str]) -> bytes:
    """Return a .zip archive of texts; equal texts give equal bytes."""
    from io import BytesIO
    from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

    made = BytesIO()
    with ZipFile(made, "w") as archive:
        for name, text in files.items():
            archive.writestr(ZipInfo(name), text.encode(), ZIP_DEFLATED)
    return made.getvalue()
