"""A column with another zero or a ratio, beside a wrong value: both are found in the residual.

Each alone explains little, so neither is seen where one cause is looked for. The zero and the ratio
of each column of the motion are further unknowns of the equations, with the parameters.
An edit is undone only if it lets the residual fall by far together with one value, and not alone:
then the rows without it are diagnosed, and that value is named.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.numbers.double import SMALL_STEP, Array
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.definitions import Understandings
from heyoka_bike.scoring.diagnosis.budget import Deadline
from heyoka_bike.scoring.diagnosis.odds import WEIGHTS
from heyoka_bike.scoring.diagnosis.programs.program import Program, changed
from heyoka_bike.scoring.diagnosis.residual.linear_fits import (
    Blocks,
    best_subsets,
    blocks,
    gauss_newton,
    solve,
)
from heyoka_bike.scoring.diagnosis.residual.observed import STATE, observe
from heyoka_bike.scoring.diagnosis.residual.residual import Residual
from heyoka_bike.scoring.evidence.output_faults import ColumnRatio
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.units import factor

_ZERO, _RATIO = "zero ", "ratio "
# Edits that are tried with the value that explains most beside each, and pairs of both.
_TRIED = 4


@dataclass(frozen=True, eq=False)
class _Edited:
    """The residual with zeros and ratios of columns undone.

    Attributes
    ----------
    parts : sequence of Part
    understood : mapping of str to Understanding
    program : Program
        The right one.
    """

    parts: Sequence[Part]
    understood: Understandings
    program: Program
    deadline: Deadline
    _known: dict[tuple[tuple[str, float], ...], Residual | None] = field(default_factory=dict)

    @property
    def edits(self) -> list[str]:
        """Names of zeros and ratios of the columns that all parts have."""
        keys = [k for k in STATE if all(k in p.values for p in self.parts) and k in self.understood]
        return [kind + key for key in keys for kind in (_ZERO, _RATIO)]

    def residual(self, changes: Mapping[str, float]) -> Residual | None:
        """The residual of the rows without some edits; None if these show no motion."""
        edits = tuple(sorted((n, x) for n, x in changes.items() if _is_edit(n) and x))
        if edits not in self._known:
            self.deadline.check()
            equations = Equations.binary64(self.program.motion.bicycle)
            seen = [observe(self.undone(p, dict(edits)), self.understood, equations)
                    for p in self.parts]  # fmt: skip
            motions = [m for m in seen if m is not None]
            is_whole = len(motions) == len(self.parts)
            self._known[edits] = Residual(motions, self.program, ()) if is_whole else None
        return self._known[edits]

    def undone(self, part: Part, edits: Mapping[str, float]) -> Part:
        """The rows without some edits [SI]."""
        values = dict(part.values)
        for key in {name.split(" ")[1] for name in edits}:
            u = self.understood[key]
            zero = edits.get(_ZERO + key, 0.0) / (u.sign * factor(u.unit)[0])
            values[key] = (values[key] - zero) / (1.0 + edits.get(_RATIO + key, 0.0))
        return replace(part, values=values, lo={k: x for k, x in part.lo.items() if k in values})

    def left(self, names: Sequence[str]) -> Callable[[Sequence[Array]], list[list[Array]]]:
        """From values of some unknowns to the blocks of what they leave."""
        right = self.residual({})
        assert right is not None

        def errors(several: Sequence[Array]) -> list[list[Array]]:
            found = []
            for x in several:
                changes = dict(zip(names, x.tolist(), strict=True))
                seen = self.residual(changes) or right
                values = {n: v for n, v in changes.items() if not _is_edit(n) and v}
                off = seen.observed - seen.of(changed(self.program, values))
                found.append(right.weighted(off))
            return found

        return errors

    def sizes(self, names: Sequence[str]) -> Array:
        """Sizes of unknowns, of which parts are taken for their derivatives."""
        bicycle = self.program.motion.bicycle.values
        return np.array([abs(float(bicycle[n])) or 1.0 if n in bicycle else 1.0 for n in names])

    def first_order(self, names: Sequence[str], x: Array) -> Blocks:
        """The normal equations at some values of the unknowns."""
        right = self.residual({})
        assert right is not None
        shifts = SMALL_STEP * self.sizes(names)
        here, *moved = self.left(names)([x, *(x + np.diag(shifts))])
        slopes = [np.nan_to_num((block[:, None] - np.stack(others, axis=-1)) / shifts)
                  for block, *others in zip(here, *moved, strict=True)]  # fmt: skip
        return blocks(here, slopes, right.floors)

    def refined(self, names: Sequence[str], x: Array) -> tuple[Array, float]:
        """The values that leave least, and the geometric mean of what they leave."""
        right = self.residual({})
        assert right is not None
        found, b = gauss_newton(self.left(names), x, self.sizes(names), right.floors)
        return found, b.left


def _is_edit(name: str) -> bool:
    return name.startswith((_ZERO, _RATIO))


def edit_beside_a_value(
    parts: Sequence[Part], understood: Understandings, program: Program, deadline: Deadline
) -> ColumnRatio | None:
    """A zero or a ratio of a column that together with one value explains the residual.

    Raises
    ------
    BudgetSpentError
        The time is spent.
    """
    asked = _Edited(parts, understood, program, deadline)
    right = asked.residual({})
    if right is None or not right.is_resolved or not asked.edits:
        return None
    every = [*asked.edits, *PARAMETERS]
    start = asked.first_order(every, np.zeros(len(every)))
    alone = best_subsets(start, 1, len(every))
    edits = [int(i) for (i,) in alone.members if _is_edit(every[i])][:_TRIED]
    values = [int(i) for (i,) in alone.members if not _is_edit(every[i])][:_TRIED]
    pairs = [
        (int(i), int(j))
        for i, j in best_subsets(start, 2, _TRIED**2).members
        if _is_edit(every[i]) != _is_edit(every[j])
    ][:_TRIED]
    for first in (*edits[:2], *values[:2]):
        x, _ = asked.refined([every[first]], np.zeros(1))
        names = [every[first], *(n for n in every if n != every[first])]
        there = asked.first_order(names, np.concatenate([x, np.zeros(len(names) - 1)]))
        others = [k for k in range(1, len(names)) if _is_edit(names[k]) != _is_edit(names[0])]
        _, gains = solve(there, np.array([[0, k] for k in others]))
        best = others[int(np.argmax(gains))]
        pairs.append((first, every.index(names[best])))
    found = []
    for pair in dict.fromkeys(
        tuple(sorted(p, key=lambda k: not _is_edit(every[k]))) for p in pairs
    ):
        names = [every[k] for k in pair]
        x, left = asked.refined(names, np.zeros(2))
        found.append((left, names[0], float(x[0])))
    if not found:
        return None
    left, name, size = min(found)
    ones = [asked.refined([every[k]], np.zeros(1))[1] for k in (*edits[:2], *values[:2])]
    # Errors of integrators resemble the best pair by 7, two and a half times as much as one of it.
    is_both = CLEARLY * left < min(ones, default=start.left)
    gain = start.left / left
    if not (is_both and gain > max(BY_FAR, right.limit / WEIGHTS.nearly)):
        return None
    kind, key = name.split(" ")
    by, more = (1.0, size) if f"{kind} " == _ZERO else (1.0 + size, 0.0)
    return ColumnRatio(key, tuple(p.number for p in parts), by, more, None)
