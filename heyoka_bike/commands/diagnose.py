"""Find out why a result file differs: name the mistake whose simulation explains it.

Simulate the usual mistakes (a sign of a product of inertia, a wheel's inertia, the steer axis,
gravity, the initial conditions, rates from differences, ...), alone and in pairs, and name those
that explain the file. If none does, name one, two or three parameters whose values would. If that
fails too, describe the error: a step size and its order, damping, noise, interpolation.

The diagnosis takes 1 to 5 s of processor time. At the limit of 18 s (--budget) it reports the
causes found so far and says that it stopped early; a step that runs 5 s over the limit is
interrupted. If the file shows a force that no single mistake explains, pairs are tried only with
--thorough.

Files are read as by 'score'. The first lines of the output list the file's conventions (axes,
units, zero of the energy, definitions), which are not errors. 'score --diagnose' gives the same
result, with a figure in the HTML report. heyoka is not needed. -v logs for each step what was
tried, the error that remained, and the time.

example: heyoka-bike diagnose my-results.txt

exit codes: 0 the diagnosis is complete; 4 it stopped early
"""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands import options
from heyoka_bike.errors import Exit, NothingScoredError
from heyoka_bike.system.console import progress_bar

if TYPE_CHECKING:
    from heyoka_bike.scoring.report import Report


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    files = {"FILE...": "result file, or files of one run"}
    p = options.add_command(subparsers, run, __doc__, files)
    options.add_format(p, ("text", "json"))
    maneuver = {"--maneuver N": "number of the maneuver in a file that contains only one"}
    details = {"--details": "print every finding, including those that name no cause"}
    options.add_arguments(
        p, maneuver | options.COLUMNS | options.BUDGET | options.REFERENCE | details
    )
    options.add_workers(p)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.commands.result_files import maneuvers_of, parse_budget, read
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.scoring.diagnosis.conclusions import NothingToDiagnose
    from heyoka_bike.scoring.diagnosis.diagnose import diagnosed_elsewhere
    from heyoka_bike.scoring.score import score
    from heyoka_bike.showing.formats.summary import diagnosis
    from heyoka_bike.system.parallel import side_by_side

    budget = parse_budget(args.budget, args.thorough)
    reference = load_reference(args.reference)
    numbers = maneuvers_of(args.maneuver, len(args.file), reference)
    files = [
        read(f, n, reference, args.columns, args.max_bytes)
        for f, n in zip(args.file, numbers, strict=True)
    ]
    with progress_bar("simulating mistakes") as progress:
        (found,) = side_by_side(
            diagnosed_elsewhere, [(score(files, reference), reference, budget)], [("", 1.0)],
            lambda name, stage, share: progress(share),
        )  # fmt: skip
    nothing = NothingToDiagnose().finding()
    if nothing in found.diagnosis:
        raise NothingScoredError(f"{found.file.path}: {nothing.message}")
    text = diagnosis(found, has_details=args.details)
    print(_as_json(found) if args.format == "json" else text)
    return Exit.STOPPED_EARLY if found.is_stopped_early else Exit.OK


def _as_json(found: Report) -> str:
    from heyoka_bike.showing.formats.json import document

    # `findings` lists the findings of the diagnosis first, then those of `score`.
    whole = document(found)
    keys = ("schema_version", "dataset_version", "bicycle", "file", "findings", "stopped_early")
    return json.dumps({key: whole[key] for key in keys}, indent=2, allow_nan=False)
