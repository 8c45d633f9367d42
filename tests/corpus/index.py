"""Write `index.toml`: the description of each file of the corpus, and the size of its mistake.

``python -m corpus.index`` in tests (NumPy and h5py only).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from corpus.files import files
from corpus.writing import HERE, ORDER, File, Runs

RIGHT = {
    "symbrim": "symbrim-dop853-1e-12", "newton": "newton-dop853-1e-12",
    "exudyn": "exudyn-trapezoidal-0.001", "linear": "linear-expm",
}  # fmt: skip
"""The correct run of each program, with which its mistakes are compared."""
OWN_ERROR = {"symbrim": 2e-7, "newton": 3e-8, "exudyn": 2e-4, "linear": 1e-9}
"""Error of these runs, relative to each column's largest value."""


def size(file: File, runs: Runs) -> float:
    """Largest change of a column by the mistake, relative to the column's largest value."""
    largest = 0.0
    program = file.run.split("-")[0]
    for place, maneuver in enumerate(file.maneuvers):
        block, is_of_run = runs.block(file.run, maneuver), runs.index[file.run]["did"]
        if not is_of_run:
            for change in file.changes:
                block = change(block)
        meant = place + 1 if len(file.maneuvers) == 3 else maneuver
        right = runs.block(RIGHT[program], meant)
        # Interpolate the correct values at the times of the file.
        rows = np.isfinite(block["roll"]) & (block["time"] <= right["time"][-1])
        for name in ORDER:
            there = np.interp(block["time"][rows], right["time"], right[name])
            scale = max(abs(right[name]).max(), 1e-300)
            largest = max(largest, abs(block[name][rows] - there).max() / scale)
    return largest


def entries(runs: Runs) -> Iterator[Mapping[str, Any]]:
    for file in files(runs.index):
        run = runs.index[file.run]
        entry = {
            "name": file.name,
            "program": run["program"],
            "did": "; ".join(x for x in (run["did"], file.did) if x),
            "expected": expected(file, run),
        }
        if is_mistake(entry["expected"]):
            found = float(size(file, runs))
            entry |= {
                "size": float(f"{found:.2g}"),
                "visible": bool(found > 10 * OWN_ERROR[file.run.split("-")[0]]),
            }
        yield entry


def expected(file: File, run: Mapping[str, Any]) -> str:
    """The right answer: a mistake of the run or of its output, ``convention`` or ``correct``."""
    right: str = run["expected"]
    if file.expected in ("", "convention"):
        return right if right not in ("correct",) or not file.expected else file.expected
    return file.expected


def is_mistake(answer: str) -> bool:
    return answer not in ("correct", "convention", "linearised")


def main() -> None:
    lines = ["# Written by index.py.", ""]
    for entry in entries(Runs()):
        lines.append("[[file]]")
        lines += [f"{key} = {json.dumps(value)}" for key, value in entry.items()]
        lines.append("")
    Path(HERE / "index.toml").write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
