"""``heyoka-bike certify``: prove the published digits again, from the published files."""

from __future__ import annotations

import argparse
from typing import Any

from heyoka_bike.errors import Exit

_SHARES = {"certify": 0.5, "rows": 0.05, "dense": 0.05, "motion": 0.4}


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = subparsers.add_parser(
        "certify",
        help="prove the published digits in ball arithmetic",
        description=(
            "Prove, from candidate.h5 alone and in ball arithmetic, how far the exact motion may "
            "be from the candidate; from that, that every published value is the correctly rounded "
            "exact one and that the dense output keeps its bounds, those of the whole motion and "
            "its forces too; and compare with the files and certificate.json. Needs python-flint, "
            "not heyoka. Two minutes of processor time for the published set."
        ),
        epilog="example: heyoka-bike certify my-reference",
    )
    p.add_argument("folder", nargs="?", metavar="DIR", help="folder (default: the published set)")
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from heyoka_bike.numbers.rounding import decimal_above
    from heyoka_bike.reference.proof.prove_again import certify
    from heyoka_bike.system.parallel import progress_bars
    from heyoka_bike.system.resources import reference_folder

    folder = args.folder or reference_folder()
    with progress_bars(_SHARES) as progress:
        proofs = certify(args.folder or None, progress=progress)
    view = Table(title=f"certificate of {folder}")
    headings = (
        "maneuver", "steps", "bound over the interval", "bound at the end", "entries",
        "ambiguous", "dense, relative", "CPU [s]",
    )  # fmt: skip
    for heading in headings:
        view.add_column(
            Text(heading), justify="left" if heading == "maneuver" else "right", no_wrap=True
        )
    for proof in proofs:
        view.add_row(
            proof.name, str(proof.steps), decimal_above(proof.bound),
            decimal_above(proof.bound_end), str(proof.entries), str(proof.ambiguous),
            decimal_above(max(proof.dense.values())), f"{proof.cpu:.1f}",
        )  # fmt: skip
    console = Console()
    console.width = max(console.width, 120)
    console.print(view)
    print(f"{folder}: every published value is proved")
    return Exit.OK
