"""At which level `heyoka-bike check` sees each mistake: docs/reference/checked-mistakes.md.

Every usual mistake of the model is made in a program that computes the known states and moves
nothing; its table is checked. Run as a script, this writes the page's table.
"""

from pathlib import Path

import numpy as np

from heyoka_bike.bicycle.equations.instant import Instant, quantities
from heyoka_bike.bicycle.instant_columns import COORDINATES, LEVELS, UNITS
from heyoka_bike.bicycle.parameters import read_bicycle
from heyoka_bike.bicycle.stability.linear import closed_form
from heyoka_bike.errors import BicycleError
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.reference.proof.instants import known_states
from heyoka_bike.scoring.diagnosis.mistakes.in_equations import EQUATION_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.programs.forces import rates_altered
from heyoka_bike.scoring.diagnosis.programs.program import Motion, Program
from heyoka_bike.scoring.instants.check import binary64_states, check, quantities_of_states
from heyoka_bike.system.resources import benchmark_bicycle
from marked_parts import filled

PAGE = Path(__file__).parent.parent / "reference" / "checked-mistakes.md"
RIGHT = Program(Motion(read_bicycle(benchmark_bicycle()), {}))
IN_MODEL = (*(m for m in MISTAKES if m.kind == "model"), *EQUATION_MISTAKES)
# Of a parameter that is only rounded.
SAME = 1e-14
KEYS = ("roll", "steer", "roll_rate", "steer_rate", "speed")


def given():
    """The coordinates of the known states."""
    states = known_states()
    return {
        name: np.array([float(getattr(s, key)) for s in states])
        for name, key in zip(COORDINATES, KEYS, strict=True)
    }


def computed(program):
    """What a program has of each known state, by name."""
    states = given()
    try:
        found = dict(quantities_of_states(program.motion.bicycle, states))
    except (BicycleError, ArithmeticError, ValueError):
        # Without mass there are no linear equations.
        found = dict(quantities_of_states(program.motion.bicycle, states, is_linear=False))
    if program.motion.amounts:
        equations, state = binary64_states(program.motion.bicycle, states)
        rates = list(Instant.of(equations, state).rates)
        rates[:7] = rates_altered(equations, state[:7], dict(program.motion.amounts))
        altered = quantities(Instant(equations, state, rates))
        found |= {c.name: altered[c.name] for c in level("accelerations").columns}
    if program.motion.linear is not None:
        found |= linear(program, states)
    return found


def linear(program, states):
    """Of a program of the linear equations: no pitch, and its own accelerations."""
    p = {s: float(x) for s, x in program.motion.bicycle.values.items()}
    m, c1, k0, k2 = (np.array(x, float) for x in closed_form(p, Arrays()))
    angles, rates = (
        np.array([states[f"{a}_{b}"] for a in ("roll", "steer")]) for b in ("angle", "rate")
    )
    v, terms = states["forward_speed"], program.motion.linear

    def scaled(matrix, base, power):
        return 0 if power is None else base**power * matrix[:, :, None]

    stiffness = scaled(k0, p["g"], terms.k0) + scaled(k2, v, terms.k2) + np.zeros((2, 2, len(v)))
    damping = scaled(c1, v, terms.c1) + np.zeros((2, 2, len(v)))
    force = np.einsum("ijn,jn->in", stiffness, angles) + np.einsum("ijn,jn->in", damping, rates)
    roll, steer = -np.linalg.solve(m, force)
    nothing = np.zeros(len(v))
    return {"pitch": nothing, "roll_acceleration": roll, "steer_acceleration": steer}


def level(name):
    return next(x for x in LEVELS if x.name == name)


def right_level(program):
    """Where a program's mistake enters first."""
    if program.motion.linear is not None:
        return "posture"
    if program.motion.amounts:
        return "accelerations"
    right, made = RIGHT.motion.bicycle, program.motion.bicycle
    changed = {
        s for s, x in right.values.items()
        if abs(float(made[s]) - float(x)) > SAME * (1 + abs(float(x)))
    }  # fmt: skip
    return next(x.name for x in LEVELS if changed & set(x.parameters))


def outcome(mistake):
    """The right level, and what the check says of the mistake."""
    program = mistake.change(RIGHT)
    with np.errstate(all="ignore"):
        table = {f"{k} [{UNITS[k]}]": x for k, x in computed(program).items() if k in UNITS}
    numbers = np.arange(1, len(known_states()) + 1)
    return right_level(program), check({"state": numbers, **table})


def lines():
    """The table, and above it how many are seen."""
    rows, seen, right = [], 0, 0
    for m in IN_MODEL:
        expected, found = outcome(m)
        named = found.failed.level.name if found.failed else None
        seen += named is not None
        right += named == expected
        worst = found.failed.columns[0].key if found.failed else ""
        values = ", ".join(f"{x.symbol} = {round(x.value, 6) + 0.0:.5g}" for x in found.explained)
        said = f"{named}" if named == expected else f"**{named or 'not seen'}**, not {expected}"
        rows.append(f"| `{m.code}` | {said} | {f'`{worst}`' if worst else ''} | {values} |")
    return [
        f"Of {len(IN_MODEL)} mistakes in the model {seen} are seen, {right} of them at the first "
        "level that depends on them.",
        "",
        "| mistake | first level that is wrong | worst column | one parameter that explains it |",
        "|---|---|---|---|",
        *rows,
    ]


def main():
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(filled(page, "mistakes", "\n".join(lines())), encoding="utf-8")


if __name__ == "__main__":
    main()
