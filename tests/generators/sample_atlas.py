"""An atlas of invented numbers, for tests of its page."""

import numpy as np

from heyoka_bike.workbench.atlas.data import FALLS, UPRIGHT, Atlas, Edge, GridAxis

POSITIVE = ("fate_time", "lift_time", "largest_lean", "largest_steer", "condition")


def made(bicycle, x=("speed", 1.0, 9.0, 17), y=("roll_rate", 0.0, 4.0, 9)):
    """Return an atlas of invented numbers: motions fall in the upper half of the second axis."""
    axes = tuple(GridAxis(name, np.linspace(low, high, n)) for name, low, high, n in (x, y))
    shape = tuple(len(a.values) for a in axes)
    rng = np.random.default_rng(7)
    falls = np.broadcast_to(axes[1].values > np.mean(axes[1].values), shape)
    variables = {name: np.exp(rng.normal(0, 2, shape)) for name in POSITIVE}
    variables["largest_lean"][0, 0] = 0.0
    variables["lift_time"][~falls] = np.nan
    variables["final_speed"] = np.where(falls, np.nan, rng.uniform(4, 6, shape))
    variables["fate"] = np.where(falls, FALLS, rng.integers(UPRIGHT, FALLS, shape)).astype(np.int8)
    variables["lift_wheel"] = falls.astype(np.int8)
    edge = np.full(shape[0], np.mean(axes[1].values))
    start = {"roll": 0.0, "steer": 0.0, "roll_rate": 0.0, "steer_rate": 0.0, "speed": 5.0}
    return Atlas(
        bicycle, axes, start, variables, Edge(axes[0].values, edge, np.nextafter(edge, 9)),
        {"version": '<b onclick="x">'},
    )  # fmt: skip
