"""Causes of the residual: the terms that explain a file's motion in the exact equations.

What remains of an equation of motion in a maneuver is a *block*. Its size is unknown, so what is
minimised is the sum of the logarithms of what is left in the blocks, as in `linear_fits`. The
*relief* of a cause is the factor by which the blocks fall, as a geometric mean. Causes are the
mistakes of the library, alone and two together, and one, two or three parameters and forces whose
values are fitted. "None of these" has a relief of one. They are compared by their odds, see
`evidence`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.evidence import WEIGHTS, log_odds_before
from heyoka_bike.scoring.diagnosis.programs.forces import is_plausible
from heyoka_bike.scoring.diagnosis.programs.program import (
    Mistake,
    Program,
    apply,
    changed,
    other_values,
)
from heyoka_bike.scoring.diagnosis.residual.linear_fits import (
    Blocks,
    best_subsets,
    blocks,
    solve,
    uncertain,
)
from heyoka_bike.scoring.diagnosis.residual.methods import Method, find_methods
from heyoka_bike.scoring.diagnosis.residual.observed import Observed
from heyoka_bike.scoring.diagnosis.residual.terms import UNKNOWNS, Accelerations, blocks_of


@dataclass(frozen=True, slots=True)
class _Thresholds:
    """Thresholds of the search among terms, each with the experiment that gave it.

    Attributes
    ----------
    above
        What the best cause leaves of the equations is so many times what the rates are off from the
        slopes of the angles where a force is missing: in files of correct programs up to 152 (IDA,
        which solves for the rates), in those of engines that slip and yield up to 662.
    blown_up
        Where the rates are off by more than so much of themselves.
    spacing
        Rows that are farther apart do not show the castering mode, which decays at 25 1/s [s].
    shows
        The equations are judged where what remains is so many times what is uncertain, or that is
        less than such a part of the accelerations.
    kept
        Of the library, what explains this part of what the best does is a rival.
    rivals
        So many are compared together, or as pairs.
    also
        Two mistakes that explain so many times more than each of them are compared: whole runs
        tell more of a small one beside a large one.
    promise
        To first order a large change explains little: this power of its relief is hoped for.
    enough
        What explains this part of all that the digits show needs no further value.
    beside
        Pairs of unknowns that are tried with a third.
    steps, halvings
        Of Gauss and Newton's method: an inertia of zero in the place of the largest is found in
        six, the first of which is halved twice.
    """

    above: float = 1000.0
    blown_up: float = 0.3
    spacing: float = 0.03
    shows: tuple[float, float] = (30.0, 1e-5)
    kept: float = 0.1
    rivals: int = 6
    also: float = 1.05
    promise: float = 4.0
    enough: float = 0.1
    beside: int = 12
    steps: int = 6
    halvings: int = 5


_T = _Thresholds()

EQUATIONS = ("roll", "steer", "speed")
"""Whose accelerations the blocks of a maneuver are, in order."""


@dataclass(frozen=True, slots=True)
class Cause:
    """Mistakes or changed values that explain the accelerations of a file.

    Attributes
    ----------
    mistakes : tuple of Mistake
        Of the library.
    changes : mapping of str to float
        Of parameters, and of forces from zero [SI].
    uncertain : mapping of str to float
        A further change by so much would leave twice as much [SI].
    relief
        Factor by which what remains falls.
    """

    mistakes: tuple[Mistake, ...]
    changes: Mapping[str, float]
    uncertain: Mapping[str, float]
    relief: float

    def made(self, right: Program) -> tuple[Mistake, ...]:
        """Return the mistakes, or the changed values as one."""
        if not self.changes:
            return self.mistakes
        return (other_values(self.changes, self.uncertain, right),)


@dataclass(frozen=True, slots=True)
class Causes:
    """Causes, those that explain most first.

    Attributes
    ----------
    known : tuple of Cause
        Of the library, alone and two together.
    fitted : tuple of Cause
        Of one, two and three unknowns, each number where it explains far more than fewer do; whole
        runs tell which. Empty if none explains more than the library does.
    motions : sequence of Observed
        Of the file, as they were understood.
    program : Program
        The right one.
    shares : mapping of str to float
        What remains of the accelerations of roll, steer and speed, in parts of them: the largest
        of the maneuvers.
    above
        How much more remains than the file's own rates are off from the slopes of its angles, both
        in parts of what they are: errors of integrators are in both.
    most
        The largest relief times how little then remains, to compare ways to understand a file.
    is_shown
        True if the rows are near enough and have digits enough to judge the equations.
    remainder
        The residual, to ask it of further causes.
    methods : tuple of Method
        Of integration, that explain what remains and cannot be told apart.
    """

    known: tuple[Cause, ...]
    fitted: tuple[Cause, ...]
    motions: Sequence[Observed]
    program: Program
    shares: Mapping[str, float]
    above: float
    most: float
    is_shown: bool
    remainder: _Remainder
    methods: tuple[Method, ...]

    def relief(self, mistakes: Sequence[Mistake]) -> float:
        """Factor by which some mistakes let what remains fall."""
        a = self.remainder.accelerations
        return self.remainder.relief(self.remainder.left_by(a.of(apply(a.program, mistakes))))

    def best_of(self, library: Sequence[Mistake]) -> list[Mistake]:
        """Those that let what remains fall most first."""
        return sorted(library, key=lambda m: -self.relief((m,)))

    @property
    def best(self) -> tuple[Mistake, ...] | None:
        """The cause that explains nearly all by the equations alone; None if none does.

        Where a force is left several causes together mean nothing: each takes a share of it.
        """
        count = len(self.motions)
        credible = [
            c
            for c in (*self.known, *self.fitted)
            if len(c.mistakes) + len(c.changes) == 1 or not self.leaves_force(c.relief)
        ]
        likely = max(credible, key=lambda c: log_odds(c, count), default=None)
        if likely is None or not self.is_shown or self.is_blown_up:
            return None
        is_sure = likely.relief > WEIGHTS.nearly and log_odds(likely, count) > WEIGHTS.said
        return likely.made(self.program) if is_sure else None

    @property
    def is_blown_up(self) -> bool:
        """True if rates and angles have nothing to do with each other."""
        return max(m.inconsistency() for m in self.motions) > _T.blown_up

    @property
    def is_open(self) -> bool:
        """True if there is a force or a term that no cause explains, and no integrator makes."""
        return self.leaves_force(max((c.relief for c in (*self.known, *self.fitted)), default=1.0))

    def leaves_force(self, relief: float) -> bool:
        """True if a cause of some relief leaves what no integrator does."""
        return self.above > _T.above * relief


def find_causes(
    accelerations: Accelerations, library: Sequence[Mistake], motions: Sequence[Observed]
) -> Causes:
    """The causes that explain most.

    Parameters
    ----------
    accelerations : Accelerations
    library
        Mistakes of the model.
    motions : sequence of Observed
        Those of the accelerations.
    """
    remainder = _Remainder(accelerations)
    known = _known(remainder, library)
    fitted = _fitted(remainder, known[:1], len(motions))
    most = max([1.0, *(c.relief for c in (*known[:1], *fitted))])
    size = float(np.exp(np.mean(np.log(remainder.before)) / 2))
    return Causes(
        known=known,
        fitted=fitted,
        motions=motions,
        program=accelerations.program,
        shares={name: float(np.max(remainder.shares[k::3])) for k, name in enumerate(EQUATIONS)},
        above=_above(remainder, motions),
        most=most / size,
        is_shown=remainder.is_shown()
        and all(float(np.median(np.diff(m.time))) <= _T.spacing for m in motions),
        remainder=remainder,
        methods=find_methods(accelerations.equations, motions),
    )


def _above(remainder: _Remainder, motions: Sequence[Observed]) -> float:
    shares = remainder.shares
    # Those of roll and steer: where the speed hardly changes it says little.
    return float(
        max(
            np.sqrt(shares[3 * i] * shares[3 * i + 1]) / max(m.inconsistency(), WEIGHTS.nothing)
            for i, m in enumerate(motions)
        )
    )


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x)))) or float(np.finfo(np.float64).tiny)


class _Remainder:
    """The residual of the equations, in blocks."""

    def __init__(self, accelerations: Accelerations) -> None:
        self.accelerations = a = accelerations
        self.right = a.of(a.program)
        unknown = blocks_of(a.block, a.uncertain)
        self.floors = [float(np.median(x)) for x in unknown]
        # Windows that the rows do not resolve count for little.
        shares = [f**2 / (f**2 + x**2) for f, x in zip(self.floors, unknown, strict=True)]
        self._weights = np.concatenate([np.sqrt(x / np.mean(x)) for x in shares])
        self.rows = self.weighted(a.observed - self.right)
        sizes = np.array([_rms(x) for x in blocks_of(a.block, a.observed)])
        self._least = np.square(self.floors)
        self.shares = np.sqrt(self.squares(self.rows)) / sizes
        # What is left below this needs no other cause.
        self._least = self._least + np.square(WEIGHTS.nothing * sizes)
        self.before = self.squares(self.rows)

    def weighted(self, rows: Array) -> Array:
        """Rows, shape (n,) or (n, U), each with its weight."""
        found: Array = (rows.T * self._weights).T
        return found

    def squares(self, rows: Array) -> Array:
        """Mean square of each block, that of the digits included."""
        parts = blocks_of(self.accelerations.block, rows)
        return np.array([np.mean(x**2) for x in parts]) + self._least

    def relief(self, rows: Array) -> float:
        """Factor by which the blocks fall if so much remains."""
        with np.errstate(all="ignore"):
            found = float(np.exp(np.mean(np.log(self.before / self.squares(rows))) / 2))
        return found if np.isfinite(found) else 0.0

    def left_by(self, accelerations: Array) -> Array:
        """Return the residual if a program has these accelerations."""
        return self.weighted(self.accelerations.observed - accelerations)

    def normal(self, rows: Array, slopes: Array) -> Blocks:
        """Normal equations of terms, shape (n, U)."""
        block = self.accelerations.block
        return blocks(blocks_of(block, rows), blocks_of(block, slopes), self.floors)

    def is_shown(self) -> bool:
        """True if digits and spacing leave little enough to judge the equations."""
        above, share = _T.shows
        resolved = np.sqrt(self.before) / self.floors
        return bool(
            np.exp(np.mean(np.log(resolved))) > above or np.median(self.shares / resolved) < share
        )


def _known(remainder: _Remainder, library: Sequence[Mistake]) -> tuple[Cause, ...]:
    """Mistakes of the library, alone and two together."""
    a = remainder.accelerations
    alone = {m.code: a.of(apply(a.program, (m,))) for m in library}
    relief = {m.code: remainder.relief(remainder.left_by(alone[m.code])) for m in library}
    ranked = sorted((m for m in library if relief[m.code] > 1.0), key=lambda m: -relief[m.code])
    singles = [Cause((m,), {}, {}, relief[m.code]) for m in ranked]
    pairs = []
    for i, first in enumerate(ranked[: _T.rivals]):
        # A small one beside a large one may make it worse alone.
        for second in (m for m in library if m not in ranked[: i + 1]):
            # What two mistakes add is nearly the sum of what each does.
            both = alone[first.code] + alone[second.code] - remainder.right
            about = remainder.relief(remainder.left_by(both))
            if about > _T.also * relief[first.code]:
                pairs.append((about, first, second))
    pairs.sort(key=lambda x: -x[0])
    together = []
    for _, first, second in pairs[: _T.rivals]:
        pair = tuple(m for m in library if m in (first, second))
        exact = remainder.relief(remainder.left_by(a.of(apply(a.program, pair))))
        if exact > _T.also * max(relief[first.code], relief[second.code]):
            together.append(Cause(pair, {}, {}, exact))
    found = sorted([*singles, *together], key=lambda c: -c.relief)
    least = _T.kept * found[0].relief if found else 0.0
    return tuple(c for c in found if c.relief > least)


def _fitted(remainder: _Remainder, known: Sequence[Cause], maneuvers: int) -> tuple[Cause, ...]:
    """The fewest unknowns that are likelier than fewer are, and than the library is."""
    a = remainder.accelerations
    normal = remainder.normal(remainder.rows, remainder.weighted(a.slopes(a.program)))
    best: list[Cause] = []
    members = None
    least = max([0.0, *(log_odds(c, maneuvers) for c in known)])
    enough = _T.enough * remainder.relief(np.zeros_like(remainder.rows))
    for size, count in ((1, 6), (2, 3), (3, 2)):
        if any(c.relief > enough for c in best):
            break
        first = best_subsets(normal, size, _T.beside, members)
        members = first.members
        promised = Cause(
            (), dict.fromkeys(UNKNOWNS[:size], 0.0), {}, float(first.gains[0]) ** _T.promise
        )
        if log_odds(promised, maneuvers) < 0.0:
            continue
        found = [
            _refined(remainder, [UNKNOWNS[i] for i in chosen], x)
            for chosen, x in zip(first.members[:count], first.changes[:count], strict=True)
        ]
        best += [c for c in found if log_odds(c, maneuvers) > least]
    best.sort(key=lambda c: -log_odds(c, maneuvers))
    # Further values explain more always. Whole runs tell which causes are right.
    return tuple(c for c in best if not any(_needs_no_more(other, c) for other in best))


def _needs_no_more(one: Cause, other: Cause) -> bool:
    """True if one cause explains nearly as much as another with further values."""
    return one.changes.keys() < other.changes.keys() and other.relief < WEIGHTS.beside * one.relief


def log_odds(cause: Cause, maneuvers: int) -> float:
    """Logarithm of the odds against none, by the equations alone."""
    if not all(is_plausible(name, x) for name, x in cause.changes.items()):
        return float("-inf")
    one = WEIGHTS.fitted + WEIGHTS.unknown
    before = log_odds_before(cause.mistakes) - one * len(cause.changes)
    return WEIGHTS.values * maneuvers * float(np.log(max(cause.relief, 1e-9))) + before


def _refined(remainder: _Remainder, names: Sequence[str], step: Array) -> Cause:
    """Fit values by Gauss and Newton's method from a first step; one that leaves more is halved.

    A light body has accelerations that turn over where its inertia is zero.
    """
    a = remainder.accelerations
    best, x = Cause((), {}, {}, 1.0), np.zeros(len(names))
    for _ in range(_T.steps):
        for half in range(_T.halvings):
            ahead = x + step / 2.0**half
            program = changed(a.program, dict(zip(names, ahead.tolist(), strict=True)))
            rows = remainder.left_by(a.of(program))
            relief = remainder.relief(rows)
            if relief > best.relief:
                break
        else:
            break
        x = ahead
        normal = remainder.normal(rows, remainder.weighted(a.slopes(program, names)))
        best = Cause(
            (),
            dict(zip(names, x.tolist(), strict=True)),
            dict(zip(names, uncertain(normal, remainder.squares(rows)), strict=True)),
            relief,
        )
        step = solve(normal, np.arange(len(names))[None])[0][0]
    return best
