"""What the columns of a file mean: definition, sign, unit and zero, judged by what fits.

The benchmark text defines none of them, so a difference of definition is no error. Every candidate
is compared with the reference over all maneuvers of the file together. The *typical* error of a
candidate in a maneuver is the root mean square of e without the largest hundredth of the rows, so
that a few bad ones do not decide. The best candidate has the least product of typical errors over
the maneuvers, which is the likeliest if the size of the error in each maneuver is unknown. Another
candidate *cannot be told apart* from it if their typical errors differ by less than a factor of 2
in every maneuver, or if it is better in one of them and what speaks against it in the others is not
five times that, in logarithms of these factors; then the default is kept, so that no definition is
claimed without evidence.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, COMPARED
from heyoka_bike.numbers.double import Array, median
from heyoka_bike.scoring.alignment import HALF, Part
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.units import UNITS, factor

_TOLD_APART = 2.0
# ... if it is not worse in any maneuver by more than this: errors that happen to resemble the
# difference of two definitions do so in one maneuver, not in all ...
_NOT_WORSE = 0.8
# ... or if what the others say outweighs it so many times. Where errors are as large as the
# difference of the definitions a maneuver says little, and now and then the wrong thing.
_OUTWEIGHED = 5.0
# Fewer rows than this show nothing but by meeting the floor of the digits written.
_FEW_ROWS = 10
# One row of so many is left out of the typical error.
_LEFT_OUT = 100
_CLEARLY = 10.0
# Of the scale.
_FAR_ZERO = 0.1
# Speeds and energies hardly vary: units that are not tried, ft/s or a wheel's rad/s, come within a
# tenth of one that is.
_NEAR = 0.02
_HARDLY_VARYING = ("m s-1", "J")
# Taking a constant from an error that grows does not lower it this much: a line keeps half.
_CLEARLY_CONSTANT = 10.0
_ENERGIES = ("kinetic_energy", "mechanical_energy", "potential_energy")
_UNSIGNED = (*_ENERGIES, "rear_friction", "front_friction")


@dataclass(frozen=True, slots=True)
class Understanding:
    """How a written column is taken.

    Attributes
    ----------
    column : Column
        The definition.
    unit, sign, offset
        SI value = sign * (value in unit) - offset.
    indistinguishable : tuple of str
        Definitions that fit as well.
    """

    column: Column
    unit: str
    sign: int = 1
    offset: float = 0.0
    indistinguishable: tuple[str, ...] = ()

    def is_plain(self) -> bool:
        """Whether this is how the column is taken as written."""
        return self == replace(plain(self.column.key), indistinguishable=self.indistinguishable)


def plain(key: str) -> Understanding:
    """A column as written: default definition, SI unit, right positive, zero at the floor."""
    column = COMPARED[key][0]
    return Understanding(column, column.unit)


def understand(parts: Sequence[Part]) -> Mapping[str, Understanding]:
    """How each column of a file is taken, by key; one choice for all its maneuvers."""
    return understand_samples([Sample(part) for part in parts])


def understand_samples(samples: Sequence[Sample]) -> Mapping[str, Understanding]:
    """How each column of a file is taken, by key, against the motion that the samples expect."""
    found = {}
    for key in COMPARED:
        having = [s for s in samples if key in s.values]
        if having:
            found[key] = _choose(key, having)
    _share_the_unit_of_energies(found)
    _find_offset(found, samples)
    return found


class Sample:
    """Some rows of a part, with every definition at them and what a written digit is worth.

    Parameters
    ----------
    part : Part
    pick : ndarray of int, shape (n,)
        The rows; by default as `Part.sample` has it.
    expected : mapping of str to ndarray, shape (n,)
        Columns in every definition at these rows; by default those of the reference. Rows where
        it is not finite do not count.
    """

    def __init__(
        self,
        part: Part,
        pick: NDArray[np.intp] | None = None,
        expected: Mapping[str, Array] | None = None,
    ) -> None:
        rows = part.sample() if pick is None else pick
        present = {key: v[rows] for key, v in part.values.items()}
        if expected is None:
            names = [c.name for key in present for c in COMPARED[key]]
            expected = part.reference.approximate(part.time[rows], names)
        self.values, self.expected, self.scale, self.floor = {}, {}, {}, {}
        self.at_start: set[str] = set()
        for key, values in present.items():
            good = np.isfinite(values) & np.isfinite(expected[key])
            if not good.any():
                continue
            self.values[key] = values[good]
            if good[0] and part.time[rows[0]] == 0.0:
                self.at_start.add(key)
            self.expected.update({c.name: expected[c.name][good] for c in COMPARED[key]})
            scale = part.reference.scale(key)
            quantum = part.quantum.get(key)
            written = 0.0 if quantum is None else float(median(quantum.at(values[good]))) / 2
            self.scale[key] = scale
            # What plain binary64 can tell, see `ReferenceManeuver.approximate`.
            self.floor[key] = (written, 1e-15 * scale or np.finfo(np.float64).tiny)

    def error(self, key: str, u: Understanding) -> Array:
        return (
            u.sign * factor(u.unit)[0] * self.values[key] - u.offset - self.expected[u.column.name]
        )

    def starts_otherwise(self, key: str, u: Understanding, default: Understanding) -> bool:
        """Whether the first row, at the known start, speaks against a definition.

        It fits the default one, and is as far from the other as the rest of the run.
        """
        if key not in self.at_start:
            return False
        error = abs(float(self.error(key, u)[0]))
        known = abs(float(self.error(key, default)[0]))
        return error > _CLEARLY * max(known, sum(self.floor[key])) and (
            error > self.typical(key, u) / _CLEARLY
        )

    def typical(self, key: str, u: Understanding) -> float:
        """Root mean square of the errors but the largest, not below what the digits can tell."""
        written, known = self.floor[key]
        error = np.sort(np.abs(self.error(key, u)))
        kept = error[: len(error) - len(error) // _LEFT_OUT]
        return max(rms(kept), written * factor(u.unit)[0], known)


_Typical = tuple[float, ...]


def _typical(key: str, u: Understanding, samples: Iterable[Sample]) -> _Typical:
    return tuple(s.typical(key, u) for s in samples if key in s.values)


def _joint(typical: _Typical) -> float:
    return float(np.sum(np.log(typical)))


def _told_apart(worse: _Typical, better: _Typical) -> bool:
    """Whether the maneuvers say that one candidate is better, and next to nothing the contrary."""
    ratios = np.array(worse) / np.array(better)
    says = np.log(ratios)
    contrary = -says[ratios <= _NOT_WORSE].sum()
    return bool(ratios.max() > _TOLD_APART and says[says > 0].sum() > _OUTWEIGHED * contrary)


def _choose(key: str, samples: Sequence[Sample]) -> Understanding:
    """Unit and sign, then the definition under them."""
    columns = COMPARED[key]
    signs = (1,) if key in _UNSIGNED else (1, -1)
    typical = {
        (unit, sign, c): _typical(key, Understanding(c, unit, sign), samples)
        for unit in UNITS[columns[0].unit]
        for sign in signs
        for c in columns
    }

    def best(candidates: Iterable[tuple[str, int, Column]]) -> tuple[str, int, Column]:
        return min(candidates, key=lambda c: _joint(typical[c]))

    for unit, sign in {c[:2] for c in typical}:
        for c in columns[1:]:
            candidates = [Understanding(d, unit, sign) for d in (c, columns[0])]
            if any(s.starts_otherwise(key, *candidates) for s in samples):
                del typical[unit, sign, c]

    unit, sign, _ = chosen = best(typical)
    as_si = best(c for c in typical if c[:2] == (columns[0].unit, 1))
    if not _is_shown(key, typical[chosen], samples):
        return plain(key)
    clear = _told_apart(typical[as_si], typical[chosen])
    if not (clear and _is_near(key, typical[chosen], samples)):
        unit, sign, _ = chosen = as_si
    alike = [
        c
        for c in columns
        if (unit, sign, c) in typical and not _told_apart(typical[unit, sign, c], typical[chosen])
    ]  # the chosen one among them
    column = columns[0] if columns[0] in alike else chosen[2]
    others = tuple(c.definition for c in alike if c is not column)
    return Understanding(column, unit, sign, indistinguishable=others)


def _is_shown(key: str, typical: _Typical, samples: Sequence[Sample]) -> bool:
    """Whether there are rows enough to tell anything, or the few of them fit to the last digit."""
    if max(len(s.values[key]) for s in samples) >= _FEW_ROWS:
        return True
    floors = [sum(s.floor[key]) for s in samples]
    return all(t <= _CLEARLY * f for t, f in zip(typical, floors, strict=True))


def _is_near(key: str, typical: _Typical, samples: Sequence[Sample]) -> bool:
    """Whether the typical error is below half the size of the column itself.

    Zeros, or any noise scaled down to nothing, have an error as large as that.
    """
    limit = _NEAR if _hardly_varies(key, samples) else HALF
    sizes = [rms(s.expected[key]) for s in samples]
    return all(sizes) and _joint(typical) < _joint(tuple(limit * size for size in sizes))


def _hardly_varies(key: str, samples: Sequence[Sample]) -> bool:
    if key in BENCHMARK_COLUMNS:
        return COMPARED[key][0].unit in _HARDLY_VARYING
    return all(float(np.ptp(s.expected[key])) < HALF * s.scale[key] for s in samples)


def _share_the_unit_of_energies(found: dict[str, Understanding]) -> None:
    """The kinetic energy has no zero to choose, so its unit is the surest."""
    leader = next((key for key in _ENERGIES if key in found), None)
    if leader is None:
        return
    for key in _ENERGIES:
        if key in found:
            found[key] = replace(found[key], unit=found[leader].unit)


def _find_offset(found: dict[str, Understanding], samples: Sequence[Sample]) -> None:
    """A zero of the potential energy elsewhere, shared by the mechanical energy.

    It is looked for in the potential energy: an offset of the mechanical energy alone, which is
    constant, could as well be a wrong initial state.
    """
    key, total = "potential_energy", "mechanical_energy"
    if key not in found:
        return
    u = found[key]
    having = [s for s in samples if key in s.values]
    errors = [s.error(key, u) for s in having]
    # From the maneuver in which the error is the most constant, its least disturbed row: the first.
    offset = float(min(errors, key=lambda e: float(median(np.abs(e - median(e)))))[0])
    moved = replace(u, offset=offset)
    left = _typical(key, moved, having)
    scale = max(s.scale[key] for s in having)
    # Zeros that programs choose (the start, the hubs, the centre of mass) are far from the floor;
    # a wrong weight or height moves the energy a little, and nearly by a constant.
    if abs(offset) < _FAR_ZERO * scale or not _is_shown(key, left, having):
        return
    if _explained(key, u, moved, samples) < _CLEARLY_CONSTANT:
        return
    # What is left must be an error of the motion, not all of it.
    for s, typical in zip(having, left, strict=True):
        expected = s.expected[u.column.name]
        if typical > HALF * rms(expected - median(expected)) + sum(s.floor[key]):
            return
    if total in found:
        both = replace(found[total], offset=offset)
        if _explained(total, found[total], both, samples) < _CLEARLY_CONSTANT:
            return
        found[total] = both
    found[key] = moved


def _explained(
    key: str, before: Understanding, after: Understanding, samples: Sequence[Sample]
) -> float:
    """Least factor, over the maneuvers, by which the typical error falls."""
    pairs = zip(_typical(key, before, samples), _typical(key, after, samples), strict=True)
    return min(a / b for a, b in pairs)
