"""Evidence from the mechanical energy of a file, which is constant in the benchmark.

Gravity is the only force, and a wheel that rolls without slip does no work. So an energy that
changes indicates a force that does work, or an integrator. If the energy is constant while its
parts are wrong, the wrong forces do no work. This evidence needs no simulation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.diagnosis.residual.observed import Observed, state_vector
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import short_number
from heyoka_bike.scoring.findings import Finding, Severity, info, maneuvers
from heyoka_bike.scoring.grades import (
    MAX_ROUNDING_FLOORS,
    MIN_ROWS_FOR_SHAPE,
    TOLERANCE,
    has_right_digits,
)
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.noise import roughness
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.rows.table import ENERGY, PARTS_OF_ENERGY, floor_of
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore

_SUNK = (0.05, 0.12)
"""Interval in which a wheel has sunk into a soft floor, and roll errors are still small [s].
MuJoCo's contact with its default settings comes to rest within 0.05 s."""
_FEWEST_SUNK = 3  # minimum number of rows in the interval `_SUNK`
# Largest relative difference between the potential energies that the maneuvers lose to a soft
# contact, for these energies to count as equal. With MuJoCo the difference is 0.05.
_ALIKE = 0.2


@dataclass(frozen=True, slots=True)
class EnergyTrend(Evidence):
    """The mechanical energy falls or grows steadily in every maneuver.

    Attributes
    ----------
    maneuvers
    changes : tuple of float
        Change in each maneuver relative to the energy; all have the same sign.
    """

    maneuvers: tuple[int, ...]
    changes: tuple[float, ...]

    only_describes = True

    def _finding(self) -> Finding:
        every = " in every maneuver" if len(self.maneuvers) > 1 else ""
        numbers, each = list(self.maneuvers), map(str, self.maneuvers)
        changes = dict(zip(each, self.changes, strict=True))
        if max(self.changes) > 0.0:
            said = (
                f"The mechanical energy grows steadily{every}, as with a drive in the model or an "
                "explicit method of low order. If a smaller step reduces the growth, the method "
                "causes it"
            )
            return info("energy_grows", said, maneuvers=numbers, relative_change=changes)
        said = (
            f"The mechanical energy falls steadily{every}, as with a damper, drag, a slipping "
            "contact or numerical damping. If a smaller step or tolerance reduces the loss, "
            "numerical damping causes it"
        )
        return info("numerical_damping", said, maneuvers=numbers, relative_change=changes)


@dataclass(frozen=True, slots=True)
class EnergyVaries(Evidence):
    """The mechanical energy changes, but not steadily in every maneuver.

    Attributes
    ----------
    largest : mapping of int to (float, float)
        By maneuver number: the largest change since the first row [J], and its time [s]. Only
        maneuvers with a change are included.
    until
        Time from which the energy is constant in all these maneuvers [s]; None if there is no
        such time.
    """

    largest: Mapping[int, tuple[float, float]]
    until: float | None = None

    only_describes = True
    code = "energy_varies"

    def message(self) -> str:
        if self.until is not None:
            each = ", ".join(f"{x:+.3g} J in maneuver {n}" for n, (x, _) in self.largest.items())
            return (
                f"The mechanical energy changes only before {self.until:.3g} s, at most by {each}. "
                "Look for a force that acts only until then"
            )
        each = ", ".join(
            f"{x:+.3g} J at {t:.4g} s in maneuver {n}" for n, (x, t) in self.largest.items()
        )
        changes, them = ("change", "it") if len(self.largest) == 1 else ("changes", "them")
        return (
            f"The mechanical energy is not constant. Largest {changes} since the first row: "
            f"{each}. If a smaller step does not reduce {them}, a force does work, or the energy "
            "is incomplete or computed wrongly"
        )

    def numbers(self) -> Mapping[str, Any]:
        changes = {str(n): x for n, (x, _) in self.largest.items()}
        times = {str(n): t for n, (_, t) in self.largest.items()}
        return {"changes": changes, "times": times, "until": self.until}


@dataclass(frozen=True, slots=True)
class ContactYields(Evidence):
    """The potential energy falls by the same amount at the beginning of every maneuver.

    Attributes
    ----------
    energy
        The amount [J].
    time
        The time at which it stops falling [s].
    constant
        Time constant of the contact: the square root of its depth over gravity [s].
    """

    energy: float
    time: float
    constant: float

    code = "contact_yields"

    def message(self) -> str:
        return (
            f"In every maneuver the potential energy falls by {short_number(self.energy)} J within "
            f"{self.time:g} s, whatever the roll angle: the bicycle sinks into the floor. Make "
            "contact and friction stiffer (docs/how-to/engines.md); a smaller step alone does not "
            "help"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"energy": self.energy, "time": self.time, "time_constant": self.constant}


@dataclass(frozen=True, slots=True)
class EnergyKept(Evidence):
    """The mechanical energy is constant, while its parts are wrong in every maneuver.

    Attributes
    ----------
    left
        The largest change of the mechanical energy [J].
    exchanged : mapping of int to float
        By maneuver number: the error of the potential and the kinetic energy [J].
    """

    left: float
    exchanged: Mapping[int, float]

    only_describes = True
    code = "energy_kept"

    def message(self) -> str:
        most = max(self.exchanged.values())
        to = f" to within {short_number(self.left)} J" if self.left else ""
        return (
            f"The mechanical energy is constant{to}, although the potential and the kinetic energy "
            f"are off by up to {short_number(most)} J. This makes a damper, drag, friction or a "
            "drive unlikely, because these change the mechanical energy"
        )

    def numbers(self) -> Mapping[str, Any]:
        exchanged = {str(n): x for n, x in self.exchanged.items()}
        return {"left": self.left, "exchanged": exchanged}


@dataclass(frozen=True, slots=True)
class EnergyOfOtherMotion(Evidence):
    """An energy differs from the energy of the motion in the file.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    off
        Largest difference from the energy that follows from the file's angles, rates and speed [J].
    """

    key: str
    maneuvers: tuple[int, ...]
    off: float

    code = "energy_of_other_motion"
    severity = Severity.WARNING

    def message(self) -> str:
        other = "inertias and lengths" if self.key == "kinetic_energy" else "lengths and gravity"
        return (
            f"{self.key} of {maneuvers(self.maneuvers)} does not fit the motion in the file. The "
            "energy computed from the file's angles, rates and speed differs by up to "
            f"{short_number(self.off)} J, far more than the errors of these columns explain. Check "
            f"with which masses, {other} this energy is computed, and whether both wheels stay on "
            "the floor and roll"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": list(self.maneuvers), "off": self.off}


@dataclass(frozen=True, eq=False, slots=True)
class _Energy:
    """The mechanical energy of a maneuver.

    Attributes
    ----------
    time, change : ndarray, shape (n,)
        Times [s], and change of the energy since the first row [J].
    size, floor
        Size of the energy, and smallest change that its digits resolve [J].
    exchanged
        Largest change of the error of potential or kinetic energy, whichever is smaller [J]; None
        if the file does not contain both.
    steer_rate : ndarray, shape (n,)
        Steer rate of the exact motion [rad/s].
    """

    time: Array
    change: Array
    size: float
    floor: float
    exchanged: float | None
    steer_rate: Array

    @property
    def largest(self) -> tuple[float, float]:
        """The largest change of the energy [J], and the time of this change [s]."""
        row = int(np.argmax(np.abs(self.change)))
        return float(self.change[row]), float(self.time[row])

    @property
    def is_seen(self) -> bool:
        """True if the energy changes by clearly more than its digits hide."""
        return abs(self.largest[0]) > CLEARLY * self.floor

    @property
    def trend(self) -> float:
        """Relative change of the energy over the run, if the change is steady; otherwise 0."""
        if not self.is_seen or len(self.change) < 2 * MIN_ROWS_FOR_SHAPE:
            return 0.0
        means = np.array([np.mean(part) for part in np.array_split(self.change, 10)])
        change = float(means[-1] - means[0])
        back = float(np.min(np.diff(means) * np.sign(change)))
        if abs(change) <= CLEARLY * self.floor or -back * BY_FAR > abs(change):
            return 0.0
        # A change of the energy is steady if at most half of it happens in any tenth of the run.
        if float(np.max(np.abs(np.diff(means)))) > MEANINGLESS_ERROR * abs(change):
            return 0.0
        return change / self.size

    @property
    def until(self) -> float | None:
        """Time from which the energy is constant [s].

        None if this time is in the second half, or if the exact motion has nearly died away until
        then. In such a motion any force that depends on it does work only at first.
        """
        left = np.abs(self.change - self.change[-1])
        limit = max(abs(self.largest[0]) / BY_FAR, CLEARLY * self.floor)
        moving = np.flatnonzero(left > limit)
        end = float(self.time[moving[-1]]) if len(moving) else float(self.time[0])
        rate = np.abs(self.steer_rate)
        lasts = np.max(rate[self.time >= end]) > MEANINGLESS_ERROR * np.max(rate)
        return end if lasts and end < MEANINGLESS_ERROR * float(self.time[-1]) else None


def of_energy(report: Report) -> Iterator[EnergyTrend | EnergyVaries | EnergyKept]:
    """Yield what the mechanical energy shows; nothing unless all maneuvers contain it."""
    each = {m.maneuver: _energy(m) for m in report.maneuvers}
    known = {n: x for n, x in each.items() if x is not None}
    if len(known) < len(each):
        return
    numbers, trends = tuple(known), tuple(x.trend for x in known.values())
    worst = max((c.error for m in report.maneuvers for c in m.columns), default=0.0)
    varying = {n: x.largest for n, x in known.items() if x.is_seen and not _is_next_to(x, worst)}
    # If the file is right, the small change of the energy comes from the integrator and does not
    # indicate a force.
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
    """Yield evidence that the bicycle sinks into a soft floor, by its loss of potential energy.

    This energy is the same in all maneuvers, although their roll angles differ by a factor of ten.
    An error of the roll angle, a mass or a length would change it more where the roll angle is
    larger.
    """
    fallen, masses = [], []
    for m in report.maneuvers:
        first = {c.key: float(c.trace.reference[0]) for c in m.compared}
        if not first.get("forward_speed") or "kinetic_energy" not in first:
            return
        # Mass that would have the kinetic energy without rotation. The energy includes the rotation
        # of the wheels, so this mass exceeds the bicycle's by 5 %.
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
    """True if the energy is constant: errors of its parts exceed its change by `BY_FAR**2`.

    The large factor excludes weak springs and dampers, whose work is a thousandth of the energy
    exchanged between the parts.
    """
    could = max(abs(x.largest[0]), x.floor)
    return x.exchanged is not None and x.exchanged > BY_FAR**2 * could


def _is_next_to(x: _Energy, worst: float) -> bool:
    """True if the change of the energy is negligible compared with the other errors.

    It is compared with the error of its parts or, if these are missing, with the worst error in
    scales: an error of the speed changes the energy by twice as much, an error of the lean by its
    square.
    """
    return _is_kept(x) or (x.exchanged is None and BY_FAR**2 * abs(x.largest[0]) < worst * x.size)


def _does_work(x: _Energy) -> bool:
    """True if the energy's change is a visible fraction (`TOLERANCE`) of the error of its parts."""
    return x.exchanged is None or abs(x.largest[0]) > TOLERANCE * x.exchanged


def _energy(m: ManeuverScore) -> _Energy | None:
    """Return the mechanical energy as written, or else the sum of its parts; None without both."""
    columns = {c.key: c for c in m.columns if c.values == m.rows > 1}
    parts = [columns[key] for key in PARTS_OF_ENERGY if key in columns]
    whole = columns.get(ENERGY)
    summed = [whole] if whole is not None else parts
    if whole is None and len(parts) < len(PARTS_OF_ENERGY):
        return None
    change = sum((_change(c) for c in summed), np.zeros(m.rows))
    return _Energy(
        summed[0].trace.time,
        change,
        sum(float(np.max(np.abs(c.trace.value))) for c in summed),
        sum(c.floor or 0.0 for c in summed),
        min(float(np.max(np.abs(_change(c)))) for c in parts) if len(parts) > 1 else None,
        m.part.reference.approximate(summed[0].trace.time, ["steer_rate"])["steer_rate"],
    )


def _change(c: ColumnScore) -> Array:
    """Return the change of a column's error since the first row [J]."""
    change: Array = c.trace.error - c.trace.error[0]
    return change


def is_of_motions(report: Report, motions: Sequence[Observed], equations: Equations) -> bool:
    """True if the mechanical energy changes as that of the motions in the file.

    Then the force that changes the motion does all of the work. False if the file does not show it.
    """
    for motion in motions:
        energy = _energy(report[motion.number])
        if energy is None or not motion.has_state:
            return False
        own = equations.columns(state_vector(equations, motion.state.__getitem__))[ENERGY]
        _, here, there = np.intersect1d(energy.time, motion.time, return_indices=True)
        apart = energy.change[here] - own[there]
        least = CLEARLY * energy.floor
        if rms(apart - apart[0]) > max(rms(energy.change[here]) / CLEARLY, least):
            return False
    return True


def of_other_motions(
    report: Report, motions: Sequence[Observed], equations: Equations
) -> Iterator[EnergyOfOtherMotion]:
    """Yield energies that are not those of the motion in the file.

    The potential and kinetic energy are functions of the state. The errors of the state in the file
    change these functions, whatever causes them. A column must differ from the energy of the file's
    state far more than that energy differs from the exact one, and visibly in a plot of its
    changes: if the constraints of a right program drift a little, its heights do too. Noise of a
    column does not count.
    """
    off = {}
    for motion in motions:
        m = report[motion.number]
        own = equations.columns(state_vector(equations, motion.state.__getitem__))
        for key in PARTS_OF_ENERGY if motion.has_state else ():
            if key not in m:
                continue
            c = m[key]
            _, here, there = np.intersect1d(c.trace.time, motion.time, return_indices=True)
            apart = c.trace.value[here] - own[key][there]
            shown = own[key][there] - c.trace.reference[here]
            size = rms(apart)
            is_noise = 2.0 * roughness(apart).size > size
            is_seen = size > TOLERANCE * float(np.ptp(c.trace.reference))
            explained = max(rms(shown), MAX_ROUNDING_FLOORS * floor_of(c))
            if is_seen and not is_noise and size > CLEARLY * explained:
                off[m.maneuver, key] = float(np.max(np.abs(apart)))
    for key, of in grouped((key, n) for n, key in off).items():
        yield EnergyOfOtherMotion(key, tuple(of), max(off[n, key] for n in of))
