"""Write parts of a game as files of various programs, and return what these files contain."""

import gzip
from decimal import Decimal

import h5py
import numpy as np
from scipy.io import savemat

from games.files import EIGHT, Part, decimal_times, written
from heyoka_bike import read_results

TEXTS = ("text", "csv", "semicolons", "text.gz", "long", "below", "timetable")
ARRAYS = ("npz", "mat", "hdf5", "array", "npy", "cells")
# These forms mix numbers and words in a row. Such texts are read up to 2 MiB.
AMONG_WORDS = ("long", "below", "timetable")
MOST_AMONG_WORDS = 2**21 // 80
# Kinds of text: with exponents such as 1.5*^-3, with dates as times, and with a name in front of
# each row.
KINDS = ("Mathematica", "clock", "upright")
NEEDS_ALL = ("array", "npy", "cells")
# Names used in vehicle simulation; the values show the meaning of u, p and theta.
VEHICLES = {
    "roll_angle": ("phi", "theta"), "roll_rate": ("p", "rolld"), "forward_speed": ("u", "vx"),
    "steer_angle": ("delta", "steer"), "steer_rate": ("deltad", "steerd"),
    "potential_energy": ("V", "Epot"), "kinetic_energy": ("T", "Ekin"),
}  # fmt: skip


def headings(random, parts):
    """Return names of columns in any order, numbered if there are several maneuvers."""
    style = random.integers(4 if len(parts) == 1 else 3)
    if style == 3:
        return vehicle_headings(random, parts[0])
    found = []
    for p in parts:
        n = p.maneuver
        found += [(p, k, (f"m{n}_{k}", f"{k}_{n}", f"maneuver_{n}_{k}")[style]) for k in p.hi]
    return [found[i] for i in random.permutation(len(found))]


def vehicle_headings(random, part):
    """Return short names in any order; theta is the roll angle if there is no pitch."""
    found = []
    for key in part.hi:
        names = VEHICLES.get(key, (key,))
        names = names[:1] if "pitch" in part.hi else names
        name = str(random.choice(names))
        # T is the kinetic energy. In a file without a mechanical energy, a column T could also be a
        # torque or a temperature, and is rejected. Then use the other name of the kinetic energy.
        is_told = "mechanical_energy" in part.hi
        found.append((part, key, names[-1] if name == "T" and not is_told else name))
    return [found[i] for i in random.permutation(len(found))]


def is_plain(parts):
    """Return whether the parts are the benchmark's columns in order, of one or all maneuvers."""
    numbers = [p.maneuver for p in parts]
    return all(tuple(p.hi) == EIGHT for p in parts) and (len(parts) == 1 or numbers == [1, 2, 3])


def write(random, parts, path, form, digits=17):
    """Write parts that share their times; return what to read, and the parts as written.

    Text of at most 17 digits represents binary64; longer text represents hi + lo. Binary files
    contain hi.
    """
    folder = path.parent
    if form in TEXTS:
        return _text(random, parts, folder / f"{path.name}.txt", form, digits)
    said = [Part(p.maneuver, p.time, p.time_lo, p.hi,
                 {k: np.zeros_like(v) for k, v in p.hi.items()}) for p in parts]  # fmt: skip
    arrays = {name: p.hi[k] for p, k, name in headings(random, parts)}
    time = parts[0].time
    if form == "npz":
        file = folder / f"{path.name}.npz"
        np.savez(file, time=time, **arrays)
    elif form == "mat":
        file = folder / f"{path.name}.mat"
        savemat(file, {"time": time, **arrays}, oned_as=str(random.choice(["row", "column"])))
    elif form == "hdf5":
        file = folder / f"{path.name}.h5"
        with h5py.File(file, "w") as f:
            for p in parts:
                group = f.create_group(f"maneuver_{p.maneuver}")
                group["time"] = p.time
                for k, v in p.hi.items():
                    group[k] = v
    elif form == "cells":
        file, held = folder / f"{path.name}.mat", np.empty(len(parts), dtype=object)
        held[:] = [np.column_stack([time, *(p.hi[k] for k in EIGHT)]) for p in parts]
        savemat(file, {"results": held if len(parts) > 1 else held[0]})
    else:
        table = np.column_stack([time, *(p.hi[k] for p in parts for k in EIGHT)])
        if form == "array":
            return table, said
        file = folder / f"{path.name}.npy"
        np.save(file, table)
    return file, said


def _text(random, parts, file, form, digits):
    time = [repr(float(t)) for t in parts[0].time]
    hi, lo = decimal_times(parts[0].time)
    said = {p.maneuver: Part(p.maneuver, hi, lo, is_rounded=digits < 17) for p in parts}
    columns, heads = [time], ["time"]
    if form in ("long", "below"):
        return _by_rows(parts, said, file, form, time, digits), list(said.values())
    plain = form != "timetable" and is_plain(parts) and random.random() < 0.5
    order = [(p, k, k) for p in parts for k in EIGHT] if plain else headings(random, parts)
    for p, k, name in order:
        texts, h, rest = written(p.hi[k], p.lo[k] * (digits > 17), digits)
        columns.append(texts)
        heads.append(name)
        said[p.maneuver].hi[k], said[p.maneuver].lo[k] = h, rest
    sep = {"csv": ",", "timetable": ",", "semicolons": ";"}.get(
        form, str(random.choice([" ", "\t", "  "]))
    )
    if form == "timetable":
        columns[0] = [f"{t} sec" for t in time]
    if form == "semicolons":
        columns = [[t.replace(".", ",") for t in c] for c in columns]
    # Draw from a separate generator, so that the other files of the game do not change.
    apart = random.spawn(1)[0]
    kind = str(apart.choice(KINDS)) if apart.random() < 0.2 and form != "timetable" else ""
    if kind == "Mathematica":
        columns = [[t.replace("e", "*^") for t in c] for c in columns]
    is_short = len(time) * len(columns) < MOST_AMONG_WORDS and not plain
    if kind == "clock" and is_short:
        point = "," if form == "semicolons" else "."
        whole = [f"{Decimal(t):f}".partition(".") for t in time]
        columns[0] = [f"2024-01-05T12:00:{s:0>2}{point * bool(x)}{x}" for s, _, x in whole]
    lines = [sep.join(row) for row in zip(*columns, strict=True)]
    if kind == "upright" and is_short:
        lines = [sep.join(row) for row in zip(heads, *zip(*columns, strict=True), strict=True)]
    elif not plain:
        mark = "# " if form == "text" and random.random() < 0.3 else ""
        lines.insert(0, mark + sep.join(heads))
    text = ("\r\n" if random.random() < 0.2 else "\n").join(lines) + "\n"
    if form == "text.gz":
        file = file.with_suffix(".gz")
        file.write_bytes(gzip.compress(text.encode(), 1))
    else:
        file.write_text(text, newline="")
    return file, list(said.values())


def _by_rows(parts, said, file, form, time, digits):
    """Write a row for each value, or stacked maneuvers with a line that names each."""
    lines = ["maneuver,time,variable,value"] if form == "long" else []
    for p in parts:
        texts = {}
        for k in p.hi:
            texts[k], said[p.maneuver].hi[k], said[p.maneuver].lo[k] = written(
                p.hi[k], p.lo[k] * (digits > 17), digits
            )
        if form == "below":
            lines += [f"Maneuver {p.maneuver}", ",".join(["time", *texts])]
            lines += [",".join(row) for row in zip(time, *texts.values(), strict=True)]
        else:
            lines += [f"{p.maneuver},{t},{k},{x}" for k, column in texts.items()
                      for t, x in zip(time, column, strict=True)]  # fmt: skip
    file.write_text("\n".join(lines) + "\n")
    return file


def read(source, parts):
    """Read the file; pass the number of the maneuver if the file has only one."""
    return read_results(source, maneuver=parts[0].maneuver if len(parts) == 1 else None)
