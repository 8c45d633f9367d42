"""Columns along a trajectory, in ball arithmetic."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

import flint

from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.motion.trajectory import Certificate, Trajectory, row_times
from heyoka_bike.numbers.arithmetic import Balls, exact_ball, span_ball, upper_fraction
from heyoka_bike.numbers.rounding import upward_ball


@dataclass(frozen=True)
class Drift:
    """Largest drift, over the rows, of quantities that the exact motion conserves, rounded up.

    Attributes
    ----------
    energy : float
        max abs(E - E0) / E0, in units of 2^-p.
    contact : float
        max abs height of the front wheel above the floor [m].
    performance : float
        The benchmark's eq. (1): 100 (max E - min E) / E0 [%].
    """

    energy: float
    contact: float
    performance: float


def evaluator(
    trajectory: Trajectory, bits: int, certificate: Certificate | None = None
) -> Evaluator:
    """Columns of a trajectory in ball arithmetic of `bits`.

    With a certificate they are enclosures of the exact motion's columns, without one of the
    candidate's.
    """
    balls = Balls(bits)
    equations = Equations.of(trajectory.bicycle, balls, is_regular=trajectory.is_regular)
    return Evaluator(trajectory, balls, equations, certificate)


@dataclass(frozen=True)
class Evaluator:
    """Evaluates columns along a trajectory; use it inside ``with evaluator.balls.precision()``.

    Attributes
    ----------
    trajectory
        What is evaluated.
    balls, equations
        The number type, and the equations of the bicycle in it.
    certificate
        How far the exact motion may be from the trajectory; if given, its columns are enclosed.
    """

    trajectory: Trajectory
    balls: Balls
    equations: Equations
    certificate: Certificate | None = None

    def columns(self, t: Fraction | flint.arb, piece: int | None = None) -> dict[str, flint.arb]:
        """Every column by name at time `t`, see `state`."""
        return dict(self.equations.columns(self.state(t, piece)))

    def state(self, t: Fraction | flint.arb, piece: int | None = None) -> list[flint.arb]:
        """State at time `t`; that of a ball without a piece holds those of all pieces it meets."""
        if piece is None:
            if not isinstance(t, Fraction):
                return self._across(t)
            piece = self.trajectory.piece_at(t)
        state = self.trajectory.state(t, piece)
        if self.certificate is not None:
            bounds = self.certificate.pieces[piece]
            state = [flint.arb(x, _arb(b)) for x, b in zip(state, bounds, strict=True)]
        return state

    def _across(self, t: flint.arb) -> list[flint.arb]:
        run, low, high = self.trajectory, -upper_fraction(-t), upper_fraction(t)
        # Each piece for its own part of the time: its bounds hold there only.
        parts = [
            self.state(span_ball(max(low, run.breaks[i]), min(high, run.breaks[i + 1])), i)
            for i in range(run.piece_at(low), run.piece_at(high) + 1)
        ]
        return [reduce(flint.arb.union, values) for values in zip(*parts, strict=True)]

    @property
    def end(self) -> Fraction:
        """End of the last piece [s]."""
        return self.trajectory.breaks[-1]

    def near(self, t: flint.arb, about: Fraction) -> dict[str, flint.arb]:
        """Every column by name at `t`, on the piece that holds the time `about`."""
        return self.columns(t, self.trajectory.piece_at(about))

    def drift(self) -> Drift:
        """Energy and contact drift over the rows of the maneuver."""
        k, a, run = self.equations.k, self.balls, self.trajectory
        values = []
        contact = flint.arb(0)
        with a.precision():
            for t in row_times(run.maneuver):
                state = run.state(t)
                e = self.equations.energies(state)
                values.append(e.potential + e.kinetic)
                gap = abs(front_contact_height(k, a, state[0], state[1], state[2]))
                contact = gap.max(contact)
            start = values[0]
            high, low = values[0], values[0]
            for value in values:
                high, low = high.max(value), low.min(value)
            worst = (high - start).max(start - low) / start
            return Drift(
                energy=upward_ball(worst * flint.arb(2) ** run.bits),
                contact=upward_ball(contact),
                performance=upward_ball(100 * (high - low) / start),
            )


def _arb(value: Fraction) -> flint.arb:
    """A dyadic as a ball of no radius, or a slightly larger one."""
    return exact_ball(value).upper()
