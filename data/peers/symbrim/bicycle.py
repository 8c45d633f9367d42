"""The uncontrolled bicycle of SymBRiM, integrated by SciPy.

``simulate`` is what `../field.py` calls. SymBRiM's model is in Moore's convention: both frames have
axes of their own with z down the steer axis, so lengths and inertia are turned before they are
used; z is down, y to the right. Deriving the equations takes a minute or more.
"""

import time
from functools import cache

import numpy as np
import sympy as sm
import sympy.physics.mechanics as me
from scipy.integrate import solve_ivp
from symbrim import bicycle as parts


@cache
def functions():
    """The names of the parameters, the order of the speeds, and the equations as functions."""
    bike = parts.WhippleBicycle("bike")
    bike.ground = parts.FlatGround("ground")
    bike.rear_frame, bike.front_frame = parts.RigidRearFrame("rear"), parts.RigidFrontFrame("front")
    bike.rear_wheel, bike.front_wheel = parts.KnifeEdgeWheel("R"), parts.KnifeEdgeWheel("F")
    bike.rear_tire, bike.front_tire = parts.NonHolonomicTire("Rt"), parts.NonHolonomicTire("Ft")
    bike.define_all()
    system, ground, g = bike.to_system(), bike.ground, sm.Symbol("g")
    system.apply_uniform_gravity(-g * ground.get_normal(ground.origin))
    q, u = list(bike.q), list(bike.u)
    # Pitch follows from the contact; all speeds from those of roll, rear wheel and steer.
    system.q_ind, system.q_dep = [*q[:4], *q[5:]], [q[4]]
    system.u_ind, system.u_dep = [u[3], u[5], u[6]], [*u[:3], u[4], u[7]]
    system.form_eoms(constraint_solver="CRAMER")
    kane, bodies = system.eom_method, [b for b in system.bodies if b is not ground.body]
    down = [b.masscenter.pos_from(ground.origin).dot(ground.frame.z) for b in bodies]
    energies = [
        -sum(g * b.mass * z for b, z in zip(bodies, down, strict=True)),
        sum(me.kinetic_energy(ground.frame, b) for b in bodies),
    ]
    rates = {x.diff(me.dynamicsymbols._t): y for x, y in zip(q, u, strict=True)}
    height = system.holonomic_constraints[0]
    rolls = [height.diff(me.dynamicsymbols._t), *system.nonholonomic_constraints]
    rolling = sm.Matrix(rolls).xreplace(rates).jacobian(sm.Matrix(u))
    motion = [*kane.mass_matrix, *kane.forcing]
    plain = {x: sm.Dummy() for x in (*q, *u)}
    names = sorted(
        {g, *sm.Matrix(motion).xreplace(plain).free_symbols} - {*plain.values()}, key=str
    )

    def compiled(expressions):
        bare = [sm.sympify(x).xreplace(rates).xreplace(plain) for x in expressions]
        return sm.lambdify((list(plain.values()), names), bare, "math", cse=True)

    order = [u.index(x) for x in kane.u]
    return [str(x) for x in names], order, [*map(compiled, (motion, [height], rolling, energies))]


def parameters(p):
    """Table 1 in SymBRiM's terms: axes along and across the steer axis, distances from the hubs."""
    c, s = np.cos(p["lam"]), np.sin(p["lam"])
    turn = np.array([[c, -s], [s, c]])

    found = {"g": p["g"], "rear_d1": (turn @ [p["w"] + p["c"], p["rR"]])[0]}
    across, found["front_d2"] = turn @ [p["w"], p["rR"] - p["rF"]]
    found["front_d3"] = across - found["rear_d1"]
    found["rear_l1"], found["rear_l2"] = turn @ [p["xB"], p["zB"] + p["rR"]]
    found["front_l3"], found["front_l4"] = turn @ [p["xH"] - p["w"], p["zH"] + p["rF"]]
    for b, body in (("B", "rear"), ("H", "front")):
        xx, zz, xz = p[f"I{b}xx"], p[f"I{b}zz"], p[f"I{b}xz"]
        (xx, xz), (_, zz) = turn @ [[xx, xz], [xz, zz]] @ turn.T
        found |= {f"{body}_ixx": xx, f"{body}_izz": zz, f"{body}_izx": xz}
        found |= {f"{body}_iyy": p[f"I{b}yy"], f"{body}_body_mass": p[f"m{b}"]}
    for b in ("R", "F"):
        found |= {f"{b}_mass": p[f"m{b}"], f"{b}_r": p[f"r{b}"]}
        found |= {f"{b}_ixx": p[f"I{b}xx"], f"{b}_iyy": p[f"I{b}yy"]}
    return found


def simulate(p, speed, roll_rate, tolerance, method="DOP853"):
    """Rows of the eight columns every 0.01 s, and the processor time of the simulation [s]."""
    names, order, (equations, height, rolling, energies) = functions()
    values = parameters(p)
    values = [float(values[name]) for name in names]
    places = [8 + i for i in order]

    def slope(_, state):
        found = np.array(equations(state.tolist(), values))
        rates = np.empty(16)
        rates[:8] = state[8:]
        rates[places] = np.linalg.solve(found[:64].reshape(8, 8), found[64:])
        return rates

    state = np.zeros(16)
    state[4] = p["lam"]
    if abs(height(state.tolist(), values)[0]) > 1e-12:
        raise ArithmeticError("the front wheel is not on the floor")
    known = {3: roll_rate, 5: -speed / p["rR"], 6: 0.0}
    rest = [i for i in range(8) if i not in known]
    rows = np.array(rolling(state.tolist(), values)).reshape(5, 8)
    state[[8 + i for i in known]] = list(known.values())
    state[[8 + i for i in rest]] = np.linalg.solve(rows[:, rest], -rows @ state[8:])

    times, begin = np.arange(1001) / 100, time.process_time()
    y = solve_ivp(
        slope, (0, 10), state, method=method, t_eval=times, rtol=tolerance, atol=tolerance * 1e-3
    ).y.T
    cpu = time.process_time() - begin
    v, t = np.array([energies(row.tolist(), values) for row in y]).T
    return np.column_stack([y[:, 3], y[:, 11], y[:, 8], v, t, v + t, y[:, 6], y[:, 14]]), cpu
