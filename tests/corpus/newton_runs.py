"""Runs with the Newton-Euler equations: correct ones, and mistakes in the equations."""

from __future__ import annotations

import numpy as np

from corpus import methods as by
from corpus.benchmark import TABLE_1, Run, changed
from corpus.newton_model import B, F, H, Program, R

_TIGHT = by.EXACT


def _table(**values: float) -> Program:
    """A program with some values of Table 1 changed."""
    return Program(_TIGHT, p=changed(**values))


_P = TABLE_1
_CORRECT = (
    ("dop853-1e-12", "DOP853, rtol = atol = 1e-12", _TIGHT),
    ("rk45-1e-6", "RK45, rtol = atol = 1e-6", by.scipy_method("RK45", 1e-6)),
    ("rk4-0.01", "Runge-Kutta 4, h = 0.01", by.fixed(by.runge_kutta_4, 1)),
)

_MISTAKES = (
    ("no-gyroscopic", "gyroscopic torque missing", "w x (I w) left out of Euler's equations",
     Program(_TIGHT, gyroscopic=())),
    ("no-gyroscopic-wheels", "gyroscopic torque of the wheels missing",
     "w x (I w) left out for the wheels", Program(_TIGHT, gyroscopic=(B, H))),
    ("tensor-in-global-axes", "inertia not turned with the body",
     "inertia of the frames kept in global axes while they turn",
     Program(_TIGHT, turned_by={B: None, H: None})),
    ("contact-below-hub", "contact point straight below the hub",
     "wheels touch straight below their hubs, also when they lean",
     Program(_TIGHT, contact="below")),
    ("products-missing", "rear frame and fork product of inertia missing",
     "inertia of the frames as diagonal tensors", _table(IBxz=0.0, IHxz=0.0)),
    ("rear-axes", "rear frame Ixx and Izz exchanged", "Ixx and Izz of the rear frame exchanged",
     _table(IBxx=_P["IBzz"], IBzz=_P["IBxx"])),
    ("rear-radius-twice", "both wheels with the rear radius", "radius 0.3 m for both wheels",
     _table(rF=_P["rR"])),
    ("trail-across", "trail taken across the steer axis",
     "0.08 m taken as the distance of the contact point from the steer axis",
     _table(c=_P["c"] / np.cos(_P["lam"]))),
    ("rider-80-kg", "another mass of the rear frame", "m_B = 80 instead of 85", _table(mB=80.0)),
    ("gravity-10", "gravity 10", "g = 10", _table(g=10.0)),
    ("gravity-and-product", "gravity 9.8, and rear frame product of inertia with the other sign",
     "two mistakes: g = 9.8 and I_Bxz = -2.4", _table(g=9.8, IBxz=-_P["IBxz"])),
    ("fork-point-mass", "fork is a point mass", "fork without moments of inertia",
     _table(IHxx=0.0, IHyy=0.0, IHzz=0.0, IHxz=0.0)),
    ("wheels-weightless", "weight of the wheels missing", "gravity acts on the frames alone",
     Program(_TIGHT, weightless=(R, F))),
)  # fmt: skip

_PROGRAM = "Newton-Euler in NumPy"

RUNS = (
    *(
        Run(f"newton-{name}", f"{_PROGRAM}, {words}", "", "correct", Program(method).compute)
        for name, words, method in _CORRECT
    ),
    *(
        Run(f"newton-{name}", f"{_PROGRAM}, DOP853, rtol = atol = 1e-12", did, expected,
            program.compute)
        for name, expected, did, program in _MISTAKES
    ),
)  # fmt: skip
