"""The true error of a file, in the reading of its columns with the smallest error.

A reading is a definition, a sign and a unit of a column, the same for all maneuvers. Energies may
have any zero, and so may heading, positions and wheel angles. A requirement that no reading meets
is not met by the file. This module contains no estimate and no threshold.
"""

from itertools import product

import numpy as np

from games.files import EIGHT, END, UNITS, names, references, scale, truth
from heyoka_bike.numbers.double import two_sum

PI = np.longdouble("3.14159265358979323846264338327950288")
# For each SI unit: the units that a file may use, and how many of each make one SI unit.
_DEGREES = 180 / PI
_ONE = np.longdouble(1)
_FACTORS = {
    "rad": {"rad": _ONE, "deg": _DEGREES},
    "rad s-1": {"rad/s": _ONE, "deg/s": _DEGREES, "rpm": _DEGREES / 6},
    "m s-1": {
        "m/s": _ONE,
        "km/h": np.longdouble("3.6"),
        "mm/s": 1000 * _ONE,
        "mph": 3600 / np.longdouble("1609.344"),
    },
    "J": {"J": _ONE, "kJ": np.longdouble("1e-3"), "mJ": 1000 * _ONE},
    "m": {"m": _ONE, "mm": 1000 * _ONE},
    "N": {"N": _ONE, "kN": np.longdouble("1e-3"), "mN": 1000 * _ONE},
    "N m": {"N m": _ONE, "N mm": 1000 * _ONE, "kN m": np.longdouble("1e-3")},
    "1": {"1": _ONE},
}
SIGNED = ("roll_angle", "roll_rate", "forward_speed", "steer_angle", "steer_rate")
ZEROED = ("potential_energy", "mechanical_energy")
# No equation contains these columns, so they may have any initial value, and the angles among them
# may differ by whole turns.
FREE = ("yaw", "rear_wheel_angle", "front_wheel_angle",
        *(f"{place}_{axis}" for place in ("rear_contact", "front_contact", "rear_hub", "front_hub",
                                          "rear_frame_com", "front_frame_com", "com")
          for axis in "xy"))  # fmt: skip
TOLERANCE = 1e-3


def units(key):
    return _FACTORS[UNITS[key]]


def errors(hi, lo, exact, factor=_ONE, zero=0.0):
    """Return errors in SI units of a column written as `factor` times exact values plus `zero`."""
    if abs(factor) == 1:
        s = float(factor)
        hi, rest = two_sum(s * hi, np.full_like(hi, -zero))
        return (hi - exact[0]) + (rest + (s * lo - exact[1]))
    wide = hi.astype(np.longdouble) + lo
    want = factor * ((exact[0].astype(np.longdouble) + exact[1]) + zero)
    return ((wide - want) / factor).astype(float)


def readings(key):
    """Yield each column, sign and unit that a column may represent, with its factor."""
    signs = (1, -1) if key in SIGNED or key not in EIGHT else (1,)
    for name, sign, (unit, factor) in product(names(key), signs, units(key).items()):
        yield (name, sign, unit), sign * factor


class Truth:
    """The best readings of some parts, as bounds that no measure of them can exceed."""

    def __init__(self, parts):
        self.parts = {p.maneuver: p for p in parts}
        self.keys = list(dict.fromkeys(k for p in parts for k in p.hi))
        self._exact = {}
        self._errors = {}
        self._measures = {}

    def inside(self, number):
        t = self.parts[number].time
        return (t >= 0) & (t <= END * (1 + 1e-10))

    def exact(self, number, wanted):
        known = self._exact.setdefault(number, {})
        missing = [n for n in wanted if n not in known]
        if missing:
            p = self.parts[number]
            ok = self.inside(number)
            time, lo = p.time[ok], p.time_lo[ok]
            late = time + lo >= END
            time, lo = np.where(late, END, time), np.where(late, 0.0, lo)
            known |= truth(number, missing, time, lo)
        return known

    def errors(self, key):
        """Return for each reading the errors and the column's scale in each maneuver."""
        if key not in self._errors:
            found = {}
            wanted = names(key)
            if key in EIGHT:
                wanted = [n for k in EIGHT if k in self.keys for n in names(k)]
            for reading, factor in readings(key):
                found[reading] = {
                    n: (errors(p.hi[key][self.inside(n)], p.lo[key][self.inside(n)],
                               self.exact(n, wanted)[reading[0]], factor), scale(n, reading[0]))
                    for n, p in self.parts.items() if key in p.hi
                }  # fmt: skip
            self._errors[key] = found
        return self._errors[key]

    def bound(self, metric, maneuvers=None, keys=None):
        """Return the best value over all readings, for the worst column and maneuver."""
        least = metric in ("scd", "mescd", "time_to_tolerance")
        best, worst = (max, min) if least else (min, max)
        found = []
        for key in keys or self.keys:
            each = []
            for reading, of in self.errors(key).items():
                taken = [self._measure(metric, key, reading, n, *e) for n, e in of.items()
                         if maneuvers is None or n in maneuvers]  # fmt: skip
                each.append(worst(taken))
            found.append(best(each))
        return worst(found)

    def _measure(self, metric, key, reading, number, e, size):
        at = metric, key, reading, number
        if at not in self._measures:
            self._measures[at] = self._one(metric, key, number, e, size)
        return self._measures[at]

    def _one(self, metric, key, number, e, size):
        e = e[np.isfinite(e)]
        if not len(e):
            return np.inf if metric in ("scd", "mescd", "time_to_tolerance") else 0.0
        if UNITS[key] == "rad":
            # Angles that differ by whole turns describe the same attitude.
            turn = 2 * np.pi
            e = e - turn * np.rint((e - e[0] * (key in FREE)) / turn)
        if key in ZEROED or key in FREE:
            middle = np.mean(e) if metric == "rms_error" else (e.max() + e.min()) / 2
            e = e - middle
        if metric == "max_abs_error":
            return np.max(abs(e))
        if metric == "rms_error":
            return np.sqrt(np.mean((e / (m := max(np.max(abs(e)), 1e-300))) ** 2)) * m
        if metric == "max_rel_error":
            return np.max(abs(e)) / size
        if metric == "scd":
            return _digits(np.max(abs(e)) / size)
        if metric == "mescd":
            # The measure divides by 1 + |reference|, which is at most 1 + scale.
            return _digits(np.max(abs(e)) / (1 + size))
        if metric == "time_to_tolerance":
            return self._first(key, number, abs(e) > TOLERANCE * size)
        raise ValueError(metric)

    def _first(self, key, number, bad):
        p = self.parts[number]
        t = p.time[self.inside(number)]
        if key in ZEROED or len(t) != len(bad) or not bad.any():
            return np.inf
        return float(np.min(t[bad]))

    def performance(self, number):
        """Return a bound of eq. (1), for energies whose zero is the floor."""
        p = self.parts[number]
        e = p.hi["mechanical_energy"][self.inside(number)]
        start = references()[0][number].rows["mechanical_energy"][0]
        sizes = [abs(start) * float(f) for f in units("mechanical_energy").values()]
        near = min(sizes, key=lambda s: abs(np.log(s / max(abs(e[0]), 1e-300))))
        return 100 * (e.max() - e.min()) / max(near, abs(e[0]))

    def gaps(self, number):
        """Return the lengths of the gaps in the run between rows with all of their values."""
        p = self.parts[number]
        ok = self.inside(number)
        for v in p.hi.values():
            ok = ok & np.isfinite(v)
        return np.diff(np.concatenate([[0.0], np.sort(p.time[ok]), [END]]))


def _digits(relative):
    return 32.0 if relative <= 1e-32 else min(32.0, -np.log10(relative))
