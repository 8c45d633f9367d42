"""The cycle that maneuver 1 settles on: a periodic orbit of the bicycle, by Newton's method.

The bicycle keeps its energy, so cycles come in families of one parameter; the one wanted has the
energy of the maneuver. It is its own mirror image half a period later: with roll = 0 and rising, a
point (steer, roll rate, steer rate, speed) is mapped to the next upright crossing, mirrored, and a
point that is mapped to itself is looked for. One of the four conditions follows from the others and
is replaced by that of the energy. Derivatives are central differences at full precision.
"""

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import flint
import mpmath

from heyoka_bike.motion.evaluator import evaluator
from heyoka_bike.motion.events import GREATEST_LEAN, UPRIGHT, events, zeros
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.arithmetic import exact_ball
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.precision import Precision

COLUMNS = ("steer_angle", "roll_rate", "steer_rate", "forward_speed")
MIRRORED = (-1, -1, -1, 1)
ENERGY = "mechanical_energy"

# Longer than half a period of the cycle, and shorter than a whole one [s].
_A_HALF = Fraction(3, 2)
_SETTLING = Fraction(300)
_NEWTON_STEPS = 8


def _steer_rate(equations, state):
    return equations.unfold(state)[1].steer_rate


@dataclass
class Section:
    """The half return map of upright crossings, at a number of digits."""

    bicycle: object
    digits: int

    def __post_init__(self):
        self.bits = Precision.of(self.digits).bits
        self.mp = mpmath.mp.clone()
        self.mp.prec = self.bits + 32

    def run(self, x, duration):
        values = [Exact(self.rational(v)) for v in x]
        maneuver = self.maneuver(*values, duration)
        return integrate(self.bicycle, maneuver, self.digits, is_regular=True)

    @staticmethod
    def maneuver(steer, roll_rate, steer_rate, speed, duration):
        from heyoka_bike.bicycle.parameters import Maneuver

        return Maneuver("cycle", speed, roll_rate, duration, duration, steer=steer,
                        steer_rate=steer_rate)  # fmt: skip

    def rational(self, v):
        return Fraction(int(self.mp.nint(self.mp.ldexp(v, self.bits))), 2**self.bits)

    def number(self, x):
        man, exp = x.mid().man_exp()
        return self.mp.ldexp(self.mp.mpf(int(man)), int(exp))

    def half(self, x):
        """The next crossing, mirrored; its time [s]; the energy [J]."""
        run = self.run(x, _A_HALF)
        crossing = next(events(run, (UPRIGHT,)))
        at = evaluator(run, run.bits + 64)
        with at.balls.precision():
            there = at.columns(crossing.time)
            energy = self.number(at.columns(Fraction(0))[ENERGY])
            point = [s * self.number(there[c]) for s, c in zip(MIRRORED, COLUMNS, strict=True)]
            return point, self.number(crossing.time), energy

    def derivatives(self, x):
        """Of the map and of the energy, shape (5, 4)."""
        step = self.mp.ldexp(1, -self.bits // 3)
        found = self.mp.matrix(5, 4)
        for j in range(4):
            (up, _, e_up), (down, _, e_down) = (
                self.half([v + side * step * (i == j) for i, v in enumerate(x)]) for side in (1, -1)
            )
            for i, (a, b) in enumerate(zip([*up, e_up], [*down, e_down], strict=True)):
                found[i, j] = (a - b) / (2 * step)
        return found


def settled(bicycle, maneuver):
    """A rising upright crossing of the maneuver once it has settled, in binary64."""
    run = integrate(bicycle, replace(maneuver, duration=_SETTLING))
    crossing = [e for e in events(run, (UPRIGHT,)) if e.rises][-1]
    at = evaluator(run, 128)
    with at.balls.precision():
        there = at.columns(crossing.time)
        return [float(there[c].mid()) for c in COLUMNS]


@dataclass
class Cycle:
    """The cycle of the energy of a maneuver."""

    section: Section
    point: list
    half_period: object
    slopes: object

    @classmethod
    def of(cls, bicycle, maneuver, digits):
        section = Section(bicycle, digits)
        at = evaluator(integrate(bicycle, replace(maneuver, duration=maneuver.spacing), digits),
                       section.bits + 64)  # fmt: skip
        with at.balls.precision():
            wanted = section.number(at.columns(Fraction(0))[ENERGY])
        # The derivatives of the first guess are good enough for every step.
        rough = Section(bicycle, 30)
        x = [section.mp.mpf(v) for v in settled(bicycle, maneuver)]
        slopes = section.mp.matrix(rough.derivatives(x))
        for _ in range(_NEWTON_STEPS):
            there, time, energy = section.half(x)
            rest = [*(b - a for a, b in zip(x[:3], there[:3], strict=True)), energy - wanted]
            matrix = slopes[:4, :].copy()
            for i in range(3):
                matrix[i, i] -= 1
            matrix[3, :] = slopes[4, :]
            change = section.mp.lu_solve(matrix, section.mp.matrix(rest))
            x = [a - b for a, b in zip(x, change, strict=True)]
            if section.mp.norm(change) < section.mp.ldexp(1, 12 - section.bits):
                break
        return cls(section, x, time, section.derivatives(x))

    @property
    def period(self):
        return 2 * self.half_period

    @cached_property
    def half_multipliers(self):
        """Eigenvalues of the half map, the largest first; one is 1, by the energy."""
        values, _ = self.section.mp.eig(self.slopes[:4, :])
        return sorted(values, key=abs, reverse=True)

    @cached_property
    def extremes(self):
        """Greatest roll and steer angle [rad], least and greatest speed [m/s], its mean [m/s]."""
        s = self.section
        run = s.run(self.point, s.rational(self.half_period))
        at = evaluator(run, s.bits + 64)
        with at.balls.precision():

            def of(event, name):
                return abs(s.number(at.columns(event.time)[name]))

            lean = next(events(run, (GREATEST_LEAN,)))
            steer = max(of(e, "steer_angle") for e in zeros(run, _steer_rate, "steer"))
            return {
                "roll": of(lean, "roll_angle"),
                "steer": steer,
                "mean speed": s.number(self._distance(run) / exact_ball(run.maneuver.duration)),
            }

    def _distance(self, run):
        """Way of the rear hub along its heading over half a period [m]."""
        radius = exact_ball(run.bicycle["rR"].rational)
        end, total = run.maneuver.duration, flint.arb(0)
        for i in range(run.steps):
            piece = run.piece(i)
            s = exact_ball((min(end, piece.t1) - piece.t0) / piece.h)
            spin = flint.arb_poly(list(piece.rows[5])).integral()
            total += spin(s) * exact_ball(piece.h) / flint.arb(2) ** piece.grid
        return radius * total
