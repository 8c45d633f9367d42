"""A motion of a slightly changed bicycle or start, to first order: what can be said without heyoka.

The reference plus its sensitivities times the changes. It is used only where that moves no column
by more than a small part of its scale, so that what is left out is a small part of that change.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.sensitivities import Sensitivities

# Of the scale; what is left out is some such part of the change.
_SMALL = 0.03
_NAMES = [c.name for c in COLUMNS]
# Parts of the kinetic energy, see `simulator`, that the reference does not have.
_UNKNOWN = ("spin_energy", "rotation_energy")
_STATE = ("roll", "pitch", "steer", "roll_rate", "steer_rate", "speed")


class FirstOrder:
    """Takes the place of a `Simulator` for one maneuver."""

    def __init__(
        self, maneuver: ReferenceManeuver, sensitivities: Sensitivities | None, number: int,
        bicycle: Bicycle,
    ) -> None:  # fmt: skip
        self._maneuver, self._bicycle = maneuver, bicycle
        self._sensitivity = sensitivities[number] if sensitivities else None
        self._start = {key: float(Exact.parse(maneuver.inputs[key])) for key in START}

    def run(
        self, bicycle: Bicycle, start: Sequence[float], time: Array,
        amounts: Mapping[str, float] | None = None,
    ) -> dict[str, Array]:  # fmt: skip
        """Columns as `Simulator.run` has them; NaN where first order does not reach."""
        made = dict.fromkeys([*_NAMES, *_UNKNOWN], np.full(len(time), np.nan))
        if amounts:
            return made
        given = dict(zip(_STATE, start, strict=True))
        changes = np.array(
            [float(bicycle[s].rational - self._bicycle[s].rational) for s in PARAMETERS]
            + [given[key] - self._start[key] for key in START]
        )
        within = time <= float(self._maneuver.duration)
        t = time[within]
        exact = self._maneuver.approximate(t, _NAMES)
        slopes: Mapping[str, Array] = {}
        if changes.any():
            if self._sensitivity is None:
                return made
            slopes = self._sensitivity.evaluate(t, _NAMES)
        for name in slopes:
            moved = slopes[name] @ changes
            if not np.max(np.abs(moved), initial=0.0) <= _SMALL * self._maneuver.scale(name):
                return made
            exact[name] = exact[name] + moved
        for name in _NAMES:
            made[name] = np.full(len(time), np.nan)
            made[name][within] = exact[name]
        return made
