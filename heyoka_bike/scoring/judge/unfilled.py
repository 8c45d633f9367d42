"""Columns that hold one number in every row where the quantity varies: they were never filled in.

Programs that write the benchmark's file without some of its columns, the energies mostly, leave
zeros in their place, NaN or the first value. That is no result: it is named, and left out. A
requirement that speaks of such a column fails, see `requirements`.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, LATERAL
from heyoka_bike.scoring.alignment import Alignment, Part
from heyoka_bike.scoring.findings import Finding, warning

# Fewer rows may be alike.
_FEW_ROWS = 10
# Another number than zero is what was never filled in of these alone: a constant speed is what the
# linear equations have, a constant angle what a motion has that stands still.
_HELD = ("potential_energy", "kinetic_energy", "mechanical_energy")
# What is said of numbers that are none.
_NOTHING = {"nan": "nothing but NaN", "0.0": "nothing but zeros", "-0.0": "nothing but zeros"}
# Zeros are the rate of such an angle.
_RATES = {"roll_rate": "roll_angle", "steer_rate": "steer_angle"}
# Of a bicycle that runs upright and straight nothing varies but by an integrator's roundoff.
_ROUNDOFF = 1e-9
# The quantity varies by more of what can be written than this: rounding does not explain one value.
_STEPS = 4.0


def without_unfilled(alignment: Alignment) -> Alignment:
    """The rows without the columns that were never filled in, and a finding that names them.

    A file that has nothing else stays as it is.
    """
    found = [(part, _unfilled(part)) for part in alignment.parts]
    kept = tuple(
        part.only(part.values.keys() - keys) if keys else part
        for part, keys in found
        if part.values.keys() - keys
    )
    if not kept or not any(keys for _, keys in found):
        return alignment
    return replace(alignment, parts=kept, findings=(*alignment.findings, _finding(found)))


def _unfilled(part: Part) -> dict[str, float]:
    """The columns that were never filled in, with the number that they hold."""
    empty = {key: np.nan for key, x in part.values.items() if len(x) and np.isnan(x).all()}
    if len(part.time) < _FEW_ROWS or _runs_straight(part):
        return empty
    constant = {
        key: float(values[0])
        for key, values in part.values.items()
        if key in BENCHMARK_COLUMNS and np.all(values == values[0])
    }
    found = {
        key: number
        for key, number in constant.items()
        if (key in _HELD if number else not constant.get(_RATES.get(key, "")))
        and _should_vary(part, key, number)
    }
    # Their sum is constant, as the mechanical energy should be, and as empty.
    parts = [found.get(key) for key in ("potential_energy", "kinetic_energy")]
    total = constant.get("mechanical_energy")
    if None not in parts and total is not None and total == sum(x or 0.0 for x in parts):
        found["mechanical_energy"] = total
    return empty | found


def _runs_straight(part: Part) -> bool:
    """True if all columns together are those of a bicycle that stays upright and straight."""
    lateral = [part.values[key] for key in LATERAL if key in part.values]
    others = [
        x for key, x in part.values.items() if key in BENCHMARK_COLUMNS and key not in LATERAL
    ]
    return (
        bool(lateral and others)
        and not any(x.any() for x in lateral)
        and all(x.any() and np.ptp(x) <= _ROUNDOFF * np.max(np.abs(x)) for x in others)
    )


def _should_vary(part: Part, key: str, number: float) -> bool:
    """True if no definition of the quantity is one number, as far as the digits written show."""
    names = [c.name for c in part.reference.definitions[key]]
    rows = part.time[part.sample()]
    quantum = part.quantum.get(key)
    for name, expected in part.reference.approximate(rows, names).items():
        step = 1e-15 * part.reference.scale(name)
        if quantum is not None:
            step = max(step, float(np.max(quantum.at(expected))))
        # Nothing but zeros is no mechanical energy either, which is constant.
        far = np.max(np.abs(expected)) if number == 0.0 else np.ptp(expected)
        if far <= _STEPS * step:
            return False
    return True


def _finding(found: Sequence[tuple[Part, dict[str, float]]]) -> Finding:
    held: dict[tuple[str, float], list[int]] = {}
    for part, keys in found:
        for key, number in keys.items():
            held.setdefault((key, number), []).append(part.number)
    alike: dict[tuple[float, str], list[str]] = {}
    for (key, number), numbers in held.items():
        where = f" of maneuver {', '.join(map(str, numbers))}" if len(numbers) < len(found) else ""
        alike.setdefault((number, where), []).append(key)
    said = [
        f"{', '.join(names)}{where} hold{'s' if len(names) == 1 else ''} "
        f"{_NOTHING.get(str(number), f'{number:.9g}')}"
        for (number, where), names in alike.items()
    ]
    return warning(
        "never_filled",
        f"{', '.join(said)}: one number in every row of what varies, so never filled in; left out "
        "of the result",
        columns=[f"{part.number}.{key}" for part, keys in found for key in keys],
    )
