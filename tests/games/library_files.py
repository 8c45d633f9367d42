"""Randomly drawn files as programs write them with libraries, and the plain text they mean.

A drawing is a motion, right or wrong, with a program's names, order, units and layout. This module
does not depend on how files are read.
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

KEYS = (
    "roll_angle", "roll_rate", "forward_speed", "potential_energy", "kinetic_energy",
    "mechanical_energy", "steer_angle", "steer_rate",
)  # fmt: skip
ENERGIES = KEYS[3:6]
RATES = ("roll_rate", "steer_rate")
_ROOT = Path(__file__).resolve().parents[2]
MOTIONS = {
    "right": _ROOT / "data/peers/scipy-rtol1e-10.txt",
    "exact": _ROOT / "reference/uncontrolled-bicycle.txt",
    "close": _ROOT / "data/peers/exudyn-h0.001.txt",
    "coarse": _ROOT / "data/peers/scipy-rtol1e-4.txt",
    "loose": _ROOT / "data/peers/exudyn-loose-newton.txt",
}
WRONGS = ("rates", "speed", "exchanged", "sign", "noise", "neighbour")

# Names that programs use for the eight columns, in addition to the benchmark's names.
_SHORT = {
    "roll_angle": ("phi", "roll", "lean", "φ", "varphi"),
    "roll_rate": ("phid", "phidot", "dphi", "roll_dot", "lean_rate", "p"),
    "forward_speed": ("v", "speed", "vx", "velocity", "u"),
    "potential_energy": ("Epot", "V", "PE", "E_pot", "Ep", "potential"),
    "kinetic_energy": ("Ekin", "T", "KE", "E_kin", "Ek", "kinetic"),
    "mechanical_energy": ("Etot", "E", "energy", "E_tot", "total_energy", "Emech"),
    "steer_angle": ("delta", "steer", "δ", "steering_angle"),
    "steer_rate": ("deltad", "deltadot", "ddelta", "steer_dot", "steering_rate"),
}
_JOINTS = {
    "roll_angle": ("{}.roll.phi", "{}/roll/angle", "{}.Roll_Joint.Rz.q"),
    "roll_rate": ("der({}.roll.phi)", "{}/roll/rate", "{}.Roll_Joint.Rz.w"),
    "steer_angle": ("{}.steer.phi", "{}/steer/angle", "{}.Steer_Joint.Rz.q"),
    "steer_rate": ("der({}.steer.phi,1)", "{}/steer/rate", "{}.Steer_Joint.Rz.w"),
}
STYLES = {
    "exact": str,
    "spaced": lambda key: key.replace("_", " "),
    "title": lambda key: key.replace("_", " ").title(),
    "camel": lambda key: key.title().replace("_", ""),
    "capitals": str.upper,
    "hyphen": lambda key: key.replace("_", "-"),
}
PREFIXES = (
    "bike.", "field.", "/bike/state/", "bike::", "bike/", "sim.bike.", "Bicycle1.", "bike|",
    "bike:",
)  # fmt: skip
_OF_MESSAGES = ("data", "value")
_NUMBERED = (
    "m{n}_{x}", "{x}_{n}", "maneuver_{n}_{x}", "{x}_m{n}", "{x}[{n}]", "{x}{n}", "maneuver_{n}.{x}",
    "man{n}.{x}", "M{n} {x}", "{x} (maneuver {n})",
)  # fmt: skip
# For each column: the spelling of a unit, the suffix of a name in that unit, and the factor from
# the SI unit.
_UNITS = {
    "roll_angle": (("deg", "deg", 180 / np.pi), ("°", None, 180 / np.pi), ("rad", "rad", 1.0),
                   ("degrees", None, 180 / np.pi), ("mrad", "mrad", 1e3)),
    "roll_rate": (("deg/s", "deg_s", 180 / np.pi), ("º/s", None, 180 / np.pi),
                  ("rad/s", "rad_s", 1.0), ("rpm", "rpm", 30 / np.pi), ("rad s-1", None, 1.0),
                  ("deg s^-1", None, 180 / np.pi)),
    "forward_speed": (("km/h", "kmh", 3.6), ("m/s", "mps", 1.0), ("mm/s", "mm_s", 1e3),
                      ("mph", "mph", 3600 / 1609.344), ("m s^-1", None, 1.0)),
    "energy": (("kJ", "kJ", 1e-3), ("J", "J", 1.0), ("mJ", "mJ", 1e3), ("N m", "Nm", 1.0)),
}  # fmt: skip
_WAYS_OF_UNITS = ("{x} [{u}]", "{x} ({u})", "{x}_{ending}", "{x} in {u}", "{x} / {u}", "{x}[{u}]")
_TIMES = {
    "s": (1.0, ("time", "t", "Time", "time [s]", "t_s", "TIME", "timestamp", "Time (s)", "t [s]")),
    "ms": (1e3, ("time [ms]", "t_ms", "time_ms", "Time (ms)", "t / ms")),
    "us": (1e6, ("time [us]", "t_us", "time_us")),
    "min": (1 / 60, ("time [min]", "t_min")),
    "ns": (1e9, ("time_ns", "time [ns]")),
}
_EPOCH = 1.7e9


@dataclass
class Column:
    """A column of a table: names of its groups, its name, its unit if separate, values."""

    path: tuple[str, ...]
    values: np.ndarray
    unit: str = ""
    key: str = ""
    joint: str = "."

    @property
    def name(self):
        """Name of the column in a table without groups."""
        *groups, last = self.path
        if self.joint.startswith("/"):
            return "".join(f"/{x}" for x in self.path) if groups else last
        return self.joint.join(self.path)


@dataclass
class Drawing:
    """The output of a program: its tables by maneuver, and the numbers in them."""

    number: int
    seed: int
    motion: str
    wrong: str
    layout: str
    units_apart: str
    style: str
    time: np.ndarray
    parts: dict
    tables: dict = field(default_factory=dict)
    is_told: bool = True
    time_kind: str = "s"
    time_name: str = ""
    names_in_rows: dict = field(default_factory=dict)
    writer: str = ""
    digits: int = 17

    def written_as(self, key):
        """Return the names of a column, in a table or as values of another column."""
        every = [c for table in self.tables.values() for c in table]
        return {c.name for c in every if c.key == key} | self.names_in_rows.get(key, set())

    @property
    def table(self):
        """The only table, if the maneuvers share one; else None."""
        (table,) = self.tables.values()
        return table

    def __str__(self):
        return (
            f"{self.seed}/{self.number} {self.writer}: {self.motion} {self.wrong} {self.layout} "
            f"m{','.join(map(str, self.parts))} {self.style}, units {self.units_apart}, "
            f"time {self.time_kind}, {self.digits} digits"
        )


@lru_cache
def _motion(name):
    return np.loadtxt(MOTIONS[name])


def draw(seed, number, layouts, units, digits, every=None):
    """Return the drawing of this number, for a writer of these layouts and unit styles.

    It contains every `every`-th row of its motion.
    """
    random = np.random.default_rng([seed, number])
    pick = lambda of: of[int(random.integers(len(of)))]  # noqa: E731
    motion, wrong = pick(["right", "right", "exact", "close", "coarse", "loose"]), ""
    if random.random() < 0.5:
        wrong = pick(WRONGS)
    layout = pick(layouts)
    step = pick([10, 10, 20])
    x = _motion(motion)[:: every or step]
    numbers = [pick([1, 2, 3])]
    if layout in ("stacked", "groups", "long") or random.random() < 0.4:
        numbers = [1, 2, 3] if random.random() < 0.7 else sorted({pick([1, 2, 3]), pick([1, 2, 3])})
    if len(numbers) == 1 and layout in ("stacked", "groups"):
        numbers = [1, 2, 3]
    keys = list(KEYS)
    if random.random() < 0.5:
        keys = sorted(
            random.choice(KEYS, int(random.integers(2, 8)), replace=False), key=KEYS.index
        )
    parts = {n: {k: x[:, 8 * n - 7 + KEYS.index(k)].copy() for k in keys} for n in numbers}
    wrong = _spoil(random, parts, wrong)
    if digits < 17:
        parts = {n: {k: _rounded(v, digits) for k, v in p.items()} for n, p in parts.items()}
    units = pick([u for u in units if u != "row" or layout != "long"])
    drawn = Drawing(number, seed, motion, wrong, layout, units, "", x[:, 0], parts,
                    digits=digits)  # fmt: skip
    _lay_out(random, drawn, keys)
    return drawn


def _rounded(values, digits):
    return np.array([float(f"{x:.{digits - 1}e}") for x in values])


def _spoil(random, parts, wrong):
    """Make a motion wrong; return the kind, or nothing if the columns are missing."""
    keys = list(next(iter(parts.values())))
    held = [k for k in RATES if k in keys]
    if wrong == "rates" and held:
        for p in parts.values():
            p.update({k: 1.5 * p[k] for k in held})
    elif wrong == "speed" and "forward_speed" in keys:
        for p in parts.values():
            p["forward_speed"] = 1.1 * p["forward_speed"]
    elif wrong == "exchanged":
        a, b = random.choice(keys, 2, replace=False)
        for p in parts.values():
            p[a], p[b] = p[b], p[a]
    elif wrong == "sign":
        key = random.choice(keys)
        for p in parts.values():
            p[key] = -p[key]
    elif wrong == "noise":
        key = random.choice(keys)
        for p in parts.values():
            p[key] = p[key] + 0.01 * np.ptp(p[key]) * random.normal(size=len(p[key]))
    elif wrong == "neighbour":
        key = random.choice(keys)
        for p in parts.values():
            p[key] = np.roll(p[key], 3)
    else:
        return ""
    return wrong


def _lay_out(random, drawn, keys):
    """Name, scale and order the columns."""
    pick = lambda of: of[int(random.integers(len(of)))]  # noqa: E731
    numbers, layout = list(drawn.parts), drawn.layout
    names, path, joint, drawn.style = _names(random, keys, pick)
    scales = {}
    spelled = dict(names)
    apart, spelled_units = {}, {}
    way = pick(_WAYS_OF_UNITS)
    if drawn.units_apart != "none":
        if drawn.units_apart != "name":
            drawn.style += " + units"
        one = pick(_UNITS["energy"])
        for key in keys:
            is_bare = spelled[key] in _OF_MESSAGES
            is_left = key not in ENERGIES and random.random() < 0.3
            if drawn.units_apart == "name" and (is_bare or is_left):
                continue
            kind = {"steer_angle": "roll_angle", "steer_rate": "roll_rate"}.get(
                key, "energy" if key in ENERGIES else key
            )
            unit, ending, scale = one if kind == "energy" else pick(_UNITS[kind])
            if drawn.units_apart == "name":
                if ending is None and "{ending}" in way:
                    continue
                if way == "{x} / {u}" and "/" in spelled[key]:
                    continue
                spelled_units[key] = (unit, ending)
            else:
                apart[key] = unit
            scales[key] = scale
    is_wide_many = layout == "wide" and len(numbers) > 1
    told = _NUMBERED[:3] if "{ending}" in way else _NUMBERED
    numbered = pick(told) if is_wide_many or (layout == "wide" and random.random() < 0.2) else None
    drawn.is_told = bool(numbered) or layout != "wide"

    def column(n, key):
        name = spelled[key]
        groups = path(key)
        if numbered and name in _OF_MESSAGES:
            *groups, last = groups
            groups.append(numbered.format(n=n, x=last))
        elif numbered:
            name = numbered.format(n=n, x=name)
        if key in spelled_units:
            unit, ending = spelled_units[key]
            name = way.format(x=name, u=unit, ending=ending)
        values = scales.get(key, 1.0) * drawn.parts[n][key]
        return Column((*groups, name), values, apart.get(key, ""), key, joint)

    kinds = ["s"] * 5 + ["ms", "us", "min", "epoch", "ns"]
    kinds += ["stamp", "delta"] if layout != "long" else []
    drawn.time_kind = pick(kinds)
    time = _time_columns(random, drawn, pick, path, joint)
    drawn.time_name = time[0].path[-1]
    if layout in ("wide", "long"):
        per = {None: [column(n, k) for n in numbers for k in keys]}
        if layout == "long":
            per = {n: [column(n, k) for k in keys] for n in numbers}
    else:
        per = {n: [column(n, k) for k in keys] for n in numbers}
    extras = _extras(random, len(drawn.time), joint, keys)
    count = len(next(iter(per.values()))) + len(extras)
    order = random.permutation(count)
    at = 0 if random.random() < 0.6 else int(random.integers(count + 1))
    for n, columns in per.items():
        every = [*columns, *extras]
        some = [every[i] for i in order]
        drawn.tables[n] = [*some[:at], *time, *some[at:]]
    if layout == "stacked":
        _stack(random, drawn, pick)
    elif layout == "long":
        _lengthen(random, drawn, pick)


def _stack(random, drawn, pick):
    """Stack the tables of all maneuvers, with or without a column for the maneuver."""
    tables = [*drawn.tables.items()]
    joined = [
        replace(first, values=np.concatenate([table[j].values for _, table in tables]))
        for j, first in enumerate(tables[0][1])
    ]
    drawn.is_told = random.random() < 0.8
    if drawn.is_told:
        spelled = pick(["{}", "{}", "maneuver_{}", "m{}"])
        told = [int(n) if spelled == "{}" else spelled.format(n) for n, _ in tables]
        told = np.repeat(np.array(told, None if spelled == "{}" else object), len(drawn.time))
        joined.insert(int(random.integers(len(joined) + 1)),
                      Column((pick(["maneuver", "man", "Maneuver"]),), told))  # fmt: skip
    drawn.tables = {None: joined}


def _lengthen(random, drawn, pick):
    """Return a row for each value, without values that are not numbers."""
    rows = []
    for n, table in drawn.tables.items():
        (time,) = [c for c in table if c.path[-1] == drawn.time_name]
        rows += [(n, t, c.name, x) for c in table if c is not time and c.key
                 for t, x in zip(time.values, c.values, strict=True)]  # fmt: skip
    if random.random() < 0.3:
        rows = [rows[i] for i in random.permutation(len(rows))]
    drawn.names_in_rows = {k: {c.name for t in drawn.tables.values() for c in t if c.key == k}
                           for k in KEYS}  # fmt: skip
    told, times, names, values = zip(*rows, strict=True)
    drawn.tables = {None: [
        *([Column(("maneuver",), np.array(told))] if len(drawn.parts) > 1 else []),
        Column((drawn.time_name,), np.array(times)),
        Column((pick(["variable", "name", "signal"]),), np.array(names, object)),
        Column(("value",), np.array(values)),
    ]}  # fmt: skip
    drawn.is_told = len(drawn.parts) > 1


def _names(random, keys, pick):
    """Draw names of the columns, their groups, the separator, and its description."""
    kind = pick(["style", "style", "short", "path", "path", "split", "joint", "data"])
    joint = pick(PREFIXES)
    steps = tuple(x for x in joint.replace("::", ".").replace("/", ".").replace("|", ".")
                  .replace(":", ".").split(".") if x)  # fmt: skip
    mark = joint.rstrip()[-2:] if joint.endswith("::") else joint[-1]
    mark = f"/{mark}" if joint.startswith("/") else mark
    if kind == "style":
        style = pick([*STYLES])
        return {k: STYLES[style](k) for k in keys}, lambda _: (), ".", style
    if kind == "short":
        found = {k: str(pick(_SHORT[k])) for k in keys}
        return found, lambda _: (), ".", f"short {' '.join(found.values())}"
    if kind == "joint":
        i, of = int(random.integers(3)), pick(["bike", "model.bike", "Bicycle"])
        found = {k: _JOINTS[k][i].format(of) if k in _JOINTS else k for k in keys}
        return found, lambda _: (), ".", "joint"
    if kind == "split":
        of = {k: "energy" if k in ENERGIES else "state" for k in keys}
        return {k: k for k in keys}, lambda k: (*steps, of.get(k, "state")), mark, f"split {joint}"
    if kind == "data":
        last = pick(_OF_MESSAGES)
        return (dict.fromkeys(keys, last), lambda k: (*steps, k),
                mark, f"data {joint}")  # fmt: skip
    return {k: k for k in keys}, lambda _: steps, mark, f"path {joint}"


def _time_columns(random, drawn, pick, path, joint):
    t, kind = drawn.time, drawn.time_kind
    groups = path("time") if random.random() < 0.5 and "data" not in drawn.style else ()
    if kind == "stamp":
        secs, nsecs = np.floor(t + 1e-12), np.rint((t - np.floor(t + 1e-12)) * 1e9)
        a, b = pick([("secs", "nsecs"), ("sec", "nanosec")])
        of = pick([("header", "stamp"), ("stamp",)])
        return [
            Column(
                (*groups, *of, a), (secs + pick([0, int(_EPOCH)])).astype(np.int64), joint=joint
            ),
            Column((*groups, *of, b), nsecs.astype(np.int64), joint=joint),
        ]
    if kind == "epoch":
        return [Column((*groups, pick(["time", "timestamp", "t"])), t + _EPOCH, joint=joint)]
    if kind == "delta":
        delta = np.rint(t * 1e9).astype("m8[ns]")
        return [Column((*groups, pick(["time", "t"])), delta, joint=joint)]
    scale, names = _TIMES[kind]
    values = np.rint(t * scale * 1e6) / 1e6 if scale >= 1 else t * scale
    if kind == "ns":
        values = np.rint(t * 1e9).astype(np.int64)
    return [Column((*groups, pick(names)), values, joint=joint)]


def _extras(random, rows, joint, keys):
    """Return columns of another object, or of another part of the bicycle."""
    t = np.linspace(0, 1, rows)
    all_of_them = [
        (("wheel_rpm",), 120 + 10 * t), (("front", "wheel_speed"), 4 + t),
        (("roll_angle_setpoint",), 0.1 * t), (("target_speed",), 4 + 0 * t),
        (("phase",), np.array(["free", "rolling"] * rows, object)[:rows]),
        (("is_stable",), np.arange(rows) % 3 == 0), (("step",), np.arange(rows)),
        (("seq",), np.arange(100, 100 + rows)), (("mass",), np.full(rows, 85.0)),
        (("cadence",), 60 + t), (("status",), np.array(["ok"] * rows, object)),
        (("header", "frame_id"), np.array(["map"] * rows, object)),
        (("torque [Nm]",), 0.2 * t), (("iterations",), np.full(rows, 3)),
        (("rider_lean",), 0.02 * t), (("gps_speed",), 14 + t), (("temperature",), 20 + t),
        (("error",), 1e-9 * t), (("x",), 4 * t), (("y",), t**2),
        (("empty",), np.full(rows, np.nan)),
        (("tire", "slip_angle"), 0.01 * t), (("dt",), np.full(rows, 0.1)),
    ]  # fmt: skip
    # A name that contains one of the eight names means that column, unless another column has the
    # name itself.
    held = {"roll_angle_setpoint": "roll_angle", "target_speed": "forward_speed"}
    all_of_them = [x for x in all_of_them if held.get(x[0][0], keys[0]) in keys]
    if random.random() < 0.4:
        return []
    some = random.choice(len(all_of_them), int(random.integers(1, 5)), replace=False)
    return [Column(all_of_them[i][0], all_of_them[i][1], joint=joint) for i in some]


def twin(drawn):
    """Return the benchmark's plain text with the same numbers under its own names."""
    numbers = list(drawn.parts)
    if not drawn.is_told and len(numbers) > 1:
        # The maneuvers are stacked without their numbers, so only the times separate them.
        lines = [" ".join(["time", *drawn.parts[numbers[0]]])]
        for p in drawn.parts.values():
            rows = zip(drawn.time, *p.values(), strict=True)
            lines += [" ".join(map(repr, map(float, row))) for row in rows]
        return "\n".join(lines) + "\n"
    if drawn.is_told:
        heads = [f"m{n}_{k}" for n, p in drawn.parts.items() for k in p]
    else:
        heads = list(drawn.parts[numbers[0]])
    rows = zip(drawn.time, *(v for p in drawn.parts.values() for v in p.values()), strict=True)
    lines = [" ".join(map(repr, map(float, row))) for row in rows]
    return "\n".join([" ".join(["time", *heads]), *lines]) + "\n"
