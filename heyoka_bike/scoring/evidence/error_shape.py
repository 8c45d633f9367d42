"""Evidence about the shape of an error with an unknown cause."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.contradictions import SinglePrecision
from heyoka_bike.scoring.evidence.words import scale_words, short_number
from heyoka_bike.scoring.findings import Finding, Severity, info, maneuvers, named

_HIGHEST_ORDER = 3
"""Largest value of `BeginsAs.order`."""

_BOTH_TOLERANCES = "heyoka-bike score A B --tolerance 1e-8,1e-9"


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
class WorkFromStart(Evidence):
    """From the first row on the kinetic energy changes, although gravity does no work there.

    Attributes
    ----------
    powers, forces
        By maneuver number: the initial rate of change of the kinetic energy [W], and the force
        along the motion with this power [N]. If the file has no kinetic energy, they are computed
        from the speed.
    """

    powers: Mapping[int, float]
    forces: Mapping[int, float]

    only_describes = True
    code = "work_from_start"
    severity = Severity.WARNING

    def message(self) -> str:
        each = ", ".join(f"{x:.3g} W in maneuver {n}" for n, x in self.powers.items())
        forces = ", ".join(f"{x:.3g} N" for x in self.forces.values())
        return (
            f"From the first row on, the kinetic energy changes at a rate of {each}, although "
            f"gravity does no work there. A force of {forces} along the motion would cause this: "
            "drag, wind, a slope or a drive. If a smaller step reduces the rate, the integrator "
            "causes it"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "powers": {str(n): x for n, x in self.powers.items()},
            "forces": {str(n): x for n, x in self.forces.items()},
        }


@dataclass(frozen=True, slots=True)
class NoForceAlong(Evidence):
    """In the first rows a wrong forward speed is right, so no force acts along the motion there.

    Attributes
    ----------
    time
        End of these rows [s].
    forces
        By maneuver number: a constant force that would change the speed until this time by as much
        as the error or its resolution limit [N].
    """

    time: float
    forces: Mapping[int, float]

    only_describes = True
    code = "no_force_along"

    def message(self) -> str:
        largest = max(self.forces.values())
        return (
            f"In the first {self.time:.3g} s the forward speed shows no force along the motion "
            f"above {largest:.1g} N (drag, friction, a slope or a drive). The speed becomes wrong "
            "later, as it does if roll and steer are wrong. Their columns show more"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"time": self.time, "forces": {str(n): x for n, x in self.forces.items()}}


@dataclass(frozen=True, slots=True)
class Unsymmetric(Evidence):
    """An error begins alike in two maneuvers, although their initial roll rates differ greatly.

    Attributes
    ----------
    key
    small, large
        The numbers of the maneuvers with the small and the large initial roll rate.
    times
        Ratio of the error in `large` to the error in `small`.
    """

    key: str
    small: int
    large: int
    times: float

    only_describes = True
    code = "unsymmetric"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"In the first rows, the error of {self.key} is only {self.times:.2g} times as large "
            f"in maneuver {self.large} as in maneuver {self.small}, which has a far smaller roll "
            "rate. Look for an asymmetry (mass, axis, torque, wind, slope) or constant friction"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": [self.small, self.large], "times": self.times}


@dataclass(frozen=True, slots=True)
class BeginsAs(Evidence):
    """The error of angles, or of rates, begins in proportion to a power of the time.

    Attributes
    ----------
    keys : tuple of str
        Either angles or rates.
    order
        The power in the error of an angle; that of its rate is lower by 1. 1 indicates a wrong
        initial rate, wrong times or an integrator; 2 a force or a wrong initial speed; 3 a force
        that is zero at the start. Higher powers count as 3.
    maneuvers
    is_alone
        True if the file has no other column of roll and steer, which would show whether the motion
        or only the output is wrong.
    """

    keys: tuple[str, ...]
    order: int
    maneuvers: tuple[int, ...]
    is_alone: bool = False

    only_describes = True
    code = "begins_as"
    severity = Severity.WARNING

    def message(self) -> str:
        kind = "rate" if self.keys[0].endswith("rate") else "angle"
        power = ("the time", "the square of the time", "the cube of the time")[
            self.order - 1 - (kind == "rate")
        ]
        higher = ", or to a higher power of it" if self.order == _HIGHEST_ORDER else ""
        rates = " or ".join(key.replace("angle", "rate") for key in self.keys)
        why = {
            1: (
                f"a wrong initial {rates}, wrong times, or a stiff force that acts within the "
                "first rows"
            ),
            2: "a wrong parameter, force or term that acts from the first row on, or a wrong "
            "initial speed",
            3: "a wrong parameter, force or term that has no effect while the bicycle is upright "
            "and straight, or that acts only later",
        }[self.order]
        many = len(self.keys) > 1
        if kind == "rate" and self.order < _HIGHEST_ORDER:
            why += ", or the integrator"
        if self.is_alone:
            why += (
                ". The file has no other column of roll and steer, so the motion may also be right "
                f"and only the {kind} computed wrongly"
            )
        return (
            f"In the first rows of {maneuvers(self.maneuvers)}, the error{'s' * many} of "
            f"{' and '.join(self.keys)} grow{'s' * (not many)} in proportion to {power}"
            f"{higher}. Typical causes: {why}"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.keys[0], "columns": list(self.keys)}
        return {**where, "maneuvers": list(self.maneuvers), "order": self.order}


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


@dataclass(frozen=True, slots=True)
class FallsOver(Evidence):
    """The bicycle falls over, although it does not in the exact motion.

    Attributes
    ----------
    times : mapping of int to float
        By maneuver number: the time at which the lean exceeds a quarter turn [s].
    """

    times: Mapping[int, float]

    code = "falls_over"
    severity = Severity.WARNING

    def message(self) -> str:
        times = " and ".join(f"at {t:.3g} s in maneuver {n}" for n, t in self.times.items())
        return (
            f"The bicycle falls over: its lean exceeds 90 degrees {times}. Check contact, friction "
            "and step size in the first tenths of a second, and ignore the later rows"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"times": {str(n): t for n, t in self.times.items()}}


@dataclass(frozen=True, slots=True)
class RightElsewhere(Evidence):
    """Some maneuvers are right; the diagnosis is about the other maneuvers only.

    Attributes
    ----------
    wrong, right : tuple of int
        Numbers of the maneuvers.
    max_rel_error
        Largest error of the right maneuvers, relative to the scale.
    is_rest
        True if other faults of the file are named beside this.
    """

    wrong: tuple[int, ...]
    right: tuple[int, ...]
    max_rel_error: float
    is_rest: bool = False

    only_describes = True
    code = "right_elsewhere"

    def message(self) -> str:
        is_are = "is" if len(self.wrong) == 1 else "are"
        start = "Otherwise only" if self.is_rest else "Only"
        return (
            f"{start} {maneuvers(self.wrong)} {is_are} wrong. In {maneuvers(self.right)} the "
            f"largest error is only {self.max_rel_error:.1g} of a column's largest value. So look "
            f"for input or settings of your program that differ in {maneuvers(self.wrong)}"
        )

    def numbers(self) -> Mapping[str, Any]:
        numbers = {"wrong": list(self.wrong), "right": list(self.right)}
        return {**numbers, "max_rel_error": self.max_rel_error}


@dataclass(frozen=True, slots=True)
class NotDiagnosed(Evidence):
    """Columns that the benchmark does not define are wrong, and so are the benchmark's."""

    keys: tuple[str, ...]

    only_describes = True
    code = "not_diagnosed"

    def message(self) -> str:
        return (
            f"Also wrong, but not diagnosed: {named(self.keys)}. Only the benchmark's columns are "
            "diagnosed; correct those first"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


def _with_missing(keys: Sequence[str]) -> str:
    """Return the end of a sentence on columns that would show more; empty if there are none."""
    if not keys:
        return ""
    return f". If the file also has {named(keys)}, the diagnosis checks the equations of motion"
