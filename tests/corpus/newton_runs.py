"""Runs with Newton's and Euler's equations: right ones, and mistakes in the equations."""

from __future__ import annotations

from corpus import methods as by
from corpus.benchmark import Run
from corpus.newton_model import B, F, H, Program, R

_TIGHT = by.EXACT

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
     Program(_TIGHT, tensor_turns=False)),
    ("contact-below-hub", "contact point straight below the hub",
     "wheels touch straight below their hubs, also when they lean",
     Program(_TIGHT, contact="below")),
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
