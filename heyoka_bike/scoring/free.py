"""Free choices of programs: whole turns of an angle, the order of a quaternion, and the start.

An angle and the same angle plus a whole turn are one attitude. Programs write angles within one
turn, from 0 to 360 degrees or from minus pi to pi. The whole turns between two rows follow from the
angle by which the reference turns between them.

A quaternion is written with its scalar first or last.

The equations of motion contain neither the heading nor the place on the floor (see
`columns.FREE_ZERO`): a program may start anywhere, in any direction. If it starts in another
direction, the path on the floor is turned; this module turns it back. `definitions` finds the
constants that remain.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import COMPARED, FREE_ZERO
from heyoka_bike.numbers.double import PI, Array, Double, fast_two_sum, multiply, two_sum
from heyoka_bike.numbers.unit import size
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.column_meaning import PathTurned, ScalarLast, WholeTurns
from heyoka_bike.scoring.ratios import BY_FAR, CLEARLY
from heyoka_bike.scoring.reading.results import AnyRows, Quantum, Rows, renamed
from heyoka_bike.scoring.units import factor, tried

# Fraction of a turn by which rounding may widen the range of angles within one turn.
_ROUNDING = 1e-3
# Largest absolute value of an angle with a fixed zero that may be written within one turn [turns]:
# one turn, plus a quarter because angles of the benchmark may exceed one turn by this much.
_MOST_TURNS = 1.25
# Minimum number of rows that show the direction of a path.
_FEWEST_ROWS_OF_PATH = 3
_ANGLES = tuple(key for key, columns in COMPARED.items() if columns[0].unit == "rad")
_PLACES = tuple(
    key.removesuffix("_x") for key in FREE_ZERO if key.endswith("_x") and key in COMPARED
)


def with_free_values(
    rows: AnyRows, reference: ReferenceManeuver
) -> tuple[AnyRows, tuple[Evidence, ...]]:
    """Return the rows with whole turns added to angles that jump, and with paths turned back.

    Quaternions get their scalar first. The evidence describes each change.

    Parameters
    ----------
    rows
        Rows of one maneuver, within the run.
    reference : ReferenceManeuver
        The reference of the same maneuver.
    """
    seen: list[Evidence] = []
    last = [end for end in ("rear", "front") if _has_scalar_last(rows, end, reference)]
    for end in last:
        rows = _with_scalar_first(rows, end)
        seen.append(ScalarLast(end))
    wrapped = {key: found for key in _ANGLES if (found := _turns(rows, key, reference))}
    if wrapped:
        rows = _with_turns(rows, wrapped)
        seen.append(WholeTurns(tuple(wrapped)))
    if angle := _heading_of_path(rows, reference):
        rows = _turned_back(rows, *angle)
        seen.append(PathTurned(angle.heading))
    return rows, tuple(seen)


def with_all_turns(seen: Sequence[Evidence]) -> tuple[Evidence, ...]:
    """Return the evidence of all maneuvers, with the angles within one turn in one finding."""
    keys = dict.fromkeys(key for x in seen if isinstance(x, WholeTurns) for key in x.keys)
    others = [x for x in seen if not isinstance(x, WholeTurns)]
    return (*others, WholeTurns(tuple(keys))) if keys else tuple(others)


def _quaternion(end: str) -> list[str]:
    """Return the keys of the quaternion of a frame, the scalar first."""
    return [f"{end}_frame_q{i}" for i in range(4)]


def _has_scalar_last(rows: Rows, end: str, reference: ReferenceManeuver) -> bool:
    """True if the quaternion of a frame fits clearly better with its last element as the scalar.

    Only absolute values are compared, because the signs depend on the choice of axes.
    """
    keys = _quaternion(end)
    if not rows.values.keys() >= {*keys}:
        return False
    written = np.abs([rows.values[key] for key in keys])
    good = np.isfinite(written).all(axis=0)
    if not good.any():
        return False
    expected = reference.approximate(rows.time[good], keys)
    right = np.abs([expected[key] for key in keys])
    first, last = (_rms(x - right) for x in (written[:, good], np.roll(written[:, good], 1, 0)))
    return last < first / CLEARLY


def _with_scalar_first(rows: AnyRows, end: str) -> AnyRows:
    keys = _quaternion(end)
    return renamed(rows, dict(zip(keys, [*keys[1:], keys[0]], strict=True)))


class _Turns(NamedTuple):
    """The number of whole turns to add to each row of an angle, and a turn in the angle's unit."""

    number: NDArray[np.float64]
    turn: Fraction


def _turns(rows: Rows, key: str, reference: ReferenceManeuver) -> _Turns | None:
    """Return the whole turns missing from an angle; None if it is not written within one turn."""
    values = rows.values.get(key)
    if values is None:
        return None
    good = np.flatnonzero(np.isfinite(values))
    written = values[good]
    if len(written) < 2 or not written.any():
        return None
    expected = None
    for unit in [rows.units[key]] if key in rows.units else tried("rad", None):
        turn = _turn(unit)
        one = float(turn)
        within = float(np.ptp(written)) <= (1 + _ROUNDING) * one
        # If the zero of an angle is fixed, the angle must also stay near zero.
        within &= key in FREE_ZERO or float(np.abs(written).max()) <= _MOST_TURNS * one
        is_beyond = key not in FREE_ZERO and bool(np.abs(written).min() > one / 2)
        if not within or not (is_beyond or np.abs(np.diff(written)).max() > one / 2):
            continue
        if expected is None:
            expected = reference.approximate(rows.time[good], [key])[key]
        right = [sign * expected / factor(unit)[0] for sign in (1, -1)]
        best = min((_unwrapped(written, x, one, is_beyond) for x in right), key=lambda x: x[1])
        if best[1] < best[2] / (BY_FAR if is_beyond else CLEARLY):
            count = np.zeros(len(values))
            count[good] = best[0]
            return _Turns(count, turn)
    return None


def _unwrapped(
    written: Array, expected: Array, turn: float, is_beyond: bool
) -> tuple[Array, float, float]:
    """Return the turns missing from each row, and the rms errors with and without these turns.

    The errors are those of the steps between rows. For an angle that never comes near its zero
    (`is_beyond`), they are those of the angle itself.
    """
    off = written - expected
    count = -np.rint(np.concatenate([off[:1], np.diff(off)]) / turn).cumsum()
    both = off + turn * count, off
    with_turns, without = both if is_beyond else map(np.diff, both)
    return count, _rms(with_turns), _rms(without)


def _turn(unit: str) -> Fraction:
    """Return the size of a whole turn in a unit of angle."""
    found = size(unit)
    assert found is not None
    one, half_turns, _ = found
    return Fraction(2) / one * (1 if half_turns else PI)


def _with_turns(rows: AnyRows, wrapped: Mapping[str, _Turns]) -> AnyRows:
    values, lo, quantum = dict(rows.values), dict(rows.lo), dict(rows.quantum)
    for key, (count, turn) in wrapped.items():
        one = float(turn)
        of_turn = np.full(len(count), one), np.full(len(count), float(turn - Fraction(one)))
        hi, rest = _sum(rows.written(key), multiply((count, np.zeros(len(count))), of_turn))
        if key in quantum:
            quantum[key] = _step(quantum[key], values[key])
        values[key] = hi
        if key in lo:
            lo[key] = np.where(np.isfinite(hi), rest, 0.0)
    return replace(rows, values=values, lo=lo, quantum=quantum)


def _sum(a: Double, b: Double) -> Double:
    hi, rest = two_sum(a[0], b[0])
    return fast_two_sum(hi, rest + (a[1] + b[1]))


def _step(quantum: Quantum, *written: Array) -> Quantum:
    """Return the resolution of computed numbers: the resolution of the largest written number."""
    largest = max(float(np.nanmax(np.abs(x))) for x in written)
    return Quantum(2, places=0, step=float(quantum.at(np.array(largest))))


class _Heading(NamedTuple):
    """The direction in which a path starts [rad], and whether its y axis points to the left."""

    heading: float
    is_left: bool


def _heading_of_path(rows: Rows, reference: ReferenceManeuver) -> _Heading | None:
    """Return the heading at the start of a path; None if the path fits about as well unturned."""
    places = [p for p in _PLACES if f"{p}_x" in rows.values and f"{p}_y" in rows.values]
    if not places:
        return None
    names = [f"{p}_{axis}" for p in places for axis in "xy"]
    good = np.logical_and.reduce([np.isfinite(rows.values[name]) for name in names])
    if np.count_nonzero(good) < _FEWEST_ROWS_OF_PATH:
        return None
    expected = reference.approximate(rows.time[good], names)
    written = np.concatenate([_centred(*_both(rows.values, p, good)) for p in places])
    right = np.concatenate([_centred(expected[f"{p}_x"], expected[f"{p}_y"]) for p in places])
    length = float(np.vdot(right, right).real)
    best: tuple[float, _Heading] | None = None
    for is_left in (False, True):
        path = written.conj() if is_left else written
        ratio = complex(np.vdot(right, path)) / length
        off = _rms(np.abs(path - ratio * right))
        if best is None or off < best[0]:
            best = off, _Heading(float(np.angle(ratio)), is_left)
            scale = abs(ratio)
    assert best is not None
    # Compare the path also as it is written, with either sign of each axis.
    as_written = min(
        _rms(np.abs(written - scale * (x * right.real + 1j * y * right.imag)))
        for x, y in product((1, -1), repeat=2)
    )
    return best[1] if best[0] < as_written / BY_FAR else None


def _both(values: Mapping[str, Array], place: str, good: NDArray[np.bool_]) -> tuple[Array, Array]:
    return values[f"{place}_x"][good], values[f"{place}_y"][good]


def _centred(x: Array, y: Array) -> NDArray[np.complex128]:
    path = x + 1j * y
    return np.asarray(path - path.mean())


def _turned_back(rows: AnyRows, heading: float, is_left: bool) -> AnyRows:
    """Return the rows with the path on the floor turned so that it starts as in the reference."""
    values, lo, quantum = dict(rows.values), dict(rows.lo), dict(rows.quantum)
    turn = np.exp((1j if is_left else -1j) * heading)
    for x, y in ((f"{p}_x", f"{p}_y") for p in _PLACES):
        if x not in values or y not in values:
            continue
        path = (values[x] + 1j * values[y]) * turn
        for key in (x, y):
            lo.pop(key, None)
            if key in quantum:
                quantum[key] = _step(quantum[key], values[x], values[y])
        values[x], values[y] = np.ascontiguousarray(path.real), np.ascontiguousarray(path.imag)
    return replace(rows, values=values, lo=lo, quantum=quantum)


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(np.square(x))))
