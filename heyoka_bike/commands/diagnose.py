"""Say why a result file differs: the mistake whose simulation explains it.

Simulate the usual mistakes (a sign of a product of inertia, a wheel's inertia, the steer axis,
gravity, the start, rates by differences, ...), alone and two together, and name those that explain
the file; else the one, two or three parameters whose other values do; else what the error looks
like: a step size and its order, damping, noise, interpolation. Files are read as by 'score'. Takes
1 to 5 seconds of processor time, and at most 20 (--budget): a search that is not over then says
what it found, and that it stopped early; a step that passes this by 5 s is interrupted. Where a
force is left that nothing explains, two mistakes at once are tried with --thorough only. heyoka is
not needed. The same is part of 'score --diagnose', with a figure in its HTML. The first lines say
which conventions the file follows (axes, units, zero of the energy, definitions), which are no
errors. -v tells of each step what it tried, what that left and how long it took.

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
    maneuver = {"--maneuver N": "maneuver that a file of one maneuver holds"}
    details = {"--details": "print every remark, also where no cause is named"}
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

    # Those of the diagnosis come first, then those of `score`.
    whole = document(found)
    keys = ("schema_version", "dataset_version", "bicycle", "file", "findings", "stopped_early")
    return json.dumps({key: whole[key] for key in keys}, indent=2, allow_nan=False)
