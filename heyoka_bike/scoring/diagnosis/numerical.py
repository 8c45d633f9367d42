"""Describe the shape of an error that no mistake of the model explains."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.diagnosis.beginnings import BeginsAs, NoForceAlong, beginnings
from heyoka_bike.scoring.diagnosis.energies import EnergyKept, EnergyVaries, of_energy
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.residual.observed import missing_for_equations
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.contradictions import SinglePrecision
from heyoka_bike.scoring.evidence.words import scale_words
from heyoka_bike.scoring.findings import Severity, named
from heyoka_bike.scoring.grades import MIN_ROWS_FOR_SHAPE, TOLERANCE, has_right_digits
from heyoka_bike.scoring.judge.precision import single_precision
from heyoka_bike.scoring.measures import ROUNDING
from heyoka_bike.scoring.noise import FEWEST_ROWS, Roughness, roughness
from heyoka_bike.scoring.ratios import CLEARLY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ColumnScore

# Smallest noise, as a fraction of an error, that counts as visible, and smallest noise that
# indicates loose iterations of a solver. With Exudyn this fraction is below 2e-4 if the tolerance
# of the iterations is tight, and above 5e-3 if it is loose.
_LEAST_NOISE = 1e-4
_ITERATION_NOISE = 2e-3
# An error alternates from row to row if its fourth differences are correlated by at least this
# much: negatively between neighbouring rows, and positively between rows two apart.
_ALTERNATING_PART = 0.95
# If the noise is more than this fraction of a column's error, the error counts as noise.
_PART_OF_ROWS_ROUGH = 0.3
_BOTH_TOLERANCES = "heyoka-bike score A B --tolerance 1e-8,1e-9"
# Number of parts of equal length of a run. The noise of the run is the median of the noise of its
# parts.
_PARTS_OF_RUN = 5


@dataclass(frozen=True, slots=True)
class TooFar(Evidence):
    """Half of the columns or more are off by at least half of their scale.

    Attributes
    ----------
    missing : tuple of str
        Columns of the state that are needed to check the equations of motion, but are missing.
    """

    missing: tuple[str, ...] = ()

    code = "too_far"

    def message(self) -> str:
        return (
            "At least half of the columns are off by at least half of their largest value. Check "
            "the first rows, and that the columns are the benchmark's, in its order and units"
            + _with_missing(self.missing)
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"missing": list(self.missing)}


@dataclass(frozen=True, slots=True)
class BlownUp(Evidence):
    """The motion blows up.

    Attributes
    ----------
    maneuver, key
        The column with the largest error.
    time
        Time from which its error exceeds half of its scale [s].
    max_rel_error
        Its largest error relative to the scale.
    """

    maneuver: int
    key: str
    time: float
    max_rel_error: float

    code = "blown_up"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"The motion blows up: {self.key} of maneuver {self.maneuver} is off by more than half "
            f"of its largest value from {self.time:.3g} s on, and by up to "
            f"{scale_words(self.max_rel_error)}. Compare only the rows before that time"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "maneuver": self.maneuver,
            "column": self.key,
            "time": self.time,
            "max_rel_error": self.max_rel_error,
        }


@dataclass(frozen=True, slots=True)
class ErrorOfRounding(Evidence):
    """The largest error, relative to the scale, is no larger than rounding causes in a run."""

    max_rel_error: float

    code = "limited_by_rounding"

    def message(self) -> str:
        return (
            f"The error is at most {self.max_rel_error:.1g} of a column's largest value, as small "
            "as the accumulated rounding of binary64 arithmetic. If a smaller step or tolerance "
            f"does not reduce it, it is rounding. To compare the files A and B of two runs: "
            f"{_BOTH_TOLERANCES}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"max_rel_error": self.max_rel_error}


@dataclass(frozen=True, slots=True)
class TooFewRows(Evidence):
    """The file has too few rows to show the shape of the error."""

    code = "cannot_tell"

    def message(self) -> str:
        return "There are too few rows to show the shape of the error. Write more rows"


@dataclass(frozen=True, slots=True)
class SmoothError(Evidence):
    """The error is smooth, as from an integrator, a different model or wrong times.

    Attributes
    ----------
    missing : tuple of str
        Columns of the state that are needed to check the equations of motion, but are missing.
    """

    missing: tuple[str, ...] = ()

    code = "smooth_error"

    def message(self) -> str:
        return (
            "The error is smooth. Halve the step or divide the tolerance by ten. If the error "
            "falls, it is the integrator's. If it stays, look for another cause"
            + _with_missing(self.missing)
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"missing": list(self.missing)}


@dataclass(frozen=True, slots=True)
class RoughError(Evidence):
    """The error of columns is noise, far above the digits written.

    Attributes
    ----------
    places : tuple of str
        The columns (``2.roll_angle``).
    are_all
        True if noise is most of the error in most columns; False if it is only a part.
    """

    places: tuple[str, ...]
    are_all: bool = True

    code = "rough_error"

    def message(self) -> str:
        whose = "The error" if self.are_all else f"A part of the error of {named(self.places)}"
        return (
            f"{whose} jumps from row to row like noise, and is far larger than the rounding of the "
            "values. The step size is not the cause: look for single-precision numbers, random "
            "terms, or a loose tolerance in an iterative solver"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.places)}


@dataclass(frozen=True, slots=True)
class StepRinging(Evidence):
    """The rates of maneuvers alternate up and down from row to row."""

    maneuvers: tuple[int, ...]

    code = "step_ringing"

    def message(self) -> str:
        return (
            "The velocities alternate up and down from row to row, as with the trapezoidal rule if "
            "nothing damps the highest frequency. Start with consistent accelerations, or add a "
            "little numerical damping"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class IterationNoise(Evidence):
    """The rates of maneuvers jump from row to row, much more than the angles."""

    maneuvers: tuple[int, ...]

    code = "iteration_noise"

    def message(self) -> str:
        return (
            "The velocities jump from row to row, much more than the angles. Tighten the Newton "
            "tolerance; a smaller step does not help. If the jumps remain, check contact and "
            "friction, or rounding if they are below 1e-8 of the largest value"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class SinglePrecisionBeside(Evidence):
    """The values are single-precision numbers, but the error is far larger than their rounding."""

    single: SinglePrecision

    code = "single_precision"

    def message(self) -> str:
        said = self.single.message()
        return f"{said}. But the error is far larger than this: look for another cause first"

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.single.keys)}


class _Rough(NamedTuple):
    """The noise in a column's error, relative to the error and to the column's scale."""

    part: float
    size: float
    shape: Roughness


def causes(report: Report) -> tuple[Evidence, ...]:
    """Return the evidence of numerical causes, or at least that the error is smooth."""
    there = report.by_column()
    missing = missing_for_equations(there)
    far = [c.error > MEANINGLESS_ERROR for _, c in report.places]
    if 2 * sum(far) >= len(far):
        # The first rows tell their part even if the error becomes large later.
        return (*beginnings(report), TooFar(missing))
    m, c = max(report.places, key=lambda place: place[1].error)
    worst = c.error
    if worst * min(c.scale / _size(c), 1.0) > CLEARLY:
        first = np.argmax(np.abs(c.trace.error) > 0.5 * np.max(np.abs(c.trace.reference)))
        return (BlownUp(m.maneuver, c.key, float(c.trace.time[first]), worst),)
    if worst < ROUNDING:
        return (ErrorOfRounding(worst),)
    single = next(single_precision(report), None)
    # Single precision explains only small errors: its runs have errors of 1e-5 with steps of 0.01
    # s, and 9e-5 with steps of 0.001 s (measured).
    if single is not None and worst < TOLERANCE:
        return (single,)
    if max(m.rows for m in report.maneuvers) < MIN_ROWS_FOR_SHAPE:
        return (TooFewRows(),)
    every = {c.key for m in report.maneuvers for c in m.columns}
    # A negligible error needs no explanation by noise.
    rough = tuple(_rough(report, every)) if worst > THRESHOLDS.negligible_error else ()
    if has_right_digits(worst):
        # In a right file, jumps of the error do not show loose iterations: they also occur when a
        # multistep method changes its order.
        rough = tuple(x for x in rough if not isinstance(x, IterationNoise))
    found = (*described(report), *rough)
    is_general = all(
        isinstance(x, BeginsAs | NoForceAlong | EnergyVaries | EnergyKept) for x in found
    )
    jumps = _roughness(c, hidden=0.0)
    is_noise = jumps is not None and _is_jumping(jumps) and jumps.part > _PART_OF_ROWS_ROUGH
    if is_general and not is_noise:
        # An integrator could explain all evidence found so far, so also report that the error is
        # smooth.
        found = (*found, SmoothError(missing))
    return found if single is None else (*found, SinglePrecisionBeside(single))


def described(report: Report) -> tuple[Evidence, ...]:
    """Return the evidence of forces that needs no simulation: energy and first rows."""
    return (*of_energy(report), *beginnings(report))


def _size(c: ColumnScore) -> float:
    """Size that a column does not exceed unless the motion blows up.

    It is the scale, or 1 rad or 1 rad/s if that is more: in a maneuver with small angles and rates
    the error may be many times the scale.
    """
    return max(c.scale, 1.0) if c.unit in ("rad", "rad s-1") else c.scale


def noise(report: Report, keys: Collection[str]) -> tuple[RoughError, ...]:
    """Return the evidence that some columns contain noise."""
    return tuple(x for x in _rough(report, keys) if isinstance(x, RoughError))


def _rough(
    report: Report, keys: Collection[str]
) -> Iterator[RoughError | StepRinging | IterationNoise]:
    """Yield the evidence of errors of columns that jump from row to row.

    They may be noise, ringing or iterations.
    """
    found = {
        (m.maneuver, c.key): _roughness(c)
        for m in report.maneuvers for c in m.columns if c.key in keys
    }  # fmt: skip
    jumping = {place: r for place, r in found.items() if r is not None and _is_jumping(r)}
    numbers = [m.maneuver for m in report.maneuvers]
    noisy = {place: r for place, r in jumping.items() if r.shape.is_white}
    wholly = [r for r in noisy.values() if r.part > _PART_OF_ROWS_ROUGH]
    in_rates = [n for n in numbers if _in_rates(n, jumping)]
    ringing = [n for n in numbers if _rings(n, jumping)]
    if len(wholly) > len(found) / 2:
        yield RoughError(tuple(f"{number}.{key}" for number, key in jumping), are_all=True)
    elif 2 * len(ringing) > len(numbers):
        yield StepRinging(tuple(ringing))
    elif 2 * len(in_rates) > len(numbers):
        yield IterationNoise(tuple(in_rates))
    # Report noise in single columns only above `TOLERANCE`: the error of a multistep method makes
    # smaller jumps when its order changes.
    elif large := [place for place, r in noisy.items() if r.size > TOLERANCE]:
        yield RoughError(tuple(f"{number}.{key}" for number, key in large), are_all=False)


def _is_jumping(rough: _Rough) -> bool:
    """True if a visible part of an error jumps from row to row."""
    return rough.shape.at_one < MEANINGLESS_ERROR and rough.part > _LEAST_NOISE


def _in_rates(number: int, jumping: Mapping[tuple[int, str], _Rough]) -> bool:
    """True if both rates of a maneuver jump from row to row, much more than their angles."""
    for kind in ("roll", "steer"):
        angle, rate = (jumping.get((number, f"{kind}_{x}")) for x in ("angle", "rate"))
        if rate is None or rate.shape.at_one >= 0 or rate.part < _ITERATION_NOISE:
            return False
        # Noise in the velocities is hardly visible in the angles, because angles are integrals of
        # velocities. Noise in the output is visible in both.
        if angle is not None and rate.part < CLEARLY * angle.part:
            return False
    return True


def _rings(number: int, jumping: Mapping[tuple[int, str], _Rough]) -> bool:
    """True if the steer rate of a maneuver alternates from row to row."""
    rate = jumping.get((number, "steer_rate"))
    if rate is None:
        return False
    return min(-rate.shape.at_one, rate.shape.at_two) > _ALTERNATING_PART


def _roughness(c: ColumnScore, hidden: float = CLEARLY) -> _Rough | None:
    """Return the roughness of a column's error; None if its digits can cause it.

    Digits can cause a roughness of `hidden` times the resolution limit.
    """
    if c.values < FEWEST_ROWS:
        return None
    found = roughness(c.trace.error, _PARTS_OF_RUN)
    spread = float(np.std(c.trace.error))
    if found.size <= hidden * (c.floor or 0.0) or not spread:
        return None
    return _Rough(found.size / spread, found.size / (c.scale or 1.0), found)


def _with_missing(keys: Sequence[str]) -> str:
    """Return the end of a sentence on columns that would show more; empty if there are none."""
    if not keys:
        return ""
    return f". If the file also has {named(keys)}, the diagnosis checks the equations of motion"
