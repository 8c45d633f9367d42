"""Prove the published digits in ball arithmetic.

Prove the numbers of a dataset in ball arithmetic, starting from candidate.h5 alone. The proof
bounds the distance between the exact motion and the candidate polynomials. It follows that every
published value is the exact value, correctly rounded, and that the dense output, the whole motion
with its forces, and the derivatives with respect to the parameters and the initial conditions stay
within their stated bounds. The result is compared with the files and with certificate.json.

The output names the proved files. A dataset that lacks a file is rejected. If a proof fails, one
line says which, and nothing else is printed. Needs python-flint, not heyoka. The published dataset
takes six minutes of processor time.

example: heyoka-bike certify my-reference
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from heyoka_bike.commands import options
from heyoka_bike.commands.printing import print_json, print_table
from heyoka_bike.errors import Exit
from heyoka_bike.system.console import progress_bars
from heyoka_bike.system.resources import after_folder, reference_folder
from heyoka_bike.version import __version__

_SHARES_OF_CERTIFY = {"certify": 0.2, "rows": 0.02, "dense": 0.03, "motion": 0.15, "vary": 0.6}


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    after = {
        "--after-ten-seconds": "prove the facts about the motions after their first ten seconds "
        "instead; DIR then contains after-ten-seconds.json (default: the published one); takes two "
        "minutes of processor time"
    }
    p = options.add_command(subparsers, run, __doc__, options.FOLDER | after)
    options.add_format(p, ("table", "json"))
    options.add_workers(p)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    return _after(args) if args.after_ten_seconds else _set(args)


def _after(args: argparse.Namespace) -> int:
    from heyoka_bike.reference.layout import AFTER
    from heyoka_bike.workbench.after_ten_seconds.facts import certify_after

    with progress_bars({"certify": 1.0}) as progress:
        facts = certify_after(args.dir or None, progress=progress)
    folder = args.dir or after_folder()
    if args.format == "json":
        said = [{"about": fact.about, "statement": fact.statement} for fact in facts]
        print_json(_document(folder, {AFTER: []}, facts=said))
        return Exit.OK
    for fact in facts:
        print(f"{fact.about}: {fact.statement}")
    numbers = sum(len(fact.numbers) for fact in facts)
    print(f"{folder}: proved: {AFTER}, {numbers} numbers and the sentences above")
    return Exit.OK


def _set(args: argparse.Namespace) -> int:
    from heyoka_bike.numbers.rounding import decimal_above
    from heyoka_bike.reference.manifest import read_manifest
    from heyoka_bike.reference.proof.certificate import entry, proved
    from heyoka_bike.reference.proof.certify import certify
    from heyoka_bike.reference.structure import COLUMNS_OF

    folder = args.dir or reference_folder()
    with progress_bars(_SHARES_OF_CERTIFY) as progress:
        proofs = certify(args.dir or None, progress=progress)
    columns = proved(read_manifest(folder).files, COLUMNS_OF)
    if args.format == "json":
        said = [{**entry(proof), "cpu_seconds": proof.cpu} for proof in proofs]
        print_json(_document(folder, columns, maneuvers=said))
        return Exit.OK
    headings = (
        "maneuver", "steps", "bound over the interval", "bound at the end", "entries",
        "ambiguous", "dense, relative", "derivatives, relative", "CPU [s]",
    )  # fmt: skip
    widest = [max(*p.dense.values(), *p.motion_dense.values()) for p in proofs]
    rows = [
        (
            proof.name, str(proof.steps), decimal_above(proof.bound),
            decimal_above(proof.bound_end),
            str(proof.entries + proof.motion_entries + proof.derivative_entries),
            str(proof.ambiguous + proof.derivatives_ambiguous), decimal_above(dense),
            decimal_above(max(proof.derivatives.values())),
            f"{proof.cpu:.1f}",
        )
        for proof, dense in zip(proofs, widest, strict=True)
    ]  # fmt: skip
    print_table(headings, rows, title=f"certificate of {folder}")
    listed = ", ".join(f"{name} ({len(names)} columns)" for name, names in columns.items())
    print(f"{folder}: proved: {listed}")
    return Exit.OK


def _document(
    folder: str | Path, proved: Mapping[str, Sequence[str]], *,
    maneuvers: Sequence[Mapping[str, Any]] = (), facts: Sequence[Mapping[str, str]] = (),
) -> dict[str, Any]:  # fmt: skip
    """Return the document that ``certify-1.schema.json`` describes."""
    return {
        "schema_version": 1, "version": __version__, "folder": str(folder), "proved": dict(proved),
        "computed": {}, "maneuvers": list(maneuvers), "facts": list(facts),
    }  # fmt: skip
