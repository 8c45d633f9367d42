"""Columns at the published rows, as a mapping, as an array and as a CSV file."""

import csv

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS


def published_columns(reference, number=2, every=1, keys=BENCHMARK_COLUMNS):
    """Return the time and columns of a maneuver by name, at every `every`-th published row."""
    m = reference[number]
    return {
        name: x[::every].copy() for name, x in {"time": m.time, **{k: m[k] for k in keys}}.items()
    }


def published_table(reference, numbers=(1, 2, 3), every=1):
    """Return an array of the time and eight columns of each maneuver, as in the published text."""
    columns = [reference[n][key] for n in numbers for key in BENCHMARK_COLUMNS]
    return np.column_stack([reference[1].time, *columns])[::every].copy()


def side_by_side(by_maneuver, time):
    """Return columns m1_roll_angle, ... of all maneuvers, with their common times."""
    return {"time": time} | {
        f"m{n}_{key}": x for n, columns in by_maneuver.items() for key, x in columns.items()
    }


def write_csv(path, columns):
    """Write columns by name to a CSV file, in which only the names are quoted; return its path."""
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, quoting=csv.QUOTE_NONNUMERIC)
        out.writerow(columns)
        out.writerows(zip(*(map(float, x) for x in columns.values()), strict=True))
    return path
