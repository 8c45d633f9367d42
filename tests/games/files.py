"""Result files of the two games: values of the reference in hi + lo, before they are written.

This module does not depend on how results are judged; it uses only the package's form of results in
memory.
"""

from dataclasses import dataclass, field, fields, replace
from decimal import Decimal, localcontext
from functools import cache, cached_property, lru_cache

import numpy as np

from heyoka_bike import load_motion, load_reference
from heyoka_bike.bicycle.columns import COMPARED, DEFINITIONS
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.numbers.double import two_sum
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.values import Values
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows

EIGHT = tuple(DEFINITIONS)
MOTION = tuple(c.name for c in MOTION_COLUMNS)
UNITS = {key: columns[0].unit for key, columns in COMPARED.items()}
END = 10.0


class RememberingManeuver(ReferenceManeuver):
    """A maneuver that caches its values at times that thousands of files share."""

    most = 40
    joined = cache(ReferenceManeuver.joined)

    @cached_property
    def _values(self):
        """Columns by name, hi and lo, at each of the latest times."""
        return {}

    def continued(self, times, names):
        at = hash((times[0].tobytes(), times[1].tobytes()))
        if at not in self._values and len(self._values) > self.most:
            del self._values[next(iter(self._values))]
        known = self._values.setdefault(at, {})
        if missing := [n for n in dict.fromkeys(names) if n not in known]:
            found = super().continued(times, missing)
            for n in missing:
                known[n] = found.hi[n], found.lo[n]
                for part in known[n]:
                    part.setflags(write=False)
        return Values({n: known[n][0] for n in names}, {n: known[n][1] for n in names})


def remembering(whole):
    """Return a dataset with the same values, whose maneuvers cache them."""
    maneuvers = tuple(
        RememberingManeuver(**{f.name: getattr(m, f.name) for f in fields(m)})
        for m in whole.maneuvers
    )
    return replace(whole, maneuvers=maneuvers)


@lru_cache(maxsize=1)
def references():
    """Return the published dataset and its whole motion, for the games."""
    return remembering(load_reference()), remembering(load_motion())


def names(key):
    """Return the reference's columns for a key in every definition, the default first."""
    return [c.name for c in COMPARED[key]]


def scale(number, name):
    reference, motion = references()
    return (motion if name in MOTION else reference)[number].scale(name)


@dataclass(eq=False)
class Part:
    """One maneuver of a file: hi and lo of the time and of each column; changed in place."""

    maneuver: int
    time: np.ndarray
    time_lo: np.ndarray
    hi: dict = field(default_factory=dict)
    lo: dict = field(default_factory=dict)
    is_rounded: bool = False

    def pick(self, rows):
        """Keep only these rows, in this order."""
        self.time, self.time_lo = self.time[rows], self.time_lo[rows]
        self.hi = {k: v[rows] for k, v in self.hi.items()}
        self.lo = {k: v[rows] for k, v in self.lo.items()}

    def add(self, key, change):
        """Add to a column in its own unit; the part below its last binary digit goes to lo."""
        total, rest = two_sum(self.hi[key], change + np.zeros_like(self.hi[key]))
        is_long = bool(self.lo[key].any())
        self.hi[key] = total
        if is_long:
            self.lo[key] = self.lo[key] + rest

    def set(self, key, values, rows=slice(None)):
        self.hi[key][rows] = values
        self.lo[key][rows] = 0.0

    def copy(self):
        return Part(self.maneuver, self.time.copy(), self.time_lo.copy(),
                    {k: v.copy() for k, v in self.hi.items()},
                    {k: v.copy() for k, v in self.lo.items()})  # fmt: skip


def truth(number, wanted, time, time_lo):
    """Return exact values of columns: published ones at rows, else the dense output."""
    reference, motion = references()
    found = {}
    for source, is_of_motion in ((reference[number], False), (motion[number], True)):
        mine = [n for n in wanted if (n in MOTION) == is_of_motion]
        if mine:
            values = source.evaluate((time, time_lo), mine)
            found |= {n: (values.hi[n], values.lo[n]) for n in mine}
    return found


def correct(number, chosen, time=None, time_lo=None, *, is_long=False):
    """Return a part with these columns; `chosen` maps keys to the reference's names."""
    m = references()[0][number]
    if time is None:
        time, time_lo = m.time, m.time_lo
    exact = truth(number, list(dict.fromkeys(chosen.values())), time, time_lo)
    part = Part(number, time.copy(), time_lo.copy())
    for key, name in chosen.items():
        hi, lo = exact[name]
        part.hi[key] = hi.copy()
        part.lo[key] = lo.copy() if is_long else np.zeros_like(hi)
    return part


def in_memory(parts, quantum=None):
    """Return the parts in the form that reading them gives."""
    rows = []
    for p in parts:
        order = np.argsort(p.time, kind="stable")
        quanta = {k: quantum or Quantum(2, 53) for k in p.hi}
        rows.append(Rows(p.maneuver, p.time[order], p.time_lo[order],
                         {k: v[order] for k, v in p.hi.items()},
                         {k: v[order] for k, v in p.lo.items() if v.any()}, quanta))  # fmt: skip
    return Results("game", "text", tuple(rows), 16)


def decimal_times(time):
    """Return hi and lo of the times as read from the shortest decimals of these binary64."""
    with localcontext() as context:
        # Number of digits that avoids rounding in differences of binary64 numbers.
        context.prec = 1100
        lo = [float(Decimal(repr(t)) - Decimal(t)) for t in np.asarray(time, float).tolist()]
    return np.asarray(time, float), np.array(lo)


def written(hi, lo, digits):
    """Return numbers as text with this many significant digits, and the text's hi and lo."""
    if digits <= 17 and not np.any(lo):
        texts = [f"{x:.{digits - 1}e}" if digits < 17 else repr(float(x)) for x in hi]
        return texts, np.array([float(t) for t in texts]), np.zeros(len(hi))
    with localcontext() as context:
        context.prec = digits
        texts = [str(+(Decimal(float(x)) + Decimal(float(y)))) if np.isfinite(x) else repr(float(x))
                 for x, y in exact_sums(hi, lo)]  # fmt: skip
    found = np.array([float(t) for t in texts])
    with localcontext() as context:
        context.prec = 60
        rest = [float(Decimal(t) - Decimal(float(x))) if np.isfinite(x) else 0.0
                for t, x in zip(texts, found, strict=True)]  # fmt: skip
    return texts, found, np.array(rest)


def exact_sums(hi, lo):
    return zip(hi.tolist(), lo.tolist(), strict=True)
