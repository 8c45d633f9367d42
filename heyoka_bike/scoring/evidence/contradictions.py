"""Evidence that a file contradicts itself or the exact motion."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from heyoka_bike.bicycle.columns import ANGLE_OF
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.words import scale_words, short_number
from heyoka_bike.scoring.findings import Severity, maneuvers, named

VISIBLE = 1e-2
"""Error, in scales, that is visible in a plot, although eq. (1) may miss it."""

# If the time limit stopped the diagnosis, the message proposes a limit that is longer by this
# factor.
_MORE_TIME = 5


@dataclass(frozen=True, slots=True)
class TimeShift(Evidence):
    """All times are late, or early, by the same constant.

    Attributes
    ----------
    shift
        Delay of the times [s]; negative if they are early.
    begins_at_start
        True if the first row contains the initial state.
    """

    shift: float
    begins_at_start: bool

    code = "time_shifted"
    severity = Severity.WARNING

    def message(self) -> str:
        starts = f". The first row, at {self.shift:.6g} s, contains the initial state"
        size = f"{abs(self.shift):.9g} s"
        wrong, mended = ("late", "subtracted") if self.shift > 0 else ("early", "added")
        return (
            f"All times are {size} too {wrong}: with {size} {mended}, the motion "
            f"fits{starts if self.begins_at_start else ''}. The errors in the report are for the "
            "times as written"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"shift": self.shift}


@dataclass(frozen=True, slots=True)
class StoppedEarly(Evidence):
    """The diagnosis reached its time limit before it had tried every cause.

    Attributes
    ----------
    seconds
        Limit of the processor time [s].
    has_cause
        False if no cause was found within the limit.
    """

    seconds: float
    has_cause: bool = True

    code = "stopped_early"
    severity = Severity.WARNING

    def message(self) -> str:
        said = (
            f"Stopped early: the limit of {self.seconds:g} s of processor time was reached before "
            "every cause was tried. An untried cause may explain the file as well or better"
            if self.has_cause
            else f"No cause was found within the limit of {self.seconds:g} s of processor time. An "
            "untried cause may explain the file"
        )
        more = f"{_MORE_TIME * self.seconds:g}"
        return f"{said}. To allow more time, use --budget {more}, or budget={more} in Python"

    def numbers(self) -> Mapping[str, Any]:
        return {"seconds": self.seconds}


@dataclass(frozen=True, slots=True)
class CoveredInPart(Evidence):
    """Complete rows cover only a part of the run.

    Attributes
    ----------
    maneuvers
        Numbers of the maneuvers with these rows.
    t_start, t_end, gap
        Times of the first and the last complete row, and the longest time between two [s].
    has_holes
        True if the missing parts lie between rows.
    """

    maneuvers: tuple[int, ...]
    t_start: float
    t_end: float
    gap: float
    has_holes: bool

    code = "coverage"
    severity = Severity.WARNING

    def message(self) -> str:
        which = maneuvers(self.maneuvers)
        rows = f"The complete rows of {which}"
        said = f"{rows} cover only {self.t_start:.6g} to {self.t_end:.6g} s; the rest of the run is"
        if self.t_start == self.t_end:
            row = f"The only complete row of {which} is at {self.t_start:.6g} s"
            said = f"{row}; the rest of the run is"
        elif self.has_holes:
            said = f"{rows} are up to {self.gap:.3g} s apart; the motion between them is"
        return f"{said} not judged"

    def numbers(self) -> Mapping[str, Any]:
        return {
            "maneuvers": list(self.maneuvers),
            "t_start": self.t_start,
            "t_end": self.t_end,
            "gap": self.gap,
        }


@dataclass(frozen=True, slots=True)
class EnergyHidesError(Evidence):
    """The energy is within the limit of eq. (1), although another column is visibly wrong.

    Attributes
    ----------
    maneuvers
        All maneuvers with such an error.
    maneuver, key, max_rel_error, performance
        Place of the worst column, its error relative to the scale, and eq. (1) there [%].
    """

    maneuvers: tuple[int, ...]
    maneuver: int
    key: str
    max_rel_error: float
    performance: float

    code = "energy_hides_error"
    severity = Severity.WARNING

    def message(self) -> str:
        is_one = len(self.maneuvers) == 1
        where = "" if is_one else f" in maneuver {self.maneuver}"
        return (
            f"{maneuvers(self.maneuvers).capitalize()} {'passes' if is_one else 'pass'} eq. (1), "
            "which checks only that the energy in the file is constant. But an error exceeds "
            f"{100 * VISIBLE:g} %: {self.key} is wrong by up to {scale_words(self.max_rel_error)}"
            f"{where}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "maneuvers": list(self.maneuvers),
            "maneuver": self.maneuver,
            "performance": self.performance,
            "column": self.key,
            "max_rel_error": self.max_rel_error,
        }


@dataclass(frozen=True, slots=True)
class EnergySum(Evidence):
    """The sum of potential and kinetic energy differs from the mechanical energy.

    Attributes
    ----------
    maneuvers
    energy_sum, floor
        The largest difference, and the difference that rounding explains [J].
    """

    maneuvers: tuple[int, ...]
    energy_sum: float
    floor: float

    code = "energy_sum"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            f"{maneuvers(self.maneuvers).capitalize()}: potential plus kinetic energy differs from "
            f"the mechanical energy by up to {short_number(self.energy_sum)} J; rounding explains "
            f"only {short_number(self.floor)} J"
        )

    def numbers(self) -> Mapping[str, Any]:
        numbers = list(self.maneuvers)
        return {"maneuvers": numbers, "energy_sum": self.energy_sum, "floor": self.floor}


@dataclass(frozen=True, slots=True)
class RateContradiction(Evidence):
    """A rate is not the derivative of its own angle.

    Attributes
    ----------
    maneuvers
    key
    rms_difference
        Root mean square of the difference between the rate and that derivative [rad/s], the
        largest of these maneuvers.
    maneuver
        The maneuver with this difference.
    """

    maneuvers: tuple[int, ...]
    key: str
    rms_difference: float
    maneuver: int

    code = "rate_is_not_the_derivative"
    severity = Severity.WARNING

    def message(self) -> str:
        size = f"{self.rms_difference:.2g} rad/s"
        if len(self.maneuvers) > 1:
            size = f"up to {size} (maneuver {self.maneuver})"
        return (
            f"{maneuvers(self.maneuvers).capitalize()}: {self.key} is not the derivative of "
            f"{ANGLE_OF[self.key]}. The root mean square of the difference is {size}. The angle is "
            "closer to the exact motion, so check the rate"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {
            "maneuvers": list(self.maneuvers),
            "column": self.key,
            "rms_difference": self.rms_difference,
        }


@dataclass(frozen=True, slots=True)
class SinglePrecision(Evidence):
    """The values are single-precision numbers, or were computed from such numbers.

    Attributes
    ----------
    keys
    is_written
        True if the written values are single-precision numbers; False if only intermediate values
        were.
    are_all
        True if all values are single-precision numbers; False if only those of `keys` are.
    """

    keys: tuple[str, ...]
    is_written: bool
    are_all: bool = True

    code = "single_precision"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.is_written:
            which = "All values" if self.are_all else f"The values of {named(self.keys)}"
            return (
                f"{which} are single-precision numbers, which have seven digits. Relative errors "
                "near 1e-7, and larger errors that grow out of them, come from single precision, "
                "in the computation or in the output. Compute and store in double precision"
            )
        return (
            "The values jump from row to row by about 1e-7 of their size, as if computed from "
            "single-precision numbers. This comes from single precision, in the computation or in "
            "the output. Compute and store in double precision throughout"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys)}


@dataclass(frozen=True, slots=True)
class FewDigits(Evidence):
    """The error of these columns is no larger than rounding to the digits written."""

    keys: tuple[str, ...]
    significant_digits: int

    code = "digits_written"

    def message(self) -> str:
        digits = self.significant_digits
        return (
            f"{named(self.keys)}: the error is no larger than rounding to the digits written "
            f"({digits} in the column with the fewest). Write 17 digits to show the accuracy of "
            "the program"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"columns": list(self.keys), "significant_digits": self.significant_digits}
