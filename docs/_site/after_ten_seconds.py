"""The tables of docs/after-ten-seconds.md, computed. Run as a script, this writes them.

What is 'certified' is an enclosure of the exact value; what is 'computed' was found at two
precisions, and has the digits that both have, at most 30.
"""

import re
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import flint
import mpmath

sys.path.append(str(Path(__file__).parents[2] / "tests"))

from support.limit_cycle import Cycle

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import lateral_condition, posture
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.motion.evaluator import evaluator
from heyoka_bike.motion.events import FRONT_LIFT, GREATEST_LEAN, KINDS, REAR_LIFT, events, zeros
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.arithmetic import Balls, exact_ball
from heyoka_bike.numbers.exact import ZERO, Exact
from heyoka_bike.reference.proof.enclose import enclose
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers

PAGE = Path(__file__).parent.parent / "after-ten-seconds.md"
MARKS = "<!-- {}: begin -->", "<!-- {}: end -->"
DIGITS = (50, 60)
SHOWN = 30

# After the rear wheel has left the floor, and before the variables of the regular form fail [s].
FALLEN = Fraction("44.44")
# Long after both, where the few-product form still holds [s].
BEYOND = Fraction("0.03")
# Candidates are proved with so many digits.
PROVED = 70
# Of a piece, in the proof that a force does not vanish: down to the width of the time of the lift.
HALVINGS = 300


def agreed(a, b):
    """Digits that two computations of a number have in common, and the number with them."""
    mp = mpmath.mp.clone()
    mp.dps = 80
    a, b = mp.mpf(a), mp.mpf(b)
    same = 80 if a == b else int(mp.floor(-mp.log10(abs(a - b) / abs(b))))
    digits = min(SHOWN, same)
    return mp.nstr(b, digits, min_fixed=-3, strip_zeros=False), digits


def enclosed(x, digits=SHOWN):
    """A ball by its common digits."""
    return x.str(min(digits, max(int(x.rel_accuracy_bits() * 0.30103) - 1, 1)), radius=False)


def table(rows, *heading):
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


# Maneuver 1


def cycle_rows(bicycle, maneuver, digits=DIGITS):
    """What there is to say of the cycle, each with the digits of both precisions."""
    first, second = (Cycle.of(bicycle, maneuver, d) for d in digits)

    def row(what, of):
        value, count = agreed(of(first), of(second))
        return what, f"`{value}`", f"computed, {count} digits"

    names = ("roll angle", "steer angle")
    multipliers = [
        row(f"half-period multiplier {i}", lambda c, i=i: mpmath.re(c.half_multipliers[i]))
        for i in range(1, 4)
    ]
    squares = [
        row(f"Floquet multiplier {i}", lambda c, i=i: mpmath.re(c.half_multipliers[i]) ** 2)
        for i in range(1, 4)
    ]
    return [
        row("period [s]", lambda c: c.period),
        *(row(f"largest {n} [rad]", lambda c, n=n: c.extremes[n.split()[0]]) for n in names),
        row("mean of the forward speed [m/s]", lambda c: c.extremes["mean speed"]),
        *(
            row(f"{name} upright, leaning to the right", lambda c, i=i: c.point[i])
            for i, name in enumerate(
                ("steer angle [rad]", "roll rate [rad/s]", "steer rate [rad/s]", "speed [m/s]")
            )
        ),
        (
            "half-period multiplier of the energy, minus 1",
            f"{float(abs(second.half_multipliers[0] - 1)):.0e}",
            f"computed with {digits[1]} digits",
        ),
        *multipliers,
        *squares,
    ]


# Maneuver 2


def final_speed(bicycle, maneuver, bits=400):
    """Speed of the upright bicycle that has the energy of a start upright and straight."""
    balls = Balls(bits)
    with balls.precision():
        equations = Equations.of(bicycle, balls)

        def kinetic(m):
            return equations.energies(initial_state(equations, m)).kinetic

        one = replace(maneuver, speed=Exact(Fraction(1)), roll_rate=ZERO)
        return (kinetic(maneuver) / kinetic(one)).sqrt()


def settling_rows(bicycle, maneuver, end=Fraction(100), digits=DIGITS[0]):
    """The final speed, its eigenvalues, and both from the motion."""
    speed = final_speed(bicycle, maneuver)
    mp = mpmath.mp.clone()
    mp.dps = 60
    with flint.ctx.workprec(400):
        v = mp.mpf(speed.mid().str(58, radius=False))
        shown = enclosed(speed)
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
        ("final speed, from the energy [m/s]", f"`{shown}`", "certified"),
        (f"speed of the motion at {end} s, minus that [m/s]", f"{float(reached - v):.1e}",
         f"computed with {digits} digits"),
        *(
            (f"eigenvalue at that speed, {name} [1/s]", f"`{mp.nstr(x.real, SHOWN)}`"
             + (f" +- `{mp.nstr(abs(x.imag), SHOWN)}` i" if x.imag else ""),
             f"computed, {SHOWN} digits")
            for name, x in (("caster", values[0]), ("capsize", values[1]), ("weave", slowest))
        ),
        ("rate of decay of the last two leans of the motion [1/s]", f"{rate:.9f}",
         f"the weave's to {abs(rate / float(slowest.real) - 1):.0e}"),
    ]  # fmt: skip


# Maneuver 3


def turn_divisor(equations, state):
    """What gives the turn rate from roll and steer rate is divided by this, see `rear_rates`."""
    o = posture(equations.k, equations.a, *state[:3])
    _, c1, c3 = lateral_condition(o)
    return c3 * o.cb - c1 * o.sb


def stays_positive(run, certificate, kind, end):
    """Prove that a quantity of the exact motion is positive from the start to a time [s]."""
    at = evaluator(run, run.bits + 64, certificate)
    with at.balls.precision():

        def check(i, low, high, depth):
            middle, half = exact_ball((low + high) / 2), exact_ball((high - low) / 2)
            state = at.state(flint.arb(middle, half), i)
            value = KINDS[kind](at.equations, state)
            if value > 0:
                return True
            if depth == HALVINGS:
                return False
            between = (low + high) / 2
            return check(i, low, between, depth + 1) and check(i, between, high, depth + 1)

        return all(
            check(i, run.breaks[i], min(run.breaks[i + 1], end), 0)
            for i in range(run.steps)
            if run.breaks[i] < end
        )


def fall_rows(bicycle, maneuver):
    """The lift of the rear wheel, proved, and what the equations do after it."""
    run = integrate(bicycle, replace(maneuver, duration=FALLEN), PROVED)
    proof = enclose(run)
    lift = next(events(run, (REAR_LIFT,), proof))
    lean = list(events(run, (GREATEST_LEAN,), proof))[-1]
    at = evaluator(run, run.bits + 64, proof)
    rows = []
    with at.balls.precision():
        man, exp = lift.time.lower().man_exp()
        before = int(man) * Fraction(2) ** int(exp)
        is_first = all(stays_positive(run, proof, kind, before) for kind in (REAR_LIFT, FRONT_LIFT))
        largest = at.columns(lean.time)
        there = at.columns(lift.time)
        on_floor = [forces(at.equations, at.state(e.time)) for e in (lean, lift)]
        rows += [
            ("greatest lean, time [s]", f"`{enclosed(lean.time)}`", "certified"),
            ("roll angle then [rad]", f"`{enclosed(largest['roll_angle'])}`", "certified"),
            ("friction coefficient that the rear wheel needs then",
             f"`{enclosed(on_floor[0].rear.friction(at.balls))}`", "certified"),
            ("the rear wheel leaves the floor [s]", f"`{enclosed(lift.time)}`",
             "certified" + (", and that both wheels press on the floor until then" if is_first
                            else "")),
            ("roll angle then [rad]", f"`{enclosed(there['roll_angle'])}`", "certified"),
            ("steer angle then [rad]", f"`{enclosed(there['steer_angle'])}`", "certified"),
            ("speed then [m/s]", f"`{enclosed(there['forward_speed'])}`", "certified"),
            ("normal force on the front wheel then [N]", f"`{enclosed(on_floor[1].front.normal)}`",
             "certified"),
        ]  # fmt: skip
    value, count = agreed(*(singular_time(bicycle, maneuver, d) for d in DIGITS))
    rows.append(
        ("the regular form's variables fail [s]", f"`{value}`", f"computed, {count} digits")
    )
    return rows


def singular_time(bicycle, maneuver, digits):
    """When the divisor of the regular form vanishes: the few-product form goes on [s]."""
    run = integrate(bicycle, replace(maneuver, duration=FALLEN), digits, is_regular=True)
    at = evaluator(run, run.bits + 64)
    with at.balls.precision():
        state = at.state(FALLEN)
        values = [
            Exact(Fraction(int((x * flint.arb(2) ** run.grid).mid().floor().unique_fmpz()),
                           2**run.grid))
            for x in (state[5] * at.constants.length, state[3], state[0], state[2], state[4])
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
        begin, end = (mark.format(name) for mark in MARKS)
        lines = text.partition(begin)[2].partition(end)[0].strip().splitlines()[2:]
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
        begin, end = (mark.format(name) for mark in MARKS)
        head, _, rest = PAGE.read_text(encoding="utf-8").partition(begin)
        text = f"{head}{begin}\n{made}\n{end}{rest.partition(end)[2]}"
        PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
