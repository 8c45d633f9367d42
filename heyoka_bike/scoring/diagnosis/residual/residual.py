"""The residual of the exact equations along the motions of a file, and the causes that explain it.

Along a motion, the equations of another program give other accelerations. Their difference from the
exact ones is a *term*. The term of a known mistake is exact. The term of a parameter or a force is
its derivative times a coefficient, which is fitted. No motion is simulated for this.

The residual of an equation of motion in a maneuver is a *block*. Its size is unknown, so the fit
minimises the sum of the logarithms of the residuals of all blocks, as in `linear_fits`. Possible
causes are the mistakes of the library, alone and in pairs, and fitted values of one, two or three
parameters and forces. They are compared by their odds, see `odds`, with equations instead of
columns. The likeliest values are then refined by whole runs.
"""

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from functools import cached_property, lru_cache, partial
from math import exp

import numpy as np

from heyoka_bike.bicycle.parameters import PARAMETERS, START
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR
from heyoka_bike.scoring.diagnosis import step_log
from heyoka_bike.scoring.diagnosis.budget import NEVER, Deadline
from heyoka_bike.scoring.diagnosis.hypothesis import Hypothesis
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS, fall
from heyoka_bike.scoring.diagnosis.programs.forces import (
    FORCES,
    OF_THE_STATE,
    PLACE_IN_STATE,
    Moving,
    forces_and_tensors,
    rates_altered,
)
from heyoka_bike.scoring.diagnosis.programs.program import (
    Cause,
    FittedValues,
    Mistake,
    ParameterValues,
    Program,
    apply,
    beginning,
    equations_of,
    other_values,
)
from heyoka_bike.scoring.diagnosis.residual.fits import Fits
from heyoka_bike.scoring.diagnosis.residual.laws import Law, best_law
from heyoka_bike.scoring.diagnosis.residual.linear_fits import best_subsets
from heyoka_bike.scoring.diagnosis.residual.loads import FittedLoad, Windows, find_loads
from heyoka_bike.scoring.diagnosis.residual.methods import Method, find_methods
from heyoka_bike.scoring.diagnosis.residual.observed import (
    STATE_KEYS,
    Observed,
    start_shown,
    state_vector,
)
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, TOLERANCE
from heyoka_bike.scoring.ratios import CLEARLY

EQUATIONS = ("roll", "steer", "speed")
"""Equations of motion, in the order of the blocks of a maneuver."""

UNKNOWNS = (*PARAMETERS, *(name for name, force in FORCES.items() if force.is_fitted))
"""Parameters and forces whose values can be fitted."""

GROUPS = tuple(
    names
    for b in "BH"
    for names in (
        tuple(f"I{b}{axes}" for axes in ("xx", "yy", "zz", "xz")),
        (f"m{b}", f"x{b}", f"z{b}"),
        (f"m{b}", f"z{b}"),
    )
)
"""Parameters that a mistake changes together: the inertia of a body, or its mass and its centre."""

# Relative residual of equations that have no solution. Larger residuals are reduced to this value.
_NO_LIMIT = 1e9
_METHOD = step_log.Step("method", "which integrator's error explains the residual?")
_TINY = float(np.finfo(np.float64).tiny)


class Visibility(IntEnum):
    """How much of the motion a file shows; each level includes the levels before it."""

    NOTHING = 0
    """Nothing: the rates contradict the angles, or the exact equations have no solution there."""
    STARTS = 1
    """Only the initial conditions: rows are too far apart for the equations, or have few digits."""
    EQUATIONS_PARTLY = 2
    """The equations, but with a computed speed or computed rates, which may be wrong."""
    EQUATIONS = 3
    """The equations of motion: the file contains both angles, at least one rate, and the speed or
    the kinetic energy."""


class Residual:
    """The residual of the equations of motion, and the causes that explain it.

    Parameters
    ----------
    motions : sequence of Observed
        Motions of the file, by one interpretation of its columns.
    program : Program
        The correct program.
    library : sequence of Mistake
        Mistakes of the model.
    deadline : Deadline
        The search for causes ends at this time.

    Attributes
    ----------
    equations : tuple of str
        The members of `EQUATIONS` that are compared; without the speed if it is not in the file.
    known : tuple of Hypothesis
        Mistakes of the library, alone and in pairs; those that explain most first.
    shares : mapping of str to float
        Residual of the accelerations of roll, steer and speed, relative to their size; the largest
        of the maneuvers.
    above
        Ratio of the residual to the difference between the rates and the slopes of the angles, both
        relative to their size. An integrator's error is in both, a force only in the residual.
    visibility : Visibility
    is_resolved
        True if the file determines the whole state, and the residual is above its digits.
    observed : ndarray, shape (n,)
        Averages of the file's accelerations, block by block.
    floors : ndarray, shape (B,)
        Resolution limit of each block.
    """

    def __init__(
        self, motions: Sequence[Observed], program: Program, library: Sequence[Mistake],
        deadline: Deadline = NEVER,
    ) -> None:  # fmt: skip
        self.program, self._deadline = program, deadline
        count = min(len(m.accelerations) for m in motions)
        self.motions = tuple(m.without_speed() for m in motions) if count == 2 else tuple(motions)
        self.equations = EQUATIONS[:count]
        self._pitch: dict[object, Array] = {}
        self._moving = lru_cache(2)(self._along_the_motions)
        self._starts_shown = lru_cache(2)(self._back_to_the_start)
        self._places = tuple((m.number, name) for m in motions for name in self.equations)
        self._ends = np.cumsum([len(m.time) for m in motions])[:-1]
        self._cuts = np.cumsum(np.repeat([len(m.windows) for m in motions], count))[:-1]
        self.observed = np.concatenate([m.accelerations.ravel() for m in self.motions])
        unknown = self.blocks(np.concatenate([m.uncertain.ravel() for m in self.motions]))
        digits = np.array([np.median(x) for x in unknown])
        # Windows in which the rows are too far apart to resolve the motion have little weight.
        shares = [f**2 / (f**2 + x**2) for f, x in zip(digits, unknown, strict=True)]
        self._weights = np.concatenate([np.sqrt(x / np.mean(x)) for x in shares])
        self._sizes = np.array([_rms(x) or _TINY for x in self.blocks(self.observed)])
        self._right = self.of(program)
        self.floors = digits
        rest = self._left(self._right)
        # Raise the limits to the size of a negligible residual, which needs no further cause.
        self.floors = np.hypot(digits, THRESHOLDS.negligible_error * self._sizes)
        self._before = self._left(self._right)
        self.shares = {name: float(np.max(rest[k::count])) for k, name in enumerate(self.equations)}
        # Use only the equations of roll and steer: if the speed hardly changes, its equation shows
        # little.
        slopes = [max(m.inconsistency(), THRESHOLDS.negligible_error) for m in motions]
        self.above = float(np.max(np.sqrt(rest[0::count] * rest[1::count]) / slopes))
        is_blown_up = max(slopes) > MEANINGLESS_ERROR or bool(np.max(rest) == _NO_LIMIT)
        resolved = self._before * self._sizes / digits
        is_above = np.exp(np.mean(np.log(resolved))) > THRESHOLDS.visible_ratio
        is_resolved = bool(is_above) and not is_blown_up
        is_judged = is_resolved or bool(np.median(rest / resolved) < THRESHOLDS.visible_fraction)
        self._determines_state = all(m.determines_state for m in motions)
        self.is_resolved = is_resolved and self._determines_state
        if is_blown_up:
            self.visibility = Visibility.NOTHING
        elif not is_judged:
            self.visibility = Visibility.STARTS
        else:
            self.visibility = (
                Visibility.EQUATIONS if self._determines_state else Visibility.EQUATIONS_PARTLY
            )
        self.known = self._known(library)

    @cached_property
    def fitted(self) -> tuple[Hypothesis, ...]:
        """Fitted values of one, two or three unknowns that explain the residual.

        Empty if none explains more than the library does. If these leave a force, laws of the state
        are fitted, too.
        """
        found = self._of_unknowns
        if shows_equations(self):
            is_open = self.leaves_force([*self.known, *found])
        else:
            largest = _largest_relief(*self.known, *found)
            # If the file does not determine the speed or the rates, a law of the state may wrongly
            # seem to explain far more than other causes. Then simulations of whole runs decide.
            is_partly = self.visibility is Visibility.EQUATIONS_PARTLY
            is_force = any(x.name in FORCES for h in found[:1] for x in h.found)
            is_more = is_force or THRESHOLDS.direction_factor * largest < self.limit
            is_open = is_partly and self.is_large and is_more
        return self._fitted([*UNKNOWNS, *OF_THE_STATE]) if is_open else found

    @cached_property
    def _of_unknowns(self) -> tuple[Hypothesis, ...]:
        """The fitted values as in `fitted`, but without laws of the state."""
        return self._fitted(UNKNOWNS)

    @property
    def limit(self) -> float:
        """Largest possible relief: that of a cause that leaves the resolution limit only."""
        return self._relief(self.observed)

    @cached_property
    def as_good_as_known(self) -> tuple[Hypothesis, ...]:
        """Fitted single parameters that explain nearly as much as the best known mistake."""
        least = _largest_relief(*self.known) / CLEARLY
        found = self._fits().fewest(
            [*PARAMETERS], lambda m: [self.judged(m)], lambda _: False, counts=(1,)
        )
        return tuple(h for h in found if h.relief > max(least, THRESHOLDS.direction_factor))

    @cached_property
    def methods(self) -> tuple[Method, ...]:
        """Methods of integration that explain the residual equally well."""
        equations = equations_of(tuple(self.program.motion.bicycle.values.items()))
        with step_log.logged(_METHOD) as log:
            found = find_methods(equations, self.motions)
            if found:
                each = (f"{m.says} (step {m.step:.3g} s)" for m in found)
                log.found = partial(", ".join, each)
        return found

    @cached_property
    def law(self) -> Law | None:
        """A torque as a function of one variable that explains the residual; None if none does."""
        moving = self._moving(tuple(self.program.motion.bicycle.values.items()))
        zero = 0.0 * moving.state[0]
        unit = np.array([[1.0], [1.0], [float(moving.equations.k.length)]])
        added = {
            name: np.array(moving.added([zero + float(i == j) for j in range(3)])) * unit
            for i, name in enumerate(EQUATIONS[:2])
        }
        found = best_law(
            {name: np.asarray(moving.state[i]) for name, i in PLACE_IN_STATE.items()},
            added,
            lambda x: self.weighted(self._averages(x)),
            self.weighted(self.observed - self._right),
            self.floors,
        )
        return found if found and found.relief > CLEARLY else None

    @cached_property
    def loads(self) -> tuple[FittedLoad, ...]:
        """Loads that explain the residual, with any size, the best first."""
        count = len(self.equations)
        sizes = np.maximum(self._before * self._sizes, self.floors)

        def by_maneuver(blocks: Sequence[Array]) -> list[Array]:
            each = [x / size for x, size in zip(blocks, sizes, strict=True)]
            return [np.array(each[i : i + count]) for i in range(0, len(each), count)]

        floors = (self.floors / sizes)[:, None]
        moving = self._moving(tuple(self.program.motion.bicycle.values.items()))
        return find_loads(
            moving,
            Windows(
                by_maneuver(self.weighted(self.observed - self._right)),
                [floors[i : i + count] for i in range(0, len(floors), count)],
                lambda x: by_maneuver(self.weighted(self._averages(x))),
                [m.number for m in self.motions],
                [m.windows @ m.time for m in self.motions],
                {
                    name: [
                        m.windows @ x
                        for m, x in zip(
                            self.motions,
                            np.split(np.asarray(moving.state[i]), self._ends),
                            strict=True,
                        )
                    ]
                    for name, i in PLACE_IN_STATE.items()
                },
            ),
        )

    @cached_property
    def promise(self) -> float:
        """Rank of an interpretation of the file: largest expected relief, divided by the residual.

        The relief is that of the library, or of one unknown to first order.
        """
        to_first_order = self._fits().first_order_gain(UNKNOWNS)
        largest = max(_largest_relief(*self.known), to_first_order)
        return largest / float(np.exp(np.mean(np.log(self._before))))

    @property
    def mismatch(self) -> float:
        """Largest relative difference between the rates and the slopes of the angles."""
        return max(m.inconsistency() for m in self.motions)

    @property
    def is_explained(self) -> bool:
        """True if the residual is small, or a mistake or fitted values explain nearly all of it."""
        if not self.is_resolved or not self.is_large:
            return True
        largest = _largest_relief(*self.known, *self._of_unknowns)
        return largest > min(THRESHOLDS.direction_factor, self.limit / CLEARLY)

    @property
    def is_large(self) -> bool:
        """True if the errors of the accelerations would be visible in a plot.

        Errors of most integrators would not.
        """
        return max(self.shares.values()) > TOLERANCE

    @property
    def promising(self) -> tuple[str, ...]:
        """The unknowns that, each alone and to first order, explain most of the residual."""
        found = best_subsets(self._fits().first_order(UNKNOWNS), 1, THRESHOLDS.max_values)
        return tuple(UNKNOWNS[i] for (i,) in found.members.tolist())

    @property
    def log_odds(self) -> float:
        """Log odds of the likeliest cause; at least 0, the value for "none of the known causes"."""
        return max([0.0, *(h.log_odds for h in (*self.known, *self.fitted))])

    @property
    def is_open(self) -> bool:
        """True if the residual shows a force or a term that no cause or integrator explains."""
        return self.leaves_force([*self.known, *self.fitted])

    @property
    def largest(self) -> Hypothesis | None:
        """The cause that explains most, however unlikely it is; None if there are no causes."""
        return max((*self.known, *self.fitted), key=lambda h: h.relief, default=None)

    @property
    def is_met(self) -> bool:
        """True if the file's motion satisfies the exact equations within the resolution limits."""
        return bool(np.all(self._before * self._sizes <= MAX_ROUNDING_FLOORS * self.floors))

    def leaves_force(self, causes: Iterable[Hypothesis]) -> bool:
        """True if each of these causes leaves a residual that no integrator makes.

        As for `above`, only the equations of roll and steer count. False if the speed or both rates
        are not in the file: the computed ones may be wrong.
        """
        places = [place for place in self._places if place[1] in EQUATIONS[:2]]
        most = max((exp(fall(h.before, h.after, places)) for h in causes), default=1.0)
        return self._determines_state and self.above > THRESHOLDS.force_ratio * most

    @property
    def is_described(self) -> bool:
        """True if the residual is visible and no integrator explains it, so it is reported."""
        return self.is_resolved and not self.methods

    @cached_property
    def acts_in(self) -> str:
        """Name of the equation in which the residual is largest, as a generalised force.

        The generalised force is the mass matrix times the residual accelerations. It is compared
        relative to the one of the accelerations themselves, as a geometric mean over the maneuvers.
        """
        moving = self._moving(tuple(self.program.motion.bicycle.values.items()))
        unit = np.array([[1.0], [1.0], [float(moving.equations.k.length)]])[: len(self.equations)]
        mass = np.array([np.broadcast_arrays(*row) for row in moving.mass])[
            : len(unit), : len(unit)
        ]
        found, rows = [], iter(np.split(self._right, self._cuts))
        for m, each in zip(self.motions, np.split(mass, self._ends, axis=2), strict=True):
            right = np.array([next(rows) for _ in self.equations])
            left, whole = (
                np.sum((each @ m.windows.T) * (x / unit), axis=1)
                for x in (m.accelerations - right, m.accelerations)
            )
            found.append(np.log(np.mean(left**2, axis=1) / np.mean(whole**2, axis=1)))
        shares = np.mean(found, axis=0)
        # A residual that exceeds the acceleration itself indicates that a column was read wrongly,
        # so prefer other equations.
        told = shares if np.min(shares) > 0.0 else np.where(shares > 0.0, -np.inf, shares)
        return self.equations[int(np.argmax(told))]

    @property
    def definitions(self) -> Mapping[str, str]:
        """Names of the columns of `STATE_KEYS`, under the interpretation of the file."""
        return self.motions[0].definitions

    @property
    def best(self) -> Hypothesis | None:
        """The hypothesis with the fewest causes that explains nearly all of the residual, or None.

        If a force remains, several causes together do not count: each explains a share of it.
        """
        sure = [
            h
            for h in (*self.known, *self.fitted)
            if h.relief > THRESHOLDS.direction_factor and h.log_odds > THRESHOLDS.report_log_odds
            if len(h.parts) == 1 or not self.leaves_force([h])
        ]
        if not shows_equations(self):
            return None
        return min(sure, key=lambda h: (len(h.parts), -h.log_odds), default=None)

    def weighted(self, rows: Array) -> list[Array]:
        """Return the rows of each block, weighted by the resolution of their windows."""
        return self.blocks(self._weights * rows)

    def blocks(self, rows: Array) -> list[Array]:
        """Split rows into blocks: roll, steer and speed of each maneuver."""
        return np.split(rows, self._cuts)

    def of(self, program: Program) -> Array:
        """Return averages of a program's accelerations, shape (n,); NaN without a solution."""
        forces, unturned = forces_and_tensors(dict(program.motion.amounts))
        try:
            with np.errstate(all="ignore"):
                values = tuple(program.motion.bicycle.values.items())
                moving = self._moving(values, tuple(unturned.items()))
                rates = moving.altered(forces)[3:6]
                each = np.array([rates[0], rates[1], rates[2] * moving.equations.k.length])
        except ZeroDivisionError:
            return np.full(len(self.observed), np.nan)
        return self._averages(each)

    def _averages(self, accelerations: Array) -> Array:
        """Average accelerations of all motions, shape (3, rows), over windows: shape (n,)."""
        parts = np.split(accelerations[: len(self.equations)], self._ends, axis=1)
        return np.concatenate(
            [(x @ m.windows.T).ravel() for x, m in zip(parts, self.motions, strict=True)]
        )

    def _along_the_motions(
        self, values: ParameterValues, unturned: tuple[tuple[str, float], ...] = ()
    ) -> Moving:
        equations = equations_of(values)
        k = equations.k
        key = k.tilt, k.d1, k.d2, k.d3, k.h0, k.h1, k.h2, k.h3

        def column(name: str) -> Array:
            return np.concatenate([m.state[name] for m in self.motions])

        state = state_vector(equations, column, self._pitch.get(key))
        self._pitch[key] = state[1]
        return Moving(equations, state, dict(unturned))

    def _left(self, accelerations: Array) -> Array:
        """Return the RMS residual of each block, relative to the size of the block."""
        with np.errstate(all="ignore"):
            rows = self.weighted(self.observed - accelerations)
            squares = np.array([np.mean(x**2) for x in rows]) + self.floors**2
            left = np.nan_to_num(np.sqrt(squares) / self._sizes, nan=_NO_LIMIT, posinf=_NO_LIMIT)
            found: Array = np.minimum(left, _NO_LIMIT)
        return found

    def _relief(self, accelerations: Array) -> float:
        return float(np.exp(np.mean(np.log(self._before / self._left(accelerations)))))

    def relief(self, mistakes: Sequence[Cause]) -> float:
        """Return the factor by which some mistakes reduce the residual."""
        return self._relief(self.of(apply(self.program, mistakes)))

    def leaves_more(self, mistakes: Sequence[Cause]) -> bool:
        """True if mistakes leave a residual that neither rounding nor an integrator explains.

        An integrator's error is also in the rates, which then differ from the slopes of the angles.
        """
        if self.visibility is not Visibility.EQUATIONS:
            return False
        accelerations = self.of(apply(self.program, mistakes))
        enough = THRESHOLDS.visible_ratio
        left = self._left(accelerations) * self._sizes / self.floors
        return bool(np.max(left) > enough and self.above > enough * self._relief(accelerations))

    def judged(self, *mistakes: Cause) -> Hypothesis:
        """Return some mistakes as a hypothesis about the residual."""
        return self._compared(mistakes, self.of(apply(self.program, mistakes)))

    def _compared(self, mistakes: tuple[Cause, ...], accelerations: Array) -> Hypothesis:
        before, left = (
            dict(zip(self._places, x.tolist(), strict=True))
            for x in (self._before, self._left(accelerations))
        )
        return Hypothesis(mistakes, before, left, self._places)

    def _known(self, library: Sequence[Mistake]) -> tuple[Hypothesis, ...]:
        """Judge the known mistakes, singly and in pairs."""
        alone = {m.code: self._tried(apply(self.program, (m,))) for m in library}
        found = [self._compared((m,), alone[m.code]) for m in library]
        relief = {h.codes[0]: h.relief for h in found}
        ranked = sorted(library, key=lambda m: -relief[m.code])
        pairs = []
        for i, first in enumerate(ranked[: THRESHOLDS.max_pairs]):
            for second in ranked[i + 1 :]:
                # The effect of two mistakes together is nearly the sum of their effects. A small
                # mistake may increase the residual if it is alone, but reduce it together with a
                # large mistake.
                both = alone[first.code] + alone[second.code] - self._right
                about = self._relief(both)
                if about > THRESHOLDS.min_pair_gain * max(relief[first.code], 1.0):
                    pairs.append((about, first, second))
        pairs.sort(key=lambda x: -x[0])
        for _, *pair in pairs[: THRESHOLDS.max_pairs]:
            both_made = self.judged(*(m for m in library if m in pair))
            if both_made.relief > THRESHOLDS.min_pair_gain * max(relief[m.code] for m in pair):
                found.append(both_made)
        return tuple(sorted(found, key=lambda h: -h.relief))

    def _fitted(self, names: Sequence[str]) -> tuple[Hypothesis, ...]:
        """Fit as few unknowns as explain the residual, if they are likelier than the library."""
        enough = self.limit / CLEARLY
        known = self.known[0]
        if (
            len(known.mistakes) == 1
            and known.relief > enough
            and known.log_odds > THRESHOLDS.report_log_odds
        ):
            return ()
        least = max(0.0, known.log_odds)
        return self._fits().fewest(
            names,
            lambda m: [self.judged(m)],
            lambda h: h.relief > enough,
            least=least,
            groups=GROUPS,
        )

    def _fits(self) -> Fits:
        return Fits(
            self.program,
            self._leaves,
            self.floors,
            len(self.motions),
            THRESHOLDS.residual_exponent,
            needed=THRESHOLDS.explained_factor,
        )

    def _leaves(self, programs: Sequence[Program]) -> list[list[Array]]:
        """Return the blocks of the residual that remain with the accelerations of each program."""
        return [self.weighted(self.observed - self._tried(p)) for p in programs]

    def _tried(self, program: Program) -> Array:
        """Check the time limit, then return the accelerations of a program, see `of`."""
        self._deadline.check()
        return self.of(program)

    def _back_to_the_start(self, causes: tuple[Cause, ...]) -> dict[int, tuple[Array, Array]]:
        """Return initial states with their scatter, see `start_shown`.

        They are those of a program with these causes, by maneuver that has first rows.
        """
        motion = apply(self.program, causes).motion
        equations = equations_of(tuple(motion.bicycle.values.items()))
        amounts = dict(motion.amounts)

        def rates(y: Array) -> Array:
            return np.array(np.broadcast_arrays(*rates_altered(equations, list(y), amounts)))

        # Motions that have become unstable give infinite values or NaN. Suppress the warnings about
        # them.
        with np.errstate(all="ignore"):
            return {m.number: start_shown(m, equations, rates) for m in self.motions if m.is_begun}

    def starts_nearby(self, library: Sequence[Mistake]) -> list[Mistake]:
        """Return mistakes with initial conditions nearer to the file's than the given ones are."""
        shown = self._starts_shown(())
        own = {m.number: shown[m.number][0] for m in self.motions if m.has_beginning}

        def distance(program: Program) -> float:
            found = 0.0
            for n, state in own.items():
                size = np.abs(_given(self.program, n)) + np.abs(state) + 1e-3
                found += float(np.sum(np.abs(_given(program, n) - state) / size))
            return found

        right = distance(self.program)
        near = [(distance(apply(self.program, (m,))), i) for i, m in enumerate(library)]
        return [library[i] for x, i in sorted(near)[: THRESHOLDS.max_starts] if x < right]

    def other_starts(self, causes: tuple[Cause, ...] = ()) -> list[FittedValues]:
        """Return the initial values, for each maneuver, that differ from the given ones.

        They are found by integrating the equations of a program with these causes back from the
        file's own rows, see `start_shown`.
        """
        found, shown = [], self._starts_shown(causes)
        for m in self.motions:
            if not m.is_begun:
                continue
            start, scatter = shown[m.number]
            off = start - _given(self.program, m.number)
            size = np.std([m.state[key] for key in STATE_KEYS], axis=1) + _TINY
            # An initial value counts as different if its difference exceeds the scatter of the
            # rows, and is not negligible relative to the largest difference.
            least = (
                THRESHOLDS.start_scatter_factor * scatter
                + TOLERANCE * np.max(np.abs(off) / size) * size
            )
            names = [f"initial_{name}_{m.number}" for name in START]
            is_other = np.abs(off) > least
            changes = {n: float(x) for n, x, y in zip(names, off, is_other, strict=True) if y}
            if changes:
                found.append(other_values(changes, dict.fromkeys(changes, 0.0), self.program))
        return found


def shows_equations(residual: Residual | None) -> bool:
    """True if a file determines the whole state, and its rows resolve the equations."""
    return residual is not None and residual.visibility is Visibility.EQUATIONS


def _largest_relief(*causes: Hypothesis) -> float:
    return max((h.relief for h in causes), default=1.0)


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def _given(program: Program, number: int) -> Array:
    """Return the given columns of `observed.STATE_KEYS` at the start of a maneuver."""
    return np.delete(np.array(beginning(program, number)), 1)
