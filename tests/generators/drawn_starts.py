"""Randomly drawn bicycles and initial states: values zero, exact, huge or tiny, combined."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.numbers.exact import Exact

VALUES = {
    "speed": ("0", "5", "-4.6", "0.125", "1e-12", "300", "pi"),
    "roll": ("0", "0.1", "-1/4", "1.2", "1e-30"),
    "steer": ("0", "-0.02", "1/2", "pi/4", "1e-20", "-1.3"),
    "roll_rate": ("0", "0.5", "-2", "1e-25", "40"),
    "steer_rate": ("0", "-1/8", "3", "1e-40", "60"),
}
"""Values of the initial states. Each entry is zero in about half of the states."""

_SCALED = (
    "w", "c", "g", "rR", "mR", "xB", "zB", "mB", "IByy", "mH", "IHyy", "rF", "mF", "IFyy", "IRyy",
)  # fmt: skip


def bicycles(bicycle: Bicycle, count: int, seed: int = 1) -> Iterator[Bicycle]:
    """Yield bicycles with parameters 0.8 to 1.25 times the given ones, as short decimals."""
    draw = random.Random(seed)
    for number in range(count):
        factors = {name: Fraction(draw.randint(80, 125), 100) for name in _SCALED}
        changed = {name: Exact(bicycle[name].rational * x) for name, x in factors.items()}
        yield replace(bicycle.replace(**changed), name=f"drawn {number}")


def starts(maneuver: Maneuver, count: int, seed: int = 1) -> Iterator[Maneuver]:
    """Yield maneuvers of two rows, a millisecond apart."""
    draw = random.Random(seed)
    for number in range(count):
        given = {
            key: "0" if draw.random() < 0.4 else draw.choice(values)
            for key, values in VALUES.items()
        }
        name = f"{number}: " + ", ".join(f"{key} {x}" for key, x in given.items())
        exact = {key: Exact.parse(x) for key, x in given.items()}
        short = Fraction(1, 1000)
        yield replace(
            maneuver, name=name, **exact, duration=short, spacing=short, performance_limit=None
        )
