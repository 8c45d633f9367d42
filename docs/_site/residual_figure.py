"""The figure of docs/how-diagnosis-works.md: what remains of the equations along a file's motion.

A program whose fork has the wrong sign of its product of inertia, integrated by SciPy, written with
seven digits. Run as a script, this writes docs/residual.svg.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

DOCS = Path(__file__).parent.parent
sys.path.append(str(DOCS.parent / "tests"))

from generators.mistaken_programs import columns_of, correct, results
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.definitions import understand
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.programs.program import apply, changed
from heyoka_bike.scoring.diagnosis.residual.observed import observe
from heyoka_bike.scoring.diagnosis.residual.residual import Residual
from heyoka_bike.workbench.style import BLACK, BLUE, ORANGE, VERMILLION, WIDTH, render, style

MANEUVER, MADE, DIGITS = 2, "sign_IHxz", 7
TERMS = ("sign_IHxz", "inertia_H_rotated", "no_IHxz")
COLOURS = (VERMILLION, BLUE, ORANGE)
# The motion decays.
END = 3.0


def remainders(reference):
    """Times, and by term the steer acceleration that the file has beyond the right one."""
    known = {m.code: m for m in MISTAKES}
    columns = {MANEUVER: columns_of(reference, [known[MADE]])[MANEUVER]}
    written = {k: np.array([float(f"{x:.{DIGITS}g}") for x in v]) for k, v in columns[2].items()}
    parts = align(results(reference, {MANEUVER: written}), reference).parts
    program = correct(reference)
    motion = observe(parts[0], understand(parts), Equations.binary64(program.motion.bicycle))
    residual = Residual([motion], program, [known[code] for code in TERMS])
    right = residual.of(program)
    found = {"": residual.observed - right}
    found |= {code: residual.of(apply(program, [known[code]])) - right for code in TERMS}
    assert np.allclose(residual.of(changed(program, {})), right)
    return motion.windows @ motion.time, {code: residual.blocks(x)[1] for code, x in found.items()}


def draw(time, found):
    with style():
        figure = Figure((WIDTH, 4.2), layout="constrained")
        above, below = figure.subplots(2, sharex=True)
        size = np.max(np.abs(found[""]))
        above.plot(time, found[""], ".", color=BLACK, markersize=5, label="what remains")
        for code, colour in zip(TERMS, COLOURS, strict=True):
            above.plot(time, found[code], color=colour, label=f"term of {code}")
            left = np.abs(found[""] - found[code])
            below.semilogy(time, np.maximum(left, 1e-9 * size), color=colour, label=code)
        below.semilogy(time, np.abs(found[""]), ".", color=BLACK, markersize=5)
        above.set_ylabel("steer acceleration [rad s$^{-2}$]")
        below.set_ylabel("left by each term [rad s$^{-2}$]")
        below.set_xlabel("time [s]")
        below.set_xlim(0.0, END)
        above.legend()
        return figure


if __name__ == "__main__":
    (DOCS / "residual.svg").write_bytes(render(draw(*remainders(load_reference())), "svg"))
