"""Find an offset or a ratio of a column that occurs together with a wrong parameter.

Each alone explains little of the residual, so a search for one cause finds neither. The offset
(`zero`) and the ratio of each column of the motion are further unknowns of the equations, in
addition to the parameters. Such an offset or ratio (an edit) is undone only if it and one parameter
together reduce the residual by a large factor, and neither does so alone. The rows without the edit
are then diagnosed, and that diagnosis reports the parameter.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.alignment import Part
from heyoka_bike.scoring.definitions import Understandings
from heyoka_bike.scoring.diagnosis.budget import Deadline
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS
from heyoka_bike.scoring.diagnosis.programs.program import Program, changed
from heyoka_bike.scoring.diagnosis.residual.fits import size_of
from heyoka_bike.scoring.diagnosis.residual.linear_fits import (
    Blocks,
    Errors,
    best_subsets,
    gauss_newton,
    linearised,
    solve,
)
from heyoka_bike.scoring.diagnosis.residual.observed import STATE_KEYS, observe
from heyoka_bike.scoring.diagnosis.residual.residual import Residual
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.rows.scaled_columns import ColumnRatio

_ZERO, _RATIO = "zero ", "ratio "
# Number of single edits (an offset or a ratio of a column), and of single parameters, that are
# fitted alone. For each of them the best partner of the other kind is then found.
_ALONE = 2
# Number of pairs of an edit and a parameter that are fitted exactly. They are the pairs that
# explain most of the error to first order.
_PAIRS = 4


@dataclass(frozen=True, eq=False)
class _Edited:
    """Residuals of the rows with offsets and ratios of columns undone.

    Attributes
    ----------
    parts : sequence of Part
    understood : mapping of str to Understanding
    program : Program
        The correct program.
    deadline : Deadline
    """

    parts: Sequence[Part]
    understood: Understandings
    program: Program
    deadline: Deadline
    _known: dict[tuple[tuple[str, float], ...], Residual | None] = field(default_factory=dict)

    @property
    def edits(self) -> list[str]:
        """Names of the offsets and ratios, for each column of the state that all parts have."""
        keys = [
            k for k in STATE_KEYS if all(k in p.values for p in self.parts) and k in self.understood
        ]
        return [kind + key for key in keys for kind in (_ZERO, _RATIO)]

    def residual(self, changes: Mapping[str, float]) -> Residual | None:
        """Return the residual after these edits are undone; None if the rows show no motion."""
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
        """Return the rows with offsets [SI] subtracted and then divided by ratios."""
        values = dict(part.values)
        for key in {name.split(" ")[1] for name in edits}:
            zero = edits.get(_ZERO + key, 0.0) / self.understood[key].factor
            values[key] = (values[key] - zero) / (1.0 + edits.get(_RATIO + key, 0.0))
        return replace(part, values=values, lo={k: x for k, x in part.lo.items() if k in values})

    def left(self, names: Sequence[str]) -> Callable[[Sequence[Array]], list[list[Array]]]:
        """Return the function that computes the blocks of the residual from unknowns."""
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

    def first_order(self, names: Sequence[str], x: Array) -> Blocks:
        """Return the normal equations at some values of the unknowns."""
        return linearised(*self._problem(names, x))

    def refined(self, names: Sequence[str], x: Array) -> tuple[Array, float]:
        """Find the values with the least residual; return them and the size of the residual."""
        found, b = gauss_newton(*self._problem(names, x))
        return found, b.left

    def _problem(self, names: Sequence[str], x: Array) -> tuple[Errors, Array, Array, Array]:
        """Return errors, values, their sizes and the floors: the arguments of `linear_fits`."""
        right = self.residual({})
        assert right is not None
        bicycle = self.program.motion.bicycle
        sizes = np.array([size_of(bicycle, name) for name in names])
        return self.left(names), x, sizes, right.floors


def _is_edit(name: str) -> bool:
    return name.startswith((_ZERO, _RATIO))


def edit_beside_a_value(
    parts: Sequence[Part], understood: Understandings, program: Program, deadline: Deadline
) -> ColumnRatio | None:
    """Find an offset or a ratio of a column that, with one parameter, explains the residual.

    Raises
    ------
    BudgetSpentError
        The time limit is reached.
    """
    asked = _Edited(parts, understood, program, deadline)
    right = asked.residual({})
    if right is None or not right.is_resolved or not asked.edits:
        return None
    every = [*asked.edits, *PARAMETERS]
    start = asked.first_order(every, np.zeros(len(every)))
    likeliest = [every[i] for (i,) in best_subsets(start, 1, len(every)).members]
    edits = [n for n in likeliest if _is_edit(n)][:_ALONE]
    values = [n for n in likeliest if not _is_edit(n)][:_ALONE]
    promised: dict[frozenset[str], float] = {}
    likely = best_subsets(start, 2, _PAIRS**2)
    for members, pair_gain in zip(likely.members, likely.gains, strict=True):
        pair = frozenset(every[k] for k in members)
        # A pair must consist of an edit and a parameter. Its gain is zero if their effects cancel
        # each other.
        if sum(map(_is_edit, pair)) == 1 and pair_gain > 0.0:
            promised[pair] = start.left / float(pair_gain)
    ones = []
    for name in (*edits, *values):
        x, left = asked.refined([name], np.zeros(1))
        ones.append(left)
        others = [n for n in every if _is_edit(n) != _is_edit(name)]
        there = asked.first_order([name, *others], np.concatenate([x, np.zeros(len(others))]))
        _, gains = solve(there, np.array([[0, k] for k in range(1, len(others) + 1)]))
        best = int(np.argmax(gains))
        pair = frozenset((name, others[best]))
        promised[pair] = min(promised.get(pair, np.inf), there.left / float(gains[best]))
    best_alone = min(ones, default=start.left)
    found = []
    for pair in sorted(promised, key=lambda p: promised[p])[:_PAIRS]:
        # To first order, a pair must be ten times better than the best single edit or parameter. In
        # three files with both faults, the best pair was 57 to 3,200 times better. For an
        # integrator's error (ode-default) it was 1.3 times better.
        if CLEARLY * promised[pair] < best_alone:
            names = sorted(pair, key=_is_edit, reverse=True)
            x, left = asked.refined(names, np.zeros(2))
            found.append((left, names[0], float(x[0])))
    if not found:
        return None
    left, name, size = min(found)
    # After the exact fit, a pair must be ten times better than a single edit or parameter. For
    # errors of integrators, the best pair is at most 2.5 times better, although it reduces the
    # residual by a factor of 7.
    is_both = CLEARLY * left < best_alone
    gain = start.left / left
    if not (is_both and gain > max(BY_FAR, right.limit / THRESHOLDS.direction_factor)):
        return None
    kind, key = name.split(" ")
    by, more = (1.0, size) if f"{kind} " == _ZERO else (1.0 + size, 0.0)
    return ColumnRatio(key, tuple(p.number for p in parts), by, more, None)
