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
def solver(values, tolerance, method, dense, double, rate):
    """A compiled function of the start, for the 1001 states and the number of steps."""
    jax.config.update("jax_enable_x64", double)
    motion, times = functions("jax")[0], jnp.arange(1001) / rate
    steps = diffrax.PIDController(rtol=tolerance, atol=tolerance)

    def slope(_, state, __):
        found = jnp.array(motion(state, values))
        return jnp.concatenate([state[8:], jnp.linalg.solve(found[:64].reshape(8, 8), found[64:])])

    def solve(start):
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(slope), getattr(diffrax, method)(), 0.0, times[-1], 1e-3, start,
            saveat=diffrax.SaveAt(ts=times), max_steps=1000000,
            stepsize_controller=steps if dense else diffrax.ClipStepSizeController(steps, times),
        )  # fmt: skip
        return found.ys, found.stats["num_steps"]

    return jax.jit(solve)


def simulate(p, speed, roll_rate, tolerance, method="Dopri8", dense=True, double=True, rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; steps."""
    bicycle = Bicycle(p)
    solve = solver(tuple(bicycle.values), tolerance, method, dense, double, rate)
    start = jnp.array(bicycle.start(speed, roll_rate))
    jax.block_until_ready(solve(start))
    begin = time.process_time()
    found, steps = jax.block_until_ready(solve(start))
    cpu = time.process_time() - begin
    return bicycle.rows(np.asarray(found, float)), cpu, {"steps": int(steps)}
