"""Evidence about the shape of an error whose cause is not known."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.contradictions import SinglePrecision
from heyoka_bike.scoring.findings import Finding, Severity, info, maneuvers, named

_BOTH_TOLERANCES = "heyoka-bike score A B --tolerance 1e-8,1e-9"


@dataclass(frozen=True, slots=True)
class TooFar(Evidence):
    """Half of the columns or more are off by half their own size: hardly any motion is left."""

    code = "too_far"

    def message(self) -> str:
        return (
            "Half of the columns or more are off by half their own size, so that their error says "
            "nothing: look at the first rows, whether the columns are those of the benchmark, in "
            "its order and units, and at a run that is short"
        )


@dataclass(frozen=True, slots=True)
class BlownUp(Evidence):
    """A motion that blows up.

    Attributes
    ----------
    maneuver, key
        The column that is off the most.
    time
        Time from which its error is half its size [s].
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
            f"The motion blows up: {self.key} of maneuver {self.maneuver} is off by "
            f"{self.max_rel_error:.2g} times its size, and by half of it from {self.time:.3g} s "
            "on. Compare the rows before: what follows says nothing"
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
    """No column is off by more than what rounding leaves of a run, in scales."""

    max_rel_error: float

    code = "limited_by_rounding"

    def message(self) -> str:
        return (
            f"The error is {self.max_rel_error:.1g} of the scale at the most: that is what "
            "rounding leaves of a run in binary64 arithmetic. If it does not fall with the "
            f"tolerance or the step ({_BOTH_TOLERANCES}), it is the arithmetic, and not the model"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"max_rel_error": self.max_rel_error}


@dataclass(frozen=True, slots=True)
class TooFewRows(Evidence):
    """So few rows that the error has no shape."""

    code = "cannot_tell"

    def message(self) -> str:
        return "So few rows do not show what the error looks like"


@dataclass(frozen=True, slots=True)
class SmoothError(Evidence):
    """An error that is smooth, as an integrator, another model or other times leave it.

    Attributes
    ----------
    missing : tuple of str
        Columns of the state that the file lacks and that checking the equations needs.
    """

    missing: tuple[str, ...] = ()

    code = "smooth_error"

    def message(self) -> str:
        said = (
            "The error is smooth. Halve the step or divide the tolerance by ten: if the error "
            "falls, it is the integrator's; if it stays, it is not"
        )
        if self.missing:
            said += (
                f". With {named(self.missing)} in the file, the equations of motion could be "
                "checked"
            )
        return said

    def numbers(self) -> Mapping[str, Any]:
        return {"missing": list(self.missing)}


@dataclass(frozen=True, slots=True)
class WorkFromStart(Evidence):
    """Work that is done from the first row on, where gravity does none.

    Attributes
    ----------
    powers, forces
        By maneuver number: the power with which the kinetic energy begins to change [W], and the
        force along the motion [N].
    """

    powers: Mapping[int, float]
    forces: Mapping[int, float]

    code = "work_from_start"
    severity = Severity.WARNING

    def message(self) -> str:
        each = ", ".join(f"{x:.3g} W in maneuver {n}" for n, x in self.powers.items())
        forces = ", ".join(f"{x:.3g} N" for x in self.forces.values())
        return (
            f"From the first row on the kinetic energy changes by {each}, where gravity does no "
            f"work, as a force of {forces} along the motion does: drag, wind, a slope or a drive. "
            "An integrator's share falls with its step"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "powers": {str(n): x for n, x in self.powers.items()},
            "forces": {str(n): x for n, x in self.forces.items()},
        }


@dataclass(frozen=True, slots=True)
class Unsymmetric(Evidence):
    """An error that begins alike in two maneuvers, though the roll rate of one is far larger.

    Attributes
    ----------
    key
    small, large
        The numbers of the maneuvers with the small and the large roll rate.
    times
        Ratio of the error in `large` to the error in `small`.
    """

    key: str
    small: int
    large: int
    times: float

    code = "unsymmetric"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"The error of {self.key} begins in maneuver {self.large} with {self.times:.2g} times "
            f"what it is in maneuver {self.small}, whose roll rate is far smaller. So something "
            "moves the upright bicycle to one side (a mass, an axis, a torque, wind, a slope), or "
            "a friction has a size of its own"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"column": self.key, "maneuvers": [self.small, self.large], "times": self.times}


@dataclass(frozen=True, slots=True)
class BeginsAs(Evidence):
    """An error of angles that begins as a power of the time.

    Attributes
    ----------
    keys : tuple of str
    order
        1 for another initial rate, other times or an integrator; 2 for a force or another initial
        speed; 3 for a force that is zero at the start. Higher orders count as 3.
    maneuvers
    """

    keys: tuple[str, ...]
    order: int
    maneuvers: tuple[int, ...]

    code = "begins_as"
    severity = Severity.WARNING

    def message(self) -> str:
        power = {1: "the time", 2: "its square", 3: "its cube, or a higher power"}[self.order]
        rates = " or ".join(key.replace("angle", "rate") for key in self.keys)
        why = {
            1: (
                f"another first {rates}, other times, or a stiff force that acts within the first "
                "rows"
            ),
            2: "a force or a term that acts from the first row on, or another speed",
            3: "a force or a term that is zero upright and straight, or one that sets in later",
        }[self.order]
        many = len(self.keys) > 1
        return (
            f"The error{'s' * many} of {' and '.join(self.keys)} of {maneuvers(self.maneuvers)} "
            f"begin{'s' * (not many)} in proportion to {power}, as with {why}"
        )

    def numbers(self) -> Mapping[str, Any]:
        where = {"column": self.keys[0], "columns": list(self.keys)}
        return {**where, "maneuvers": list(self.maneuvers), "order": self.order}


@dataclass(frozen=True, slots=True)
class EnergyTrend(Evidence):
    """A mechanical energy that falls or grows steadily in every maneuver.

    Attributes
    ----------
    maneuvers
    changes : tuple of float
        Change in each maneuver relative to the energy; all have the same sign.
    """

    maneuvers: tuple[int, ...]
    changes: tuple[float, ...]

    def _finding(self) -> Finding:
        every = " in every maneuver" if len(self.maneuvers) > 1 else ""
        numbers, each = list(self.maneuvers), map(str, self.maneuvers)
        changes = dict(zip(each, self.changes, strict=True))
        if max(self.changes) > 0.0:
            said = (
                f"The mechanical energy grows steadily{every}, as with a drive in the model, or an "
                "explicit method of low order, whose share falls with its step"
            )
            return info("energy_grows", said, maneuvers=numbers, relative_change=changes)
        said = (
            f"The mechanical energy falls steadily{every}, as with a damper, drag or a contact "
            "that slips, or with numerical damping, which alone falls with the step or the "
            "tolerance"
        )
        return info("numerical_damping", said, maneuvers=numbers, relative_change=changes)


@dataclass(frozen=True, slots=True)
class EnergyVaries(Evidence):
    """A mechanical energy that changes, and not steadily in every maneuver.

    Attributes
    ----------
    largest : mapping of int to (float, float)
        By maneuver number: the largest change since the first row [J], and its time [s]. Only
        maneuvers that show a change.
    until
        Time from which the energy stays constant in all of these [s]; None if it does not.
    """

    largest: Mapping[int, tuple[float, float]]
    until: float | None = None

    code = "energy_varies"

    def message(self) -> str:
        if self.until is not None:
            each = ", ".join(f"{x:+.3g} J in maneuver {n}" for n, (x, _) in self.largest.items())
            return (
                f"The mechanical energy changes before {self.until:.3g} s only, by up to {each}, "
                "and then stays: look at what acts, or is ramped, in that time"
            )
        each = ", ".join(
            f"{x:+.3g} J at {t:.4g} s in maneuver {n}" for n, (x, t) in self.largest.items()
        )
        return (
            f"The mechanical energy changes by up to {each}. A force does work, or stores energy "
            "that is not in the sum; or it is an integrator's error, which falls with its step"
        )

    def numbers(self) -> Mapping[str, Any]:
        changes = {str(n): x for n, (x, _) in self.largest.items()}
        times = {str(n): t for n, (_, t) in self.largest.items()}
        return {"changes": changes, "times": times, "until": self.until}


@dataclass(frozen=True, slots=True)
class ContactYields(Evidence):
    """A potential energy that falls by the same amount at the beginning of every maneuver.

    Attributes
    ----------
    energy
        The amount [J].
    time
        The time until which it falls [s].
    constant
        Time constant of the contact: the root of its depth over gravity [s].
    """

    energy: float
    time: float
    constant: float

    code = "contact_yields"

    def message(self) -> str:
        return (
            f"In every maneuver the potential energy falls by {self.energy:.2g} J within "
            f"{self.time:g} s, whatever the roll angle: the bicycle sinks into the floor. The "
            "contact yields, and the wheels slip. Make contact and friction stiffer "
            "(docs/how-to/engines.md); a smaller step alone does not help"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"energy": self.energy, "time": self.time, "time_constant": self.constant}


@dataclass(frozen=True, slots=True)
class EnergyKept(Evidence):
    """A mechanical energy that stays, while its parts are wrong in every maneuver.

    Attributes
    ----------
    left
        The largest change [J].
    exchanged : mapping of int to float
        By maneuver number: the error of the parts [J].
    """

    left: float
    exchanged: Mapping[int, float]

    code = "energy_kept"

    def message(self) -> str:
        most = max(self.exchanged.values())
        return (
            f"The mechanical energy keeps to {self.left:.2g} J, while its parts are off by up to "
            f"{most:.2g} J. A damper, drag, friction or a drive in the motion would change it"
        )

    def numbers(self) -> Mapping[str, Any]:
        exchanged = {str(n): x for n, x in self.exchanged.items()}
        return {"left": self.left, "exchanged": exchanged}


@dataclass(frozen=True, slots=True)
class RoughError(Evidence):
    """Columns (``2.roll_angle``) whose error is noise, far above the digits written.

    Attributes
    ----------
    places : tuple of str
    are_all
        True if noise is most of the error in most columns; False if it is only a part.
    """

    places: tuple[str, ...]
    are_all: bool = True

    code = "rough_error"

    def message(self) -> str:
        whose = "The error" if self.are_all else f"A part of the error of {named(self.places)}"
        return (
            f"{whose} jumps from row to row like noise, far above the digits written, which no "
            "step size makes: look for single-precision numbers on the way, random terms, or a "
            "loose tolerance of the iterations"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.places)}


@dataclass(frozen=True, slots=True)
class StepRinging(Evidence):
    """Maneuvers whose rates alternate from row to row."""

    maneuvers: tuple[int, ...]

    code = "step_ringing"

    def message(self) -> str:
        return (
            "The velocities alternate from row to row, as the trapezoidal rule leaves them where "
            "nothing damps the highest frequency: accelerations that are consistent at the start, "
            "or a little numerical damping"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class IterationNoise(Evidence):
    """Maneuvers whose rates jump from row to row, much more than their angles."""

    maneuvers: tuple[int, ...]

    code = "iteration_noise"

    def message(self) -> str:
        return (
            "The velocities jump from row to row, much more than the angles, as a loose tolerance "
            "of the Newton iterations in each step makes them, or impulses of a contact: tighten "
            "it until the energy's error is smooth (a smaller step does not help); if it stays "
            "rough, it is the contact or the friction, or, where the jumps are below 1e-8 of the "
            "scale, rounding divided by the step"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"maneuvers": list(self.maneuvers)}


@dataclass(frozen=True, slots=True)
class SinglePrecisionBeside(Evidence):
    """Numbers of single precision, beside an error that is far larger."""

    single: SinglePrecision

    code = "single_precision"

    def message(self) -> str:
        said = self.single.message()
        return f"{said}. The error is far larger: another cause comes before this one"

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.single.keys)}


@dataclass(frozen=True, slots=True)
class FallsOver(Evidence):
    """A bicycle that falls over, where the exact one does not.

    Attributes
    ----------
    times : mapping of int to float
        By maneuver number: the time at which the lean passes a quarter turn [s].
    """

    times: Mapping[int, float]

    code = "falls_over"
    severity = Severity.WARNING

    def message(self) -> str:
        times = " and ".join(f"at {t:.3g} s in maneuver {n}" for n, t in self.times.items())
        return (
            f"The bicycle falls over: its lean passes 90 degrees {times}. Compare the first tenths "
            "of a second: contact, friction or step there, for what follows is another motion"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"times": {str(n): t for n, t in self.times.items()}}


@dataclass(frozen=True, slots=True)
class RightElsewhere(Evidence):
    """Some maneuvers are right, and what was found is about the others alone.

    Attributes
    ----------
    wrong, right : tuple of int
        Numbers of the maneuvers.
    max_rel_error
        Largest error of the right maneuvers, relative to the scale.
    """

    wrong: tuple[int, ...]
    right: tuple[int, ...]
    max_rel_error: float

    code = "right_elsewhere"

    def message(self) -> str:
        is_are, it_they = ("is", "it") if len(self.wrong) == 1 else ("are", "them")
        return (
            f"Only {maneuvers(self.wrong)} {is_are} wrong, and what is said here is about "
            f"{it_they} alone: the largest error of {maneuvers(self.right)} is "
            f"{self.max_rel_error:.1g} of the scale. So look at what your program does, or is "
            "given, otherwise there"
        )

    def numbers(self) -> Mapping[str, Any]:
        numbers = {"wrong": list(self.wrong), "right": list(self.right)}
        return {**numbers, "max_rel_error": self.max_rel_error}


@dataclass(frozen=True, slots=True)
class NotDiagnosed(Evidence):
    """Columns beside the benchmark's that are wrong where those are, too."""

    keys: tuple[str, ...]

    code = "not_diagnosed"

    def message(self) -> str:
        return (
            f"{named(self.keys)}: not right either, and not diagnosed, as programs with mistakes "
            "are simulated for the benchmark's columns only; begin with those"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}
