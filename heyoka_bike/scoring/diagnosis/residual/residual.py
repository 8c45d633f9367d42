"""The residual of the exact equations along the motions of a file, and the causes that explain it.

Along a motion, equations of another program give other accelerations. Their difference from the
right ones is a *term*: of a known mistake exactly, of a parameter or a force its derivative, whose
coefficient is to be found. No motion is simulated for it.

What remains of an equation of motion in a maneuver is a *block*. Its size is unknown, so what is
minimised is the sum of the logarithms of what is left in the blocks, as in `linear_fits`. Causes
are the mistakes of the library, alone and two together, and one, two or three parameters and forces
whose values are fitted. They are compared by their odds, see `evidence`, with the equations in the
place of the columns. The likeliest values are then refined by whole runs.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, lru_cache

import numpy as np

from heyoka_bike.bicycle.parameters import PARAMETERS, START, Bicycle
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import spread
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS, Hypothesis
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES, TENSORS_TURNING, Moving
from heyoka_bike.scoring.diagnosis.programs.program import (
    Mistake,
    Program,
    Values,
    apply,
    beginning,
    changed,
    equations_of,
    other_values,
)
from heyoka_bike.scoring.diagnosis.programs.simulator import AskedMotion, Simulator
from heyoka_bike.scoring.diagnosis.residual.linear_fits import (
    Errors,
    best_subsets,
    gauss_newton,
    left,
    linearised,
    solve,
    uncertain,
)
from heyoka_bike.scoring.diagnosis.residual.methods import Method, find_methods
from heyoka_bike.scoring.diagnosis.residual.observed import STATE, Observed, state_vector

EQUATIONS = ("roll", "steer", "speed")
"""Whose accelerations the blocks of a maneuver are, in order."""

UNKNOWNS = (*PARAMETERS, *(name for name, force in FORCES.items() if force.is_fitted))
"""Whose coefficients can be found."""

# Left by equations that have no solution, in parts of the accelerations.
_ALL = 1e9
_TINY = float(np.finfo(np.float64).tiny)
_COMPARED = 251
# Nothing is seen of a column below this part.
_NOTHING = 1e-12


class Residual:
    """The residual of the equations of motion, and the causes that explain it.

    Parameters
    ----------
    motions : sequence of Observed
        Of the file, as they were understood.
    program : Program
        The right one.
    library : sequence of Mistake
        Mistakes of the model.

    Attributes
    ----------
    equations : tuple of str
        Those of `EQUATIONS` that are compared: without that of the speed if it is not in the file.
    known : tuple of Hypothesis
        Mistakes of the library, alone and two together, those that explain most first.
    fitted : tuple of Hypothesis
        Values of one, two and three unknowns, each number where it explains far more than fewer do;
        whole runs tell which. Empty if none explains more than the library does.
    shares : mapping of str to float
        What remains of the accelerations of roll, steer and speed, in parts of them: the largest
        of the maneuvers.
    above
        How much more remains than the file's own rates are off from the slopes of its angles, both
        in parts of what they are: errors of integrators are in both.
    is_resolved, is_shown
        True if the rows are near enough and have digits enough to see what remains, or at least to
        judge the equations; False without the speed, whose start may be another.
    is_blown_up
        True if rates and angles have nothing to do with each other.
    observed : ndarray, shape (n,)
        Averages of the file's accelerations, block by block.
    """

    def __init__(
        self, motions: Sequence[Observed], program: Program, library: Sequence[Mistake]
    ) -> None:
        self.program = program
        count = min(len(m.accelerations) for m in motions)
        self.motions = tuple(m.without_speed() for m in motions) if count == 2 else tuple(motions)
        self.equations = EQUATIONS[:count]
        self._pitch: dict[object, Array] = {}
        self._moving = lru_cache(2)(self._along_the_motions)
        self._places = tuple((m.number, name) for m in motions for name in self.equations)
        self._ends = np.cumsum([len(m.time) for m in motions])[:-1]
        self._cuts = np.cumsum(np.repeat([len(m.windows) for m in motions], count))[:-1]
        self.observed = np.concatenate([m.accelerations.ravel() for m in self.motions])
        unknown = self.blocks(np.concatenate([m.uncertain.ravel() for m in self.motions]))
        digits = np.array([np.median(x) for x in unknown])
        # Windows that the rows do not resolve count for little.
        shares = [f**2 / (f**2 + x**2) for f, x in zip(digits, unknown, strict=True)]
        self._weights = np.concatenate([np.sqrt(x / np.mean(x)) for x in shares])
        self._sizes = np.array([_rms(x) or _TINY for x in self.blocks(self.observed)])
        self._right = self.of(program)
        self._floors = digits
        rest = self._left(self._right)
        # What is left below this needs no other cause.
        self._floors = np.hypot(digits, WEIGHTS.nothing * self._sizes)
        self._before = self._left(self._right)
        self.shares = {name: float(np.max(rest[k::count])) for k, name in enumerate(self.equations)}
        # Those of roll and steer: where the speed hardly changes it says little.
        slopes = [max(m.inconsistency(), WEIGHTS.nothing) for m in motions]
        self.above = float(np.max(np.sqrt(rest[0::count] * rest[1::count]) / slopes))
        self.is_blown_up = max(slopes) > WEIGHTS.blown_up
        resolved, (enough, share) = self._before * self._sizes / digits, WEIGHTS.shows
        is_near = all(np.median(np.diff(m.time)) <= WEIGHTS.spacing for m in motions)
        is_motion = is_near and not self.is_blown_up and self.equations == EQUATIONS
        self.is_resolved = is_motion and bool(np.exp(np.mean(np.log(resolved))) > enough)
        self.is_shown = self.is_resolved or (is_motion and bool(np.median(rest / resolved) < share))
        self.known = self._known(library)
        self.fitted = self._fitted()

    @cached_property
    def methods(self) -> tuple[Method, ...]:
        """Methods of integration that explain what remains and cannot be told apart."""
        return find_methods(equations_of(tuple(self.program.bicycle.values.items())), self.motions)

    @property
    def most(self) -> float:
        """The largest relief times how little remains, to compare ways to understand a file."""
        largest = max([1.0, *(h.relief for h in (*self.known, *self.fitted))])
        return largest / float(np.exp(np.mean(np.log(self._before))))

    @property
    def log_odds(self) -> float:
        """Logarithm of the odds of the likeliest cause, "none of these" among them."""
        return max([0.0, *(h.log_odds for h in (*self.known, *self.fitted))])

    @property
    def is_open(self) -> bool:
        """True if there is a force or a term that no cause explains, and no integrator makes."""
        return self.leaves_force(max((h.relief for h in (*self.known, *self.fitted)), default=1.0))

    def leaves_force(self, relief: float) -> bool:
        """True if a cause of some relief leaves what no integrator does.

        Where the speed is not in the file, it may be that of the speed.
        """
        return self.equations == EQUATIONS and self.above > WEIGHTS.above * relief

    @property
    def best(self) -> Hypothesis | None:
        """The cause that explains nearly all by the equations alone; None if none does.

        Where a force is left several causes together mean nothing: each takes a share of it.
        """
        credible = [
            h
            for h in (*self.known, *self.fitted)
            if len(h.parts) == 1 or not self.leaves_force(h.relief)
        ]
        likely = max(credible, key=lambda h: h.log_odds, default=None)
        if likely is None or not self.is_shown:
            return None
        is_sure = likely.relief > WEIGHTS.nearly and likely.log_odds > WEIGHTS.said
        return likely if is_sure else None

    def blocks(self, rows: Array) -> list[Array]:
        """Rows of each block: of each maneuver roll, steer, speed."""
        return np.split(rows, self._cuts)

    def of(self, program: Program) -> Array:
        """Return averages of a program's accelerations, shape (n,); NaN where it has none."""
        amounts = dict(program.amounts)
        try:
            with np.errstate(all="ignore"):
                values = tuple(program.bicycle.values.items())
                moving = self._moving(values, amounts.pop(TENSORS_TURNING, 0.0))
                rates = moving.altered(amounts)[3:6]
                each = np.array([rates[0], rates[1], rates[2] * moving.equations.k.length])
        except ZeroDivisionError:
            return np.full(len(self.observed), np.nan)
        parts = np.split(each[: len(self.equations)], self._ends, axis=1)
        return np.concatenate(
            [(x @ m.windows.T).ravel() for x, m in zip(parts, self.motions, strict=True)]
        )

    def _along_the_motions(self, values: Values, still: float) -> Moving:
        equations = equations_of(values)
        k = equations.k
        key = k.tilt, k.d1, k.d2, k.d3, k.h0, k.h1, k.h2, k.h3

        def column(name: str) -> Array:
            return np.concatenate([m.state[name] for m in self.motions])

        state = state_vector(equations, column, self._pitch.get(key))
        self._pitch[key] = state[1]
        return Moving(equations, state, still)

    def _left(self, accelerations: Array) -> Array:
        """Root mean squares of what accelerations leave in each block, in parts of its size."""
        with np.errstate(all="ignore"):
            rows = self.blocks(self._weights * (self.observed - accelerations))
            squares = np.array([np.mean(x**2) for x in rows]) + self._floors**2
            left: Array = np.nan_to_num(np.sqrt(squares) / self._sizes, nan=_ALL, posinf=_ALL)
        return left

    def _relief(self, accelerations: Array) -> float:
        return float(np.exp(np.mean(np.log(self._before / self._left(accelerations)))))

    def relief(self, mistakes: Sequence[Mistake]) -> float:
        """Factor by which some mistakes let what remains fall."""
        return self._relief(self.of(apply(self.program, mistakes)))

    def _judged(self, *mistakes: Mistake) -> Hypothesis:
        return self._compared(mistakes, self.of(apply(self.program, mistakes)))

    def _compared(self, mistakes: tuple[Mistake, ...], accelerations: Array) -> Hypothesis:
        before, left = (
            dict(zip(self._places, x.tolist(), strict=True))
            for x in (self._before, self._left(accelerations))
        )
        return Hypothesis(mistakes, before, left, self._places)

    def _known(self, library: Sequence[Mistake]) -> tuple[Hypothesis, ...]:
        """Mistakes of the library, alone and two together."""
        alone = {m.code: self.of(apply(self.program, (m,))) for m in library}
        found = [self._compared((m,), alone[m.code]) for m in library]
        relief = {h.codes[0]: h.relief for h in found}
        ranked = sorted(library, key=lambda m: -relief[m.code])
        pairs = []
        for i, first in enumerate(ranked[: WEIGHTS.pairs]):
            for second in ranked[i + 1 :]:
                # What two mistakes add is nearly the sum of what each does. A small one beside a
                # large one may make it worse alone.
                both = alone[first.code] + alone[second.code] - self._right
                about = self._relief(both)
                if about > WEIGHTS.also * max(relief[first.code], 1.0):
                    pairs.append((about, first, second))
        pairs.sort(key=lambda x: -x[0])
        for _, *pair in pairs[: WEIGHTS.pairs]:
            both_made = self._judged(*(m for m in library if m in pair))
            if both_made.relief > WEIGHTS.also * max(relief[m.code] for m in pair):
                found.append(both_made)
        return tuple(sorted(found, key=lambda h: -h.relief))

    def _fitted(self) -> tuple[Hypothesis, ...]:
        """The fewest unknowns that are likelier than fewer are, and than the library is."""
        enough = WEIGHTS.enough * self._relief(self.observed)
        known = self.known[0]
        if len(known.mistakes) == 1 and known.relief > enough and known.log_odds > WEIGHTS.said:
            return ()
        least = max(0.0, known.log_odds)
        best: list[Hypothesis] = []
        sizes = np.array([size_of(self.program.bicycle, name) for name in UNKNOWNS])
        first = linearised(self._errors(UNKNOWNS), 0.0 * sizes, sizes, self._floors)
        members = None
        for size, count in WEIGHTS.subsets:
            if any(h.relief > enough for h in best):
                break
            subsets = best_subsets(first, size, WEIGHTS.further_subsets, members)
            members = subsets.members
            promised = WEIGHTS.values * len(self.motions) * np.log(subsets.gains[0])
            if WEIGHTS.promise * promised < (WEIGHTS.fitted + WEIGHTS.unknown) * size:
                continue
            found = [self._refined([UNKNOWNS[i] for i in m], sizes[m]) for m in members[:count]]
            best += [h for h in found if h.log_odds > least]
        best.sort(key=lambda h: -h.log_odds)
        # Further values explain more always. Whole runs tell which causes are right.
        return tuple(h for h in best if not any(_needs_no_more(other, h) for other in best))

    def _errors(self, names: Sequence[str]) -> Errors:
        """From values of unknowns, as changes, to what they leave."""

        def missing(x: Array) -> list[Array]:
            changes = {name: float(v) for name, v in zip(names, x, strict=True) if v}
            made = self.of(changed(self.program, changes))
            return self.blocks(self._weights * (self.observed - made))

        return lambda several: [missing(x) for x in several]

    def _refined(self, names: Sequence[str], sizes: Array) -> Hypothesis:
        x, b = gauss_newton(self._errors(names), 0.0 * sizes, sizes, self._floors)
        changes, off = (dict(zip(names, v, strict=True)) for v in (x.tolist(), uncertain(b)))
        return self._judged(other_values(changes, off, self.program))

    def starts_nearby(self, library: Sequence[Mistake]) -> list[Mistake]:
        """Mistakes of the start that come nearer to the file's own than the right one does."""
        own = {m.number: m.beginning for m in self.motions if m.beginning is not None}

        def distance(program: Program) -> float:
            found = 0.0
            for n, state in own.items():
                size = np.abs(_given(self.program, n)) + np.abs(state) + 1e-3
                found += float(np.sum(np.abs(_given(program, n) - state) / size))
            return found

        right = distance(self.program)
        near = [(distance(apply(self.program, (m,))), i) for i, m in enumerate(library)]
        return [library[i] for x, i in sorted(near)[: WEIGHTS.starts] if x < right]

    def other_starts(self) -> list[Mistake]:
        """The start of each maneuver that its own rows lead back to, in what is another."""
        found = []
        for m in self.motions:
            if m.beginning is None:
                continue
            off = m.beginning - _given(self.program, m.number)
            size = np.std([m.state[key] for key in STATE], axis=1) + _TINY
            least = WEIGHTS.sure * m.scatter + WEIGHTS.small * np.max(np.abs(off) / size) * size
            names = [f"initial_{name}_{m.number}" for name in START]
            is_other = np.abs(off) > least
            changes = {n: float(x) for n, x, y in zip(names, off, is_other, strict=True) if y}
            if changes:
                found.append(other_values(changes, dict.fromkeys(changes, 0.0), self.program))
        return found


class WholeRuns:
    """Whole runs of programs with changed values, compared with the motions of a file.

    What is minimised is the sum of the logarithms of what is left in roll, steer, their rates and
    the speed of each maneuver, each in parts of its size.
    """

    def __init__(self, motions: Sequence[Observed], right: Program, simulator: Simulator) -> None:
        self._motions, self._right, self._simulator = motions, right, simulator
        self._rows = [spread(len(m.time), _COMPARED) for m in motions]
        self._floors = np.full(sum(len(m.keys) for m in motions), _NOTHING)

    def refined(self, several: Iterable[Mistake], *, with_others: bool = False) -> list[Mistake]:
        """Values near some, that whole runs show.

        Or, of rivals, those that leave nothing, or also the single one with others beside it.
        """
        found = []
        for mistake in several:
            found.append(self._of_values(mistake.changes, mistake))
            if with_others and found[-1][1] < WEIGHTS.known_well:
                return [found[-1][0]]
        alone = next((x for x in found if len(x[0].found) == 1), None)
        if with_others and alone is not None:
            found.append(self._with_others(*alone))
        return [mistake for mistake, _ in found]

    def _with_others(self, best: Mistake, left: float) -> tuple[Mistake, float]:
        """Add the parameter that leaves least, as long as it leaves far less."""
        while len(best.found) < len(WEIGHTS.subsets):
            more, rest = self._of_values(self._further(best.changes))
            fall = WEIGHTS.values * len(self._motions) * float(np.log(left / rest))
            cost = WEIGHTS.fitted + WEIGHTS.unknown + WEIGHTS.said
            if fall < cost or left < WEIGHTS.beside * rest:
                break
            best, left = more, rest
        return best, left

    def _of_values(
        self, changes: Mapping[str, float], known: Mistake | None = None
    ) -> tuple[Mistake, float]:
        """Values nearby that leave least, and how much that is; those that are known if enough."""
        errors, start = self._errors(changes), np.array([*changes.values()])
        if known is not None:
            near = left(errors([start])[0], self._floors)
            if near < WEIGHTS.known_well:
                return known, near
        x, b = gauss_newton(errors, start, self._sizes(changes), self._floors)
        found, off = (dict(zip(changes, v, strict=True)) for v in (x.tolist(), uncertain(b)))
        return other_values(found, off, self._right), b.left

    def _further(self, changes: Mapping[str, float]) -> dict[str, float]:
        """Values with one more parameter, that to first order leaves least of what these leave."""
        every = {**changes, **{name: 0.0 for name in PARAMETERS if name not in changes}}
        names, x = [*every], np.array([*every.values()])
        b = linearised(self._errors(names), x, self._sizes(names), self._floors)
        known = range(len(changes))
        subsets = np.array([[*known, i] for i in range(len(changes), len(names))])
        steps, gains = solve(b, subsets)
        i = int(np.argmax(gains))
        values = x[subsets[i]] + steps[i]
        return dict(zip([names[k] for k in subsets[i]], values.tolist(), strict=True))

    def _sizes(self, names: Iterable[str]) -> Array:
        return np.array([size_of(self._right.bicycle, name) for name in names])

    def _errors(self, names: Iterable[str]) -> Errors:
        """From values to the errors of their programs in the states, in parts of each column."""

        def errors(several: Sequence[Array]) -> list[list[Array]]:
            asked = []
            for x in several:
                p = changed(self._right, dict(zip(names, x.tolist(), strict=True)))
                asked += [
                    AskedMotion(p.bicycle, beginning(p, m.number), m.time[rows], dict(p.amounts))
                    for m, rows in zip(self._motions, self._rows, strict=True)
                ]
            made = iter(self._simulator.run_all(asked))
            return [
                [
                    _part(columns[key], m.state[key][rows])
                    for m, rows, columns in zip(self._motions, self._rows, made, strict=False)
                    for key in m.keys
                ]
                for _ in several
            ]

        return errors


def _part(values: Array, written: Array) -> Array:
    """Return the error of a column in parts of its size; 1 after the end of the motion."""
    size = float(np.sqrt(np.mean(written**2))) + float(np.finfo(np.float64).tiny)
    return np.nan_to_num((written - values) / size, nan=1.0, posinf=1.0, neginf=1.0)


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x))))


def _given(program: Program, number: int) -> Array:
    """Columns of `observed.STATE` at the start of a maneuver."""
    return np.delete(np.array(beginning(program, number)), 1)


def _needs_no_more(one: Hypothesis, other: Hypothesis) -> bool:
    """True if one cause explains nearly as much as another with further values."""
    return one.parts < other.parts and other.relief < WEIGHTS.beside * one.relief


def size_of(bicycle: Bicycle, name: str) -> float:
    """Size of an unknown; one for starts, and for parameters that are zero."""
    if name in FORCES:
        return FORCES[name].size
    return abs(float(bicycle[name])) or 1.0 if name in bicycle.values else 1.0
