"""Read a bicycle from another program's file: BicycleParameters, URDF, SDFormat or MJCF.

Write the bicycle as a TOML file for the other commands. A BicycleParameters file has lines such as
IBxx = 9.2+/-0.1 or IBxx: 9.2, with or without standard deviations. A URDF, SDFormat or MJCF file
must describe a tree of a frame, a fork and two wheels that stands upright at zero angles. Its axes
may have any names and directions. Links that are fixed to one another are joined.

Each property that the 26 parameters cannot represent is reported in a line on standard error:
products of inertia xy and yz, offsets from the plane of the rear wheel, unbalanced wheels. A fifth
moving body, wheels that are not parallel or do not stand on one level, and other kinds of joints
are rejected.

examples:
  heyoka-bike import BrowserBenchmark.txt -o browser.toml
  heyoka-bike import my_bicycle.urdf | tee my_bicycle.toml
  heyoka-bike import my_bicycle.sdf -o my_bicycle.toml
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
        "FILE": "a file of BicycleParameters, URDF, SDFormat or MJCF",
        "-o --output FILE": "TOML file to write (default: standard output)",
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
