"""Columns that were never filled in: they are constant, although the quantity varies.

Programs that do not compute some columns of the benchmark's file, mostly the energies, write zeros,
NaN or the first value instead. Such a column is reported and not compared. A requirement on such a
column fails, see `requirements`.
"""

from dataclasses import replace

import numpy as np

from heyoka_bike.bicycle.columns import ANGLE_OF, BENCHMARK_COLUMNS, LATERAL
from heyoka_bike.scoring.alignment import Alignment, Part
from heyoka_bike.scoring.evidence.as_compared import NeverFilled, Unfilled
from heyoka_bike.scoring.grades import MAX_ROUNDING_FLOORS, MIN_ROWS_FOR_SHAPE, RIGHT
from heyoka_bike.scoring.reading.results import Quantum
from heyoka_bike.scoring.rows.grids import bits_of

# These columns count as never filled in if they have any constant value. Other columns count as
# never filled in only if they are zero, because the linear equations have a constant speed, and a
# motion at rest has a constant angle.
_MAY_HOLD_A_NUMBER = ("potential_energy", "kinetic_energy", "mechanical_energy")
# Largest relative variation of a column in an upright and straight run, due to the integrator's
# roundoff.
_ROUNDOFF_OF_INTEGRATOR = 1e-9


def without_unfilled(alignment: Alignment) -> Alignment:
    """Leave out columns that were never filled in, and add evidence that names them.

    A file without any other columns remains as it is.
    """
    found = [(part, _unfilled(part)) for part in alignment.parts]
    kept = tuple(
        part.without(keys) if keys else part for part, keys in found if part.values.keys() - keys
    )
    if not kept or not any(keys for _, keys in found):
        return alignment
    columns = tuple(
        Unfilled(part.number, key, number) for part, keys in found for key, number in keys.items()
    )
    seen = (*alignment.seen, NeverFilled(columns, len(found)))
    return replace(alignment, parts=kept, seen=seen)


def _unfilled(part: Part) -> dict[str, float]:
    """Return the columns that were never filled in, with the constant value of each."""
    empty = {key: np.nan for key, x in part.values.items() if len(x) and np.isnan(x).all()}
    if len(part.time) < MIN_ROWS_FOR_SHAPE or _runs_straight(part):
        return empty
    columns = part.only(BENCHMARK_COLUMNS).values
    each = [bits_of(x, part.quantum.get(key)) for key, x in columns.items() if np.ptp(x) > 0.0]
    # In half precision, an energy may vary by less than the spacing of the numbers, and therefore
    # be constant as written.
    bits = max((n for n in each if n), default=None) if each and all(each) else None
    constant = {key: float(x[0]) for key, x in columns.items() if np.all(x == x[0])}
    found = {
        key: number
        for key, number in constant.items()
        if (key in _MAY_HOLD_A_NUMBER if number else not constant.get(ANGLE_OF.get(key, "")))
        and _should_vary(part, key, number, bits)
        and not _is_mechanical_energy(part, key, number)
    }
    # The sum of two energies that were never filled in was not computed either, although a constant
    # sum would be right.
    parts = [found.get(key) for key in ("potential_energy", "kinetic_energy")]
    total = constant.get("mechanical_energy")
    if None not in parts and total is not None and total == sum(x or 0.0 for x in parts):
        found["mechanical_energy"] = total
    return empty | found


def _is_mechanical_energy(part: Part, key: str, number: float) -> bool:
    """True if another column contains the mechanical energy, which is constant in the benchmark."""
    exact = float(part.reference.rows["mechanical_energy"][0])
    return key != "mechanical_energy" and abs(number - exact) < RIGHT * exact


def _runs_straight(part: Part) -> bool:
    """True if the columns are those of a bicycle that runs upright and straight."""
    lateral = part.only(LATERAL).values.values()
    others = part.only({*BENCHMARK_COLUMNS} - {*LATERAL}).values.values()
    return (
        bool(lateral and others)
        and not any(x.any() for x in lateral)
        and all(
            x.any() and np.ptp(x) <= _ROUNDOFF_OF_INTEGRATOR * np.max(np.abs(x)) for x in others
        )
    )


def _should_vary(part: Part, key: str, number: float, bits: int | None) -> bool:
    """True if the quantity, in every definition, varies by more than its digits can hide."""
    names = [c.name for c in part.reference.definitions[key]]
    rows = part.time[part.sample()]
    for name, expected in part.reference.approximate(rows, names).items():
        spacing = float(np.max(part.spacing(key, expected)))
        step = max(1e-15 * part.reference.scale(name), spacing)
        if bits is not None:
            step = max(step, float(np.max(Quantum(2, digits=bits).at(expected))))
        # The exact mechanical energy is constant, but not zero. So compare its size with a column
        # of zeros, and its variation with any other constant.
        far = np.max(np.abs(expected)) if number == 0.0 else np.ptp(expected)
        # Rounding to the digits written explains that the column is constant.
        if far <= MAX_ROUNDING_FLOORS * step:
            return False
    return True
