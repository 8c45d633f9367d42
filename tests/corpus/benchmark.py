"""The benchmark as its definition states it, and the class of a run, shared by the corpus's
scripts.

No script in this folder uses the package that judges the results.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]

TABLE_1: Mapping[str, float] = {
    "w": 1.02, "c": 0.08, "lam": np.pi / 10, "g": 9.81,
    "rR": 0.3, "mR": 2.0, "IRxx": 0.0603, "IRyy": 0.12,
    "xB": 0.3, "zB": -0.9, "mB": 85.0, "IBxx": 9.2, "IByy": 11.0, "IBzz": 2.8, "IBxz": 2.4,
    "xH": 0.9, "zH": -0.7, "mH": 4.0,
    "IHxx": 0.05892, "IHyy": 0.06, "IHzz": 0.00708, "IHxz": -0.00756,
    "rF": 0.35, "mF": 3.0, "IFxx": 0.1405, "IFyy": 0.28,
}  # fmt: skip
"""SI units, axes x forward, y to the right, z down; inertia as matrix elements."""

MANEUVERS = ((4.0, 0.05), (4.6, 0.5), (8.0, 0.05))
"""Forward speed [m/s] and roll rate [rad/s] at the start."""

TIMES = np.arange(1001) / 100
"""Times of the rows [s]."""

COLUMNS = ("roll", "roll_rate", "speed", "potential", "kinetic", "steer", "steer_rate")
"""Columns that a run stores; the mechanical energy is the sum of the other two."""

Columns = Mapping[str, Array]
"""Columns of one maneuver; each has as many rows as `TIMES`."""


@dataclass(frozen=True)
class Run:
    """Three maneuvers with one program, correct or with one mistake.

    Attributes
    ----------
    name
    program
        Name of the program, with its method and tolerance.
    did
        Description of the mistake; empty for a correct run.
    expected
        The right answer: ``correct``, ``linearised`` or the mistake in a few words.
    compute
        Function that returns the columns of a maneuver; maneuvers count from 0.
    """

    name: str
    program: str
    did: str
    expected: str
    compute: Callable[[int], Columns] = field(repr=False)


def changed(**values: float) -> dict[str, float]:
    """Table 1 with some values changed."""
    unknown = values.keys() - TABLE_1.keys()
    if unknown:
        raise KeyError(*unknown)
    return {**TABLE_1, **values}
