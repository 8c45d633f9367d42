"""Degenerate result tables: few rows, times that stand still, numbers of any size.

A table starts as the exact or a wrong motion of one or all maneuvers. It is then damaged up to
three times, as programs, spreadsheets and converters do. A table depends only on its seed.
"""

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS

SIZES = (1, 2, 3, 3, 4, 5, 5, 6, 8, 11, 11, 12, 21, 41)
"""Numbers of rows of a table. The scorer's limits on numbers of rows lie between these."""

ODD = (
    0.0, -0.0, 1.0, -1.0, np.pi, np.nan, np.inf, -np.inf, 1e308, -1e308, 1e300, 1e200, 1e154, 1e150,
    1e100, 1e16, 1e-16, 1e-100, 1e-150, 1e-154, 1e-200, 1e-308, 5e-324, -5e-324,
)  # fmt: skip
_UNITS = ("deg", "rad", "rad/s", "deg/s", "km/h", "m/s", "kJ", "J", "ms", "s", "min", "h", "")


def table(reference, pick):
    """Return rows by columns: time, then eight columns of each maneuver."""
    numbers = pick.choice(([1], [2], [3], [1, 2, 3]))
    size = pick.choice(SIZES)
    # The rows are evenly spaced over the run or over its beginning, or they are chosen at random.
    last = pick.choice((1000, 1000, 1000, 500, 100, 3 * size))
    rows = np.unique(np.linspace(0, min(last, 1000), size).astype(int))
    if pick.random() < 0.15:
        rows = np.array(sorted(pick.sample(range(1001), size)))
    maneuvers = [reference[n] for n in numbers]
    columns = [maneuvers[0].time[rows]]
    columns += [m.rows[key][rows] for m in maneuvers for key in BENCHMARK_COLUMNS]
    found = np.column_stack(columns)
    wrong = pick.choice(("right", "right", "integrator", "parameters", "sines", "another"))
    t = found[:, :1]
    with np.errstate(all="ignore"):
        if wrong == "integrator":
            found[:, 1:] *= 1.0 + pick.choice((1e-9, 1e-6, 1e-3)) * t * np.sin(3.0 * t)
        elif wrong == "parameters":
            found[:, 1:] *= 1.0 + 0.3 * np.sin(pick.uniform(0.1, 2.0) * t)
        elif wrong == "sines":
            for k in range(1, found.shape[1]):
                found[:, k] = pick.choice((1e-3, 1.0, 1e3)) * np.sin(pick.uniform(0, 50) * t[:, 0])
        elif wrong == "another":
            other = reference[pick.choice([1, 2, 3])]
            found[:, 1:9] = np.column_stack([other.rows[k][rows] for k in BENCHMARK_COLUMNS])
    return found


def _times(x, pick):
    """Make the times coarse, repeated, of another unit or clock, or out of order."""
    t = x[:, 0]
    how = pick.randrange(16)
    if how == 0:
        t[:] = t[0]
    elif how == 1:
        t[:] = np.round(t, pick.choice((0, 1, 2)))
    elif how == 2:
        t *= pick.choice((1 / 60, 1 / 3600, 1 / 86400, 1e3, 1e6, 1e9, 1e-3, 1e-9, 1e-12))
    elif how == 3:
        t *= pick.choice((1e-300, 1e-200, 1e100, 1e300, -1.0, 0.0, 1.0001, 0.999, 0.7, 2.0))
    elif how == 4:
        t += pick.choice(
            (1e-9, -1e-9, 1e-3, -1e-3, 0.5, -0.5, 5.0, 9.99, 10.01, -10, -20, 1e6, 1.7e9)
        )
    elif how == 5:
        x[:] = x[::-1].copy()
    elif how == 6:
        x[:] = np.array(pick.sample(list(x), len(x)))
    elif how == 7:
        k = pick.randrange(len(x))
        t[k] = t[pick.randrange(len(x))]
    elif how == 8:
        k = pick.randrange(len(x))
        t[k:] = t[k]
    elif how == 9:
        return np.repeat(x, pick.choice((2, 3)), axis=0)
    elif how == 10:
        t[:] = np.arange(len(x)) * pick.choice((1.0, 1e-3, 1e-6, 1e-9, 1e-10, 1e-16, 5e-324))
    elif how == 11:
        # Each time differs from the previous one only in its last bit.
        t[:] = t[0] + 1.0
        for k in range(1, len(t)):
            t[k] = np.nextafter(t[k - 1], np.inf)
    elif how == 12:
        t[:] = np.sort([10 * pick.random() ** pick.choice((1, 8)) for _ in t])
    elif how == 13:
        t *= 1.0 + pick.choice((1e-15, 1e-9, 1e-3, 0.1)) * t
    elif how == 14:
        t[pick.randrange(len(t))] = pick.choice(ODD)
    else:
        t[:] = pick.choice(ODD)
    return x


def _values(x, pick):
    """Make some values missing, constant, coarse, noisy, or of an impossible size."""
    n, width = x.shape
    block = pick.randrange((width - 1) // 8)
    whole = slice(1 + 8 * block, 9 + 8 * block)
    column = pick.choice((pick.randrange(1, width), whole, slice(1, None)))
    row = pick.randrange(n)
    rows = pick.choice((row, slice(row, None), slice(0, row + 1), slice(None)))
    how = pick.randrange(16)
    if how < 4:
        x[rows, column] = pick.choice(ODD)
    elif how == 4:
        x[rows, column] = np.nan
    elif how == 5:
        x[rows, column] *= pick.choice(ODD[8:])
    elif how == 6:
        x[rows, column] *= pick.choice((-1, 180 / np.pi, np.pi / 180, 3.6, 1e3, 1e-3, 2.0, 0.5))
    elif how == 7:
        x[:, column] = np.round(x[:, column], pick.choice((0, 1, 2, 3, 6)))
    elif how == 8:
        x[:, column] = x[0, column]
    elif how == 9:
        x[row:, column] = x[row, column]
    elif how == 10:
        noise = np.array([[pick.gauss(0, 1) for _ in range(width)] for _ in range(n)])
        x[:, column] += (pick.choice((1e-12, 1e-6, 1e-3, 0.1, 10)) * noise)[:, column]
    elif how == 11:
        a, b = pick.randrange(1, width), pick.randrange(1, width)
        x[:, [a, b]] = x[:, [b, a]]
    elif how == 12:
        x[:, column] = x[:, column] ** 2
    elif how == 13:
        x[:, column] = np.cumsum(x[:, column], axis=0)
    elif how == 14:
        x[:, column] = np.roll(x[:, column], pick.choice((1, -1)), axis=0)
    else:
        x[:, column] = np.abs(x[:, column])
    return x


def text(reference, pick):
    """Return a damaged table as a file, and its number of maneuvers."""
    x = table(reference, pick)
    for _ in range(pick.choice((0, 1, 1, 2, 2, 3))):
        with np.errstate(all="ignore"):
            x = pick.choice((_times, _values))(x, pick)
    digits = pick.choice((17, 17, 17, 9, 6, 3, 1))
    apart = pick.choice((" ", "\t", ",", ";"))
    lines = [apart.join(f"{v:.{digits}g}" for v in row) for row in x]
    count = (x.shape[1] - 1) // 8
    if pick.random() < 0.15:
        names = ["time", *(f"m{m}_{k}" for m in range(1, count + 1) for k in BENCHMARK_COLUMNS)]
        lines.insert(0, apart.join(f"{k} [{pick.choice(_UNITS)}]" for k in names))
    return "\n".join(lines) + "\n", count
