"""Check whether this installation works: packages, reference, score, a run.

List the installed packages, check that the reference dataset of the package is complete, score its
text file (whose errors must be within its rounding), and integrate maneuver 1 in binary64 and
binary128 to count the digits reached. Checks that need a missing package are skipped and listed as
such. Takes a few seconds.

example: heyoka-bike selfcheck --format json > selfcheck.json

exit codes: 0 everything that is installed works; 3 a check failed, with one line for each
on standard error.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands import options
from heyoka_bike.commands.printing import complain_of_checks, print_checks, print_json
from heyoka_bike.errors import Exit

if TYPE_CHECKING:
    from heyoka_bike.testing.selfcheck import Selfcheck


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = options.add_command(subparsers, run, __doc__)
    options.add_format(p, ("table", "json"))


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.testing.selfcheck import selfcheck

    found = selfcheck()
    if args.format == "json":
        print_json(found.as_dict())
    else:
        _show(found)
    complain_of_checks(found.folder, found.checks)
    return Exit.OK if found.passed else Exit.CHECK_FAILED


def _show(found: Selfcheck) -> None:
    m = found.machine
    print(f"machine    {m['cpu']}, {m['cores']} cores, {m['system']}")
    print(f"reference  {found.folder}")
    for name, version in found.versions.items():
        print(f"{name:<13} {version}")
    print_checks("selfcheck", found.checks)
    print("this installation " + ("works" if found.passed else "does not work"))
