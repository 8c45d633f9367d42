"""Whether the whole motion agrees with the reference, with itself and with its bounds.

As in `numbers`, every number is a ball [hi + lo - bound, hi + lo + bound], and what must be equal
for exact values must overlap.
"""

from fractions import Fraction

import flint
import numpy as np

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS, NonnegativeRoots, motion_columns
from heyoka_bike.motion.trajectory import row_times
from heyoka_bike.numbers.arithmetic import exact_ball
from heyoka_bike.numbers.rounding import hi_lo
from heyoka_bike.reference.layout import HDF5, NODES
from heyoka_bike.reference.values import Dense
from heyoka_bike.reference.verification.agreement import (
    BITS,
    STATE,
    dense_of,
    follows,
    holds_zero,
    is_within,
    stored_ball,
)
from heyoka_bike.reference.verification.checks import Tally
from heyoka_bike.reference.verification.contents import StoredManeuver


def follows_from_state(x: StoredManeuver, tally: Tally) -> None:
    """Every column of a row follows from the state in the reference's row, and the integrals."""
    m = x.motion
    times = np.array([hi_lo(t, "time") for t in row_times(x.maneuver)])
    if times[:, 0].tobytes() != m.time.tobytes() or times[:, 1].tobytes() != m.time_lo.tobytes():
        tally.fail(f"{x.maneuver.name}: its times are not the multiples of the spacing")
    balls = NonnegativeRoots(BITS)
    equations = Equations.of(x.bicycle, balls)
    with balls.precision():
        for i in range(x.maneuver.rows):
            row = {name: stored_ball(x.reference.rows, name, i) for name in STATE}
            *angles_and_rates, speed, yaw = (row[name] for name in STATE)
            integrals = (stored_ball(m.rows, name, i) for name in INTEGRALS)
            state = [*angles_and_rates, speed / equations.k.length, yaw, *integrals]
            made = motion_columns(equations, state)
            follows(x, m, i, made, tally, f"from what the state in {HDF5} gives")


def identities(x: StoredManeuver, tally: Tally) -> None:
    """Unit quaternions, and wheels whose lowest points are the contact points on the floor."""
    m = x.motion
    for i in range(x.maneuver.rows):
        with flint.ctx.workprec(BITS):
            at = {name: stored_ball(m.rows, name, i) for name in m.columns}
            found = {}
            for end, radius in (("rear", x.bicycle["rR"]), ("front", x.bicycle["rF"])):
                a, *v = (at[f"{end}_frame_q{j}"] for j in range(4))
                found[f"{end} quaternion"] = a * a + sum(c * c for c in v) - 1
                # Of the axle, and how far the wheel's plane is from the vertical.
                axle = [at[f"{end}_frame_r{j}2"] for j in (1, 2, 3)]
                arm = exact_ball(radius.rational) / (1 - axle[2] * axle[2]).sqrt()
                down = [-axle[2] * axle[0], -axle[2] * axle[1], 1 - axle[2] * axle[2]]
                hub = [at[f"{end}_hub_{axis}"] for axis in "xyz"]
                contact = [at[f"{end}_contact_x"], at[f"{end}_contact_y"], flint.arb(0)]
                for axis, h, d, c in zip("xyz", hub, down, contact, strict=True):
                    found[f"{end} wheel, {axis} of its lowest point"] = h + arm * d - c
        for what, off in found.items():
            if not tally.counts(holds_zero(off), float(off.mid())):
                tally.fail(f"{x.at(what, i)}: off by {float(off.mid()):.2g}")


def rolling(x: StoredManeuver, tally: Tally) -> None:
    """The integrals' dense output changes at the rates that the reference has at its rows.

    A polynomial of degree n that is off by B over a piece of length h has, by Markov's inequality,
    a derivative off by at most 2 n^2 B / h; what is off here is nearly one.
    """
    m = x.motion
    breaks = [Fraction(float(t)) for t in m.breaks]
    rows = x.reference.rows
    with flint.ctx.workprec(BITS):
        radius = exact_ball(x.bicycle["rR"].rational)
        pieces: dict[int, dict[str, flint.arb_poly]] = {}
        piece = 0
        for i, t in enumerate(row_times(x.maneuver)):
            while piece < len(breaks) - 2 and breaks[piece + 1] <= t:
                piece += 1
            a, b = breaks[piece], breaks[piece + 1]
            if piece not in pieces:
                pieces = {piece: {n: _derivative(m.dense, n, piece) for n in _ROLLING}}
            speed = stored_ball(rows, "forward_speed_contact", i)
            yaw = stored_ball(rows, "yaw", i)
            turning = stored_ball(rows, "forward_speed_wheel_spin", i) / radius
            rates = (speed * yaw.cos(), speed * yaw.sin(), -turning)
            for name, rate in zip(_ROLLING, rates, strict=True):
                slope = pieces[piece][name](exact_ball((2 * t - a - b) / (b - a)))
                off = slope * 2 / exact_ball(b - a) - rate
                allowed = 2 * NODES**2 * float(m.dense.bound[name][piece]) / exact_ball(b - a)
                if not tally.counts(is_within(off, allowed), float(off.mid())):
                    tally.fail(
                        f"{x.at(f'dense {name}', i)}: its rate is {float(off.mid()):.2g} "
                        f"{m.units[name]} s-1 off that of the reference"
                    )


_ROLLING = INTEGRALS[:3]
"""The integrals whose rates are columns of the reference, up to a factor."""


def _derivative(dense: Dense, name: str, piece: int) -> flint.arb_poly:
    """The derivative by the argument of a Chebyshev piece."""
    x = flint.arb_poly([0, 1])
    t = [flint.arb_poly([1]), x]
    while len(t) < NODES:
        t.append(2 * x * t[-1] - t[-2])
    total = flint.arb_poly([])
    for order, polynomial in enumerate(t):
        c = flint.arb(float(dense.hi[name][piece, order])) + float(dense.lo[name][piece, order])
        total += c * polynomial
    return total.derivative()


def motion_dense(x: StoredManeuver, at_rows: Tally, joins: Tally) -> None:
    """The dense output: its value at the rows, and how its pieces join."""
    dense_of(x, x.motion, at_rows, joins)
