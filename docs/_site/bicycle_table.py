"""The tables of docs/reference/other-bicycles.md: critical speeds, certified sets.

Run as a script, this writes the first table, and in the second the rows of the bicycles named, all
by default. Sets are made in a temporary folder, or kept in one that is given::

    python docs/_site/bicycle_table.py [--sets FOLDER] [NAME ...]
"""

import argparse
import json
import tempfile
from fractions import Fraction
from pathlib import Path

import mpmath

from heyoka_bike.bicycle.parameters import read_bicycle
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.cli import main as command
from heyoka_bike.reference.layout import CERTIFICATE
from heyoka_bike.reference.manifest import MANIFEST, read_manifest
from heyoka_bike.system.resources import collection
from heyoka_bike.workbench.boxes.box import above, below, stability_box
from marked_parts import filled, split

PAGE = Path(__file__).parent.parent / "reference" / "other-bicycles.md"
NAMES = [name for name in collection("bicycles") if name != "benchmark"]
DIGITS = 6


def speeds(name):
    """Critical speeds, and their bounds if every parameter is within a standard deviation."""
    bicycle = read_bicycle(collection("bicycles")[name])
    linear = linearise(bicycle, DIGITS)
    weave = ", ".join(_text(v) for v, _ in linear.weave_speeds) or "none"
    capsize = ", ".join(map(_text, linear.capsize_speeds)) or "none"
    row = [f"`{name}`", bicycle.name, weave, capsize]
    if not bicycle.uncertainties:
        return [*row, "", "", ""]
    box = stability_box(bicycle, Fraction(1), DIGITS)
    return [
        *row,
        *(
            "not decided" if found is None
            else ", ".join(_interval(v.low, v.high, below, above) for v in found) or "none"
            for found in (box.weave, box.capsize)
        ),
        "no speed" if box.every is None else _interval(*box.every, above, below),
    ]  # fmt: skip


def set_of(name, folder):
    """Steps, bound and hash of the set of a bicycle, made in a folder if it is not there."""
    folder = Path(folder)
    if not (folder / MANIFEST).exists():
        assert command(["generate", "--bicycle", name, "--out", str(folder)]) == 0
    maneuvers = json.loads((folder / CERTIFICATE).read_text("utf-8"))["maneuvers"]
    assert all(m["ambiguous"] == 0 for m in maneuvers)
    return [
        f"`{name}`",
        ", ".join(str(m["steps"]) for m in maneuvers),
        max((m["bound"] for m in maneuvers), key=Fraction),
        f"`{read_manifest(folder).content_sha256}`",
    ]


def committed(table):
    """Rows of a table of the page, by name."""
    _, text, _ = split(PAGE.read_text("utf-8"), table)
    rows = [line.strip("|").split("|") for line in text.splitlines() if line.startswith("| `")]
    return {row[0].strip(" `"): [cell.strip() for cell in row] for row in rows}


def _text(x):
    return mpmath.nstr(x, DIGITS, strip_zeros=False)


def _interval(low, high, begin, end):
    shown = "no end" if high is None else end(high, DIGITS)
    return f"{begin(low, DIGITS)} to {shown}"


def _write(table, rows):
    page = PAGE.read_text("utf-8")
    inside = split(page, table)[1].strip("\n")
    heading = [line for line in inside.splitlines() if not line.startswith("| `")]
    lines = heading + ["| " + " | ".join(row) + " |" for row in rows]
    PAGE.write_text(filled(page, table, "\n".join(lines)), "utf-8")


def main():
    p = argparse.ArgumentParser()
    p.add_argument("--sets", metavar="FOLDER")
    p.add_argument("names", nargs="*", metavar="NAME")
    args = p.parse_args()
    _write("speeds", [speeds(name) for name in NAMES])
    for name in args.names or NAMES:
        with tempfile.TemporaryDirectory() as temporary:
            row = set_of(name, Path(args.sets or temporary) / name)
        rows = {**committed("sets"), name: row}
        _write("sets", [rows[n] for n in NAMES if n in rows])
        print(" ".join(row), flush=True)


if __name__ == "__main__":
    main()
