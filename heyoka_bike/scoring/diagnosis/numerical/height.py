"""The height of the bicycle that a file implies: potential energy against roll and steer.

Two wheels on the floor leave the potential energy to be a function of roll and steer. What a file
has more of it, over the weight, is how far its bicycle is off the floor, as a mean over its mass:
constraints that drift, wheels that sink in. It is computed from the file's own angles, whose errors
therefore do not matter.
"""

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.column_score import ColumnScore
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import ManeuverScore

# Fewer rows show no course of anything.
_FEWEST = 10
# Slopes of columns that hardly change are not looked at.
_SHIFT = 1e-6


class Heights:
    """Heights over the floor of a reference's bicycle."""

    def __init__(self, reference: Reference) -> None:
        bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
        self._reference = reference
        self._equations = Equations.binary64(bicycle)
        k = self._equations.k
        self.weight = float(k.mass * k.g * k.length)

    def of(self, m: ManeuverScore) -> tuple[Array, Array, float] | None:
        """Times [s], height over the floor [m], and what of it the digits written explain [m].

        None where a column is missing or incomplete.
        """
        columns = {c.key: c for c in m.columns if c.values and not c.missing}
        roll, steer = columns.get("roll_angle"), columns.get("steer_angle")
        potential = columns.get("potential_energy")
        if roll is None or steer is None or potential is None:
            return None
        t = roll.trace.time
        if len(t) < _FEWEST:
            return None
        by_definition = {c.definition: c.name for c in DEFINITIONS["roll_angle"]}
        meant = (roll.as_understood.definition, *roll.indistinguishable)
        names = [by_definition[d] for d in meant]
        exact = self._reference[m.maneuver].approximate(
            t, list({"roll_angle", "pitch", "steer_angle", *names})
        )
        turned = exact["steer_angle"] + steer.trace.error
        here = self._potential(exact["roll_angle"], exact["steer_angle"], exact["pitch"])
        heights = []
        # Of definitions that cannot be told apart, the one that speaks for the floor.
        for name in names:
            lean = exact["roll_angle"] + roll.trace.error + exact[names[0]] - exact[name]
            there = self._potential(lean, turned, exact["pitch"])
            heights.append((potential.trace.error - (there - here)) / self.weight)
        height = min(heights, key=rms)
        slope = np.abs(np.gradient(there)).max() / max(np.abs(np.gradient(lean)).max(), _SHIFT)
        floor = (potential.floor or 0.0) + float(slope) * max(_floor(roll), _floor(steer))
        return t, height, floor / self.weight + 1e-15 * float(np.max(there)) / self.weight

    def _potential(self, roll: Array, steer: Array, pitch: Array) -> Array:
        """With both wheels on the floor [J]; `pitch` is where to begin."""
        pitch = pitch_on_the_floor(self._equations.k, roll, pitch, steer)
        rest = np.zeros_like(roll)
        found: Array = self._equations.energies((roll, pitch, steer, rest, rest, rest)).potential
        return found


def _floor(c: ColumnScore) -> float:
    return c.floor or 0.0
