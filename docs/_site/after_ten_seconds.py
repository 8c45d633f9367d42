"""The tables of docs/after-ten-seconds.md. Run as a script, this writes them.

What is 'certified' is read from after-ten-seconds.json, which `heyoka-bike certify
--after-ten-seconds` proves again; what is 'computed' was found at two precisions, and has the
digits that both have, at most 30.
"""

import json
import re
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import flint
import mpmath

from heyoka_bike.bicycle.equations.kinematics import lateral_condition, posture
from heyoka_bike.bicycle.parameters import Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.motion.events import GREATEST_LEAN, events, zeros
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator
from heyoka_bike.numbers.arithmetic import exact_ball
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.layout import AFTER
from heyoka_bike.system.resources import after_folder, benchmark_bicycle, benchmark_maneuvers
from heyoka_bike.workbench.after_ten_seconds.facts import settling_fact
from marked_parts import filled, split

PAGE = Path(__file__).parent.parent / "after-ten-seconds.md"
DIGITS = (50, 60)
SHOWN = 30

# After the rear wheel has left the floor, and before the variables of the regular form fail [s].
FALLEN = Fraction("44.44")
# Long after both, where the few-product form still holds [s].
BEYOND = Fraction("0.03")


def agreed(a, b):
    """Digits that two computations of a number have in common, and the number with them."""
    mp = mpmath.mp.clone()
    mp.dps = 80
    a, b = mp.mpf(a), mp.mpf(b)
    same = 80 if a == b else int(mp.floor(-mp.log10(abs(a - b) / abs(b))))
    digits = min(SHOWN, same)
    return mp.nstr(b, digits, min_fixed=-3, strip_zeros=False), digits


def certified(maneuver):
    """What is proved of a maneuver, by name and unit."""
    facts = json.loads((after_folder() / AFTER).read_text(encoding="utf-8"))["proved"]
    return next(fact["numbers"] for fact in facts if fact["about"] == maneuver.name)


def certified_rows(maneuver):
    return [(name, f"`{x}`", "certified") for name, x in certified(maneuver).items()]


def table(rows, *heading):
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


def cycle_rows(bicycle, maneuver):
    """All that is said of the cycle is proved."""
    return certified_rows(maneuver)


def settling_rows(bicycle, maneuver, end=Fraction(100), digits=DIGITS[0]):
    """The final speed, its eigenvalues, and both from the motion."""
    (speed,) = settling_fact(bicycle, maneuver).numbers.values()
    mp = mpmath.mp.clone()
    mp.dps = 60
    v = mp.mpf(speed.decimal(58))
    values = linearise(bicycle, digits).eigenvalues(v)
    run = integrate(bicycle, replace(maneuver, duration=end), digits)
    at = evaluator(run, run.bits + 64)
    peaks = list(events(run, (GREATEST_LEAN,)))[-2:]
    with at.balls.precision():
        reached = mp.mpf(at.columns(end)["forward_speed"].mid().str(58, radius=False))
        lean = [abs(at.columns(e.time)["roll_angle"]) for e in peaks]
        rate = float((lean[1] / lean[0]).log() / (peaks[1].time - peaks[0].time))
    slowest = values[-1]
    return [
        *certified_rows(maneuver),
        (f"speed of the motion at {end} s, minus the final speed [m/s]",
         f"{float(reached - v):.1e}", f"computed with {digits} digits"),
        *(
            (f"eigenvalue at the final speed, {name} [1/s]", f"`{mp.nstr(x.real, SHOWN)}`"
             + (f" +- `{mp.nstr(abs(x.imag), SHOWN)}` i" if x.imag else ""),
             f"computed, {SHOWN} digits")
            for name, x in (("caster", values[0]), ("capsize", values[1]), ("weave", slowest))
        ),
        ("rate of decay between the last two lean maxima of the motion [1/s]", f"{rate:.9f}",
         f"agrees with the weave's to {abs(rate / float(slowest.real) - 1):.0e}"),
    ]  # fmt: skip


def turn_divisor(equations, state):
    """What gives the turn rate from roll and steer rate is divided by this, see `rear_rates`."""
    o = posture(equations.k, equations.a, *state[:3])
    _, c1, c3 = lateral_condition(o)
    return c3 * o.cb - c1 * o.sb


def fall_rows(bicycle, maneuver):
    """The lift of the rear wheel, proved, and where the equations end after it."""
    value, count = agreed(*(singular_time(bicycle, maneuver, d) for d in DIGITS))
    last = "the regular form's variables fail [s]", f"`{value}`", f"computed, {count} digits"
    return [*certified_rows(maneuver), last]


def singular_time(bicycle, maneuver, digits):
    """When the divisor of the regular form vanishes: the few-product form goes on [s]."""
    run = integrate(bicycle, replace(maneuver, duration=FALLEN), digits, is_regular=True)
    at = evaluator(run, run.bits + 64)
    with at.balls.precision():
        state = at.state(FALLEN)
        values = [
            Exact(Fraction(int((x * flint.arb(2) ** run.grid).mid().floor().unique_fmpz()),
                           2**run.grid))
            for x in (state[5] * at.equations.k.length, state[3], state[0], state[2], state[4])
        ]  # fmt: skip
    speed, roll_rate, roll, steer, steer_rate = values
    again = Maneuver("again", speed, roll_rate, BEYOND, BEYOND, roll, steer, steer_rate)
    after = integrate(bicycle, again, digits, is_regular=False)
    (event,) = zeros(after, turn_divisor, "the turn divisor vanishes")
    with flint.ctx.workprec(400):
        return (exact_ball(FALLEN) + event.time).mid().str(75, radius=False)


TABLES = {"cycle": cycle_rows, "settling": settling_rows, "fall": fall_rows}
HEADING = ("quantity", "value", "how well known")


def committed():
    """The rows of the page by table: what, value, how well known."""
    text = PAGE.read_text(encoding="utf-8")
    found = {}
    for name in TABLES:
        lines = split(text, name)[1].strip().splitlines()[2:]
        found[name] = [tuple(line.strip("| ").split(" | ")) for line in lines]
    return found


def number(text):
    """The number that a cell begins with."""
    return re.sub(r"[`]", "", text).split(" ")[0]


def main():
    """Write the tables that are named, or all."""
    bicycle = read_bicycle(benchmark_bicycle())
    maneuvers = read_maneuvers(benchmark_maneuvers())
    for (name, rows), maneuver in zip(TABLES.items(), maneuvers, strict=True):
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        made = table(rows(bicycle, maneuver), *HEADING)
        print(made, flush=True)
        text = filled(PAGE.read_text(encoding="utf-8"), name, made)
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
