"""What the mechanical energy of a file shows: the motion of the benchmark keeps it.

Gravity is its only force, and a wheel that rolls without slip does no work. So an energy that
changes tells of a force that does work, or of an integrator; and one that stays, while its parts
are wrong, tells that what is wrong does none. Both rest on the file alone.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.evidence.error_shape import (
    ContactYields,
    EnergyKept,
    EnergyTrend,
    EnergyVaries,
)
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, TOLERANCE, has_right_digits
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

_PARTS = ("potential_energy", "kinetic_energy")
_SUNK = (0.05, 0.12)
"""Interval in which a wheel has sunk into a soft floor, and roll errors are still small [s].
MuJoCo's contact with its default settings comes to rest within 0.05 s."""
_FEWEST_SUNK = 3  # rows in this interval
_ALIKE = 0.2  # largest relative spread of the energy over all maneuvers; MuJoCo's is 0.05


@dataclass(frozen=True, eq=False, slots=True)
class _Energy:
    """The mechanical energy of a maneuver.

    Attributes
    ----------
    time, change : ndarray, shape (n,)
        What it has more than in the first row [s], [J].
    size, floor
        Of it, and what its digits cannot tell of a change [J].
    exchanged
        How much its parts are off from the right ones, as far as that changes, at least [J]; None
        if they are not both in the file.
    """

    time: Array
    change: Array
    size: float
    floor: float
    exchanged: float | None

    @property
    def largest(self) -> tuple[float, float]:
        """The largest change, and when that is [J], [s]."""
        row = int(np.argmax(np.abs(self.change)))
        return float(self.change[row]), float(self.time[row])

    @property
    def is_seen(self) -> bool:
        """True if it changes by more than its digits."""
        return abs(self.largest[0]) > CLEARLY * self.floor

    @property
    def trend(self) -> float:
        """The change over the run if it is steady, in parts of the energy; otherwise 0."""
        if not self.is_seen or len(self.change) < 2 * MIN_ROWS_FOR_SHAPE:
            return 0.0
        means = np.array([np.mean(part) for part in np.array_split(self.change, 10)])
        change = float(means[-1] - means[0])
        back = float(np.min(np.diff(means) * np.sign(change)))
        if abs(change) <= CLEARLY * self.floor or -back * BY_FAR > abs(change):
            return 0.0
        # A steady change has at most half of its size in one tenth of the run.
        if float(np.max(np.abs(np.diff(means)))) > MEANINGLESS_ERROR * abs(change):
            return 0.0
        return change / self.size

    @property
    def until(self) -> float | None:
        """Time after which it keeps its last value [s]; None if that is not in the first half."""
        left = np.abs(self.change - self.change[-1])
        limit = max(abs(self.largest[0]) / BY_FAR, CLEARLY * self.floor)
        moving = np.flatnonzero(left > limit)
        end = float(self.time[moving[-1]]) if len(moving) else float(self.time[0])
        return end if end < MEANINGLESS_ERROR * float(self.time[-1]) else None


def of_energy(report: Report) -> Iterator[EnergyTrend | EnergyVaries | EnergyKept]:
    """What the mechanical energy of all maneuvers shows, if these have one."""
    each = {m.maneuver: _energy(m) for m in report.maneuvers}
    known = {n: x for n, x in each.items() if x is not None}
    if len(known) < len(each):
        return
    numbers, trends = tuple(known), tuple(x.trend for x in known.values())
    worst = max((c.error for m in report.maneuvers for c in m.columns), default=0.0)
    varying = {n: x.largest for n, x in known.items() if x.is_seen and not _is_next_to(x, worst)}
    # What integrators leave of a right file says nothing of forces.
    is_right = has_right_digits(worst)
    if all(_is_kept(x) for x in known.values()):
        if not is_right:
            yield EnergyKept(
                max(abs(x.largest[0]) for x in known.values()),
                {n: x.exchanged for n, x in known.items() if x.exchanged is not None},
            )
    elif (all(x < 0.0 for x in trends) or all(x > 0.0 for x in trends)) and varying:
        yield EnergyTrend(numbers, trends)
    elif not is_right and any(_does_work(known[n]) for n in varying):
        ends = [known[n].until for n in varying]
        settled = [x for x in ends if x is not None]
        yield EnergyVaries(varying, max(settled) if len(settled) == len(ends) else None)


def of_contact(report: Report) -> Iterator[ContactYields]:
    """The potential energy that the bicycle loses by sinking into a soft floor, if it does.

    This energy is the same in all maneuvers, although their roll angles differ by a factor of ten.
    An error of the roll angle, a mass or a length would change it more where the roll angle is
    larger.
    """
    fallen, masses = [], []
    for m in report.maneuvers:
        first = {c.key: float(c.trace.reference[0]) for c in m.columns if c.values}
        if not first.get("forward_speed") or "kinetic_energy" not in first:
            return
        # The rotation of the wheels makes this mass a twentieth larger than the bicycle's.
        masses.append(2 * first["kinetic_energy"] / first["forward_speed"] ** 2)
        columns = [c for c in m.columns if c.key == "potential_energy" and c.values == m.rows > 1]
        for c in columns:
            time = c.trace.time - c.trace.time[0]
            change = _change(c)[(time >= _SUNK[0]) & (time <= _SUNK[1])]
            if len(change) < _FEWEST_SUNK or np.max(change) >= -CLEARLY * (c.floor or 0.0):
                return
            fallen += [float(np.min(change)), float(np.max(change))]
    if len(fallen) > 2 and min(fallen) > (1 + _ALIKE) * max(fallen):
        energy = -float(np.median(fallen))
        gravity = float(Fraction(report.maneuvers[0].part.reference.parameters["g"]))
        constant = (energy / float(np.median(masses))) ** 0.5 / gravity
        yield ContactYields(energy, _SUNK[0], constant)


def _is_kept(x: _Energy) -> bool:
    """True if its parts are off by so much more than it changes, or could.

    Weak springs and dampers do little work, too: a thousandth of what the energies exchange.
    """
    could = max(abs(x.largest[0]), x.floor)
    return x.exchanged is not None and x.exchanged > BY_FAR**2 * could


def _is_next_to(x: _Energy, worst: float) -> bool:
    """True if it changes by next to nothing, beside its parts, or the worst error in scales.

    The energy of a wrong speed is wrong by twice as much, that of a wrong lean by its square.
    """
    return _is_kept(x) or (x.exchanged is None and BY_FAR**2 * abs(x.largest[0]) < worst * x.size)


def _does_work(x: _Energy) -> bool:
    """True if it changes by a part of what its parts are off that would be seen in a plot."""
    return x.exchanged is None or abs(x.largest[0]) > TOLERANCE * x.exchanged


def _energy(m: ManeuverScore) -> _Energy | None:
    """The energy of a maneuver as it is written, or the sum of its parts."""
    columns = {c.key: c for c in m.columns if c.values == m.rows > 1}
    parts = [columns[key] for key in _PARTS if key in columns]
    whole = columns.get("mechanical_energy")
    summed = [whole] if whole is not None else parts
    if whole is None and len(parts) < len(_PARTS):
        return None
    change = sum((_change(c) for c in summed), np.zeros(m.rows))
    return _Energy(
        summed[0].trace.time,
        change,
        sum(float(np.max(np.abs(c.trace.value))) for c in summed),
        sum(c.floor or 0.0 for c in summed),
        min(float(np.max(np.abs(_change(c)))) for c in parts) if len(parts) > 1 else None,
    )


def _change(c: ColumnScore) -> Array:
    """How much more a column is off than in its first row [J]."""
    change: Array = c.trace.error - c.trace.error[0]
    return change
