"""Check every file and every number of a dataset, in seconds.

Check the folder of a dataset: the sizes and hashes of its files, their structure, that all forms of
a number agree (hi + lo, bound, 17 and 50 digits, dense output, candidate, certificate), and that
every row obeys the model (energy, contact, equations of motion), each within the certified bounds.
Any damaged byte is found, and the report names its file. The check takes a few seconds and does not
need heyoka. It takes the bounds as given; 'certify' proves them.

With --rerun the motion is also integrated again, at the precision of the dataset and with 20 more
digits, and the agreeing digits are counted. This needs heyoka and takes a minute, or about 15 s
with --quick.

examples:
  heyoka-bike verify
  heyoka-bike verify my-reference --format json
  heyoka-bike verify --rerun --quick

exit codes: 0 every check passed; 1 the folder cannot be read; 3 a check failed (a missing
manifest too), with one line for each on standard error. See docs/verify.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands import options, printing
from heyoka_bike.errors import Exit, InputError, printable
from heyoka_bike.system.console import patience, progress_bars

if TYPE_CHECKING:
    from heyoka_bike.reference.verification.outcome import Agreement, Verification

_MAX_OTHER_FILES = 5  # maximum number of files outside the dataset that the warning lists
_SHARES_OF_VERIFY = {"integrate": 0.9, "compare": 0.1}


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    said = {
        **options.FOLDER,
        "--rerun": "also integrate the motion again and count the agreeing digits",
        "--quick": "with --rerun: integrate in binary128 and with 40 digits only",
    }
    p = options.add_command(subparsers, run, __doc__, said)
    options.add_format(p, ("table", "json"))
    options.add_workers(p)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    if args.quick and not args.rerun:
        raise InputError("--quick needs --rerun")
    if args.dir is not None and not args.dir.strip():
        raise InputError("DIR: found nothing, expected a folder")
    if args.rerun:
        from heyoka_bike.motion.heyoka_adapter import require_heyoka

        require_heyoka()
    from heyoka_bike.reference.verification.numbers import run_again
    from heyoka_bike.reference.verification.verify import verify

    with patience("checking"):
        found = verify(args.dir)
    if args.rerun:
        with progress_bars(_SHARES_OF_VERIFY) as progress:
            found = run_again(found, is_quick=args.quick, progress=progress)
    if args.format == "json":
        printing.print_json(found.as_dict())
    else:
        _show(found)
    printing.complain_of_checks(found.folder, found.checks)
    return Exit.OK if found.passed else Exit.CHECK_FAILED


def _show(found: Verification) -> None:
    printing.print_checks(f"{found.folder}, dataset version {found.dataset_version}", found.checks)
    if found.agreements:
        _show_digits(found.agreements)
    failed = sum(c.passed is False for c in found.checks)
    unmade = sum(c.passed is None for c in found.checks)
    told = f"{len(found.checks)} checks, {failed} failed"
    if unmade:
        told += f", {unmade} not made"
    extra = (c for c in found.checks if c.check == "other_files")
    others = [printable(name) for c in extra for name in c.evidence["files"]]
    if others:
        more = ["..."] if len(others) > _MAX_OTHER_FILES else []
        shown = ", ".join([*others[:_MAX_OTHER_FILES], *more])
        print(f"{found.folder}: WARNING: not part of the dataset and not checked: {shown}")
    print(f"{found.folder}: {told}")


def _show_digits(agreements: Sequence[Agreement]) -> None:
    """Print for each column how many digits agree with the published and candidate numbers."""
    columns = agreements[0].published
    rows = [
        [name, *(f"{a.published[name]:.1f} / {a.candidate[name]:.1f}" for a in agreements)]
        for name in columns
    ]
    rows.append(["expected, at least", *(f"{min(a.promised.values()):.1f}" for a in agreements)])
    rows.append(["time [s]", *(f"{a.seconds:.1f}" for a in agreements)])
    headings = ["column", *(f"{a.maneuver}\n{a.precision}" for a in agreements)]
    title = "agreeing digits: with the published numbers / with the candidate"
    printing.print_table(headings, rows, title=title, group=len(columns))
