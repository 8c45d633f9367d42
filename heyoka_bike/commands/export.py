"""Write the reference, the equations, a physics engine's model or a checker for other programs.

--format writes the reference for programs without HDF5 or Python. c, fortran and matlab (also for
GNU Octave) are source code without dependencies that evaluates the columns at any time; csv and
netcdf contain the rows; json contains both.

--equations writes the equations of motion of a bicycle as source code without dependencies, with
the parameters as constants. Its functions are: rates, the time derivative of the state; jacobian,
the derivatives of the rates; columns, the output columns of the benchmark; start_1 and so on, the
initial conditions of the maneuvers. C and Python also have the descriptor form, for solvers of
differential-algebraic equations: mass, force, constraint_jacobian, heights, and residuals of index
2 and 3.

--model writes a bicycle for physics engines as urdf, sdf (SDFormat) or mjcf (MuJoCo): four links,
three joints, thin wheels, visible shapes, axes with z up, and the initial conditions of each
maneuver.

--checker writes one header for C and C++ with the exact motion in every definition of the columns,
and with functions that count the correct digits in your arrays. It serves tests without Python and
does less than 'heyoka-bike score'. --page writes the same as a web page: a single file that reads
results in the browser and sends nothing anywhere.

examples:
  heyoka-bike export --format c --columns roll_angle,steer_angle -o src/
  heyoka-bike export --equations python
  heyoka-bike export --equations fortran --bicycle pista -o src/pista.f90
  heyoka-bike export --model urdf --bicycle browser --nearest-valid-inertia
  heyoka-bike export --checker tests/
  heyoka-bike export --page judge.html
"""

import argparse
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Any

from heyoka_bike.commands import options
from heyoka_bike.errors import Exit, InputError, quoted
from heyoka_bike.system.log import complain

_FORMAT_NAMES = ("c", "fortran", "matlab", "json", "csv", "netcdf")
_LANGUAGES = ("c", "fortran", "matlab", "julia", "python", "rust")
_MODELS = ("urdf", "sdf", "mjcf")
_STEM_NAME, _BICYCLE = "uncontrolled_bicycle", "bicycle"
# For each option that selects a kind of export: the other options that it accepts.
_GOES_WITH = {
    "format": ("maneuver", "columns", "digits", "reference"),
    "equations": ("bicycle", "maneuvers"),
    "model": ("bicycle", "maneuvers", "tyre", "nearest_valid_inertia"),
    "checker": ("reference",),
    "page": (),
}


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = options.add_command(subparsers, run, __doc__)
    what: Any = p.add_mutually_exclusive_group(required=True)
    options.add_format(what, _FORMAT_NAMES, "")
    kinds = {
        "--equations LANGUAGE": "write the equations of motion in one of "
        f"{', '.join(_LANGUAGES)} (matlab also for GNU Octave)",
        "--model FORMAT": f"write a model for physics engines in one of {', '.join(_MODELS)}",
        "--checker [FILE_OR_DIR]": f"write {_STEM_NAME}.h: the exact motion, and functions that "
        "count your correct digits",
        "--page [FILE_OR_DIR]": f"write {_STEM_NAME}.html: a page that scores files in the "
        "browser, without a server",
    }
    # Without a value, these options write to the file or folder of -o. An empty value means the
    # current folder.
    place: dict[str, object] = {"const": True, "type": lambda text: text or "."}
    options.add_arguments(
        what, kinds, equations={"choices": _LANGUAGES}, model={"choices": _MODELS},
        checker=place, page=place,
    )  # fmt: skip
    others = {
        "-o --output FILE_OR_DIR": f"file, or folder for {_STEM_NAME}.* or {_BICYCLE}.* "
        "(default: the current folder)",
        "--bicycle NAME|FILE": "with --equations and --model: name of a bundled bicycle, or a TOML "
        "file (default: benchmark)",
        "--maneuvers NAME|FILE": "with --equations and --model: name of bundled maneuvers, or a "
        "TOML file (default: the maneuvers with the bicycle's name; benchmark for a bicycle from a "
        "file)",
        "--tyre WIDTH": "with --model: width of the wheels [m]; 0, the default, makes them as thin "
        "as engines accept",
        "--nearest-valid-inertia": "with --model: if no solid body has the masses and moments of "
        "inertia, change them as little as possible, and report the changes",
        "--maneuver N": "export only this maneuver (default: all)",
        "--columns NAMES": "column names separated by commas, or all (default: the eight columns "
        "of the benchmark in their default definitions)",
        "--digits N": "digits of csv: 17 (default) or 32",
        **options.REFERENCE,
    }
    options.add_arguments(
        p, others, maneuver={"type": int}, digits={"type": int},
        nearest_valid_inertia={"default": None},
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.system.files import write_outputs

    asked = next(kind for kind in _GOES_WITH if getattr(args, kind))
    for name in dict.fromkeys(name for names in _GOES_WITH.values() for name in names):
        if getattr(args, name) is not None and name not in _GOES_WITH[asked]:
            raise InputError(f"--{name.replace('_', '-')} cannot be combined with --{asked}")
    args.output = _output(args, asked)
    write = {
        "format": _reference, "equations": _equations, "model": _model, "checker": _checker,
        "page": _page,
    }  # fmt: skip
    files = write[asked](args)
    write_outputs(files)
    for path in files:
        print(path)
    return Exit.OK


def _output(args: argparse.Namespace, asked: str) -> str:
    """Return the file or folder to write: the value of --checker, --page or -o."""
    place, output = getattr(args, asked), args.output
    if asked not in ("checker", "page") or place is True:
        return "." if output is None else str(output)
    if output is not None:
        raise InputError(
            f"--{asked}: found {quoted(place)} and -o {quoted(output)}, expected one of them"
        )
    return str(place)


def _reference(args: argparse.Namespace) -> dict[Path, bytes]:
    from heyoka_bike.reference.exports.formats import FORMATS, choose
    from heyoka_bike.reference.load import load_reference

    suffixes, render = FORMATS[args.format]
    if args.digits is not None:
        render = partial(render, digits=_digits(args))
    folder, stem = _place(args.output, suffixes, _STEM_NAME)
    selection = choose(load_reference(args.reference), args.maneuver, args.columns)
    return {folder / f"{stem}{ending}": data for ending, data in render(selection, stem).items()}


def _equations(args: argparse.Namespace) -> dict[Path, bytes]:
    from heyoka_bike.bicycle.parameters import read_inputs
    from heyoka_bike.reference.exports.equations import LANGUAGES, render

    folder, stem = _place(args.output, LANGUAGES[args.equations].suffixes, _BICYCLE)
    bicycle, maneuvers = read_inputs(args.bicycle or "benchmark", args.maneuvers)
    _warn(bicycle.name, bicycle.warnings)
    found = render(args.equations, bicycle, maneuvers, stem)
    return {folder / f"{stem}{ending}": data for ending, data in found.items()}


def _model(args: argparse.Namespace) -> dict[Path, bytes]:
    from heyoka_bike.bicycle.parameters import read_inputs
    from heyoka_bike.numbers.exact import Exact
    from heyoka_bike.reference.exports.models import MODELS, refused, render
    from heyoka_bike.reference.exports.solid import nearest_solid

    suffix = MODELS[args.model].suffix
    folder, stem = _place(args.output, (suffix,), _BICYCLE)
    bicycle, maneuvers = read_inputs(args.bicycle or "benchmark", args.maneuvers)
    width = Exact.read("--tyre", args.tyre or "0")
    if width.sign < 0 or not width.is_rational:
        raise InputError(f"--tyre: found {quoted(args.tyre)}, expected zero or more, without pi")
    if args.nearest_valid_inertia:
        bicycle, changes = nearest_solid(bicycle)
        for change in changes:
            complain(f"{bicycle.name}: {change}")
    reasons = list(refused(bicycle))
    _warn(bicycle.name, reasons)
    if reasons:
        complain("use --nearest-valid-inertia to write the nearest bicycle that every engine loads")
    return {folder / f"{stem}{suffix}": render(args.model, bicycle, maneuvers, width.rational)}


def _warn(name: str, warnings: Iterable[str]) -> None:
    for warning in warnings:
        complain(f"warning: {name}: {warning}")


def _checker(args: argparse.Namespace) -> dict[Path, bytes]:
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.workbench.checker.header import checker_header

    folder, stem = _place(args.output, (".h",), _STEM_NAME)
    return {folder / f"{stem}.h": checker_header(load_reference(args.reference))}


def _page(args: argparse.Namespace) -> dict[Path, bytes]:
    from heyoka_bike.workbench.checker.page import checker_page

    folder, stem = _place(args.output, (".html",), _STEM_NAME)
    return {folder / f"{stem}.html": checker_page().encode()}


def _digits(args: argparse.Namespace) -> int:
    from heyoka_bike.reference.exports.formats import DIGITS

    if args.format != "csv":
        raise InputError("--digits needs --format csv")
    if args.digits not in DIGITS:
        raise InputError(f"--digits: found {args.digits}, expected {' or '.join(map(str, DIGITS))}")
    return int(args.digits)


def _place(output: str, suffixes: tuple[str, ...], stem: str) -> tuple[Path, str]:
    """Return the folder and the file name without suffix: `stem` if only a folder is given."""
    if output == "-":
        raise InputError("--output: found '-', expected a file or a folder")
    out = Path(output)
    if out.is_dir() or output.endswith("/") or not (out.suffix or out.is_file()):
        return out, stem
    if out.suffix not in suffixes:
        raise InputError(
            f"--output: found '{out.name}', expected a file ending in {' or '.join(suffixes)}, or "
            "a folder (end it with / if its name contains a dot)"
        )
    return out.parent, out.stem
