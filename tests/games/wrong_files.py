"""The game of wrong files: each is wrong by construction, with requirements it cannot meet.

A file has the published values with one change. `truth` computes the resulting error, in the
reading with the smallest error. For faults without a size (missing rows, values that are not
numbers, signs that no choice of axes explains) the change determines the failed requirements.
"""

from dataclasses import dataclass, field

import numpy as np

from games.files import EIGHT, END, MOTION, correct, names, references, scale, truth
from games.truth import Truth, units
from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.scoring.reading.results import Quantum

MANEUVERS = (1, 2, 3)
ANGLES = ("roll_angle", "steer_angle")
RATES = ("roll_rate", "steer_rate")


@dataclass(eq=False)
class Wrong:
    """A wrong file.

    `fails` are requirements that the file cannot meet; `keys` and `maneuvers` say where it was
    changed; `is_sized` is true if its numbers show the size of the error; `text` is the file, if
    the fault is in its text.
    """

    kind: str
    parts: list
    keys: list
    maneuvers: list
    fails: list = field(default_factory=list)
    quantum: Quantum | None = None
    is_sized: bool = True
    text: str = ""

    @property
    def is_not_right(self):
        """Return whether the failed requirements include one that every correct file meets."""
        return any(
            text == "coverage >= 0.99"
            or (" >= " in text and text.split(" >= ")[0].endswith("scd") and _number(text) <= 6)
            for text in self.fails
        )


def _number(text):
    return float(text.split()[-1])


def _size(random, low=-13, high=2):
    return 10.0 ** random.uniform(low, high)


def _start(random, *, keys=None, grid=None):
    """Return correct parts to change: all or some maneuvers, the eight columns or a few."""
    count = random.choice([1, 2, 3], p=[0.15, 0.15, 0.7])
    maneuvers = sorted(random.choice(MANEUVERS, count, replace=False).tolist())
    if keys is None:
        keys = list(EIGHT)
        if random.random() < 0.15:
            keys = list(random.choice(EIGHT, random.integers(2, 8), replace=False))
    named = {k: random.choice(names(k)) if random.random() < 0.3 else k for k in map(str, keys)}
    time = grid(random) if grid else _grid(random)
    is_long = random.random() < 0.25
    return [correct(n, named, *time, is_long=is_long) for n in maneuvers]


def _grid(random):
    which = random.integers(8)
    if which == 0:
        t = np.arange(2001) / 200
    elif which == 1:
        t = np.arange(501) / 50
    elif which == 2:
        t = np.sort(np.concatenate([[0.0, END], random.uniform(0, END, 700)]))
    else:
        return None, None
    return t, np.zeros_like(t)


def _one_of(random, parts, keys=None):
    p = parts[random.integers(len(parts))]
    return p, str(random.choice(keys or list(p.hi)))


def _moved(random, shape):
    """Add something of a known size to one column; most faults are of this kind."""
    parts = _start(random)
    p, key = _one_of(random, parts)
    change = shape(random, p.time, len(p.time))
    p.add(key, change * _size(random) * scale(p.maneuver, key))
    return parts, [key], [p.maneuver]


def one_value(random, t, n):
    return np.eye(1, n, random.integers(n))[0]


def stretch(random, t, n):
    i, j = np.sort(random.integers(n, size=2))
    return ((np.arange(n) >= i) & (np.arange(n) <= j)) * 1.0


def short_stretch(random, t, n):
    i = random.integers(n - 5)
    return ((np.arange(n) >= i) & (np.arange(n) < i + random.integers(2, 6))) * 1.0


def bump(random, t, n):
    return np.exp(-(((t - random.uniform(0, END)) / random.uniform(0.02, 2)) ** 2) / 2)


def late_drift(random, t, n):
    return np.maximum(t - random.uniform(0, 9.5), 0) ** random.integers(1, 4)


def spikes(random, t, n):
    return (random.random(n) < 0.01) * random.choice([-1, 1], n) + np.eye(1, n, n - 1)[0]


def oscillation(random, t, n):
    return np.sin(random.uniform(1, 200) * t + random.uniform(0, 6))


def noise(random, t, n):
    return random.standard_normal(n)


def last_row(random, t, n):
    return np.eye(1, n, n - 1)[0]


def first_row(random, t, n):
    return np.eye(1, n, 0)[0]


SHAPES = (one_value, stretch, short_stretch, bump, late_drift, spikes, oscillation, noise,
          last_row, first_row)  # fmt: skip


def scaled(random):
    parts = _start(random)
    p, key = _one_of(random, parts)
    p.add(key, p.hi[key] * _size(random, -12, 0.5))
    return parts, [key], [p.maneuver]


def every_column_moved(random):
    parts = _start(random)
    size = _size(random, -12, 0)
    for p in parts:
        for key in p.hi:
            shape = SHAPES[random.integers(len(SHAPES))]
            p.add(key, shape(random, p.time, len(p.time)) * size * scale(p.maneuver, key))
    return parts, list(parts[0].hi), [p.maneuver for p in parts]


def stretch_between_rows(random):
    """The values are wrong only between two rows of the reference."""

    def grid(random):
        t = np.union1d(np.arange(1001) / 100, random.uniform(0, END) + np.linspace(-9e-3, 9e-3, 19))
        t = t[(t >= 0) & (t <= END)]
        return t, np.zeros_like(t)

    parts = _start(random, grid=grid)
    p, key = _one_of(random, parts)
    off = np.flatnonzero(abs(p.time * 100 - np.round(p.time * 100)) > 1e-6)
    off = off[: random.integers(1, len(off) + 1)]
    p.hi[key][off] += _size(random, -10, 2) * scale(p.maneuver, key)
    return parts, [key], [p.maneuver]


def rows_shifted(random):
    """Values of some columns are shifted by some rows."""
    parts = _start(random)
    p, key = _one_of(random, parts)
    k = int(random.choice([-1, 1])) * int(random.integers(1, 40))
    keys = [key] if random.random() < 0.5 else list(p.hi)
    for one in keys:
        p.hi[one] = np.roll(p.hi[one], k)
        p.lo[one] = np.roll(p.lo[one], k)
        if random.random() < 0.5:
            edge = slice(None, k) if k > 0 else slice(k, None)
            p.set(one, p.hi[one][k if k > 0 else k - 1], edge)
    return parts, keys, [p.maneuver]


def times_shifted(random):
    parts = _start(random)
    d = int(random.choice([-1, 1])) * _size(random, -9, 0.6)
    for p in parts:
        p.time = p.time + d
        p.time_lo[:] = 0.0
    return parts, list(parts[0].hi), [p.maneuver for p in parts]


def times_stretched(random):
    parts = _start(random)
    by = 1 + int(random.choice([-1, 1])) * _size(random, -9, -0.5)
    for p in parts:
        p.time = p.time * by
        p.time_lo[:] = 0.0
    return parts, list(parts[0].hi), [p.maneuver for p in parts]


def times_outside(random):
    """Part of the run is written at times after its end."""
    parts = _start(random)
    p = parts[random.integers(len(parts))]
    cut = random.uniform(0, 9)
    p.time = np.where(p.time > cut, p.time + random.uniform(11, 30), p.time)
    p.time_lo[p.time > cut] = 0.0
    return parts, list(p.hi), [p.maneuver]


def permuted(random):
    parts = _start(random)
    p, key = _one_of(random, parts)
    i, j = np.sort(random.integers(len(p.time), size=2))
    j = max(j, i + 2)
    order = random.permutation if random.random() < 0.5 else np.flip
    rows = order(np.arange(i, min(j, len(p.time))))
    keys = [key] if random.random() < 0.5 else list(p.hi)
    for one in keys:
        p.hi[one][i : i + len(rows)] = p.hi[one][rows]
        p.lo[one][i : i + len(rows)] = p.lo[one][rows]
    return parts, keys, [p.maneuver]


def repeated_with_another_value(random):
    """A time occurs twice, with a right and a wrong value, in either order."""
    parts = _start(random)
    p, key = _one_of(random, parts)
    rows = np.sort(np.concatenate([np.arange(len(p.time)), random.integers(len(p.time), size=3)]))
    p.pick(rows)
    twice = np.flatnonzero(np.diff(rows) == 0) + random.integers(2)
    p.hi[key][twice] += _size(random, -12, 1) * scale(p.maneuver, key)
    return parts, [key], [p.maneuver]


def columns_exchanged(random):
    parts = _start(random)
    some = parts if random.random() < 0.5 else parts[: random.integers(1, len(parts) + 1)]
    a, b = (str(k) for k in random.choice(list(parts[0].hi), 2, replace=False))
    for p in some:
        p.hi[a], p.hi[b] = p.hi[b], p.hi[a]
        p.lo[a], p.lo[b] = p.lo[b], p.lo[a]
    return parts, [a, b], [p.maneuver for p in some]


def maneuvers_mixed(random):
    """A column, all columns, or half of the times come from another maneuver."""
    parts = _start(random)
    p, key = _one_of(random, parts)
    other = int(random.choice([n for n in MANEUVERS if n != p.maneuver]))
    keys = [key] if random.random() < 0.5 else list(p.hi)
    rows = slice(None) if random.random() < 0.5 else slice(random.integers(len(p.time) - 1), None)
    theirs = correct(other, {k: k for k in keys}, p.time, p.time_lo)
    for one in keys:
        p.set(one, theirs.hi[one][rows], rows)
    return parts, keys, [p.maneuver]


def definitions_mixed(random):
    """The definition changes midway, or differs in one maneuver."""
    key = str(random.choice(["roll_angle", "roll_rate", "forward_speed"]))
    parts = _start(random, keys=list(EIGHT))
    a, b = (str(k) for k in random.choice(names(key), 2, replace=False))
    within = len(parts) == 1 or random.random() < 0.5
    for p in parts:
        both = correct(p.maneuver, {"a": a, "b": b}, p.time, p.time_lo)
        is_a = np.zeros(len(p.time), bool)
        if within:
            is_a[: random.integers(1, len(p.time))] = True
        else:
            is_a[:] = p is parts[0]
        p.set(key, np.where(is_a, both.hi["a"], both.hi["b"]))
    return parts, [key], None


def units_mixed(random):
    """The unit or the sign changes midway, or differs in one of several maneuvers."""
    keys = [k for k in EIGHT if len(units(k)) > 1]
    parts = _start(random, keys=keys)
    p, key = _one_of(random, parts, keys)
    factors = [float(f) for u, f in list(units(key).items())[1:]]
    signs = [-1.0, *(-f for f in factors)]
    factor = float(random.choice(factors + signs))
    whole = len(parts) > 1 and random.random() < 0.5
    i = 0 if whole else random.integers(1, len(p.time))
    j = len(p.time) if random.random() < 0.7 or whole else random.integers(i, len(p.time)) + 1
    changed = [key]
    pair = {"roll_angle": "roll_rate", "steer_angle": "steer_rate"}.get(key)
    if pair and random.random() < 0.5:
        changed.append(pair)
    for one in changed:
        p.set(one, p.hi[one][i:j] * factor, slice(i, j))
    return parts, changed, None


def wrong_unit(random):
    """A factor that is not a unit: from single precision, or a wrong power of ten."""
    parts = _start(random)
    key = _one_of(random, parts)[1]
    factor = float(random.choice([2, 0.5, 10, 0.1, 100, np.pi, 2 * np.pi, 60, 9.81, 1.01, 0.99]))
    for p in parts:
        p.set(key, p.hi[key] * factor)
    return parts, [key], [p.maneuver for p in parts]


def constant(random):
    """Never filled in: zero, the first value, or the mean, throughout or from some time on."""
    parts = _start(random)
    p, key = _one_of(random, parts)
    i = 0 if random.random() < 0.5 else random.integers(len(p.time) - 2)
    value = random.choice([0.0, p.hi[key][i], np.mean(p.hi[key]), 1.0, -99.0])
    some = parts if random.random() < 0.5 else [p]
    for q in some:
        q.set(key, float(value), slice(int(i), None))
    return parts, [key], [q.maneuver for q in some]


def few_digits(random):
    """Rounded values that are presented as exact."""
    parts = _start(random)
    digits = int(random.integers(1, 14))
    for p in parts:
        for key in p.hi:
            p.set(key, [float(f"{x:.{digits - 1}e}") for x in p.hi[key]])
    quantum = Quantum(10, digits) if random.random() < 0.5 else None
    return parts, list(parts[0].hi), [p.maneuver for p in parts], {"quantum": quantum}


def wrong_last_digits(random):
    """The values have 32 digits, but only the first ones are right."""
    parts = [correct(n, {k: k for k in EIGHT}, is_long=True) for n in MANEUVERS]
    p, key = _one_of(random, parts)
    junk = random.standard_normal(len(p.time)) * _size(random, -30, -10)
    p.lo[key] = p.lo[key] + junk * scale(p.maneuver, key)
    return parts, [key], [p.maneuver]


def energy_sum_broken(random):
    """One energy has another zero, by at least a fiftieth of the largest energy."""
    parts = _start(random, keys=list(EIGHT))
    key = str(random.choice(["potential_energy", "mechanical_energy"]))
    for p in parts:
        p.add(key, float(random.choice([-1, 1])) * random.uniform(80, 2000))
    fails = ["scd >= 6", "scd >= 2", "mechanical_energy.scd >= 3"][: 3 if "mech" in key else 2]
    return parts, [key], [p.maneuver for p in parts], {"fails": fails, "is_sized": False}


def zeros_differ(random):
    """The zero of the energies differs between maneuvers, or changes at some time."""
    parts = [correct(n, {k: k for k in EIGHT}) for n in MANEUVERS]
    i = 0 if random.random() < 0.5 else random.integers(1, 1000)
    zeros = random.permutation([-794.1195, 922.14, 300.0])
    for p, zero in zip(parts, zeros, strict=True):
        for key in ("potential_energy", "mechanical_energy"):
            p.hi[key][i:] += zero
    fails = ["scd >= 6", "potential_energy.scd >= 1", "mechanical_energy.max_rel_error < 1e-3"]
    return parts, ["potential_energy"], list(MANEUVERS), {"fails": fails, "is_sized": False}


def huge(random):
    """Huge values in one row or many."""
    parts = _start(random)
    p, key = _one_of(random, parts)
    rows = random.integers(len(p.time), size=random.choice([1, 5, 500]))
    p.hi[key][rows] = random.choice([-1, 1]) * 10.0 ** random.uniform(3, 160)
    p.lo[key][rows] = 0.0
    fails = ["scd >= 1", f"{key}.scd >= 1", f"{p.maneuver}.max_rel_error < 0.1"]
    return parts, [key], [p.maneuver], {"fails": fails, "is_sized": False}


def times_in_another_unit(random):
    parts = _start(random)
    by = float(random.choice([1000, 60, 2, 0.5, 1e-3, 1 / 60, 1.1, 100, 0.1]))
    for p in parts:
        p.time, p.time_lo = p.time * by, p.time_lo * 0.0
    return parts, list(parts[0].hi), [p.maneuver for p in parts]


def one_spike_in_many_rows(random):
    """The file has more rows than are sampled to interpret the columns, and one of
    them is wrong."""
    count = int(random.choice([8000, 15000, 30000]))
    t = np.arange(count + 1) * (END / count)
    key = str(random.choice(EIGHT))
    keys = list(EIGHT) if count < 20000 else [key]
    part = correct(int(random.choice(MANEUVERS)), {k: k for k in keys}, t, np.zeros_like(t))
    part.hi[key][random.integers(count)] += _size(random, -10, 1) * scale(part.maneuver, key)
    return [part], [key], [part.maneuver]


# Files with misleading text


def _table(random, maneuvers=MANEUVERS):
    """Return columns of text under their headings: the time, then the maneuvers' columns."""
    parts = [correct(n, {k: k for k in EIGHT}) for n in maneuvers]
    columns = [("time", [f"{i / 100:g}" for i in range(1001)])]
    columns += [
        (f"m{p.maneuver}_{k}", [repr(float(x)) for x in p.hi[k]]) for p in parts for k in EIGHT
    ]
    return parts, columns


def _without_numbers(columns):
    """Return the columns under headings without the number of the maneuver."""
    return [(name.partition("_")[2] or name, values) for name, values in columns]


def _wrong(values):
    """Return texts of values that no definition, unit or sign explains."""
    return [repr(1.3 * float(v) + 0.01) for v in values]


def _others(random):
    """Return columns without a known name, which are zero."""
    return [(f"{_word(random)}_{j}", ["0"] * 1001) for j in range(random.choice([0, 3, 120]))]


def _lines(columns):
    return [
        ",".join(row) for row in zip(*([name, *values] for name, values in columns), strict=True)
    ]


def _of_text(parts, lines, keys, fails):
    more = {"fails": fails, "is_sized": False, "text": "\n".join(lines) + "\n"}
    return parts, keys, [p.maneuver for p in parts], more


_ANY = ["scd >= 6", "scd >= 1", "max_rel_error < 0.01"]


def heading_twice(random):
    """Two columns have the same name, and one of them is wrong."""
    parts, columns = _table(random)
    name, values = columns[random.integers(1, 25)]
    wrong = [repr(float(v) + 1 + abs(float(v))) for v in values]
    columns.insert(random.integers(1, len(columns) + 1), (name, wrong))
    return _of_text(parts, _lines(columns), [name], _ANY)


def headings_exchanged(random):
    """A column has the name of another column, of the same or another maneuver."""
    parts, columns = _table(random)
    i, j = random.choice(np.arange(1, 25), 2, replace=False)
    (a, first), (b, second) = columns[i], columns[j]
    columns[i], columns[j] = (b, first), (a, second)
    fails = ["scd >= 9", "max_rel_error < 1e-9"]
    return _of_text(parts, _lines(columns), [a, b], fails)


def columns_in_another_place(random):
    """Two columns are exchanged, and there are no headings."""
    parts, columns = _table(random)
    i, j = random.choice(np.arange(0, 25), 2, replace=False)
    columns[i], columns[j] = columns[j], columns[i]
    return _of_text(parts, _lines(columns)[1:], ["any"], ["scd >= 9", "max_rel_error < 1e-9"])


def rows_commented_out(random):
    parts, columns = _table(random)
    lines = _lines(columns)
    i = random.integers(1, 930)
    j = random.integers(i + 60, 1003)
    mark = str(random.choice(["#", "%", "//", "!", "# "]))
    lines[i:j] = [mark + line for line in lines[i:j]]
    return _of_text(parts, lines, ["any"], ["coverage >= 1", "coverage >= 0.99", "gap <= 0.5"])


def a_table_after_the_table(random):
    """More rows of the same times, wrong by a little or completely."""
    parts, columns = _table(random)
    i = random.integers(1, 25)
    name, values = columns[i]
    by = 1 + _size(random, -3, 1)
    again = [*columns]
    again[i] = name, [repr(float(v) * by + 1e-3) for v in values]
    lines, more = _lines(columns), _lines(again)
    head = random.integers(2)
    first, second = (lines, more) if random.random() < 0.5 else (more, lines)
    if random.random() < 0.5:
        second = second[:head] + second[random.integers(1, 900) :]
    return _of_text(parts, first + second[1 - head :], [name], ["scd >= 9", "max_rel_error < 1e-8"])


def a_field_that_is_none(random):
    """A field is empty, a word, or missing in some rows."""
    parts, columns = _table(random)
    i = random.integers(1, 25)
    name, values = columns[i]
    values = [*values]
    word = str(random.choice(["", "nan", "--", "N/A", "NaN", "inf", "-Inf", "1e999", "*****", "x"]))
    for row in random.integers(1001, size=random.choice([1, 3, 200])):
        values[row] = word
    columns[i] = name, values
    key = name[3:]
    return _of_text(parts, _lines(columns), [name], [*_ANY, f"{name[1]}.{key}.scd >= -90"])


def cut_off(random):
    """The text ends within a line, in the last nine seconds but before the last half second."""
    parts, columns = _table(random)
    text = "\n".join(_lines(columns))
    text = text[: int(len(text) * random.uniform(0.1, 0.94))]
    return _of_text(parts, [text], ["any"], ["coverage >= 1", "coverage >= 0.99", "gap <= 0.5"])


# Files whose digits hide errors


def _wrong_motion(random, number, time, keys=EIGHT, most=0.1):
    """Return a motion that is too slow by a fraction between a tenth of `most` and `most`."""
    early = time * (1 - random.uniform(most / 10, most))
    return correct(number, {k: k for k in keys}, early, np.zeros_like(early)).hi


def times_of_one_decimal(random):
    """Exact uneven times with one decimal, which do not excuse a wrong motion."""
    tenths = np.concatenate([[0], np.cumsum(random.choice([1, 2], 100, p=[0.3, 0.7]))])
    tenths = np.append(tenths[tenths < 100], 100)
    n = int(random.choice(MANEUVERS))
    moved = _wrong_motion(random, n, tenths / 10, most=0.005)
    columns = [("time", [f"{i / 10:.1f}" for i in tenths])]
    columns += [(f"m{n}_{k}", [f"{x:.12g}" for x in moved[k]]) for k in EIGHT]
    parts = [correct(n, {k: k for k in EIGHT})]
    return _of_text(parts, _lines(columns), ["roll_angle"], ["scd >= 6"])


def digits_of_every_second_row(random):
    """Right to one decimal in some of many rows, wrong in all digits in the others."""
    n = int(random.choice(MANEUVERS))
    time = np.arange(4001) / 400
    part = correct(n, {k: k for k in EIGHT}, time, np.zeros_like(time))
    moved = _wrong_motion(random, n, time, most=0.01)
    every, first = int(random.choice([2, 3], p=[0.8, 0.2])), int(random.random() < 0.2)
    columns = [("time", [f"{t:g}" for t in time])]
    for k in EIGHT:
        some = np.arange(4001) % every != first
        texts = [
            f"{y:.12f}" if s else f"{x:.1f}"
            for s, x, y in zip(some, part.hi[k], moved[k], strict=True)
        ]
        columns.append((f"m{n}_{k}", texts))
    return _of_text([part], _lines(columns), ["roll_angle"], ["scd >= 6"])


def rows_where_rounding_is_right(random):
    """Rows of a wrong motion where it rounds to the same integers as the right one."""
    n = int(random.choice(MANEUVERS))
    part = correct(n, {"roll_angle": "roll_angle"})
    moved = _wrong_motion(random, n, part.time, ["roll_angle"], most=0.02)
    per_radian = 180 / np.pi * float(random.choice([1, 10, 100]))
    right, wrong = (np.rint(x["roll_angle"] * per_radian) for x in (part.hi, moved))
    same = right == wrong
    form = str(random.choice(["{:.2f}", "{:.17e}"]))
    texts = [form.format(x) for x in right[same] / per_radian * 180 / np.pi]
    columns = [("time", [f"{i / 100:g}" for i in np.flatnonzero(same)])]
    columns.append((f"m{n}_roll_angle_deg", texts))
    return _of_text([part], _lines(columns), ["roll_angle"], ["scd >= 6"])


def rows_at_whole_numbers(random):
    """A column at the times when it is an integer: one digit, and no error."""
    n = int(random.choice(MANEUVERS))
    m = references()[0][n]
    unit = float(random.choice([1.0, 0.5, 0.1, 0.01])) * np.pi / 180
    steps = m.rows["roll_angle"] / unit
    rows = np.flatnonzero(np.floor(steps[1:]) != np.floor(steps[:-1]))
    low, high = m.time[rows].copy(), m.time[rows + 1].copy()
    whole = np.maximum(np.floor(steps[rows]), np.floor(steps[rows + 1]))
    rises = steps[rows + 1] > steps[rows]
    for _ in range(60):
        middle = (low + high) / 2
        above = truth(n, ["roll_angle"], middle, 0 * middle)["roll_angle"][0] / unit > whole
        low, high = np.where(above == rises, low, middle), np.where(above == rises, middle, high)
    written = whole * unit * 180 / np.pi
    form = str(random.choice(["{:.2f}", "{:.12f}"]))
    lines = ["time,roll_angle_deg", "0,0"]
    lines += [f"{t!r},{form.format(x)}" for t, x in zip(high.tolist(), written, strict=True)]
    part = correct(n, {"roll_angle": "roll_angle"})
    return _of_text([part], lines, ["roll_angle"], ["scd >= 6"])


def _second_of(random, columns):
    """Return which column has a duplicate: its index, its key, and its heading.

    The headings of all columns contain the number of the maneuver, or none does.
    """
    if random.random() < 0.5:
        columns[:] = _without_numbers(columns)
    i = random.integers(1, 9)
    heading = columns[i][0]
    return i, EIGHT[i - 1], heading


def another_column_beside(random):
    """A second, wrong column of the same quantity with a name of its own."""
    parts, columns = _table(random, (int(random.choice(MANEUVERS)),))
    i, name, heading = _second_of(random, columns)
    wrong = _wrong(columns[i][1])
    unit = COMPARED[name][0].unit
    behind = ["2", "_2", "_3", ".1", "*", "#2", f" [{unit}]", f" [m{unit.partition(' ')[0]}]"]
    columns.insert(random.integers(1, 10), (f"{heading}{random.choice(behind)}", wrong))
    return _of_text(parts, _lines(columns), [name], ["scd >= 6", f"{name}.scd >= 6"])


def a_long_name_beside(random):
    """A second, wrong column of the same quantity with a very long name."""
    parts, columns = _table(random, (int(random.choice(MANEUVERS)),))
    i, name, heading = _second_of(random, columns)
    wrong = _wrong(columns[i][1])
    about = " ".join(random.choice(_REMARKS, random.integers(1, 30)))
    second = f'"{heading} ({about}) {random.integers(2, 100)}"'
    columns = [*columns, *_others(random)]
    columns.insert(random.integers(1, len(columns) + 1), (second, wrong))
    return _of_text(parts, _lines(columns), [name], ["scd >= 6", f"{name}.scd >= 6"])


def a_name_not_understood(random):
    """The only column of a quantity is wrong, and its name merely contains the known one."""
    parts, columns, keys = _wrong_under_other_names(random, _around)
    columns = [columns[0], *_others(random), *columns[1:]]
    key = keys[-1]
    return _of_text(parts, _lines(columns), [key], ["scd >= 6", f"{key}.scd >= 6"])


def _wrong_under_other_names(random, rename):
    """Return the table of one maneuver with 1 to 3 wrong columns, and the keys of these.

    The headings have no number. `rename` draws another name for each wrong column.
    """
    parts, columns = _table(random, (int(random.choice(MANEUVERS)),))
    columns, keys = _without_numbers(columns), []
    for i in random.choice(np.arange(1, 9), random.integers(1, 4), replace=False):
        key, values = columns[i]
        columns[i] = f'"{rename(random, key)}"', _wrong(values)
        keys.append(key)
    return parts, columns, keys


def under_a_path_in_a_unit(random):
    """One column is wrong, and all names have a path in front and a unit behind."""
    parts, columns = _table(random, (int(random.choice(MANEUVERS)),))
    keys = [name.partition("_")[2] for name, _ in columns[1:]]
    path, i = str(random.choice(_PATHS_READ)), random.integers(8)
    named = []
    for key, (_, values) in zip(keys, columns[1:], strict=True):
        ways = _UNITS_READ[COMPARED[key][0].unit]
        unit, factor = ways[random.integers(len(ways))]
        # A constant change of an energy would be read as a different zero, so the factor varies.
        off_by = np.linspace(1.3, 1.5, 1001) if key == keys[i] else np.ones(1001)
        held = factor * off_by * np.array(values, float)
        named.append((f'"{path}{key}{unit}"', [repr(x) for x in held.tolist()]))
    some = [named[j] for j in random.permutation(8) if j == i or random.random() < 0.8]
    lines = _lines([(f'"{path}time"', columns[0][1]), *some])
    return _of_text(parts, lines, [keys[i]], ["scd >= 6", f"{keys[i]}.scd >= 6"])


def a_maneuver_that_is_none(random):
    """The columns of one quantity are wrong, and named for nonexistent maneuvers."""
    parts, columns = _table(random)
    key = str(random.choice(EIGHT))
    own = [i for i, (name, _) in enumerate(columns) if name.endswith(key)]
    for i in own if random.random() < 0.5 else random.choice(own, 1):
        name, values = columns[i]
        number = random.integers(4, 100)
        ways = [f"m{number}_{key}", f"maneuver {number} {key}", f"{name}_{number}"]
        columns[i] = random.choice(ways), _wrong(values)
    return _of_text(parts, _lines(columns), [key], ["scd >= 6", f"{key}.scd >= 6"])


_REMARKS = (
    "rear",
    "frame",
    "measured",
    "about",
    "its",
    "x",
    "axis",
    "of",
    "the",
    "body",
    "filtered",
)
_PATHS = ("field.", "bike.", "/bike/state/", "out:", "msg.data.", "Model|rear|", "state_", "raw ")
_UNITS_NOT_KNOWN = (
    " [\u00ba/s]",
    " [\ufffd]",
    " [?]",
    " {SI units}",
    " (see manual)",
    "[",
    "_meas",
    " #",
)


# Prefixes that are recognised in front of names, and units that are recognised after them.
_PATHS_READ = ("field.", "bike.", "/bike/state/", "bicycle/", "model.bike.", "")
_UNITS_READ = {
    "rad": [(" [rad]", 1.0), (" [deg]", 180 / np.pi), (" [\u00ba]", 180 / np.pi), ("", 1.0)],
    "rad s-1": [
        (" [rad/s]", 1.0), (" [\u00ba/s]", 180 / np.pi), (" [\u00c2\u00b0/s]", 180 / np.pi),
        (" [\u02da/s]", 180 / np.pi), (" [rpm]", 30 / np.pi), ("", 1.0),
    ],
    "m s-1": [(" [m/s]", 1.0), (" [km/h]", 3.6), (" [mph]", 3600 / 1609.344), ("", 1.0)],
    "J": [(" [J]", 1.0), (" [kJ]", 1e-3), ("", 1.0)],
}  # fmt: skip


def _word(random):
    return "".join(random.choice(list("bcdfghjklmnqrswxyz"), random.integers(3, 60)))


def _around(random, name):
    """Return a known name with additions before it, after it, or both."""
    words = random.choice([name, name.title().replace("_", ""), name.replace("_", " ")])
    before = random.choice(_PATHS) if random.random() < 0.7 else f"{_word(random)}."
    behind = random.choice(_UNITS_NOT_KNOWN) if random.random() < 0.7 else f"_{_word(random)}"
    return random.choice([before + words, words + behind, before + words + behind])


def energy_that_is_bought(random):
    """Eq. (1) of an energy that is not that of the motion: constant, far zero, few digits."""
    n = int(random.choice(MANEUVERS))
    part = correct(n, {k: k for k in EIGHT})
    moved = _wrong_motion(random, n, part.time)
    has_parts = random.random() < 0.6
    if has_parts and random.random() < 0.5:
        drift = 1 + 10 ** random.uniform(-4, -2) * part.time / END
        for k in ("potential_energy", "kinetic_energy"):
            moved[k] = moved[k] * drift
    own = moved["potential_energy"] + moved["kinetic_energy"]
    far = random.choice([-1, 1]) * 10 ** random.uniform(-1, 3.5)
    kinds = [np.full(1001, own[0] + far), own + 1e6, np.rint(own / 10) * 10, np.full(1001, far)]
    energy = kinds[random.integers(len(kinds))]
    keys = EIGHT if has_parts else [k for k in EIGHT if k[:3] not in ("pot", "kin")]
    columns = [("time", [f"{i / 100:g}" for i in range(1001)])]
    values = {**moved, "mechanical_energy": energy}
    columns += [(f"m{n}_{k}", [f"{x:.12g}" for x in values[k]]) for k in keys]
    fails = [f"{n}.performance < 1e-3", "scd >= 6"]
    return _of_text([part], _lines(columns), ["mechanical_energy"], fails)


def energy_from_far_away(random):
    """Eq. (1) of a varying energy, divided by a first value that is far too large."""
    n = int(random.choice(MANEUVERS))
    part = correct(n, {k: k for k in EIGHT})
    moves = 10 ** random.uniform(0.5, 2) * np.sin(random.uniform(1, 5) * part.time)
    part.hi["potential_energy"] += random.choice([-1, 1]) * 10 ** random.uniform(5, 10) + moves
    part.set("mechanical_energy", part.hi["potential_energy"] + part.hi["kinetic_energy"])
    if random.random() < 0.5:
        del part.hi["mechanical_energy"], part.lo["mechanical_energy"]
    fails = [f"{n}.performance < 1e-3", "scd >= 6"]
    return [part], ["potential_energy"], [n], {"fails": fails, "is_sized": False}


def energy_of_coarse_parts(random):
    """Eq. (1) of a constant, with parts so coarse that it might be their sum."""
    n = int(random.choice(MANEUVERS))
    part = correct(n, {k: k for k in EIGHT})
    moved = _wrong_motion(random, n, part.time)
    own = moved["potential_energy"] + moved["kinetic_energy"]
    moved["kinetic_energy"] = moved["kinetic_energy"] + random.uniform(1, 4) * part.time / END
    off = random.choice([-1, 1]) * random.uniform(0.5, 1.5)
    moved["mechanical_energy"] = np.full_like(own, own[0] + off)
    digits = {"potential_energy": 3, "kinetic_energy": 4}
    columns = [("time", [f"{i / 100:g}" for i in range(1001)])]
    columns += [(f"m{n}_{k}", [f"{x:.{digits.get(k, 12)}g}" for x in moved[k]]) for k in EIGHT]
    fails = [f"{n}.performance < 1e-3", "scd >= 6"]
    return _of_text([part], _lines(columns), ["mechanical_energy"], fails)


def zero_of_one_energy(random):
    """A small constant is added to one of the energies, and none or another to the other."""
    parts = _start(random, keys=list(EIGHT))
    first, second = random.permutation(["potential_energy", "mechanical_energy"])
    zero = float(random.choice([-1, 1])) * 10 ** random.uniform(0.5, 2)
    for p in parts:
        p.add(str(first), zero)
        if random.random() < 0.5:
            p.add(str(second), zero * random.uniform(-1, 0.5))
    fails = ["scd >= 6", "scd >= 4", "max_rel_error < 1e-4"]
    return parts, [str(first)], [p.maneuver for p in parts], {"fails": fails, "is_sized": False}


def zero_that_moves(random):
    """The zero of both energies changes in the second half or the next maneuver."""
    parts = [correct(n, {k: k for k in EIGHT}) for n in MANEUVERS]
    zero = float(random.choice([-1, 1])) * 10 ** random.uniform(0.5, 3)
    other = zero * (1 + random.choice([-1, 1]) * 10 ** random.uniform(-2, 0.5))
    i = random.integers(0, 1000)
    for p in parts:
        for key in ("potential_energy", "mechanical_energy"):
            p.hi[key] += zero
            if p is parts[-1]:
                p.hi[key][i:] += other - zero
    fails = ["scd >= 6"]
    return parts, ["potential_energy"], [3], {"fails": fails, "is_sized": False}


def energy_of_any_zero(random):
    """A mechanical energy without the potential one: a constant far from the true one."""
    keys = [k for k in EIGHT if k != "potential_energy"]
    if random.random() < 0.5:
        keys.remove("kinetic_energy")
    n = int(random.choice(MANEUVERS))
    part = correct(n, {k: k for k in keys})
    far = float(random.choice([-1, 1])) * 10 ** random.uniform(0, 6)
    if random.random() < 0.5:
        part.set("mechanical_energy", part.hi["mechanical_energy"][0])
    part.hi["mechanical_energy"] += far
    fails = [f"{n}.performance < 1e-3"]
    return [part], ["mechanical_energy"], [n], {"fails": fails, "is_sized": False}


def speed_of_no_point(random):
    """A mean of two definitions is not right, however near it is to one of them."""
    parts = _start(random, keys=list(EIGHT))
    key = str(random.choice(["roll_angle", "roll_rate", "forward_speed"]))
    a, b = (str(k) for k in random.choice(names(key), 2, replace=False))
    weight = random.uniform(0.1, 0.9)
    for p in parts:
        both = correct(p.maneuver, {"a": a, "b": b}, p.time, p.time_lo)
        p.set(key, weight * both.hi["a"] + (1 - weight) * both.hi["b"])
    return parts, [key], [p.maneuver for p in parts]


# Files with faults that have no size


def rows_dropped(random):
    """Missing rows: a gap, an early end, a late start, or only a handful of rows."""
    parts = _start(random)
    p = parts[random.integers(len(parts))]
    t = p.time
    how = random.integers(5)
    if how == 0:
        a = random.uniform(0, 9.2)
        keep = (t < a) | (t > a + random.uniform(0.6, 10))
    elif how == 1:
        keep = t < random.uniform(0.02, 9.4)
    elif how == 2:
        keep = t > random.uniform(0.6, 9.95)
    elif how == 3:
        keep = (t < random.uniform(0, 9.3)) | (t == t[-1])
    else:
        keep = np.zeros(len(t), bool)
        keep[random.choice(len(t), random.integers(2, 9), replace=False)] = True
    keep[0] |= not keep.any()
    p.pick(np.flatnonzero(keep))
    return parts, list(p.hi), [p.maneuver], {"is_sized": False}


# In this kind of file, the values that are present are right. Nothing is known about the values
# that are missing.


def columns_missing(random):
    """The file has some of the eight columns, or only a constant energy, which proves no motion."""
    keys = [str(k) for k in random.choice(EIGHT, random.integers(1, 8), replace=False)]
    parts = _start(random, keys=["mechanical_energy"] if random.random() < 0.2 else keys)
    return _right_in_part(random, parts, f"columns >= {len(parts[0].hi) + 1}")


def few_rows(random):
    """There are so few rows that a wrong motion may have the same values at their times."""
    parts = _start(random, keys=list(EIGHT) if random.random() < 0.7 else None)
    count = random.integers(2, 12)
    for p in parts:
        last = len(p.time) - 1
        even = np.unique(np.linspace(0, last, count).astype(int))
        drawn = np.sort(random.choice(last + 1, count, replace=False))
        p.pick(even if random.random() < 0.5 else drawn)
    return _right_in_part(random, parts, "coverage >= 0.99")


def rows_where_motions_cross(random):
    """Rows only at the zeros of a wrong motion's error."""
    apart = random.uniform(0.26, 0.6)
    t = np.round(np.arange(random.uniform(0, 0.1), END, apart), 3)
    parts = _start(random, keys=list(EIGHT), grid=lambda _: (t, np.zeros_like(t)))
    return _right_in_part(random, parts, "coverage >= 0.99")


def _right_in_part(random, parts, amount):
    p, key = _one_of(random, parts)
    n = p.maneuver
    fails = ["scd >= 6", "scd >= -90", f"{n}.{key}.scd >= 1", f"{key}.max_abs_error < 1e9", amount]
    fails.append(f"{n}.gap <= 10")
    return parts, [key], [n], {"fails": fails, "is_sized": False}


def an_odd_name(random):
    """Columns are wrong under names that are misspelt, path segments, or derivatives."""
    parts, columns, _ = _wrong_under_other_names(random, _odd)
    kept = [
        columns[j]
        for j in sorted(random.choice(np.arange(1, 9), random.integers(5, 9), replace=False))
    ]
    others = _others(random)
    if all('"' not in name for name, _ in kept):
        kept = columns[1:]
    name = next(name for name, _ in kept if '"' in name)
    key = EIGHT[[x for x, _ in columns[1:]].index(name)]
    return _of_text(parts, _lines([columns[0], *others, *kept]), [key],
                    ["scd >= 6", f"{key}.scd >= 6"])  # fmt: skip


def _odd(random, name):
    letters = list(name)
    i = int(random.integers(1, len(letters) - 1))
    how = random.integers(5)
    if how == 0:
        letters[i], letters[i - 1] = letters[i - 1], letters[i]
        return "".join(letters)
    if how == 1:
        return "".join(letters[:i] + letters[i + 1 :])
    short = {"roll_angle": "phi", "roll_rate": "phi", "forward_speed": "v", "steer_angle": "delta",
             "steer_rate": "delta"}.get(name, name[0].upper())  # fmt: skip
    if how == 2:
        return f"{_word(random)}.{short}"
    if how == 3:
        return f".bicycle.{name.split('_')[-1]}.{random.choice(['Q', 'x', 'value_1'])}"
    return str(random.choice([
        f"D({short})", f"{short}\u02cdt(t)", f"Differential(t)({short}(t))", f"der_{short}_{i}",
    ]))  # fmt: skip


def no_numbers(random):
    """Values are NaN, infinite or huge, in one row or in many."""
    parts = _start(random)
    p, key = _one_of(random, parts)
    n = len(p.time)
    i = random.integers(n)
    rows = [slice(i, i + 1), slice(i, None), slice(None, i + 1), random.integers(n, size=5)]
    value = float(random.choice([np.nan, np.inf, -np.inf, 1e200, -1e300]))
    p.set(key, value, rows[random.integers(4)])
    n = p.maneuver
    fails = [f"{n}.{key}.scd >= -90", f"{key}.max_abs_error < 1e9", "scd >= 1",
             f"{n}.time_to_tolerance >= 0"]  # fmt: skip
    if key == "mechanical_energy":
        fails += [f"{n}.performance < 1e9", "performance < 1e9"]
    return parts, [key], [n], {"fails": fails, "is_sized": False}


def rate_against_angle(random):
    """An angle or its rate has the opposite sign, in every maneuver."""
    parts = _start(random, keys=list(EIGHT))
    which = random.integers(2)
    key = str(random.choice([ANGLES[which], RATES[which]]))
    for p in parts:
        p.hi[key], p.lo[key] = -p.hi[key], -p.lo[key]
    fails = ["scd >= 1", f"{ANGLES[which]}.scd >= 1", f"{RATES[which]}.max_abs_error < 1e9",
             f"{parts[0].maneuver}.{key}.scd >= 1", "max_abs_error < 1e9"]  # fmt: skip
    return parts, [key], [p.maneuver for p in parts], {"fails": fails, "is_sized": False}


def motion_parts(random, chosen, *, eight=0.3, time=(None, None)):
    count = random.choice([1, 3], p=[0.7, 0.3])
    maneuvers = sorted(random.choice(MANEUVERS, count, replace=False).tolist())
    keys = [*(EIGHT if random.random() < eight else ()), *chosen]
    return [correct(n, {k: k for k in keys}, *time) for n in maneuvers]


def matrix(end):
    return [f"{end}_frame_r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]


def quaternion(end):
    return [f"{end}_frame_q{i}" for i in range(4)]


def motion_moved(random):
    chosen = [str(k) for k in random.choice(MOTION, random.integers(1, 9), replace=False)]
    parts = motion_parts(random, chosen)
    p, key = _one_of(random, parts, chosen)
    shape = SHAPES[random.integers(len(SHAPES))]
    p.add(key, shape(random, p.time, len(p.time)) * _size(random, -12, 2) * scale(p.maneuver, key))
    return parts, [key], [p.maneuver]


def motion_midway(random):
    """Values are flipped, in another unit, from another maneuver, or constant, from
    some time on."""
    chosen = [str(k) for k in random.choice(MOTION, random.integers(1, 6), replace=False)]
    if random.random() < 0.3:
        chosen = quaternion(str(random.choice(["rear", "front"])))
    parts = motion_parts(random, chosen)
    p, key = _one_of(random, parts, chosen)
    rows = slice(random.integers(1, len(p.time)), None)
    other = correct(p.maneuver % 3 + 1, {key: key}).hi[key]
    new = [-p.hi[key], 1000 * p.hi[key], other, np.full_like(other, p.hi[key][0])]
    changed = chosen if len(chosen) == 4 and chosen[0].endswith("q0") else [key]
    if len(changed) > 1 and random.random() < 0.5:
        # From the middle on, -q replaces q: the same rotation, but the numbers jump.
        for one in changed:
            p.set(one, -p.hi[one][rows], rows)
    else:
        p.set(key, new[random.integers(4)][rows], rows)
    return parts, changed, [p.maneuver]


def motion_exchanged(random):
    a, b = (str(k) for k in random.choice(MOTION, 2, replace=False))
    parts = motion_parts(random, [a, b])
    for p in parts:
        p.hi[a], p.hi[b] = p.hi[b], p.hi[a]
    return parts, [a, b], [p.maneuver for p in parts]


def motion_between_rows(random):
    """The values between the rows of the reference are random."""
    chosen = [str(k) for k in random.choice(MOTION, random.integers(1, 4), replace=False)]
    t = np.arange(2001) / 200
    parts = motion_parts(random, chosen, eight=0, time=(t, np.zeros_like(t)))
    key = str(random.choice(chosen))
    p = parts[random.integers(len(parts))]
    junk = _size(random, 0, 6) * (1 + scale(p.maneuver, key))
    rows = slice(1, None, 2) if random.random() < 0.5 else slice(1999, 2000)
    p.set(key, random.choice([-1, 1]) * junk * random.uniform(2, 3, 2001)[rows], rows)
    n = p.maneuver
    fails = ["scd >= 1", f"{n}.{key}.scd >= 1", f"{key}.max_rel_error < 0.5"]
    return parts, [key], [n], {"fails": fails, "is_sized": False}


def improper_matrix(random):
    """A matrix with the signs of a row, a column or one entry flipped, so that it is
    no rotation."""
    end = str(random.choice(["rear", "front"]))
    chosen = matrix(end)
    parts = motion_parts(random, chosen)
    i = random.integers(3)
    sets = [chosen[3 * i : 3 * i + 3], chosen[i::3], [chosen[random.integers(9)]], chosen]
    turned = sets[random.integers(4)]
    for p in parts:
        for key in turned:
            p.hi[key] = -p.hi[key]
    fails = ["scd >= 1", f"{turned[0]}.scd >= 1", f"{turned[-1]}.max_abs_error < 100"]
    return parts, turned, [p.maneuver for p in parts], {"fails": fails, "is_sized": False}


def quaternion_of_no_turn(random):
    """An odd number of signs is flipped, which gives neither q nor its inverse in any axes."""
    end = str(random.choice(["rear", "front"]))
    chosen = quaternion(end)
    parts = motion_parts(random, chosen)
    turned = [chosen[random.integers(1, 4)]]
    for p in parts:
        for key in turned:
            p.hi[key] = -p.hi[key]
    fails = ["scd >= 1", f"{turned[0]}.scd >= 1"]
    return parts, turned, [p.maneuver for p in parts], {"fails": fails, "is_sized": False}


def quaternion_of_another_length(random):
    end = str(random.choice(["rear", "front"]))
    chosen = quaternion(end)
    parts = motion_parts(random, chosen)
    p = parts[random.integers(len(parts))]
    by = _size(random, -10, 0.5)
    for key in chosen:
        p.add(key, by * p.hi[key])
    return parts, chosen, [p.maneuver]


# Pairs of columns that can only be flipped together, because they refer to the same axis or the
# same bodies.
TIED = (
    ("rear_normal_force", "front_normal_force"), ("rear_lateral_force", "front_lateral_force"),
    ("rear_longitudinal_force", "front_longitudinal_force"), ("yaw", "yaw_rate"),
    ("rear_wheel_angle", "front_wheel_angle"), ("rear_wheel_omega_y", "front_wheel_omega_y"),
    ("rear_contact_x", "front_contact_x"), ("rear_contact_y", "front_contact_y"),
    ("rear_hub_x", "com_x"), ("rear_hub_y", "front_contact_y"), ("rear_hub_z", "front_hub_z"),
    ("com_z", "front_frame_com_z"), ("rear_frame_com_z", "rear_hub_z"),
    ("com_y", "rear_frame_com_y"), ("rear_wheel_angle", "rear_wheel_omega_y"),
    ("front_wheel_angle", "front_wheel_omega_y"),
)  # fmt: skip
UNTURNED = ("rear_friction", "front_friction", "potential_energy", "kinetic_energy")


def signs_against_each_other(random):
    pair = TIED[random.integers(len(TIED))]
    parts = motion_parts(random, pair)
    key = str(random.choice(pair))
    for p in parts:
        p.hi[key] = -p.hi[key]
    fails = ["scd >= 1", f"{pair[0]}.scd >= 1", f"{pair[1]}.scd >= 1", f"{key}.mescd >= -9"]
    return parts, list(pair), [p.maneuver for p in parts], {"fails": fails, "is_sized": False}


def sign_that_is_none(random):
    """A friction demand or a kinetic energy with the opposite sign, which is impossible."""
    key = str(random.choice(UNTURNED))
    parts = motion_parts(random, [key] if key in MOTION else [], eight=0.0 if key in MOTION else 1)
    for p in parts:
        p.hi[key] = -p.hi[key]
    fails = ["scd >= 1", f"{key}.scd >= 1"]
    return parts, [key], [p.maneuver for p in parts], {"fails": fails, "is_sized": False}


KINDS = {
    **{f.__name__: (lambda random, f=f: _moved(random, f)) for f in SHAPES},
    **{f.__name__: f for f in (
        scaled, every_column_moved, stretch_between_rows, rows_shifted, times_shifted,
        times_stretched, times_outside, permuted, repeated_with_another_value, columns_exchanged,
        maneuvers_mixed, definitions_mixed, units_mixed, wrong_unit, constant, few_digits,
        wrong_last_digits, energy_sum_broken, rows_dropped, no_numbers, rate_against_angle,
        motion_moved, motion_midway, motion_exchanged, motion_between_rows, improper_matrix,
        quaternion_of_no_turn, quaternion_of_another_length, signs_against_each_other,
        sign_that_is_none, zeros_differ, huge, times_in_another_unit, one_spike_in_many_rows,
        heading_twice, headings_exchanged, columns_in_another_place, rows_commented_out,
        a_table_after_the_table, a_field_that_is_none, cut_off, times_of_one_decimal,
        digits_of_every_second_row, rows_where_rounding_is_right, rows_at_whole_numbers,
        another_column_beside, a_long_name_beside, a_name_not_understood,
        under_a_path_in_a_unit, a_maneuver_that_is_none, energy_that_is_bought,
        zero_of_one_energy, zero_that_moves, energy_of_any_zero, speed_of_no_point,
        energy_from_far_away, energy_of_coarse_parts, columns_missing, few_rows,
        rows_where_motions_cross, an_odd_name,
    )},
}  # fmt: skip


def wrong_file(seed, number):
    """Return the wrong file of this number, which never changes and fails a requirement."""
    random = np.random.default_rng([seed, number])
    kinds = list(KINDS)
    kind = kinds[number % len(kinds)]
    while True:
        parts, keys, maneuvers, *more = KINDS[kind](random)
        found = Wrong(kind, parts, keys, maneuvers, **(more[0] if more else {}))
        known = Truth(parts)
        if found.text:
            return found
        found.fails += _gaps_not_met(random, found, known)
        if found.is_sized:
            found.fails += _sizes_not_met(random, found, known)
        if found.fails:
            return found


def _gaps_not_met(random, wrong, known):
    """Return unmet requirements on rows: gaps longer than any segment of the reference."""
    fails = []
    for n in known.parts:
        gaps = known.gaps(n)
        longest = float(np.max(np.diff(references()[0][n].breaks)))
        unseen = float(np.sum(gaps[gaps > longest * 1.02]))
        if unseen > 0.1:
            gap, seen = 0.95 * gaps.max(), 1 - 0.9 * unseen / END
            fails += ["coverage >= 1", "coverage >= 0.99", f"{n}.coverage >= {seen:.6f}"]
            fails += [f"gap <= {gap:.6f}", f"{n}.gap < {gap:.6f}"]
    return fails


_METRICS = ("scd", "mescd", "max_abs_error", "rms_error", "max_rel_error", "time_to_tolerance")


def _sizes_not_met(random, wrong, known):
    """Return requirements that no reading fulfils, on the whole file or the changed part."""
    fails = []
    is_long = any(v.any() for p in wrong.parts for v in p.lo.values())
    scopes = [(None, None)]
    key = str(random.choice(wrong.keys))
    scopes.append((None, key))
    if wrong.maneuvers:
        n = int(random.choice(wrong.maneuvers))
        scopes += [(n, None), (n, key)]
    for n, k in scopes:
        at = "".join(f"{x}." for x in (n, k) if x is not None)
        metrics = ["scd", *random.choice(_METRICS[1:], 2, replace=False)]
        for metric in metrics:
            keys = None if k is None else [k]
            bound = known.bound(metric, None if n is None else [n], keys)
            fails += _stricter(random, at, str(metric), float(bound), is_long)
        if k in (None, "mechanical_energy") and "mechanical_energy" in wrong.keys and n:
            bound = known.performance(n)
            if np.isfinite(bound) and bound > 1e-9:
                fails.append(f"{n}.performance < {0.98 * bound:.9e}")
    return fails


def _stricter(random, at, metric, bound, is_long):
    if metric in ("scd", "mescd"):
        # Above this limit, the score depends on how times are read, so a requirement that must fail
        # cannot be named.
        if bound > (29.9 if is_long else 15.4):
            return []
        digits = [x for x in (6, 12) if x > bound + 0.02]
        asked = f"{bound + 0.02:.6f}" if not digits or random.random() < 0.6 else str(digits[0])
        return [f"{at}{metric} >= {asked}"]
    if metric == "time_to_tolerance":
        return [f"{at}{metric} >= {bound + 1e-6:.9f}"] if np.isfinite(bound) else []
    if not (1e-28 if is_long else 1e-12) < bound < 1e200:
        return []
    return [f"{at}{metric} {random.choice(['<', '<='])} {0.98 * bound:.9e}"]
