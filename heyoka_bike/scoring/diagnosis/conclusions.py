"""Conclusions of a diagnosis, as evidence: causes, integrators, and that nothing explains a file.

Evidence that needs no simulation is defined in the modules that find it, or in `scoring.evidence`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.diagnosis.cause_words import (
    UNIT_OF_VALUE,
    accelerations_words,
    count_words,
    equation_words,
    inertia_words,
    mistakes_words,
    relief_words,
    with_words,
)
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.mistakes.in_start import VIOLATING
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS, Place
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES
from heyoka_bike.scoring.diagnosis.programs.program import FittedValue, NumericalMethod
from heyoka_bike.scoring.diagnosis.residual.laws import Law
from heyoka_bike.scoring.diagnosis.residual.loads import CONSTANT, LOADS, TIME, FittedLoad
from heyoka_bike.scoring.diagnosis.residual.methods import Method
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import SignContradiction, in_units
from heyoka_bike.scoring.evidence.words import either, scale_words, short_number
from heyoka_bike.scoring.findings import Finding, Severity, info, named, warning
from heyoka_bike.scoring.grades import TOLERANCE, has_right_digits
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.ratios import BY_FAR

_CHECK_FORCES = (
    "The only applied force of the benchmark is gravity. Check which other forces your program "
    "applies, by default or in its joints, and that its equations have all terms"
)
_CHECK_TERMS = "Check that the equations of your program have all terms"
_ABOUT_STARTS = (
    ". These initial velocities violate the rolling constraints. The simulation of heyoka_bike "
    "starts with the nearest velocities that satisfy the constraints"
)
# Relative errors below this limit are not mentioned, because such values have six correct digits.
_NEGLIGIBLE_ERROR = 1e-6
# The message about a torque law states the torque at these fractions of the variable's range.
_PARTS_OF_RANGE = (1 / 64, 1 / 8, 1.0)
# Largest ratio `LeftOfEquations.above` that explicit methods reach, and largest ratio that any
# integrator reaches. IDA, an implicit method that solves for the rates, reaches 152.
_MAX_RATIO_OF_EXPLICIT = 3.0
_MAX_RATIO_OF_INTEGRATORS = 152.0


@dataclass(frozen=True, eq=False, slots=True)
class Explained(Evidence):
    """Causes that explain a file.

    Attributes
    ----------
    rank
        1 for the likeliest.
    hypotheses : tuple of Hypothesis
        Indistinguishable causes, the likeliest first.
    rest
        The place where an error remains that neither the digits nor an integrator explains; None if
        the cause explains everything.
    acceleration
        The equation with the largest residual: its name, the residual relative to the acceleration,
        and the factor by which the cause reduces it. None if the equations do not show the cause.
    as_given : tuple of str
        Columns whose first row has the given initial value, although another one was fitted.
    left
        The largest typical error that the digits do not explain, in scales; 0 if there is none.
    rivals : tuple of Hypothesis
        Other causes that reduce the residual of the equations nearly as much, if an error remains.
    """

    rank: int
    hypotheses: tuple[Hypothesis, ...]
    rest: Place | None
    acceleration: tuple[str, float, float] | None
    as_given: tuple[str, ...]
    left: float = 0.0
    rivals: tuple[Hypothesis, ...] = ()

    def message(self) -> str:
        first, *others = self.hypotheses
        said = mistakes_words(first.mistakes)
        if first.found and self.rest is None:
            said = f"{count_words(first.found)} the error: {said}{inertia_words(first.found)}"
        if self.rank == 1:
            begins = "" if self.rest is None else "the nearest known cause: "
        else:
            several = ", which needs several mistakes" if len(first.mistakes) > 1 else ""
            begins = f"a less likely cause{several}: "
        text = f"{begins}{said}"
        text = f"{text[0].upper()}{text[1:]}. {self._proof()}. {self._advice()}"
        if self.rest is not None:
            text += f". {_rest_words(first, self.rest)}"
        if self.rivals:
            near = "; or ".join(mistakes_words(h.mistakes) for h in self.rivals)
            text += f". Another cause explains nearly as much: {near}"
        if others:
            same = "; or ".join(
                mistakes_words(h.mistakes) for h in others[: THRESHOLDS.max_answers]
            )
            text += f". The file fits equally well if {same}"
        return text

    def _finding(self) -> Finding:
        first = self.hypotheses[0]
        if first.found:
            changes = [[_value(x) for x in h.found] for h in self.hypotheses if h.found]
            found = warning(
                "parameters",
                self.message(),
                rank=self.rank,
                gain=first.gain,
                relief=first.relief,
                changes=changes,
                acceleration=self._acceleration(),
                is_all=self.rest is None,
            )
        else:
            codes, *alike = [list(h.codes) for h in self.hypotheses]
            found = warning(
                "mistake",
                self.message(),
                rank=self.rank,
                mistakes=codes,
                **_errors(first),
                indistinguishable=alike,
                acceleration=self._acceleration(),
                is_all=self.rest is None,
            )
        return found if self.rank == 1 else replace(found, severity=Severity.INFO)

    def _acceleration(self) -> dict[str, Any] | None:
        """Return the equation with the largest residual, and what the cause explains of it."""
        if self.acceleration is None:
            return None
        return dict(zip(("equation", "share", "relief"), self.acceleration, strict=True))

    def _proof(self) -> str:
        """Describe how much of the error the cause explains."""
        first = self.hypotheses[0]
        said = relief_words(first.mistakes, first.relief)
        if self.rest is None and self.left:
            # An integration error larger than `TOLERANCE` is unlikely: the author would have seen
            # it in a plot.
            other = ", or from another cause" if self.left > TOLERANCE else ""
            said += (
                f". The remaining error is typically {scale_words(self.left, 'a column')}. It "
                "comes from the integrator, or from details that the simulation does not "
                f"reproduce{other}"
            )
        return said

    def _advice(self) -> str:
        """Describe what to check in the program."""
        first = self.hypotheses[0]
        forces = {x.name for x in first.found} & FORCES.keys()
        if forces:
            checks = {FORCES[name].check for name in forces}
            if len(checks) == 1 and (check := checks.pop()):
                return f"Check {check}"
            is_of_terms = all(FORCES[name].is_part for name in forces)
            return _CHECK_TERMS if is_of_terms else _CHECK_FORCES
        if self.as_given:
            return (
                f"But the first row has {' and '.join(self.as_given)} as given, and the motion "
                "differs from the second row on. So look at the first step, not at the input"
            )
        text = "Check " + ". Also check ".join(dict.fromkeys(m.check for m in first.mistakes))
        return text + (_ABOUT_STARTS if VIOLATING & set(first.codes) else "")


@dataclass(frozen=True, slots=True)
class BesideCause(Evidence):
    """A fault of the rows in a file whose motion is wrong for another reason.

    Attributes
    ----------
    fault : Evidence
        The fault, compared with the motion of that cause instead of the exact one.
    """

    fault: Evidence

    @property
    def code(self) -> str:
        """The code of the fault."""
        return self.fault.code

    @property
    def severity(self) -> Severity:
        """The importance of the fault."""
        return self.fault.severity

    def message(self) -> str:
        return (
            f"{self.fault.message()}. For this finding, the file was compared with a simulation "
            "of the cause named below, not with the exact motion"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {**self.fault.numbers(), "beside_a_cause": True}


@dataclass(frozen=True, eq=False, slots=True)
class LinearMotion(Evidence):
    """The motions satisfy the linearised equations.

    Attributes
    ----------
    hypothesis : Hypothesis
    unknown : tuple of str
        Columns that are not compared.
    rest
        The place of roll and steer with the largest remaining error.
    left
        Typical error there, in scales.
    """

    hypothesis: Hypothesis
    unknown: tuple[str, ...]
    rest: Place
    left: float

    code = "linearised"

    def message(self) -> str:
        number, worst = self.rest
        rest = "No other error is visible"
        if self.left > _NEGLIGIBLE_ERROR:
            rest = (
                f"An error remains, typically {short_number(100 * self.left)} % of the largest "
                f"value of {worst} of maneuver {number} and less in roll and steer elsewhere. It "
                "may come from the integrator: try a smaller step or tolerance"
            )
        if self.unknown:
            rest += (
                f". Not compared: {', '.join(self.unknown)}, because programs with linear "
                "equations compute energies in several ways"
            )
        return (
            "The file follows the linearised equations at constant speed. A simulation "
            f"of these equations agrees with the file {short_number(self.hypothesis.relief)} times "
            f"better than the exact motion does. The benchmark asks for the nonlinear equations. "
            f"{rest}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return _errors(self.hypothesis)


@dataclass(frozen=True, eq=False, slots=True)
class LikeliestUntilThen(Evidence):
    """The likeliest cause found within the time limit; an untried one may be likelier."""

    hypothesis: Hypothesis

    code = "likeliest_until_then"

    def message(self) -> str:
        h = self.hypothesis
        return (
            f"The likeliest cause so far: {mistakes_words(h.mistakes)}. "
            f"{relief_words(h.mistakes, h.relief)}"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"mistakes": list(self.hypothesis.codes), **_errors(self.hypothesis)}


@dataclass(frozen=True, slots=True)
class Integrator(Evidence):
    """Integration methods whose first error term resembles the file's error.

    Attributes
    ----------
    methods : tuple of Method
        Indistinguishable methods.
    is_explained
        False if they are merely the nearest.
    """

    methods: tuple[Method, ...]
    is_explained: bool

    code = "integrator"

    def message(self) -> str:
        names = either([f"{m.says} with a step of {m.step:.3g} s" for m in self.methods])
        first = self.methods[0]
        without = (
            "Without that error, the file would satisfy the equations of motion "
            f"{{}}{short_number(first.relief)} times better"
        )
        if not self.is_explained:
            return (
                f"The error resembles that of {names}. {without.format('only ')}. If a smaller "
                "step does not reduce the error, look for another cause"
            )
        said = (
            f"The error is that of a method of order {first.order}, such as {names}. "
            f"{without.format('')}. "
        )
        if not first.is_of_rows:
            said += (
                "The rows are not a whole number of such steps apart, so the program uses another "
                "method of this order. "
            )
        return f"{said}Take a smaller step, or a method of higher order"

    def numbers(self) -> Mapping[str, Any]:
        methods = [{"method": m.says, "step": m.step} for m in self.methods]
        return {"methods": methods, "relief": self.methods[0].relief}


@dataclass(frozen=True, eq=False, slots=True)
class IntegratedBy(Evidence):
    """Integration methods that reproduce the file's error when they are run.

    Attributes
    ----------
    hypothesis : Hypothesis
        The likeliest one.
    methods : tuple of NumericalMethod
        Indistinguishable methods, the likeliest first.
    rest
        The place where an error remains, above the digits and a hundredth of the error; None if the
        method explains everything.
    is_next
        True if a likelier cause is reported before these methods.
    """

    hypothesis: Hypothesis
    methods: tuple[NumericalMethod, ...]
    rest: Place | None
    is_next: bool = False

    code = "integrator"

    @property
    def is_sure(self) -> bool:
        """True if no other method reproduces the error equally well.

        The explicit midpoint rule in other coordinates reduced an error of Ralston's method by a
        factor of 200.
        """
        return self.hypothesis.relief > BY_FAR**2

    def message(self) -> str:
        alike = grouped((f"{m.step:.3g} s", m.method) for m in self.methods)
        names = either([f"{either(x)} with a step of {step}" for step, x in alike.items()])
        which = "this" if len(self.methods) == 1 else "the first"
        h = self.hypothesis
        run = (
            f"A run of {which} method agrees with the file {short_number(h.relief, 1)} times "
            "better than the exact motion does"
        )
        if self.is_next:
            return f"The error also resembles that of {names}. {run}"
        if not self.is_sure:
            return (
                f"The error is nearest to that of {names}. {run}. The remaining difference may "
                "come from different state variables. If a smaller step does not reduce the error, "
                "look for another cause"
            )
        said = f"The error is that of {names}. {run}. "
        rest = "No other error is visible" if self.rest is None else _rest_words(h, self.rest)
        return f"{said}{rest}. Take a smaller step, or a method of higher order"

    def numbers(self) -> Mapping[str, Any]:
        methods = [{"method": m.method, "step": m.step} for m in self.methods]
        return {"methods": methods, "relief": self.hypothesis.relief}


@dataclass(frozen=True, eq=False, slots=True)
class Direction(Evidence):
    """A cause that explains most of the residual of the equations.

    Attributes
    ----------
    hypothesis : Hypothesis
    """

    hypothesis: Hypothesis

    code = "direction"

    def message(self) -> str:
        h = self.hypothesis
        return (
            f"This cause explains most of the error: {mistakes_words(h.mistakes)}. "
            f"{_equations_relief(h)}. Begin with it, and then look for another cause"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"mistakes": list(self.hypothesis.codes), "relief": self.hypothesis.relief}


@dataclass(frozen=True, slots=True)
class LeftOfEquations(Evidence):
    """The residual of the equations is above the digits, but too small to show a force by itself.

    Attributes
    ----------
    shares : mapping of str to float
        Errors of the accelerations relative to themselves, by the names of the equations.
    acts_in
        The equation in which it acts most, as a generalised force.
    above
        Its ratio to the difference of the rates from the slopes of the angles.
    """

    shares: Mapping[str, float]
    acts_in: str
    above: float

    code = "left_of_equations"

    @property
    def may_be_explicit(self) -> bool:
        """True if explicit Runge-Kutta methods can leave such a residual."""
        return self.above <= _MAX_RATIO_OF_EXPLICIT

    def message(self) -> str:
        said = (
            "The motion in the file does not quite satisfy the equations of motion. The largest "
            f"violation is in {equation_words(self.acts_in)}. The accelerations are off by "
            f"{accelerations_words(self.shares)}. "
        )
        if self.may_be_explicit:
            return f"{said}An integrator can cause this much; most wrong terms cause more"
        if self.above <= _MAX_RATIO_OF_INTEGRATORS:
            return f"{said}Interpolated rows or an implicit integrator can cause this much"
        return f"{said}No known integrator causes this much"

    def numbers(self) -> Mapping[str, Any]:
        return _residual(self)


@dataclass(frozen=True, slots=True)
class ForceUnexplained(Evidence):
    """A force or a term that no known cause explains.

    Attributes
    ----------
    left : LeftOfEquations
        The residual, above that of an integrator.
    is_beside
        True if a cause explains nearly everything else.
    is_end
        True if the search ended with it, and two mistakes at once were not tried.
    closest : tuple of Hypothesis
        Causes that explain a part of the residual, though not enough.
    loads : tuple of FittedLoad
        Forces or torques at one place that explain the residual with any size, the best first.
    """

    left: LeftOfEquations
    is_beside: bool
    is_end: bool
    closest: tuple[Hypothesis, ...] = ()
    loads: tuple[FittedLoad, ...] = ()

    code = "term_unexplained"
    severity = Severity.WARNING

    def message(self) -> str:
        if self.loads:
            said = _load_words(self.loads)
            if self.closest and self.closest[0].relief > THRESHOLDS.direction_factor:
                said += (
                    f". The nearest known cause is this: {mistakes_words(self.closest[0].mistakes)}"
                    f". {_equations_relief(self.closest[0])}"
                )
            return said
        what = (
            "The remaining error is larger than an integrator's. It is a nonlinear effect of this "
            "mistake, or it has another cause"
            if self.is_beside
            else "No known cause explains the error. A force or a term may be added or missing, a "
            "length may be wrong, or a constraint may drift, slip or yield"
        )
        said = (
            f"{what}. The unexplained force or torque is largest in "
            f"{equation_words(self.left.acts_in)}: look there first"
        )
        if self.closest:
            said += f". {_nearest_words(self.closest[0])}"
        if self.is_end:
            said += (
                ". Pairs of mistakes were not tried. To try them, use --thorough (thorough=True in "
                "Python)"
            )
        return said

    def numbers(self) -> Mapping[str, Any]:
        return {
            **_residual(self.left),
            "closest": [list(h.codes) for h in self.closest],
            "loads": [asdict(x) for x in self.loads],
        }


def _load_words(loads: Sequence[FittedLoad]) -> str:
    """Say where a force acts, how large it is, and what it varies with."""
    best, *others = loads
    unit = LOADS[best.load].unit
    said = (
        f"The program applies {LOADS[best.load].says}, or lacks a term that acts like this. Its "
        "size was fitted in every part of the run: with it, the file satisfies the equations "
        f"{short_number(best.relief)} times better. "
    )
    if best.varies_with == CONSTANT:
        said += f"The size is nearly constant, {best.coefficient:.2g} {unit}"
    else:
        said += (
            f"The size is largest at {best.time:.2f} s in maneuver {best.maneuver}: "
            f"{best.size:.2g} {unit}"
        )
    if best.varies_with == TIME:
        said += ". It is the same function of time in every maneuver"
    elif best.varies_with and best.varies_with != CONSTANT:
        per = "" if best.varies_with.endswith("angle") else " s"
        said += f". It is nearly {best.coefficient:.2g} {unit}{per}/rad times the "
        said += best.varies_with
    if others:
        rest = either([LOADS[x.load].says for x in others])
        said += f". It may also be {rest}: the file does not distinguish them"
    return said


@dataclass(frozen=True, slots=True)
class TorqueLaw(Evidence):
    """A torque that depends on one angle or rate, and that no known cause explains."""

    law: Law

    code = "torque_law"
    severity = Severity.WARNING

    def message(self) -> str:
        law = self.law
        of = dict(zip(law.places, law.values, strict=True))
        largest = max(of)
        unit = "rad/s" if law.variable.endswith("rate") else "rad"
        some = sorted({min(of, key=lambda x: abs(x - part * largest)) for part in _PARTS_OF_RANGE})
        where = "on the steer axis" if law.equation == "steer" else "that rolls the bicycle"
        values = ", ".join(f"{of[x]:.3g} N m at {x:.2g} {unit}" for x in some)
        said = (
            f"The program applies an extra torque {where}, or lacks one. The torque is an odd "
            f"function of the {law.variable} alone, for example {values}. It was fitted to one "
            "half of the run. In the other half, the file satisfies the equations of motion "
            f"{short_number(law.relief)} times better with this torque than without it"
        )
        if law.variable == f"{law.equation} rate" and all(of[x] < 0.0 for x in some):
            said += (
                ". It brakes, as friction does. Look at what your program applies at this joint by "
                "default"
            )
        return said

    def numbers(self) -> Mapping[str, Any]:
        law = self.law
        return {
            "equation": law.equation,
            "variable": law.variable,
            "places": list(law.places),
            "values": list(law.values),
            "relief": law.relief,
        }


@dataclass(frozen=True, slots=True)
class NoCauseFound(Evidence):
    """No known cause explains the file.

    Attributes
    ----------
    tried
        Number of programs tried.
    maneuver, key, max_rel_error
        Place and size of the largest error, in scales.
    are_equations_met
        True if the file's motion satisfies the equations.
    closest : tuple of Hypothesis
        Causes that explain a part of the residual of the equations, though not enough.
    is_of_output
        True if only some columns are wrong, which the finding before this one names.
    """

    tried: int
    maneuver: int
    key: str
    max_rel_error: float
    are_equations_met: bool
    closest: tuple[Hypothesis, ...] = ()
    is_of_output: bool = False

    code = "no_mistake_found"

    def message(self) -> str:
        size = f"{scale_words(self.max_rel_error, self.key)}, in maneuver {self.maneuver}"
        tried = f"{self.tried} mistakes and combinations were tried"
        if has_right_digits(self.max_rel_error):
            said = f"The largest error is only {size}. No known mistake explains it: {tried}"
        elif self.is_of_output:
            said = f"No known mistake explains these wrong columns: {tried}"
        else:
            said = f"No known mistake explains the error: {tried}. The largest error is {size}"
        if self.are_equations_met:
            said += ". The motion in the file satisfies the equations of motion"
        if self.closest:
            said += f". {_nearest_words(self.closest[0])}"
        return said

    def numbers(self) -> Mapping[str, Any]:
        return {
            "tried": self.tried,
            "max_rel_error": self.max_rel_error,
            "closest": [list(h.codes) for h in self.closest],
        }


@dataclass(frozen=True, slots=True)
class UnitsBeside(Evidence):
    """The motion that explains the file fits some columns in other units than the score assumed."""

    units: Mapping[str, str]

    code = "units_beside"

    def message(self) -> str:
        units = " and ".join(in_units(self.units))
        return (
            f"With this cause, the file fits if {units}. The score compares only with the exact "
            "motion, so it assumed other units, and its errors are too large. Name the units in "
            "the headings, or with --columns (roll_angle_deg)"
        )

    def numbers(self) -> Mapping[str, Any]:
        return {"units": dict(self.units)}


@dataclass(frozen=True, slots=True)
class NothingWrong(Evidence):
    """Columns are right as far as the digits written show.

    Attributes
    ----------
    keys : tuple of str
        The right columns; empty if every column that was compared is.
    signs : SignContradiction or None
        Contradictory signs of columns that are right one by one.
    are_all
        True if all columns of the file were compared.
    """

    keys: tuple[str, ...] = ()
    signs: SignContradiction | None = None
    are_all: bool = True

    def _finding(self) -> Finding:
        every = "Every column" if self.are_all else "Every column that was compared"
        which = f"{named(self.keys)}: each" if self.keys else every
        if self.signs is None:
            said = f"{which} is as exact as the digits written allow"
            return info("nothing_to_explain", said)
        said = f"{which} is right by itself, but {self.signs.message()}"
        return replace(self.signs.finding(), message=said)


@dataclass(frozen=True, slots=True)
class MostlyZeros(Evidence):
    """Most columns contain only zeros."""

    code = "cannot_tell"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            "Most columns contain only zeros. Either the bicycle rides straight on, because it "
            "starts without the initial roll rate, or the values were never filled in"
        )


@dataclass(frozen=True, slots=True)
class NothingToDiagnose(Evidence):
    """None of the benchmark's columns has a value."""

    code = "nothing_to_diagnose"
    severity = Severity.WARNING

    def message(self) -> str:
        return (
            "The diagnosis needs values of the benchmark's columns, and the file has none. The "
            f"columns are {', '.join(BENCHMARK_COLUMNS)}"
        )


def _nearest_words(h: Hypothesis) -> str:
    """Name a cause that explains the residual of the equations only in part."""
    return (
        f"The nearest known cause explains too little: {mistakes_words(h.mistakes)}. "
        f"{_equations_relief(h)}"
    )


def _equations_relief(h: Hypothesis) -> str:
    """Say by which factor a file satisfies equations with a mistake better than the exact ones."""
    return (
        f"With {with_words(h.mistakes)}, the file satisfies the equations of motion "
        f"{short_number(h.relief)} times better"
    )


def _rest_words(h: Hypothesis, rest: Place) -> str:
    """Describe where an error remains with a hypothesis, and its size."""
    number, key = rest
    return (
        f"Another error remains: {key} of maneuver {number} is still off, typically by "
        f"{scale_words(h.after[rest])}"
    )


def _errors(h: Hypothesis) -> dict[str, Any]:
    """Return the typical errors without and with a hypothesis, and how much they fall."""
    before, after = (
        {f"{maneuver}.{key}": x for (maneuver, key), x in typical.items()}
        for typical in (h.before, h.after)
    )
    return {"gain": h.gain, "relief": h.relief, "before": before, "after": after}


def _value(x: FittedValue) -> dict[str, Any]:
    """Return the numbers of a fitted value for JSON."""
    return {
        "unknown": x.name,
        "maneuver": x.maneuver,
        "value": x.value,
        "uncertain": x.uncertain,
        "instead_of": x.right,
        "unit": UNIT_OF_VALUE[x.name],
    }


def _residual(left: LeftOfEquations) -> dict[str, Any]:
    """Return the numbers of a residual of the equations for JSON."""
    return {"shares": dict(left.shares), "acts_in": left.acts_in, "above": left.above}
