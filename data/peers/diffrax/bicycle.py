"""SymBRiM's equations of the uncontrolled bicycle, by diffrax.

``simulate`` is what `../field.py` calls; the equations are those of `../equations/whipple.py`,
written for JAX, which compiles them. Without `double`, numbers are binary32, as JAX has them.
"""

import time
from functools import cache

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
from equations.whipple import Bicycle, functions


@cache
def solver(values, tolerance, method, dense, double):
    """A compiled function of the start, for the 1001 states."""
    jax.config.update("jax_enable_x64", double)
    motion, times = functions("jax")[0], jnp.arange(1001) / 100
    steps = diffrax.PIDController(rtol=tolerance, atol=tolerance)

    def slope(_, state, __):
        found = jnp.array(motion(state, values))
        return jnp.concatenate([state[8:], jnp.linalg.solve(found[:64].reshape(8, 8), found[64:])])

    def solve(start):
        return diffrax.diffeqsolve(
            diffrax.ODETerm(slope), getattr(diffrax, method)(), 0.0, 10.0, 1e-3, start,
            saveat=diffrax.SaveAt(ts=times), max_steps=1000000,
            stepsize_controller=steps if dense else diffrax.ClipStepSizeController(steps, times),
        ).ys  # fmt: skip

    return jax.jit(solve)


def simulate(p, speed, roll_rate, tolerance, method="Dopri8", dense=True, double=True):
    """Rows of the eight columns every 0.01 s, and the processor time of the simulation [s]."""
    bicycle = Bicycle(p)
    solve = solver(tuple(bicycle.values), tolerance, method, dense, double)
    start = jnp.array(bicycle.start(speed, roll_rate))
    solve(start).block_until_ready()
    begin = time.process_time()
    found = solve(start).block_until_ready()
    cpu = time.process_time() - begin
    return bicycle.rows(np.asarray(found, float)), cpu
