"""SymBRiM's equations of the uncontrolled bicycle, for programs that integrate equations.

``Bicycle`` has them in Python. Run with the line of a compiler, such as ``python whipple.py g++
bicycle.cpp``, this writes them as C, which `bicycle.hpp` includes, and runs that line. SymBRiM's
model is in Moore's convention: both frames have axes of their own with z down the steer axis, so
lengths and inertia are turned before they are used; z is down, y to the right.
"""

import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
import sympy as sm
import sympy.physics.mechanics as me
from symbrim import bicycle as parts

# Place of the rear contact (x, y), yaw, roll, pitch, rear wheel, steer, front wheel; their rates.
STATE = [sm.Symbol(f"y[{i}]") for i in range(16)]
YAW, ROLL, PITCH, REAR, STEER, FRONT = range(2, 8)


@cache
def derive():
    """Symbols of the parameters; mass matrix and forcing of the eight accelerations; V and T."""
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
    system.q_ind, system.q_dep = [*q[:PITCH], *q[REAR:]], [q[PITCH]]
    system.u_ind = [u[ROLL], u[REAR], u[STEER]]
    system.u_dep = [x for x in u if x not in system.u_ind]
    system.form_eoms(constraint_solver="CRAMER")
    kane, bodies = system.eom_method, [b for b in system.bodies if b is not ground.body]
    down = [b.masscenter.pos_from(ground.origin).dot(ground.frame.z) for b in bodies]
    potential = -sum(g * b.mass * z for b, z in zip(bodies, down, strict=True))
    kinetic = sum(me.kinetic_energy(ground.frame, b) for b in bodies)
    rates = {x.diff(me.dynamicsymbols._t): y for x, y in zip(q, u, strict=True)}
    plain = dict(zip((*q, *u), STATE, strict=True))
    matrix = kane.mass_matrix[:, [list(kane.u).index(x) for x in u]]
    motion, energies = (
        [sm.sympify(x).xreplace(rates).xreplace(plain) for x in expressions]
        for expressions in ([*matrix, *kane.forcing], [potential, kinetic])
    )
    symbols = sm.Matrix(motion + energies).free_symbols - set(STATE)
    return sorted(symbols, key=str), motion, energies


def parameters(p):
    """Table 1 in SymBRiM's terms: axes along and across the steer axis, distances from the hubs."""
    c, s = sm.cos(p["lam"]), sm.sin(p["lam"])
    turn = sm.Matrix([[c, -s], [s, c]])

    found = {"g": p["g"], "rear_d1": (turn @ sm.Matrix([p["w"] + p["c"], p["rR"]]))[0]}
    across, found["front_d2"] = turn @ sm.Matrix([p["w"], p["rR"] - p["rF"]])
    found["front_d3"] = across - found["rear_d1"]
    found["rear_l1"], found["rear_l2"] = turn @ sm.Matrix([p["xB"], p["zB"] + p["rR"]])
    found["front_l3"], found["front_l4"] = turn @ sm.Matrix([p["xH"] - p["w"], p["zH"] + p["rF"]])
    for b, body in (("B", "rear"), ("H", "front")):
        xx, zz, xz = p[f"I{b}xx"], p[f"I{b}zz"], p[f"I{b}xz"]
        xx, xz, _, zz = turn @ sm.Matrix([[xx, xz], [xz, zz]]) @ turn.T
        found |= {f"{body}_ixx": xx, f"{body}_izz": zz, f"{body}_izx": xz}
        found |= {f"{body}_iyy": p[f"I{b}yy"], f"{body}_body_mass": p[f"m{b}"]}
    for b in ("R", "F"):
        found |= {f"{b}_mass": p[f"m{b}"], f"{b}_r": p[f"r{b}"]}
        found |= {f"{b}_ixx": p[f"I{b}xx"], f"{b}_iyy": p[f"I{b}yy"]}
    return found


@cache
def functions(module):
    """Functions of state and parameters for the mass matrix with the forcing, and the energies."""
    symbols, *expressions = derive()
    plain = dict(zip(STATE, sm.symbols("y:16"), strict=True))
    return [
        sm.lambdify(
            (list(plain.values()), symbols), [x.xreplace(plain) for x in some], module, cse=True
        )
        for some in expressions
    ]


class Bicycle:
    """Accelerations, energies and start for the parameters of Table 1."""

    def __init__(self, p):
        self.p = p
        self.motion, self.energies = functions("math")
        terms = parameters(p)
        self.values = [float(terms[str(x)]) for x in derive()[0]]
        self.calls = 0

    def start(self, speed, roll_rate):
        """State of the upright bicycle that goes straight on."""
        state = np.zeros(16)
        state[PITCH], state[8], state[8 + ROLL] = self.p["lam"], speed, roll_rate
        state[8 + REAR], state[8 + FRONT] = -speed / self.p["rR"], -speed / self.p["rF"]
        return state

    def slope(self, _, state):
        """Rates of the state."""
        self.calls += 1
        found = np.array(self.motion(state.tolist(), self.values))
        return np.concatenate([state[8:], np.linalg.solve(found[:64].reshape(8, 8), found[64:])])

    def rows(self, states):
        """The eight columns; the speed is that of the rear contact along x."""
        y = np.asarray(states)
        v, t = np.array([self.energies(row.tolist(), self.values) for row in y]).T
        lean, steer = y[:, [ROLL, 8 + ROLL]], y[:, [STEER, 8 + STEER]]
        return np.column_stack([lean, y[:, 8], v, t, v + t, steer])


def c_source():
    """The equations as functions in C; parameters are those of Table 1 by name."""
    symbols, motion, energies = derive()
    names = "w c lam g rR rF mB mH mR mF xB zB xH zH IBxx IByy IBzz IBxz IHxx IHyy IHzz IHxz"
    names = [*names.split(), "IRxx", "IRyy", "IFxx", "IFyy"]
    terms = parameters({name: sm.Symbol(f'table["{name}"]') for name in names})
    plain = {x: sm.Symbol(f"p[{i}]") for i, x in enumerate(symbols)}

    def body(result, expressions):
        common, found = sm.cse([x.xreplace(plain) for x in expressions], sm.numbered_symbols("c"))
        yield from (f"const double {name} = {sm.ccode(x)};" for name, x in common)
        yield from (f"{result}[{i}] = {sm.ccode(x)};" for i, x in enumerate(found))

    lines = ["static void parameters(std::map<std::string, double> table, double *p) {"]
    lines += [*body("p", [terms[str(x)] for x in symbols]), "}"]
    for name, expressions in (("motion", motion), ("energies", energies)):
        lines += [f"static void {name}(const double *y, const double *p, double *found) {{"]
        lines += [*body("found", expressions), "}"]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "equations.inc").write_text(c_source(), encoding="utf-8")
        here = Path(__file__).parent
        sys.exit(subprocess.run([*sys.argv[1:], "-I", folder, "-I", here], check=False).returncode)
