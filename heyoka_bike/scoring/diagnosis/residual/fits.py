"""Fits of parameters, forces and initial values to the residual of the equations or to runs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.hypothesis import UNKNOWN, Hypothesis
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.forces import FORCES
from heyoka_bike.scoring.diagnosis.programs.program import (
    FittedValues,
    Program,
    changed,
    other_values,
)
from heyoka_bike.scoring.diagnosis.residual.linear_fits import (
    Blocks,
    Errors,
    best_subsets,
    gauss_newton,
    linearised,
    solve,
    uncertain,
)
from heyoka_bike.scoring.ratios import AS_GOOD, BY_FAR, CLEARLY

SPLIT = 4
"""Number of parts of a run whose errors have different sizes: the error of a wrong value grows."""

COUNTS = tuple(range(1, THRESHOLDS.max_values + 1))
"""Numbers of values that are fitted together."""

Leaves = Callable[[Sequence[Program]], Sequence[Sequence[Array]]]
"""Function from a program, and others near it, to the blocks of the error that each leaves."""


@dataclass(frozen=True, eq=False, slots=True)
class Fits:
    """Fits of programs with changed values to an error.

    Attributes
    ----------
    right : Program
        The correct program.
    leaves
        Function from programs to the blocks of the error that each leaves.
    floors : ndarray, shape (B,)
        Resolution limit of each block.
    maneuvers
        Number of maneuvers, which determines the number of independent values.
    promise
        Exponent of the gain to first order that gives the gain expected after refinement. Values
        with too small an expected gain are not refined.
    split
        Number of successive parts of the run into which each column is split.
    needed
        Factor by which each value must reduce the error. Values that cannot do so by their gain to
        first order are not refined.
    """

    right: Program
    leaves: Leaves
    floors: Array
    maneuvers: int
    promise: float
    split: int = 1
    needed: float = 1.0
    _known: dict[tuple[tuple[str, float], ...], Blocks] = field(default_factory=dict)

    def fewest(
        self,
        names: Sequence[str],
        judged: Callable[[FittedValues], Iterable[Hypothesis]],
        is_enough: Callable[[Hypothesis], bool],
        *,
        least: float = 0.0,
        begun: Sequence[Mapping[str, float]] = (),
        counts: Collection[int] = COUNTS,
        groups: Sequence[Sequence[str]] = (),
    ) -> tuple[Hypothesis, ...]:
        """Find as few values as possible that explain the error; best hypothesis first.

        The subsets of one, two and three names (or `counts`) that explain most to first order are
        refined, or those in `begun` instead, until one `is_enough`. Then the best `groups` of names
        are tried, and at last the best subset with further values.

        Parameters
        ----------
        names
            Unknowns that may be fitted.
        judged
            Makes hypotheses of fitted values.
        is_enough
            Returns True if a hypothesis ends the search.
        least
            Hypotheses with lower log odds are dropped.
        begun
            Initial values of subsets that are fitted instead of the likely ones.
        counts
            Numbers of values that are fitted together.
        groups
            Subsets of names that usually change together.
        """
        best: list[Hypothesis] = []

        def goes_on() -> bool:
            return not best or not is_enough(best[0])

        def add(several: Iterable[Mapping[str, float]]) -> bool:
            """Refine and judge subsets; return True if one is better than the best so far."""
            before = best[0] if best else None
            found = [h for changes in several for h in judged(self._refined(changes))]
            for h in found:
                # Different fits may drop some of their values and end with the same values. List
                # these only once.
                if h.log_odds > least and not any(h.parts == x.parts for x in best):
                    best.append(h)
            best.sort(key=lambda h: -h.log_odds)
            return bool(best) and best[0] is not before

        for several in [begun] if begun else self._likely(names, counts):
            add(several)
            if not goes_on():
                break
        if groups and goes_on():
            add(self._likely_groups(names, groups))
        while best and goes_on() and len(best[0].found) < max(counts):
            if not add([self._further(best[0].mistakes[0].changes, names)]):
                break
        # A fit with more values always explains more. Drop the fits that gain little from their
        # additional values.
        return tuple(h for h in best if not any(_needs_no_more(other, h) for other in best))

    def first_order(self, names: Sequence[str]) -> Blocks:
        """Return the normal equations of some values at the correct program."""
        return self._first_order(dict.fromkeys(names, 0.0))

    def first_order_gain(self, names: Sequence[str]) -> float:
        """Return the first-order gain of the value that explains most of the error."""
        found = best_subsets(self.first_order(names), 1, 1)
        return float(np.max(found.gains, initial=1.0))

    def _likely(
        self, names: Sequence[str], counts: Collection[int]
    ) -> Iterator[list[dict[str, float]]]:
        """Yield the subsets of names that explain most to first order, by their number of names.

        Both the whole run and its first part are considered: an effect that is too large later for
        the first order may be small in the first part.
        """
        whole = self.first_order(names)
        views = [whole] if self.split == 1 else [whole, whole.every(self.split)]
        members: list[NDArray[np.intp] | None] = [None] * len(views)
        cost = max(
            (THRESHOLDS.value_cost + UNKNOWN)
            / (THRESHOLDS.independent_values * self.maneuvers * self.promise),
            float(np.log(self.needed)) / max(THRESHOLDS.residual_exponent, THRESHOLDS.run_exponent),
        )
        for size in COUNTS[: len(names)]:
            found: dict[tuple[int, ...], None] = {}
            for i, view in enumerate(views):
                subsets = best_subsets(view, size, THRESHOLDS.max_partners, members[i])
                members[i] = subsets.members
                if np.log(np.max(subsets.gains, initial=1.0)) > cost * size:
                    most = max(1, THRESHOLDS.max_subsets // size // len(views))
                    # Refine every single value that may explain as much as the best one. If the
                    # error of whole runs is large, even the right value does not remove all of it
                    # to first order.
                    least = (
                        max(subsets.gains[0], self.needed) / CLEARLY
                        if self.split > 1
                        else max(subsets.gains[0] / AS_GOOD, BY_FAR)
                    )
                    count = max(most, np.sum(subsets.gains > least)) if size == 1 else most
                    found |= dict.fromkeys(map(tuple, subsets.members[:count].tolist()))
            if size in counts:
                yield [dict.fromkeys((names[i] for i in some), 0.0) for some in found]

    def _likely_groups(
        self, names: Sequence[str], groups: Sequence[Sequence[str]]
    ) -> list[dict[str, float]]:
        """Return start values of zero for the groups of names that explain most to first order."""
        place = {name: i for i, name in enumerate(names)}
        whole = self.first_order(names)
        gains = [
            (float(solve(whole, np.array([[place[name] for name in group]]))[1][0]), group)
            for group in groups
            if place.keys() >= {*group}
        ]
        likely = sorted(gains, key=lambda x: -x[0])[: THRESHOLDS.max_refined]
        return [dict.fromkeys(group, 0.0) for gain, group in likely if gain > self.needed]

    def _further(self, changes: Mapping[str, float], names: Sequence[str]) -> dict[str, float]:
        """Add the value that, to first order, explains most of the error that the others leave."""
        every = {**changes, **{name: 0.0 for name in names if name not in changes}}
        known = len(changes)
        subsets = np.array([[*range(known), i] for i in range(known, len(every))])
        _, gains = solve(self._first_order(every), subsets)
        return {**changes, [*every][known + int(np.argmax(gains))]: 0.0}

    def _refined(self, changes: Mapping[str, float]) -> FittedValues:
        """Fit values, starting at `changes`; drop values smaller than their uncertainty."""
        x, b = gauss_newton(*self._problem(changes))
        found, off = (dict(zip(changes, v, strict=True)) for v in (x.tolist(), uncertain(b)))
        other = {name: x for name, x in changes.items() if abs(found[name]) > off[name]}
        if 0 < len(other) < len(found):
            return self._refined(other)
        return other_values(found, off, self.right)

    def _first_order(self, changes: Mapping[str, float]) -> Blocks:
        key = tuple(changes.items())
        if key not in self._known:
            self._known[key] = linearised(*self._problem(changes))
        return self._known[key]

    def _problem(self, changes: Mapping[str, float]) -> tuple[Errors, Array, Array, Array]:
        """Return errors, values, their sizes and the floors: the arguments of `linear_fits`."""
        sizes = np.array([size_of(self.right.motion.bicycle, name) for name in changes])
        return self._errors([*changes]), np.array([*changes.values()]), sizes, self.floors

    def _errors(self, names: Sequence[str]) -> Errors:
        """Return the function from changes of unknowns to the errors that they leave."""

        def program(x: Array) -> Program:
            values = zip(names, x.tolist(), strict=True)
            return changed(self.right, {name: v for name, v in values if v})

        return lambda several: self.leaves([program(x) for x in several])


def _needs_no_more(one: Hypothesis, other: Hypothesis) -> bool:
    """True if one cause explains nearly as much as another that fits further values."""
    return one.parts < other.parts and other.relief < CLEARLY * one.relief


def size_of(bicycle: Bicycle, name: str) -> float:
    """Return the size of an unknown; 1 for initial values and for parameters that are zero."""
    if name in FORCES:
        return FORCES[name].size
    return abs(float(bicycle[name])) or 1.0 if name in bicycle.values else 1.0
