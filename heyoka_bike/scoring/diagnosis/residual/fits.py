"""Values of parameters, forces and starts that explain an error: of the equations, or of runs."""

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
"""Parts of a run whose errors have a size each: those of values grow, at first in proportion."""

COUNTS = tuple(range(1, THRESHOLDS.max_answers + 1))
"""Of how many values together are found."""

Leaves = Callable[[Sequence[Program]], Sequence[Sequence[Array]]]
"""From a program, and others near it, to the blocks of the error that each leaves."""


@dataclass(frozen=True, eq=False, slots=True)
class Fits:
    """Programs with other values than the right one, and what they leave of an error.

    Attributes
    ----------
    right : Program
    leaves
        From programs to the blocks of the error that each leaves.
    floors : ndarray, shape (B,)
        What cannot be seen of each block.
    maneuvers
        Number of maneuvers: each has some independent values.
    promise
        Values whose relief to first order, to this power, is too small are not refined.
    split
        Number of blocks, one after the other in time, into which each column is split.
    needed
        Each value must let the error fall by so much, or explains nothing: those that to first
        order, to the power that large changes need, do not are not refined.
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
        """The fewest values that are likelier than fewer are, and than `least`; best first.

        Of one, two and three names, or as many of them as `counts` says, those subsets that explain
        most to first order, or some that are begun with, until one is enough; then those `groups`
        of names that explain most, and the best with further ones beside it.
        """
        best: list[Hypothesis] = []

        def goes_on() -> bool:
            return not best or not is_enough(best[0])

        def add(several: Iterable[Mapping[str, float]]) -> bool:
            """Judge what is refined; true if something is better."""
            before = best[0] if best else None
            found = [h for changes in several for h in judged(self._refined(changes))]
            for h in found:
                # Fits that drop some of their values may end with the same values.
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
        # Further values explain more always.
        return tuple(h for h in best if not any(_needs_no_more(other, h) for other in best))

    def first_order(self, names: Sequence[str]) -> Blocks:
        """Return the normal equations of some values at the right program."""
        return self._first_order(dict.fromkeys(names, 0.0))

    def first_order_gain(self, names: Sequence[str]) -> float:
        """By what factor the error falls with the best one of some values, to first order."""
        found = best_subsets(self.first_order(names), 1, 1)
        return float(np.max(found.gains, initial=1.0))

    def _likely(
        self, names: Sequence[str], counts: Collection[int]
    ) -> Iterator[list[dict[str, float]]]:
        """So many of the names that explain most to first order, as they begin.

        What is large later may be so in the first blocks only.
        """
        whole = self.first_order(names)
        views = [whole] if self.split == 1 else [whole, whole.every(self.split)]
        members: list[NDArray[np.intp] | None] = [None] * len(views)
        cost = max(
            (THRESHOLDS.fitted + UNKNOWN) / (THRESHOLDS.values * self.maneuvers * self.promise),
            float(np.log(self.needed)) / max(THRESHOLDS.promise),
        )
        for size in COUNTS[: len(names)]:
            found: dict[tuple[int, ...], None] = {}
            for i, view in enumerate(views):
                subsets = best_subsets(view, size, THRESHOLDS.rivals, members[i])
                members[i] = subsets.members
                if np.log(np.max(subsets.gains, initial=1.0)) > cost * size:
                    most = max(1, THRESHOLDS.max_pairs // size // len(views))
                    # Whole runs tell those apart that to first order explain as much, by far.
                    alike = subsets.gains > max(subsets.gains[0] / AS_GOOD, BY_FAR)
                    count = max(most, np.sum(alike)) if size == 1 else most
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
        likely = sorted(gains, key=lambda x: -x[0])[: THRESHOLDS.refined]
        return [dict.fromkeys(group, 0.0) for gain, group in likely if gain > self.needed]

    def _further(self, changes: Mapping[str, float], names: Sequence[str]) -> dict[str, float]:
        """Some values with the one that to first order leaves least of what these leave."""
        every = {**changes, **{name: 0.0 for name in names if name not in changes}}
        known = len(changes)
        subsets = np.array([[*range(known), i] for i in range(known, len(every))])
        _, gains = solve(self._first_order(every), subsets)
        return {**changes, [*every][known + int(np.argmax(gains))]: 0.0}

    def _refined(self, changes: Mapping[str, float]) -> FittedValues:
        """The values that leave least, from some on, without those that are as they should be."""
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
        """Errors, values, their sizes and the floors, as `linear_fits` takes them."""
        sizes = np.array([size_of(self.right.motion.bicycle, name) for name in changes])
        return self._errors([*changes]), np.array([*changes.values()]), sizes, self.floors

    def _errors(self, names: Sequence[str]) -> Errors:
        """From values of unknowns, as changes, to what they leave."""

        def program(x: Array) -> Program:
            values = zip(names, x.tolist(), strict=True)
            return changed(self.right, {name: v for name, v in values if v})

        return lambda several: self.leaves([program(x) for x in several])


def _needs_no_more(one: Hypothesis, other: Hypothesis) -> bool:
    """True if one cause explains nearly as much as another with further values."""
    return one.parts < other.parts and other.relief < CLEARLY * one.relief


def size_of(bicycle: Bicycle, name: str) -> float:
    """Size of an unknown; one for starts, and for parameters that are zero."""
    if name in FORCES:
        return FORCES[name].size
    return abs(float(bicycle[name])) or 1.0 if name in bicycle.values else 1.0
