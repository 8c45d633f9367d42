"""Prove a limit cycle of the bicycle that is its own mirror image half a period later.

The motions considered start upright. The five unknowns u are steer angle, roll rate, steer rate and
spin of the rear wheel at the start, and the time T of the next upright crossing. The conditions are
that the state at T is the mirrored start, and that the energy has a given value. A box around the
start of a candidate contains exactly one such u if Krawczyk's operator

    K = u0 - C G(u0) + (1 - C G'(box)) (box - u0)

maps the box into itself; G' follows from the derivatives of all motions that start in the box (see
`nearby`). The proof uses three facts about the equations, which tests show to be identities: the
mirror image of a motion is a motion, the energy is constant, and the front wheel stays on the
floor. By the last two, spin and pitch need no conditions: the other variables and the energy or the
floor determine them, because the energy depends on the spin and the floor condition on the pitch.

The motion that starts at this u is a cycle of period 2 T. It has no shorter period, because all
these motions are upright only once. It attracts motions of its energy if the multipliers (the
eigenvalues of the half return map's derivative at this energy) are below 1 in magnitude.

`nearby` bounds the distance from the candidate of all motions that start in the box, and their
derivatives. The box is the initial error of `enclose`, so its bound is valid for each of these
motions. Take a piece, with Y and its defect D as in `enclose`. The derivative of any of these
motions x with respect to its state at the start of the piece is ``Y Z`` with ``Z' = Y^-1 (h (J(x) -
J(p)) Y - D) Z``, Z(0) = 1: near Y, by Gronwall's inequality. J moves little from p to x: on the
polydisc of half the radii around p it is at most 2 M / rho (see `cauchy`), and on the line from p
through x Cauchy's estimate in one variable bounds its change. Derivatives over several pieces are
products.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations

import flint

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Maneuver
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.events import UPRIGHT, events
from heyoka_bike.motion.trajectory import Certificate, OnTime, Piece, Trajectory, evaluator
from heyoka_bike.numbers.arithmetic import Number, exact_ball, upper_fraction
from heyoka_bike.numbers.ball_matrices import (
    BallVector,
    abs_times,
    identity,
    largest,
    norm,
    supremum,
    value,
)
from heyoka_bike.numbers.dual import Dual, Duals
from heyoka_bike.numbers.working import working_bits
from heyoka_bike.reference.proof.cauchy import SIZE, Circle, refused
from heyoka_bike.reference.proof.enclose import MATRIX_BITS, Flow, Frame, Prover, enclose

_TERMS_OF_SERIES = 96
"""Order of Y. With this order the defect of Y is below the precision of the matrices."""

_BITS_OF_CYCLE = 192
"""Precision. The smallest multiplier is 7e-6 and needs 22 digits: 92 bits. In a product over
sixteen pieces the enclosures grow by a factor of up to 11 each: 55 bits."""


@dataclass(frozen=True)
class Nearby:
    """Enclosures of all motions near a candidate.

    Attributes
    ----------
    certificate : Certificate
        Bounds that are valid for each of the motions.
    """

    certificate: Certificate
    _parts: tuple[_FlowPart, ...]

    def derivative(self, time: flint.arb) -> flint.arb_mat:
        """Return the derivative of the state at a time with respect to the initial state.

        Raises
        ------
        NotCertifiedError
            The time (a ball) is not inside one part of a piece.
        """
        with working_bits(_BITS_OF_CYCLE):
            product = identity(SIZE)
            for part in self._parts:
                s = (time - exact_ball(part.piece.t0)) / exact_ball(part.piece.h)
                if s > 0 and s < 1:
                    return part.derivative(s) * product
                product = part.derivative(flint.arb(1)) * product
        raise NotCertifiedError(f"found time {time}, expected one inside a piece")


@dataclass(frozen=True)
class _FlowPart:
    """A piece (or part of one) with its Y and a bound on the distance of the derivative from Y."""

    piece: Piece
    flow: Flow
    apart: flint.arb

    def derivative(self, s: flint.arb) -> flint.arb_mat:
        """Enclose the derivative of the state at s by the state at the start of the part."""
        y, w = value(self.flow.y, s), self.flow.weights
        return flint.arb_mat(
            [
                [y[i, j] + flint.arb(0, (self.apart * w[i] / w[j]).upper()) for j in range(SIZE)]
                for i in range(SIZE)
            ]
        )


def nearby(run: Trajectory, radii: BallVector) -> Nearby:
    """Enclose all motions whose initial state is within `radii` of that of the candidate.

    Raises
    ------
    NotCertifiedError
        The proof does not work over some piece.
    """
    prover = _FlowKeeper(run)
    frame = Frame(identity(SIZE), radii)
    bounds = []
    for i in range(run.steps):
        sup, frame = prover.piece(run.piece(i), frame)
        frame = frame.widened(prover.jump(i))
        bounds.append(tuple(map(upper_fraction, sup)))
    return Nearby(Certificate(run.states, tuple(bounds), bounds[-1]), tuple(prover.parts))


class _FlowKeeper(Prover):
    """A prover that stores the derivative of the flow over each part of a piece."""

    matrix_bits = _BITS_OF_CYCLE

    def __init__(self, run: Trajectory) -> None:
        super().__init__(run)
        self.parts: list[_FlowPart] = []

    def whole(
        self, piece: Piece, frame: Frame, rim: Circle, near: Circle
    ) -> tuple[BallVector, Frame]:
        sup, end = super().whole(piece, frame, rim, near)
        with working_bits(_BITS_OF_CYCLE):
            flow = self.flow(piece, rim, (_TERMS_OF_SERIES,))
            reach = largest(x / y for x, y in zip(sup, near.rho, strict=True))
            if not 4 * reach <= 1:
                raise refused(piece, "the motions leave a quarter of the polydisc")
            # No rate depends on the yaw, the last state variable, so the last column of J is zero.
            step = exact_ball(piece.h)
            moved = flint.arb_mat(
                [[*(8 * step * m * reach / x for x in near.rho[:6]), 0] for m in near.values]
            )
            size = norm(supremum(flow.y), flow.weights)
            rest = flow.defect + norm(moved, flow.weights) * size
            kappa = flow.size_inverse * rest
            self.parts.append(_FlowPart(piece, flow, (size * kappa * kappa.exp()).upper()))
        return sup, end


_RADIUS_OF_START = Fraction(1, 2**140)
"""Radius of the box: far above G at the candidate, far below the limit set by the derivative of
G."""

_ROLL, _PITCH, _STEER, _SPIN_IN_STATE = 0, 1, 2, 5
_MIRRORED = (2, 3, 4)
"""Indices of steer angle, roll rate and steer rate, which change sign from start to end."""

_UNKNOWNS = (*_MIRRORED, _SPIN_IN_STATE)


@dataclass(frozen=True)
class Cycle:
    """A cycle that is proved to exist.

    Attributes
    ----------
    run : Trajectory
        The candidate.
    certificate : Certificate
        Bound on the distance of the cycle from the candidate.
    half_period : arb
        Half the period [s].
    multipliers : tuple of arb
        Multipliers of the half return map at the cycle's energy, the largest in magnitude first.
    """

    run: Trajectory
    certificate: Certificate
    half_period: flint.arb
    multipliers: tuple[flint.arb, ...]

    @property
    def is_attracting(self) -> bool:
        """True if the cycle is proved to attract nearby motions of its energy."""
        return all(abs(x) < 1 for x in self.multipliers)


def prove_cycle(run: Trajectory, like: Maneuver, progress: OnTime | None = None) -> Cycle:
    """Prove that a limit cycle with the energy of a maneuver exists near a candidate.

    Parameters
    ----------
    run : Trajectory
        Candidate that starts upright and lasts longer than half a period, in the regular form.
    like : Maneuver
    progress
        See `enclose`.

    Raises
    ------
    NotCertifiedError
        The existence is not proved, or the multipliers cannot be separated.
    """
    if not (run.is_regular and run.maneuver.roll.is_zero):
        raise _refused(run, "expected the regular form, and an upright start")
    exact = enclose(run, progress)
    crossing = next(events(run, (UPRIGHT,), exact), None)
    if crossing is None:
        raise _refused(run, "it does not come upright again")
    at = evaluator(run, certificate=exact)
    with at.balls.precision():
        equations, radius = at.equations, exact_ball(_RADIUS_OF_START)
        time = crossing.time.mid()
        start = initial_state(equations, run.maneuver)
        end = at.state(time)
        energy = (
            equations.energies(start).total
            - equations.energies(initial_state(equations, like)).total
        )
        rest = [end[_ROLL], *(end[i] + start[i] for i in _MIRRORED), energy]
        box, tilt = _starts(run, equations, start, radius)
        unit = flint.arb(2) ** -run.grid
        radii = [abs(x - row[0] * unit).upper() for x, row in zip(box, run.pieces[0], strict=True)]
    near = nearby(run, radii)
    at = evaluator(run, at.balls.bits, near.certificate)
    with at.balls.precision():
        times = flint.arb(time, radius)
        end = at.state(times)
        rates = equations.rates_with_yaw(end)
        mirrored = [-x if i in _MIRRORED else x for i, x in enumerate(end)]
        both = [x.union(y) for x, y in zip(box, mirrored, strict=True)]
        by_energy = _energy_slopes(run, equations, both, tilt)
        flow = near.derivative(times) * _start_slopes(tilt)
    uprights = list(events(run, (UPRIGHT,), near.certificate))
    if len(uprights) != 1 or not uprights[0].is_single:
        raise _refused(run, "it is not proved that the motion is upright exactly once")
    with working_bits(MATRIX_BITS):
        _check_krawczyk(run, rest, _derivative(flow, rates, by_energy), radius)
        return Cycle(run, near.certificate, times, _multipliers(run, flow, rates, by_energy))


def _starts(
    run: Trajectory, equations: Equations, start: Sequence[flint.arb], radius: flint.arb
) -> tuple[list[flint.arb], flint.arb]:
    """Return the box with its pitch angles, and the derivative of the pitch by the steer angle.

    The front wheel is on the floor, so the steer angle determines the pitch.
    """
    box = [flint.arb(x, radius) if i in _UNKNOWNS else x for i, x in enumerate(start)]
    box[_PITCH] = flint.arb(start[_PITCH], radius)
    by_pitch, by_steer = _height_slopes(equations, box)
    # An interval Newton step proves that there is exactly one pitch inside the box for each steer
    # angle.
    gap = front_contact_height(equations.k, equations.a, box[_ROLL], start[_PITCH], box[_STEER])
    if not (abs(by_pitch) > 0 and abs(gap / by_pitch) < radius):
        raise _refused(run, "no pitch is found for every steer angle of the box")
    return box, -by_steer / by_pitch


def _height_slopes(equations: Equations, state: Sequence[flint.arb]) -> Sequence[flint.arb]:
    """Return the derivatives of the height of the front wheel by pitch and steer angle."""
    duals = Duals(equations.a)
    pitch, steer = duals.variables([state[_PITCH], state[_STEER]])
    slopes: Sequence[flint.arb] = front_contact_height(
        equations.k, duals, state[_ROLL], pitch, steer
    ).slopes
    return slopes


def _energy_slopes(
    run: Trajectory, equations: Equations, state: Sequence[flint.arb], tilt: flint.arb
) -> list[flint.arb]:
    """Return the derivatives of the energy by the unknowns, for all start and end states."""
    moving: list[Number] = list(state)
    for i, x in zip(_UNKNOWNS, Duals(equations.a).variables([state[i] for i in _UNKNOWNS]),
                    strict=True):  # fmt: skip
        moving[i] = x
    moving[_PITCH] = Dual(state[_PITCH], (tilt, 0, 0, 0))
    slopes = list(equations.over(Duals(equations.a)).energies(moving).total.slopes)
    if not (abs(slopes[-1]) > 0 and abs(_height_slopes(equations, state)[0]) > 0):
        raise _refused(run, "energy and floor do not determine spin and pitch")
    return slopes


def _start_slopes(tilt: flint.arb) -> flint.arb_mat:
    """Return the derivatives of the initial state, including the yaw, by the unknowns."""
    rows: list[list[Number]] = [[int(i == j) for j in _UNKNOWNS] for i in range(SIZE)]
    rows[_PITCH] = [tilt, 0, 0, 0]
    return flint.arb_mat(rows)


def _derivative(
    flow: flint.arb_mat, rates: Sequence[flint.arb], energy: Sequence[flint.arb]
) -> flint.arb_mat:
    """Return G' over the box, with a row per condition and a column per unknown, the last for T."""
    rows = [[*(flow[_ROLL, j] for j in range(4)), rates[_ROLL]]]
    for k, i in enumerate(_MIRRORED):
        rows.append([*(flow[i, j] + int(j == k) for j in range(4)), rates[i]])
    return flint.arb_mat([*rows, [*energy, 0]])


def _check_krawczyk(
    run: Trajectory, rest: BallVector, derivative: flint.arb_mat, radius: flint.arb
) -> None:
    """Check that the box contains exactly one zero of G; `rest` is G at the box's middle."""
    inverse = derivative.mid().inv().mid()
    spread = abs_times(identity(5) - inverse * derivative, [radius] * 5)
    moved = abs_times(inverse, [abs(x).upper() for x in rest])
    for x, y in zip(moved, spread, strict=True):
        if not x + y < radius:
            raise _refused(run, "Krawczyk's operator leaves the box")


def _multipliers(
    run: Trajectory, flow: flint.arb_mat, rates: Sequence[flint.arb], energy: Sequence[flint.arb]
) -> tuple[flint.arb, ...]:
    """Return the eigenvalues of the derivative of the half return map (see the module)."""

    def by(i: int, j: int) -> flint.arb:
        # Derivative of variable i at the mirrored crossing with respect to unknown j. The first
        # term is due to the change of the crossing time.
        return rates[i] * flow[_ROLL, j] / rates[_ROLL] - flow[i, j]

    matrix = flint.acb_mat(
        [[by(i, j) - by(i, 3) * energy[j] / energy[3] for j in range(3)] for i in _MIRRORED]
    )
    try:
        values = matrix.eig()
    except ValueError:
        raise _refused(run, "the multipliers cannot be separated") from None
    # The complex conjugate of an enclosure of one eigenvalue also encloses an eigenvalue. If the
    # conjugate overlaps no other enclosure, the eigenvalue is real.
    if any(a.overlaps(b.conjugate()) for a, b in permutations(values, 2)):
        raise _refused(run, "the multipliers are not proved to be real")
    return tuple(sorted((x.real for x in values), key=lambda x: -abs(float(x.mid()))))


def _refused(run: Trajectory, why: str) -> NotCertifiedError:
    return NotCertifiedError(f"{run.maneuver.name}: the cycle is not certified: {why}")
