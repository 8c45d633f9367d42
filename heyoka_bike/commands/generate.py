"""Integrate the maneuvers and write the reference files.

Integrate each maneuver with heyoka at high precision, prove a bound on the distance between the
exact motion and the result, round every value correctly, and write a dataset: rows and dense output
(HDF5), the 25-column text with 17 and with 50 digits, the candidate polynomials, the certificate,
the sensitivities to all parameters, the whole motion with all forces, and a manifest. A file whose
content does not change is not written. Files are replaced atomically, the manifest last. After an
interruption, give the same command again.

examples:
  heyoka-bike generate --bicycle pista --out my-reference
  heyoka-bike generate --bicycle pista silver browser --until 2 --out sets
  heyoka-bike generate --all-bicycles --cluster tcp://node7:8786
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands import options
from heyoka_bike.commands.printing import print_json, print_table
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.system.console import progress_bars
from heyoka_bike.system.log import complain
from heyoka_bike.version import __version__

if TYPE_CHECKING:
    from heyoka_bike.motion.events import Ending
    from heyoka_bike.reference.making import Generated
    from heyoka_bike.reference.proof.compute_table import Table

_DIGITS_ASKED = 70
_HEADINGS = (
    "maneuver", "steps", "order", "digits", "max |E - E0| / E0", "in 2^-p", "eq. (1) [%]",
    "certified bound", "CPU [s]",
)  # fmt: skip
_SHARES_OF_GENERATE = {
    "integrate": 0.15, "certify": 0.25, "rows": 0.05, "dense": 0.1, "motion": 0.2, "vary": 0.25,
}  # fmt: skip


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = options.add_command(subparsers, run, __doc__)
    said = {
        "--digits N": "decimal digits of the integration, 65 to 1000 (default 70)",
        "--bicycle NAME|FILE": "name of a bundled bicycle, or a TOML file (default: benchmark); "
        "for several, each dataset goes to a folder named after its bicycle",
        "--all-bicycles": "generate a dataset for each bundled bicycle",
        "--maneuvers NAME|FILE": "name of bundled maneuvers, or a TOML file (default: the "
        "maneuvers with the bicycle's name; benchmark for a bicycle from a file)",
        "--until WHEN": "end time [s], instead of the maneuvers' own durations; or 'fall': end at "
        "the last row before a wheel lifts or the model is no longer valid",
        "--after-ten-seconds": "write after-ten-seconds.json instead: proved facts about the "
        "benchmark's motions after their first ten seconds, with the candidate files that "
        "'certify --after-ten-seconds' needs; takes five minutes",
        "--out DIR": "output folder (default ./reference; ./reference/after-ten-seconds with that "
        "option; ./sets for several bicycles)",
        "--force": "replace a dataset of another version or with other inputs",
    }
    options.add_arguments(
        p, said, digits={"type": int, "default": _DIGITS_ASKED}, bicycle={"nargs": "+"}
    )
    options.add_format(p, ("table", "json"))
    options.add_workers(p)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    if args.after_ten_seconds:
        return _after(args)
    from heyoka_bike.reference.making import generate_sets

    folders = _folders(args)
    made: list[Generated] = []
    with progress_bars(_SHARES_OF_GENERATE) as progress:
        failed = generate_sets(
            folders, maneuvers=args.maneuvers or None, digits=args.digits, until=args.until,
            force=args.force, say=complain, progress=progress, made=made.append,
        )  # fmt: skip
    made.sort(key=lambda found: found.folder)
    _print(args, [_set(found) for found in made], failed, is_one=len(folders) == 1)
    codes = [_code(error) for error in failed.values()]
    for folder, error in failed.items():
        complain(f"{folder}: not written: {error}")
    if any(end.is_early for found in made for end in found.endings):
        codes.append(Exit.STOPPED_EARLY)
    return codes[0] if codes else Exit.OK


def _folders(args: argparse.Namespace) -> dict[Path, str]:
    """Return a mapping from the folder of each requested dataset to its bicycle."""
    from heyoka_bike.system.resources import collection

    if args.all_bicycles and args.bicycle is not None:
        raise InputError("found both --bicycle and --all-bicycles, expected one of them")
    bicycles = sorted(collection("bicycles")) if args.all_bicycles else args.bicycle
    if bicycles is None or len(bicycles) == 1:
        out = "reference" if args.out is None else args.out
        if not out.strip():
            raise InputError("--out: found nothing, expected a folder")
        return {Path(out): (bicycles or ["benchmark"])[0]}
    names = [Path(x).stem if x.endswith(".toml") else x for x in bicycles]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"--bicycle: found '{name}' twice, expected each bicycle once")
    out = "sets" if args.out is None else args.out
    return {Path(out, name): x for name, x in zip(names, bicycles, strict=True)}


def _after(args: argparse.Namespace) -> int:
    """Write the proved facts about the benchmark's motions after their ten seconds."""
    from heyoka_bike.workbench.after_ten_seconds.making import generate_after

    given = {
        "--bicycle": args.bicycle, "--all-bicycles": args.all_bicycles,
        "--maneuvers": args.maneuvers, "--digits": args.digits != _DIGITS_ASKED,
        "--until": args.until,
    }  # fmt: skip
    for option, is_given in given.items():
        if is_given:
            raise InputError(
                f"{option} cannot be combined with --after-ten-seconds, which always uses the "
                "benchmark's inputs"
            )
    out = "reference/after-ten-seconds" if args.out is None else args.out
    with progress_bars({"certify": 1.0}) as progress:
        changed = generate_after(out, progress=progress)
    made = {"folder": out, "dataset_version": None, "written": list(changed), "maneuvers": []}
    _print(args, [made], {}, is_one=True)
    return Exit.OK


def _print(
    args: argparse.Namespace, sets: Sequence[Any], failed: Mapping[Path, Exception], *, is_one: bool
) -> None:
    """Print the datasets: JSON, or a table of their maneuvers and one line for each dataset.

    Parameters
    ----------
    sets
        Documents of `_set`.
    is_one
        True if only one dataset was requested: the table then omits its name.
    """
    if args.format == "json":
        print_json(_document(sets, failed))
        return
    rows = [
        (
            ("" if is_one else f"{Path(made['folder']).name}, ") + run["maneuver"],
            str(run["steps"]), str(run["order"]), run["precision"].split()[0],
            f"{run['energy_drift']:.1e}", f"{run['energy_drift'] * 2.0 ** run['bits']:.2g}",
            f"{run['performance_percent']:.1e}", run["bound"], f"{run['cpu_seconds']:.1f}",
        )
        for made in sets
        for run in made["maneuvers"]
    ]  # fmt: skip
    if rows:
        print_table(_HEADINGS, rows, title="reference solution")
    for made in sets:
        version = made["dataset_version"] and f"dataset version {made['dataset_version']}, "
        written = f"written: {', '.join(made['written'])}"
        what = written if made["written"] else "already up to date, nothing written"
        print(f"{made['folder']}: {version or ''}{what}")


def _document(sets: Sequence[Any], failed: Mapping[Path, Exception]) -> dict[str, Any]:
    """Return the document that ``generate-1.schema.json`` describes."""
    left = [
        {"folder": str(folder), "message": str(error), "exit_code": _code(error)}
        for folder, error in failed.items()
    ]
    return {"schema_version": 1, "version": __version__, "sets": sets, "failed": left}


def _code(error: Exception) -> int:
    return int(getattr(error, "exit_code", Exit.INTERNAL))


def _set(made: Generated) -> dict[str, Any]:
    return {
        "folder": str(made.folder),
        "dataset_version": made.dataset_version,
        "written": list(made.changed),
        "maneuvers": list(map(_maneuver, made.tables, made.endings)),
    }


def _maneuver(made: Table, end: Ending) -> dict[str, Any]:
    from heyoka_bike.numbers.rounding import decimal_above

    run, drift = made.trajectory, made.drift
    return {
        "maneuver": run.maneuver.name,
        "duration": str(run.maneuver.duration),
        "ended_early": end.is_early,
        "ending": end.said,
        "steps": run.steps,
        "order": run.order,
        "precision": run.precision,
        "bits": run.bits,
        "energy_drift": drift.energy * 2.0**-run.bits,
        "performance_percent": drift.performance,
        "bound": decimal_above(made.certificate.worst),
        "cpu_seconds": made.cpu,
    }
