"""The exact motion of all maneuvers, with the accelerations that an additional force causes."""

from dataclasses import replace

import numpy as np

from generators.made_results import made
from generators.mistaken_programs import correct
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.programs.forces import Moving
from heyoka_bike.scoring.diagnosis.residual.observed import observe, state_vector
from heyoka_bike.scoring.diagnosis.residual.residual import Residual


def exact_motions(reference):
    """Return the equations and the observed exact motion of every maneuver."""
    equations = Equations.binary64(correct(reference).motion.bicycle)
    parts = align(made(reference), reference).parts
    understood = understand(parts)
    return equations, [observe(part, understood, equations) for part in parts]


def with_force(reference, motions, force):
    """Return the residual with a generalised force.

    `force` is a function of `Moving`, the state by name and the time. It returns the powers at unit
    roll rate, steer rate and forward speed [N m].
    """
    equations, seen = motions
    pushed = []
    for m in seen:
        moving = Moving(equations, state_vector(equations, m.state.__getitem__))
        added = np.array(np.broadcast_arrays(*moving.added(force(moving, m.state, m.time))))
        added[2] *= equations.k.length
        pushed.append(replace(m, accelerations=m.accelerations + added @ m.windows.T))
    return Residual(pushed, correct(reference), EQUATION_MISTAKES[:1])


def with_torque(reference, motions, equation, torque):
    """Return the residual with a torque, a function of state and time, in one equation."""

    def force(_, state, time):
        powers = [0.0 * time] * 3
        powers[equation] = torque(state, time)
        return powers

    return with_force(reference, motions, force)
