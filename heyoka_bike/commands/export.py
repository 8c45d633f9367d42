"""Write the reference as C, Fortran, MATLAB, JSON, CSV or netCDF.

Write the reference for programs without HDF5 or Python. c, fortran and matlab (for GNU Octave too)
are source code that evaluates the columns at any time, exact and needing nothing else; csv and
netcdf are the rows; json is both.

example: heyoka-bike export --format c --columns roll_angle,steer_angle -o src/
"""

import argparse
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from heyoka_bike.commands.options import (
    add_command,
    add_format,
    add_maneuver,
    add_output,
    add_reference,
)
from heyoka_bike.errors import Exit, InputError

_FORMATS = ("c", "fortran", "matlab", "json", "csv", "netcdf")
_STEM = "uncontrolled_bicycle"


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = add_command(subparsers, run, __doc__)
    add_format(p, _FORMATS, required=True)
    said = f"file, or folder for {_STEM}.* (default: this folder)"
    add_output(p, said, metavar="FILE_OR_DIR", default=".")
    add_maneuver(p, "export this one (default: all)", int)
    p.add_argument(
        "--columns",
        metavar="NAMES",
        help="names separated by commas, or all (default: the eight of the benchmark in their "
        "default definitions)",
    )
    p.add_argument("--digits", metavar="N", type=int, help="of csv: 17 (default) or 32")
    add_reference(p)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.reference.exports.selection import choose
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.system.files import write_outputs

    exporter = import_module(f"heyoka_bike.reference.exports.{args.format}")
    render = exporter.render
    if args.digits is not None:
        render = partial(render, digits=_digits(args))
    folder, stem = _place(args.output, exporter.SUFFIXES)
    selection = choose(load_reference(args.reference), args.maneuver, args.columns)
    files = {folder / f"{stem}{ending}": data for ending, data in render(selection, stem).items()}
    write_outputs(files)
    for path in files:
        print(path)
    return Exit.OK


def _digits(args: argparse.Namespace) -> int:
    from heyoka_bike.reference.exports.csv import DIGITS

    if args.format != "csv":
        raise InputError("--digits: expected with --format csv only")
    if args.digits not in DIGITS:
        raise InputError(f"--digits: found {args.digits}, expected {' or '.join(map(str, DIGITS))}")
    return int(args.digits)


def _place(output: str, suffixes: tuple[str, ...]) -> tuple[Path, str]:
    """Folder, and name without its suffix."""
    if output == "-":
        raise InputError("--output: found '-', expected a file or a folder")
    out = Path(output)
    if out.is_dir() or output.endswith("/") or not (out.suffix or out.is_file()):
        return out, _STEM
    if out.suffix not in suffixes:
        raise InputError(
            f"--output: found '{out.name}', expected a file ending in {' or '.join(suffixes)}, or "
            "a folder (with a final / if it has a dot)"
        )
    return out.parent, out.stem
