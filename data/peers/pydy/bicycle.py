"""The uncontrolled bicycle by SymPy's KanesMethod and PyDy's generated code.

``simulate`` is what `../field.py` calls. As in PyDy's example of the Carvallo-Whipple bicycle, the
wheels roll by the velocities of the points that touch the floor, three speeds and the pitch are
dependent, and `System` integrates all of them. Axes: x forward, y to the right, z down.
"""

import time
import warnings
from functools import cache

import numpy as np
import sympy as sm
import sympy.physics.mechanics as me
from pydy.system import System
from scipy.integrate import ODEintWarning, odeint, solve_ivp


@cache
def derive(solver):
    """The system with its compiled equations, coordinates and speeds by name, and the energies."""
    w, c, lam, g, rR, rF = sm.symbols("w c lam g rR rF")
    q = dict(zip(("yaw", "roll", "pitch", "steer"), me.dynamicsymbols("q:4"), strict=True))
    names = ("yaw", "roll", "pitch", "steer", "rear", "front")
    u = dict(zip(names, me.dynamicsymbols("u:6"), strict=True))

    N, A, L, B, R, H, F = (me.ReferenceFrame(x) for x in "NALBRHF")
    axis = sm.sin(lam) * B.x + sm.cos(lam) * B.z
    A.orient_axis(N, N.z, q["yaw"])
    L.orient_axis(A, A.x, q["roll"])
    B.orient_axis(L, L.y, q["pitch"])
    H.orient_axis(B, axis, q["steer"])
    A.set_ang_vel(N, u["yaw"] * N.z)
    L.set_ang_vel(A, u["roll"] * A.x)
    B.set_ang_vel(L, u["pitch"] * L.y)
    R.set_ang_vel(B, u["rear"] * B.y)
    H.set_ang_vel(B, u["steer"] * axis)
    F.set_ang_vel(H, u["front"] * H.y)

    touch = me.Point("touch")
    touch.set_vel(N, 0)
    rear = touch.locatenew("rear", -rR * L.z)
    foot = rear.locatenew("foot", (w + c) * B.x + rR * B.z)
    front = foot.locatenew("front", -c * H.x - rF * H.z)
    down = (A.z - A.z.dot(H.y) * H.y).normalize()
    other = front.locatenew("other", rF * down)
    x, z = (dict(zip("BH", sm.symbols(f"{a}B {a}H"), strict=True)) for a in "xz")
    centres = {
        "B": rear.locatenew("B", x["B"] * B.x + (z["B"] + rR) * B.z),
        "H": foot.locatenew("H", (x["H"] - w - c) * H.x + z["H"] * H.z),
        "R": rear,
        "F": front,
    }
    rear.v2pt_theory(touch, N, R)
    foot.v2pt_theory(rear, N, B)
    front.v2pt_theory(foot, N, H)
    other.v2pt_theory(front, N, F)
    centres["B"].v2pt_theory(rear, N, B)
    centres["H"].v2pt_theory(foot, N, H)

    bodies = []
    for name, frame, own in (("B", B, B), ("H", H, H), ("R", R, B), ("F", F, H)):
        xx, yy, zz, xz = sm.symbols([f"I{name}{a}" for a in ("xx", "yy", "zz", "xz")])
        if name in "RF":
            zz, xz = xx, 0
        inertia = me.inertia(own, xx, yy, zz, 0, 0, xz)
        mass, at = sm.Symbol(f"m{name}"), centres[name]
        bodies.append(me.RigidBody(name, at, frame, mass, (inertia, at)))
    kane = me.KanesMethod(
        N, [q[x] for x in ("yaw", "roll", "steer")], [u[x] for x in ("roll", "rear", "steer")],
        kd_eqs=[x.diff() - u[name] for name, x in q.items()],
        q_dependent=[q["pitch"]], configuration_constraints=[other.pos_from(touch).dot(A.z)],
        u_dependent=[u[x] for x in ("yaw", "pitch", "front")],
        velocity_constraints=[other.vel(N).dot(a) for a in A], constraint_solver=solver,
    )  # fmt: skip
    kane.kanes_equations(bodies, [(b.masscenter, b.mass * g * A.z) for b in bodies])
    energies = [
        sum(-g * b.mass * b.masscenter.pos_from(touch).dot(A.z) for b in bodies),
        sum(me.kinetic_energy(N, b) for b in bodies),
    ]
    system = System(kane)
    system.generate_ode_function(generator="cython")
    return system, q, u, energies


def dop853(slope, start, times, args, **asked):
    """States at the times, and how often the equations were called; as odeint gives them."""
    said = {"method": "DOP853", "t_eval": times, **asked}
    # Its functions write into the array that they gave before.
    found = solve_ivp(lambda t, y: slope(y, t, *args).copy(), (0, times[-1]), start, **said)
    return found.y.T, {"nfe": [found.nfev]}


def simulate(p, speed, roll_rate, tolerance, start=0.0, solver="CRAMER", outside=False, rate=100):
    """Rows of the eight columns, `rate` a second; processor time [s]; calls of the equations.

    ``outside`` takes SciPy's DOP853 in place of odeint.
    """
    system, q, u, energies = derive(solver)
    system.times = np.arange(1001) / rate
    system.constants = {x: p[x.name] for x in system.constants_symbols}
    known = {u["roll"]: roll_rate, u["rear"]: -speed / p["rR"], u["front"]: -speed / p["rF"]}
    system.initial_conditions = dict.fromkeys(system.states, start) | {q["pitch"]: 0.0} | known
    asked = {"rtol": tolerance, "atol": tolerance}
    system.ode_solver = dop853 if outside else odeint
    if not outside:
        asked |= {"mxstep": 100000, "full_output": True}
    begin = time.process_time()
    with warnings.catch_warnings(action="error", category=ODEintWarning):
        try:
            y, found = system.integrate(**asked)
        except ODEintWarning as e:
            raise ArithmeticError(e) from None
    cpu = time.process_time() - begin
    if not np.isfinite(y).all():
        raise ArithmeticError("the equations divide by zero")
    constants = list(system.constants)
    energy = sm.lambdify((system.states, constants), energies, cse=True)
    v, t = energy(y.T, list(system.constants.values()))
    column = dict(zip(system.states, y.T, strict=True))
    return np.column_stack([
        column[q["roll"]], column[u["roll"]], -p["rR"] * column[u["rear"]],
        v, t, v + t, column[q["steer"]], column[u["steer"]],
    ]), cpu, {"calls": int(found["nfe"][-1])}  # fmt: skip
