"""The game of honest variations: correct values as any program may write them.

Definition, unit, axes, zero, order, digits, spacing and format are drawn at random. An error may be
added to an angle and its rate consistently, as integrators do. Its size is then computed from the
written numbers, read with the drawn choices.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from games.files import EIGHT, MOTION, correct, decimal_times, names, references, scale, truth
from games.truth import FREE, PI, ZEROED, _digits, errors, units

MANEUVERS = (1, 2, 3)
END = 10.0
# Pairs of angle and rate definitions that belong together. With an error, the rate must be the
# derivative of the angle; in an exact file, any pair is honest.
PAIRS = {"lean": "lean_rate", "tait_bryan_xyz": "tait_bryan_xyz_rate", "zyx": "zyx_rate"}


@dataclass(eq=False)
class Honest:
    """An honest file: its parts, and for each key the drawn reading (name and factor).

    `own` is a column with an unknown definition; its reading is the nearest known one. `starts` are
    initial values of columns with an arbitrary zero, `wrapped` the angles written within one turn.
    """

    parts: list
    readings: dict
    zero: float
    size: float
    digits: int
    spacing: str
    own: str = ""
    starts: dict = field(default_factory=dict)
    wrapped: tuple = ()


def signs(random, keys):
    """Return the sign of every column, for axes and senses that a program may choose."""
    ground = dict(zip("xyz", random.choice([-1, 1], 3), strict=True))
    handed = int(np.prod(list(ground.values())))
    sense = int(random.choice([-1, 1]))
    axial = {a: s * handed * sense for a, s in ground.items()}
    body = ground
    # The axes of the frames may differ from those of the ground. This needs axes without a
    # reflection, and a file without quaternions, whose components would be exchanged.
    if handed > 0 and not any("_frame_q" in k for k in keys) and random.random() < 0.4:
        body = {"x": 1, "y": 1, "z": 1}
    lean, steer, yaw, ahead, wheel, _ = (int(s) for s in random.choice([-1, 1], 6))
    up, along, across, on_wheel, on_axle, on_fork = (int(s) for s in random.choice([-1, 1], 6))
    same = {end: int(random.choice([-1, 1])) for end in ("rear", "front")}
    found = {"roll_angle": lean, "roll_rate": lean, "steer_angle": steer, "steer_rate": steer,
             "yaw": yaw, "yaw_rate": yaw, "pitch": axial["y"], "forward_speed": ahead}  # fmt: skip
    for key in keys:
        if key not in MOTION:
            continue
        end = key.split("_")[0]
        last = key[-1]
        if key.endswith(("wheel_angle", "wheel_omega_y")):
            s = wheel
        elif "omega" in key:
            s = int(ground[last]) * sense * (handed if ground is body else 1)
            s = (axial if body is ground else {"x": sense, "y": sense, "z": sense})[last]
        elif "_frame_q" in key:
            turned = {a: ground[a] * handed for a in "xyz"}
            s = same[end] * (1 if last == "0" else turned["xyz"[int(last) - 1]])
            s = s if body is ground else same[end]
        elif "_frame_r" in key:
            s = ground["xyz"[int(key[-2]) - 1]] * body["xyz"[int(last) - 1]]
        elif key.endswith("normal_force"):
            s = up * on_wheel
        elif key.endswith("longitudinal_force"):
            s = along * on_wheel
        elif key.endswith("lateral_force"):
            s = across * on_wheel
        elif key.endswith("friction"):
            s = 1
        elif "axle_force" in key:
            s = on_axle * body[last]
        elif "axle_moment" in key:
            s = on_axle * (axial if body is ground else dict.fromkeys("xyz", sense))[last]
        elif "joint_force" in key:
            s = on_fork * body[last]
        elif "joint_moment" in key:
            s = on_fork * (axial if body is ground else dict.fromkeys("xyz", sense))[last]
        else:
            s = ground[last]
        found[key] = int(s)
    if random.random() < 0.3:
        found.update({k: 1 for k in found if k in EIGHT})
    return found


def grid(random):
    """Return times and their name: even, uneven, or as from an adaptive solver."""
    which = str(random.choice(["0.01", "0.005", "0.02", "0.1", "0.001", "uneven", "adaptive"],
                              p=[0.35, 0.15, 0.12, 0.08, 0.03, 0.14, 0.13]))  # fmt: skip
    if which == "uneven":
        t = np.sort(
            np.concatenate([[0.0, END], random.uniform(0, END, random.integers(100, 1500))])
        )
    elif which == "adaptive":
        steps = 0.02 * 4 ** np.sin(np.cumsum(random.standard_normal(5000)) / 4)
        t = np.concatenate([[0.0], np.cumsum(steps)])
        t = np.append(t[t < END], END)
    else:
        count = round(END / float(which))
        t = np.arange(count + 1) * 10 / count
        t = np.array([round(x, 3) for x in t.tolist()])
    return which, t


def honest_file(seed, number):
    """Return the honest file of this number, before it is written."""
    random = np.random.default_rng([seed, number, 5])
    spacing, t = grid(random)
    maneuvers = random.permutation(MANEUVERS)[: random.choice([1, 2, 3], p=[0.2, 0.15, 0.65])]
    keys = list(EIGHT)
    if random.random() < 0.15:
        keys = [str(k) for k in random.choice(EIGHT, random.integers(3, 8), replace=False)]
    if random.random() < 0.35:
        more = [*MOTION, "pitch", "yaw", "yaw_rate"]
        keys += [str(k) for k in random.choice(more, random.integers(1, 6), replace=False)]
        if random.random() < 0.2:
            keys += [f"rear_frame_q{i}" for i in range(4) if f"rear_frame_q{i}" not in keys]
    if random.random() < 0.08 and "potential_energy" in keys:
        keys.remove("potential_energy")
    chosen = {k: str(random.choice(names(k))) if random.random() < 0.5 else k for k in keys}
    is_exact = random.random() < 0.4
    size = 0.0 if is_exact else 10.0 ** random.uniform(-14, -3)
    if "roll_angle" in chosen and not is_exact:
        # The error of an angle and the error of its rate must be consistent, so the rate must be
        # the derivative of this angle.
        name = chosen["roll_angle"].removeprefix("roll_angle_")
        rate = PAIRS.get(name, "lean_rate")
        if "roll_rate" in chosen:
            chosen["roll_rate"] = "roll_rate" if rate == "lean_rate" else f"roll_rate_{rate}"
    turned = signs(random, keys)
    factors = {}
    for k in keys:
        other = list(units(k).values())
        unit = other[random.integers(len(other))] if random.random() < 0.35 else other[0]
        factors[k] = turned.get(k, 1) * unit
    # A program writes all energies in the same unit.
    energies = [k for k in keys if k.endswith("_energy")]
    factors |= dict.fromkeys(energies, factors[energies[0]] if energies else 1)
    zeroed = [k for k in ZEROED if k in keys]
    zero = _zero(random) if zeroed and random.random() < 0.3 else 0.0
    if zero and not _shows_its_zero(keys, zero, size):
        zero = 0.0
    own = ""
    if random.random() < 0.08 and _has_lateral_and_more(keys):
        own = str(random.choice([k for k in ("roll_rate", "forward_speed") if k in keys] or [""]))
    digits = int(random.choice([6, 7, 8, 9, 10, 12, 15, 16, 17, 25, 32]))
    time, lo = decimal_times(t)
    if spacing in ("uneven", "adaptive"):
        lo = np.zeros_like(lo)
    parts = []
    weight, pair = random.uniform(0.05, 0.95), _APART.get(own)
    if own and random.random() < 0.5:
        pair = [str(k) for k in random.choice(names(own), 2, replace=False)]
    for n in maneuvers.tolist():
        part = correct(n, chosen, time, lo, is_long=digits > 17)
        if own:
            _mix(part, own, pair, weight)
        if not is_exact:
            _add_error(random, part, size)
        for k in keys:
            if zero and k in ZEROED:
                part.add(k, zero)
            _convert(part, k, factors[k])
        parts.append(part)
    ends = np.random.default_rng([seed, number, 7])
    if ends.random() < 0.08:
        # This file ends early on purpose.
        count = int(np.searchsorted(time, ends.uniform(3.0, 9.5)))
        for part in parts:
            part.pick(np.arange(count))
    reading = {k: (chosen[k], factors[k]) for k in keys}
    starts, wrapped = _freely(
        np.random.default_rng([seed, number, 7]), parts, reading, size, digits
    )
    return random, Honest(parts, reading, zero, size, digits, spacing, own, starts, wrapped)


WHEELS = ("rear_wheel_angle", "front_wheel_angle")
_TURN = 2 * PI


def _freely(random, parts, reading, size, digits):
    """Give columns with an arbitrary zero another start, and put angles within one turn."""
    starts, wrapped = {}, []
    for key in (k for k in reading if k in FREE):
        name, factor = reading[key]
        largest = max(scale(p.maneuver, name) for p in parts)
        start = float(random.choice([-1, 1])) * 10.0 ** random.uniform(-1, 1.5)
        # Use only a start that is far from zero: much larger than the errors and than the last
        # digit.
        if random.random() < 0.4 and abs(start) > largest * max(1e3 * size, 10.0 ** (3 - digits)):
            starts[key] = start
        is_wrapped = key in WHEELS and random.random() < 0.4 and size < 1e-4
        wrapped += [key] if is_wrapped else []
        low = _TURN * random.choice([0.0, -0.5])
        for p in parts:
            wide = (p.hi[key].astype(np.longdouble) + p.lo[key]) / factor + starts.get(key, 0.0)
            if is_wrapped:
                wide = wide - _TURN * np.floor((wide - low) / _TURN)
            if key in starts or is_wrapped:
                wide = wide * factor
                hi = wide.astype(float)
                p.lo[key] = (wide - hi).astype(float) * (p.lo[key] != 0)
                p.hi[key] = hi
    return starts, tuple(wrapped)


def _zero(random):
    """Draw a zero of the energy: the start, the hub, the seat, a floor 1 m below, or any other."""
    if random.random() < 0.5:
        return float(random.choice([-1, 1])) * 10.0 ** random.uniform(0, 4)
    return float(random.choice([-794.1195, -94 * 9.81 * 0.3, -94 * 9.81 * 0.9, 94 * 9.81]))


def _shows_its_zero(keys, zero, size):
    """Return whether the error of the motion is too small to look like a zero of the energy.

    The mechanical energy alone cannot distinguish a wrong start from a zero, unless other columns
    are right.
    """
    has_others = _has_lateral_and_more(keys)
    if "potential_energy" not in keys:
        return has_others and size < 1e-6
    return abs(zero) > 200 or (has_others and size < 1e-5 * abs(zero))


def _has_lateral_and_more(keys):
    """Return whether columns with one meaning show how accurate the motion is."""
    steer = {"steer_angle", "steer_rate"} & set(keys)
    return bool(steer) and len(steer | {"kinetic_energy"} & set(keys)) > 1


# Pairs of definitions that are so far apart that their mean equals none of the known definitions.
_APART = {
    "roll_rate": ("roll_rate", "roll_rate_tait_bryan_xyz_rate"),
    "forward_speed": ("forward_speed_hub_global_x", "forward_speed_com_norm"),
}


def _mix(part, key, pair, weight):
    """Replace a column with a weighted mean of two definitions."""
    both = correct(part.maneuver, dict(zip("ab", pair, strict=True)), part.time, part.time_lo)
    part.set(key, weight * both.hi["a"] + (1 - weight) * both.hi["b"])


def _add_error(random, part, size):
    """Add an error that is smooth, zero at the start, and consistent in rates and energies."""
    t = part.time
    w, phase, p = random.uniform(1, 5), random.uniform(0, 6), 2
    x = t / END
    f = x**p * np.sin(w * t + phase)
    slope = p * x ** (p - 1) / END * np.sin(w * t + phase) + x**p * w * np.cos(w * t + phase)
    for angle, rate in (
        ("roll_angle", "roll_rate"),
        ("steer_angle", "steer_rate"),
        ("yaw", "yaw_rate"),
    ):
        s = size * scale(part.maneuver, angle)
        if angle in part.hi:
            part.add(angle, s * f)
        if rate in part.hi:
            part.add(rate, s * slope)
    energy = {}
    for key in ("potential_energy", "kinetic_energy"):
        # An energy varies little during the motion, so an error of the motion also changes it
        # little.
        s = size * np.ptp(references()[0][part.maneuver].rows[key]) * random.uniform(0.01, 1)
        energy[key] = s * x**p * np.sin(random.uniform(1, 5) * t)
        if key in part.hi:
            part.add(key, energy[key])
    if "mechanical_energy" in part.hi:
        part.add("mechanical_energy", sum(energy.values()))
    done = {"roll_angle", "roll_rate", "steer_angle", "steer_rate", "yaw", "yaw_rate",
            "potential_energy", "kinetic_energy", "mechanical_energy"}  # fmt: skip
    for key in part.hi:
        if key not in done:
            # Like an energy, the speed varies little, as the maneuvers in data/results show.
            is_speed = key == "forward_speed"
            moves = np.ptp(part.hi[key]) if is_speed else scale(part.maneuver, key)
            part.add(key, size * moves * f)


def _convert(part, key, factor):
    """Convert to another unit, correctly rounded, in hi and lo."""
    if abs(factor) == 1:
        part.hi[key], part.lo[key] = float(factor) * part.hi[key], float(factor) * part.lo[key]
        return
    wide = (part.hi[key].astype(np.longdouble) + part.lo[key]) * factor
    hi = wide.astype(float)
    part.lo[key] = (wide - hi).astype(float) * (part.lo[key] != 0)
    part.hi[key] = hi


@dataclass(frozen=True)
class Known:
    """Known facts about a column of a file, in the drawn reading.

    `hidden` is the distance of a definition that the file's errors or digits make indistinguishable
    in every maneuver. Reading the column with that definition is not a mistake, and adds at most
    this error.
    """

    scd: float
    max_abs_error: float
    scale: float
    hidden: float


# Two definitions reach odds of 20 to 1 only if they differ by nearly three times the error.
_HIDDEN = 3.0


def _half_a_digit(values, digits, is_rounded):
    """Return half a unit of the last digit of the largest value."""
    size = np.max(abs(values))
    if is_rounded and size:
        return 10.0 ** (np.floor(np.log10(size)) - digits + 1) / 2
    return 0.0 if digits > 17 else np.spacing(size) / 2


def known(honest, said):
    """Return the facts by maneuver and key, from the written numbers."""
    exact, typical, found = {}, {}, {}
    for p in said:
        late = p.time >= END
        time, lo = np.where(late, END, p.time), np.where(late, 0.0, p.time_lo)
        exact[p.maneuver] = truth(p.maneuver, [n for k in p.hi for n in names(k)], time, lo)
    for p in said:
        for k in p.hi:
            if k == honest.own:
                continue
            name, factor = honest.readings[k]
            is_zeroed = bool(honest.zero) and k in ZEROED
            zero = honest.zero if is_zeroed else honest.starts.get(k, 0.0)
            e = errors(p.hi[k], p.lo[k], exact[p.maneuver][name], factor, zero)
            if k in honest.wrapped:
                e -= (_TURN * np.rint(e / _TURN)).astype(float)
            half = _half_a_digit(p.hi[k], honest.digits, p.is_rounded)
            if p.lo[k].any():
                # Trailing zeros of long numbers are not written, so the number of written digits is
                # known only to within one digit.
                half = max(half, 10 * _half_a_digit(p.hi[k], honest.digits, is_rounded=True))
            else:
                half = max(half, np.spacing(np.max(abs(p.hi[k]))) / 2)
            if p.is_rounded and np.ptp(p.hi[k]) == 0:
                # The number of digits of a constant column is inferred from the other columns, and
                # may be wrong by one digit.
                half *= 10
            half /= float(abs(factor))
            if is_zeroed:
                # The zero follows from the first potential energy and is known only as well as that
                # value. That value is rounded twice: in joules, with the zero added, and in the
                # unit of the file.
                v = "potential_energy" if "potential_energy" in p.hi else k
                half_of_v = _half_a_digit(p.hi[v], honest.digits, p.is_rounded) / abs(factor)
                first = errors(p.hi[v], p.lo[v], exact[p.maneuver][v], factor, zero)[0]
                e += np.copysign(max(half_of_v, abs(first)), e)
            if k in honest.starts or k in honest.wrapped:
                # The start follows from the first row of a maneuver and is known only as well as
                # that row.
                e += np.copysign(max(half, 1e-18), e)
            size, s = float(np.max(abs(e))), scale(p.maneuver, name)
            if k in honest.wrapped:
                # Whole turns are added in binary64, which rounds the sum.
                size = max(size, 2 * np.spacing(s))
            if abs(factor) != 1:
                # The conversions of units in this module are accurate to 19 digits.
                size = max(size, 10**-18.5 * s)
            typical[p.maneuver, k] = max(np.sqrt(np.mean(e**2)), half)
            # A digit that was not written does not count as correct, even if the value happens to
            # be near the exact one.
            size = max(size, half)
            found[p.maneuver, k] = Known(_digits(size / s), size, s, 0.0)
    for k in said[0].hi:
        if k == honest.own:
            continue
        name = honest.readings[k][0]
        for other in names(k):
            away = {n: exact[n][other][0] - exact[n][name][0] for n in exact}
            if all(np.sqrt(np.mean(d**2)) < _HIDDEN * typical[n, k] for n, d in away.items()):
                for n, d in away.items():
                    hidden = max(found[n, k].hidden, float(np.max(abs(d))))
                    found[n, k] = replace(found[n, k], hidden=hidden)
    return found
