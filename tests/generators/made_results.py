"""Results made from the reference, with known definitions, errors and slips."""

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.reading.results import Quantum, Results, Rows


def exact_columns(maneuver, names=BENCHMARK_COLUMNS):
    """The published rows, one column for each name, keyed by the benchmark's key."""
    by_key = {}
    for name in names:
        key = next(k for k in BENCHMARK_COLUMNS if name == k or name.startswith(f"{k}_"))
        by_key[key] = maneuver[name].copy()
    return by_key


def rows(reference, number, values, *, lo=None, quantum=None, keep=slice(None)):
    maneuver = reference[number]
    return Rows(
        maneuver=number,
        time=maneuver.time[keep],
        time_lo=maneuver.time_lo[keep],
        values={key: v[keep] for key, v in values.items()},
        lo={key: v[keep] for key, v in (lo or {}).items()},
        quantum={key: Quantum(2, 53) for key in values} if quantum is None else quantum,
    )


def made(reference, change=lambda key, values, number: values, names=BENCHMARK_COLUMNS, **more):
    """Results of all maneuvers: the reference's rows, each column changed."""
    parts = []
    for number in reference:
        columns = exact_columns(reference[number], names)
        changed = {key: change(key, v, number) for key, v in columns.items()}
        parts.append(rows(reference, number, changed, **more))
    return Results("made.txt", "text", tuple(parts), 16)


def smooth_error(reference, number, size):
    """An error of the given largest value that grows as integrators' errors do."""
    t = reference[number].time
    shape = t / t[-1] * np.sin(3.0 * t + number)
    return size * shape / np.max(np.abs(shape))


def column(report, number, key):
    maneuver = next(m for m in report.maneuvers if m.maneuver == number)
    return next(c for c in maneuver.columns if c.key == key)


def codes(report):
    return [f.code for f in report.findings]


def is_right_in_part(report):
    """Whether every column that is there is right, and none of another name was left out."""
    return {*report.grades} == {Grade.RIGHT} and not report.not_compared
