"""What a diagnosis found, as evidence: causes, integrators, and that nothing explains a file.

What is seen without simulation is in `scoring.evidence`; the sentences are made in
`showing.causes`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.odds import Place
from heyoka_bike.scoring.diagnosis.programs.program import NumericalMethod
from heyoka_bike.scoring.diagnosis.residual.laws import Law
from heyoka_bike.scoring.diagnosis.residual.methods import Method
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import SignContradiction
from heyoka_bike.scoring.ratios import BY_FAR


@dataclass(frozen=True, eq=False, slots=True)
class Explained(Evidence):
    """Causes that explain a file.

    Attributes
    ----------
    rank
        1 of the likeliest.
    hypotheses : tuple of Hypothesis
        Those that cannot be told apart, the likeliest first.
    rest
        Where more is left than digits and an integrator leave; None if the cause is all.
    acceleration
        The equation that is off the most: its name, by what part of itself, and by what factor that
        falls with the cause; None where the equations do not show it.
    as_given : tuple of str
        Columns whose first row has the start that is given, where another one was found.
    left
        The largest typical error that digits do not explain, in scales; 0 if there is none.
    rivals : tuple of Hypothesis
        Other causes that explain nearly as much of the equations, where the cause is not all.
    """

    rank: int
    hypotheses: tuple[Hypothesis, ...]
    rest: Place | None
    acceleration: tuple[str, float, float] | None
    as_given: tuple[str, ...]
    left: float = 0.0
    rivals: tuple[Hypothesis, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class LinearMotion(Evidence):
    """Motions of the linearised equations.

    Attributes
    ----------
    hypothesis : Hypothesis
    unknown : tuple of str
        Columns that are not compared.
    rest
        The place of roll and steer in which most is left.
    left
        Typical error there, in scales.
    """

    hypothesis: Hypothesis
    unknown: tuple[str, ...]
    rest: Place
    left: float


@dataclass(frozen=True, eq=False, slots=True)
class LikeliestUntilThen(Evidence):
    """The likeliest cause when the time was spent; one that was not tried may be likelier."""

    hypothesis: Hypothesis


@dataclass(frozen=True, slots=True)
class Integrator(Evidence):
    """Methods whose first term the error has.

    Attributes
    ----------
    methods : tuple of Method
        Those that cannot be told apart.
    is_explained
        False if they only are the nearest.
    """

    methods: tuple[Method, ...]
    is_explained: bool


@dataclass(frozen=True, eq=False, slots=True)
class IntegratedBy(Evidence):
    """Methods that, run here, leave the file's error.

    Attributes
    ----------
    hypothesis : Hypothesis
        Of the likeliest.
    methods : tuple of NumericalMethod
        Those that cannot be told apart, the likeliest first.
    rest
        Where more is left than their digits and a hundredth of the error; None if the method is
        all.
    """

    hypothesis: Hypothesis
    methods: tuple[NumericalMethod, ...]
    rest: Place | None

    @property
    def is_sure(self) -> bool:
        """True if no other method comes so near.

        The explicit midpoint rule in other coordinates left a two hundredth beside Ralston's.
        """
        return self.hypothesis.relief > BY_FAR**2


@dataclass(frozen=True, eq=False, slots=True)
class Direction(Evidence):
    """A cause that nearly explains what disagrees with the equations.

    Attributes
    ----------
    hypothesis : Hypothesis
    """

    hypothesis: Hypothesis


@dataclass(frozen=True, slots=True)
class LeftOfEquations(Evidence):
    """What the equations leave, beyond digits; by itself it is too little to be called a force.

    Attributes
    ----------
    shares : mapping of str to float
        By what part of themselves accelerations are off, by the names of the equations.
    acts_in
        The equation in which it acts most, as a generalised force.
    above
        So many times what the rates are off from the slopes of the angles.
    """

    shares: Mapping[str, float]
    acts_in: str
    above: float

    @property
    def may_be_explicit(self) -> bool:
        """True if explicit methods of Runge and Kutta were seen to leave as much."""
        return self.above <= _MOST_OF_EXPLICIT


# IDA, which solves for the rates, leaves 152 times what they are off.
_MOST_OF_EXPLICIT = 3.0


@dataclass(frozen=True, slots=True)
class ForceUnexplained(Evidence):
    """A force or a term that no cause explains, alone or beside the best.

    Attributes
    ----------
    left : LeftOfEquations
        More than an integrator would leave.
    is_beside
        True if a cause explains nearly all.
    is_end
        True if the search ended with it: two mistakes at once were not tried.
    """

    left: LeftOfEquations
    is_beside: bool
    is_end: bool


@dataclass(frozen=True, slots=True)
class TorqueLaw(Evidence):
    """A torque that no cause known here explains, as a function of one angle or rate."""

    law: Law


@dataclass(frozen=True, slots=True)
class NoCauseFound(Evidence):
    """Nothing explains the file.

    Attributes
    ----------
    tried
        How many programs.
    maneuver, key, max_rel_error
        Of the largest error, in scales.
    are_equations_met
        True if the file's motion leaves nothing of the equations.
    closest : tuple of Hypothesis
        Causes that explain a part of what the equations leave, though not enough.
    """

    tried: int
    maneuver: int
    key: str
    max_rel_error: float
    are_equations_met: bool
    closest: tuple[Hypothesis, ...] = ()


@dataclass(frozen=True, slots=True)
class UnitsBeside(Evidence):
    """Units that columns have by the motion that explains the file; others were scored."""

    units: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class NothingWrong(Evidence):
    """Columns that are right.

    Attributes
    ----------
    keys : tuple of str
        Empty if that is every one.
    signs : SignContradiction or None
        What contradicts, though each is right by itself.
    """

    keys: tuple[str, ...] = ()
    signs: SignContradiction | None = None


@dataclass(frozen=True, slots=True)
class MostlyZeros(Evidence):
    """Most columns hold nothing but zeros."""


@dataclass(frozen=True, slots=True)
class NothingToDiagnose(Evidence):
    """None of the benchmark's columns has a value."""
