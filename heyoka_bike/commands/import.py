"""Read a bicycle from a file of others: BicycleParameters, URDF or MJCF.

Write it as the TOML file that the other commands take. A parameter file has lines such as IBxx =
9.2+/-0.1 or IBxx: 9.2, with or without standard deviations. A URDF or MJCF is a tree of a frame, a
fork and two wheels that stands upright at zero angles, its axes of any name and direction; links
that are fixed to one another are joined.

What the 26 parameters cannot hold is said on standard error, one line each: products of inertia xy
and yz, what is beside the plane of the rear wheel, wheels out of balance. A fifth body that moves,
wheels that are not parallel or not on one level, and joints of other kinds are refused.

examples:
  heyoka-bike import BrowserBenchmark.txt -o browser.toml
  heyoka-bike import my_bicycle.urdf | tee my_bicycle.toml
  heyoka-bike linear --bicycle my_bicycle.toml
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from heyoka_bike.commands import options
from heyoka_bike.errors import Exit
from heyoka_bike.system.log import complain


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    said = {
        "FILE": "a file of BicycleParameters, a URDF or an MJCF",
        "-o --output FILE": "the TOML file (default: standard output)",
    }
    options.add_command(subparsers, run, __doc__, said)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.bicycle.foreign.imported import import_bicycle
    from heyoka_bike.system.files import refuse_overwriting, write_output

    found = import_bicycle(args.file)
    for note in (*found.notes, *(f"warning: {x}" for x in found.bicycle.warnings)):
        complain(f"{found.bicycle.name}: {note}")
    if args.output is None:
        print(found.toml(), end="")
        return Exit.OK
    out = Path(args.output)
    refuse_overwriting([args.file], [out])
    write_output(out, found.toml().encode())
    print(out)
    return Exit.OK
