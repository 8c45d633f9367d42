"""How users write a run to a file: changes of its columns, and the text."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

HERE = Path(__file__).resolve().parent
Array = np.ndarray[Any, np.dtype[np.float64]]
Block = dict[str, Array]
"""Columns of a maneuver by name, including `time`."""
Change = Callable[[Block], Block]

ORDER = (
    "roll", "roll_rate", "speed", "potential", "kinetic", "mechanical", "steer", "steer_rate",
)  # fmt: skip
NAMES = (
    "roll_angle", "roll_rate", "forward_speed", "potential_energy", "kinetic_energy",
    "mechanical_energy", "steer_angle", "steer_rate",
)  # fmt: skip
"""Headings of the columns of `ORDER`."""


@dataclass(frozen=True)
class File:
    """A result file of the corpus.

    Attributes
    ----------
    name
    run
        Name of the run in the file.
    did
        Description of the changes to the run.
    expected
        The right answer if it differs from that of the run: a mistake of output, or ``correct``.
    changes
        Changes that are applied to the columns of each maneuver, in this order.
    maneuvers
        Numbers of the maneuvers in the file, from 1.
    columns
        Names of the columns in the file; if empty, all. If given, the file has a heading.
    number
        Format of a number.
    separator
    heading
        Whether the file begins with a line of names.
    every
        Row stride: only every `every`-th row is written.
    """

    name: str
    run: str
    did: str = ""
    expected: str = ""
    changes: tuple[Change, ...] = ()
    maneuvers: tuple[int, ...] = (1, 2, 3)
    columns: tuple[str, ...] = ()
    number: str = "%.17g"
    separator: str = " "
    heading: bool = False
    every: int = 1


def scaled(**factors: float) -> Change:
    """Multiply columns by factors."""

    def change(block: Block) -> Block:
        return {name: x * factors.get(name, 1.0) for name, x in block.items()}

    return change


def shown(**sources: str) -> Change:
    """Replace columns with other columns of the run."""

    def change(block: Block) -> Block:
        return block | {name: block[source] for name, source in sources.items()}

    return change


def with_zero(zero: Callable[[Block], float]) -> Change:
    """Change the zero of the potential energy."""

    def change(block: Block) -> Block:
        return summed(block | {"potential": block["potential"] - zero(block)})

    return change


def summed(block: Block) -> Block:
    """Compute the mechanical energy as the sum of the other two."""
    return block | {"mechanical": block["potential"] + block["kinetic"]}


def late(rows: int) -> Change:
    """Move values to the times of earlier rows, as far as there are values."""

    def change(block: Block) -> Block:
        time = block["time"]
        some = {name: x[rows:] if rows > 0 else x[:rows] for name, x in block.items()}
        return some | {"time": time[:-rows] if rows > 0 else time[-rows:]}

    return change


def shifted(seconds: float) -> Change:
    return lambda block: block | {"time": block["time"] + seconds}


def timed(factor: float) -> Change:
    return lambda block: block | {"time": block["time"] * factor}


def differences(*columns: tuple[str, str], central: bool) -> Change:
    """Compute rates as finite differences of the angles."""

    def change(block: Block) -> Block:
        found = dict(block)
        for angle, rate in columns:
            if central:
                found[rate] = np.gradient(block[angle], block["time"])
            else:
                step = np.diff(block[angle]) / np.diff(block["time"])
                found[rate] = np.append(step, step[-1])
        return found

    return change


def constant(**values: float) -> Change:
    return lambda block: block | {n: np.full_like(block["time"], x) for n, x in values.items()}


def as_single(block: Block) -> Block:
    """Round columns to binary32; the time keeps its digits."""
    return {
        name: x if name == "time" else x.astype(np.float32).astype(np.float64)
        for name, x in block.items()
    }


def coarse(rows: int) -> Change:
    """Keep every `rows`-th row, and interpolate linearly between these."""

    def change(block: Block) -> Block:
        t = block["time"]
        return {name: np.interp(t, t[::rows], x[::rows]) for name, x in block.items()}

    return change


def with_noise(size: float) -> Change:
    """Add noise of a size relative to each column's largest value."""

    def change(block: Block) -> Block:
        random = np.random.default_rng(1)
        return {
            name: x if name == "time" else x + size * abs(x).max() * random.standard_normal(len(x))
            for name, x in block.items()
        }

    return change


def lagrangian(block: Block) -> Block:
    return block | {"mechanical": block["kinetic"] - block["potential"]}


def normalised(block: Block) -> Block:
    return block | {"mechanical": block["mechanical"] / block["mechanical"][0]}


def without_wheel_spin(block: Block) -> Block:
    """Omit the energy of the wheels' rotation about their axles from the kinetic energy."""
    spin = 0.12 / 0.3**2 + 0.28 / 0.35**2
    return summed(block | {"kinetic": block["kinetic"] - spin * block["speed"] ** 2 / 2})


class Runs:
    """The stored runs."""

    def __init__(self, path: Path = HERE / "runs.h5") -> None:
        self.path = path
        with h5py.File(path) as store:
            self.index = {name: json.loads(store[name].attrs["run"]) for name in store}

    def block(self, name: str, maneuver: int) -> Block:
        """Columns of a maneuver, counted from 1."""
        with h5py.File(self.path) as store:
            values, columns = store[name][:, maneuver - 1], self.index[name]["columns"]
        found = dict(zip(columns, values, strict=True))
        found["time"] = np.round(np.linspace(0.0, 10.0, values.shape[1]), 2)
        return summed(found)


def text(file: File, runs: Runs) -> str:
    """Text of the file."""
    blocks = []
    for maneuver in file.maneuvers:
        block = runs.block(file.run, maneuver)
        for change in file.changes:
            block = change(block)
        blocks.append(block)
    rows = min(int(np.isfinite(block["roll"]).sum()) for block in blocks)
    order = file.columns or ORDER
    columns = [blocks[0]["time"], *(block[name] for block in blocks for name in order)]
    numbers = np.column_stack([x[:rows] for x in columns])[:: file.every] + 0.0
    lines = []
    if file.heading or file.columns:
        names = [NAMES[ORDER.index(name)] for name in order]
        several = len(blocks) > 1
        lines.append(file.separator.join(["time", *(
            f"m{m}_{name}" if several else name for m in file.maneuvers for name in names
        )]))  # fmt: skip
    for time, *values in numbers:
        row = [f"{time:.12g}", *(file.number % x for x in values)]
        lines.append(file.separator.join(row))
    return "\n".join(lines) + "\n"
