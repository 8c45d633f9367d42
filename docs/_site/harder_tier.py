"""The tables of docs/harder-tier.md, from docs/harder-tier.json, and how that is made.

``python docs/_site/harder_tier.py`` writes the tables. With names of problems, as ``H2``, it first
makes their reference sets below ``--sets`` (those that are there are kept), measures them, runs the
codes on them, and writes what was found into the json.
"""

import argparse
import json
import time
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import START, Bicycle, Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.cli import main as command
from heyoka_bike.errors import NothingScoredError
from heyoka_bike.motion.heyoka_adapter import (
    Compiled,
    Expressions,
    NativeNumbers,
    TaylorIntegrator,
    constant,
    variables,
)
from heyoka_bike.motion.integrate import right_hand_side
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.numbers.exact import shortest_decimal
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference.layout import CERTIFICATE
from heyoka_bike.reference.load import load_reference, load_sensitivities
from heyoka_bike.reference.manifest import MANIFEST
from heyoka_bike.reference.proof.rows import TEXT_DIGITS
from heyoka_bike.reference.structure import UNKNOWNS
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.score import score
from heyoka_bike.system.resources import find_input, reference_folder
from speed_page import filled, table

DOCS = Path(__file__).parent.parent
PAGE, FOUND = DOCS / "harder-tier.md", DOCS / "harder-tier.json"
TABLES = DOCS / "reference" / "harder-codes.md"
_IN_TABLES = {"codes", "energies"}


@dataclass(frozen=True, slots=True)
class Entry:
    """A problem: names of its bicycle and maneuvers, and whether its set comes with the project."""

    bicycle: str
    maneuvers: str
    is_published: bool = False

    def folder(self, sets):
        return reference_folder() if self.is_published else sets / self.maneuvers


PROBLEMS = {
    "H1": Entry("benchmark", "benchmark", is_published=True),
    "H2": Entry("benchmark", "harder/longer"),
    "H3": Entry("benchmark", "harder/edge-of-falling"),
    "H4": Entry("browser-jason", "harder/another-bicycle"),
}

# rtol and atol: the defaults, and what gives about the smallest error of each method. rtol stops at
# 100 epsilon; Radau, of order 5, takes minutes for what is tighter than this.
DEFAULT = (1e-3, 1e-6)
TIGHT = {"DOP853": 2.3e-14, "LSODA": 2.3e-14, "Radau": 1e-10}
PRECISIONS = {"binary64": 17, "binary128": 36}
"""Of heyoka at its default tolerance, and digits that the numbers are written with."""

CODES = {
    **{f"{m} {how}": f"SciPy {m}, {how}" for m in TIGHT for how in ("default", "tight")},
    **{f"heyoka {p}": f"heyoka, {p}" for p in PRECISIONS},
}
STATE = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
GRADES = (3, 6, 9, 12)
BITS = 256  # of constants and starts, which are then rounded once
LAST_DIGIT = 100 * float(np.finfo(np.float64).eps)  # [%]
# Of the right-hand side, far more than any run takes that gets to its end: a method that
# does not get on is stopped.
MOST_CALLS = 1_000_000


def inputs(entry):
    """The bicycle and the maneuvers of a problem."""
    return (
        read_bicycle(find_input("bicycles", entry.bicycle)),
        read_maneuvers(find_input("maneuvers", entry.maneuvers)),
    )


def generate(entry, folder):
    """Make the reference set, unless it is there."""
    if not (folder / MANIFEST).exists():
        more = ["--bicycle", entry.bicycle, "--maneuvers", entry.maneuvers, "--out", str(folder)]
        assert command(["generate", *more]) == 0


def growth(folder, number, times):
    """Spectral norm of d state(t) / d state(0) [SI units], at each of some times.

    The state is roll and steer, their rates and the speed; the pitch follows, and the yaw and the
    turns of the wheels change none of the columns.
    """
    unknowns = [list(UNKNOWNS).index(f"initial_{key}") for key in START]
    found = load_sensitivities(folder)[number].evaluate(times, STATE)
    matrices = np.stack([found[name][:, unknowns] for name in STATE], axis=1)
    return np.linalg.norm(matrices, 2, axis=(1, 2))


def facts(folder, reference, number):
    """What the reference says of a maneuver."""
    certificate = json.loads((folder / CERTIFICATE).read_text())["maneuvers"][number - 1]
    m = reference[number]
    grown = growth(folder, number, m.time)
    return {
        "rows": len(m.time),
        "roll": float(np.abs(m.rows["roll_angle"]).max()),
        "steer": float(np.abs(m.rows["steer_angle"]).max()),
        "condition": float(grown.max()),
        "condition_end": float(grown[-1]),
        "steps": certificate["steps"],
        "bound": certificate["bound"],
    }


@dataclass(frozen=True)
class Motion:
    """What the codes are given: the regular form of the equations, for near the basin boundary the
    mechanical trail passes zero. The state is without the yaw.
    """

    bicycle: Bicycle
    maneuver: Maneuver
    precision: str = "binary64"

    @property
    def number(self):
        return NativeNumbers(Precision.of(self.precision)).type

    def equations(self):
        precision = Precision.of(self.precision)
        return right_hand_side(self.bicycle, precision, is_regular=True, with_yaw=False)

    def start(self):
        balls = Balls(BITS)
        with balls.precision():
            state = initial_state(Equations.of(self.bicycle, balls), self.maneuver)[:-1]
            return np.array([self.number(x.str(60, radius=False)) for x in state])

    def times(self):
        exact = [self.maneuver.time(i) for i in range(self.maneuver.rows)]
        return np.array([self.number(t.numerator) / self.number(t.denominator) for t in exact])

    def columns(self, states):
        """The eight columns of states, shape (rows, 6): shape (8, rows)."""
        balls = Balls(BITS)
        with balls.precision():
            equations = Equations.of(self.bicycle, balls).convert(
                lambda x: constant(self.number(x.str(60, radius=False))), Expressions()
            )
        *state, _ = variables(equations.states)
        # The yaw is in none of them.
        found = equations.columns([*state, constant(self.number("0"))])
        wanted = [found[name] for name in BENCHMARK_COLUMNS]
        return Compiled(wanted, state, self.number)(states.T)


class _TooLongError(Exception):
    """Raised by a right-hand side that is called too often."""


def scipy_run(motion, method, rtol, atol):
    """Columns of the rows that were reached, shape (8, rows), calls and processor time [s]."""
    equations = motion.equations()
    compiled = Compiled([rate for _, rate in equations], [x for x, _ in equations])
    calls = 0

    def counted(_, y):
        nonlocal calls
        calls += 1
        if calls > MOST_CALLS:
            raise _TooLongError
        return compiled(y)

    times, start = motion.times(), motion.start()
    begin = time.process_time()
    with warnings.catch_warnings():
        # A run that is cut short says so by its rows.
        warnings.simplefilter("ignore")
        try:
            run = solve_ivp(
                counted, (0.0, times[-1]), start, method=method, t_eval=times, rtol=rtol, atol=atol
            )
            states = run.y.T
        except _TooLongError:
            states = np.empty((0, len(start)))
    seconds = time.process_time() - begin
    return (motion.columns(states) if len(states) else np.empty((8, 0))), calls, seconds


def heyoka_run(motion):
    """The same of heyoka at its default tolerance, with its steps."""
    times = motion.times()
    integrator = TaylorIntegrator(motion.equations(), motion.start(), motion.number)
    begin = time.process_time()
    states, steps = integrator.over(times)
    return motion.columns(states), steps, time.process_time() - begin


def run(bicycle, maneuver, code):
    """Columns, count and time of a code by its name in `CODES`."""
    name, _, how = code.partition(" ")
    if name == "heyoka":
        return heyoka_run(Motion(bicycle, maneuver, how))
    tolerances = DEFAULT if how == "default" else (TIGHT[name], TIGHT[name])
    return scipy_run(Motion(bicycle, maneuver), name, *tolerances)


def write(path, maneuver, columns, digits):
    """A result file of nine columns."""
    times = [shortest_decimal(maneuver.time(i), TEXT_DIGITS) for i in range(columns.shape[1])]
    lines = (
        " ".join([t, *(f"{x:.{digits}g}" if digits == 17 else str(x) for x in row)])
        for t, row in zip(times, columns.T, strict=True)
    )
    path.write_text("\n".join(lines) + "\n")


def judge(path, number, reference):
    """What `score` says of a file of one maneuver: worst scd, eq. (1) [%], coverage."""
    results = read_results(path, maneuver=number, count=len(reference))
    try:
        scored = score(results, reference).maneuvers[0]
    except NothingScoredError:
        return {"scd": None, "performance": None, "coverage": 0.0}
    found = [c.as_understood.measures.scd for c in scored.columns]
    whole = not any(c.missing for c in scored.columns) and None not in found
    return {
        "scd": min(found) if whole else None,
        "performance": scored.performance,
        "coverage": scored.coverage,
    }


def measure(name, sets):
    """All there is to say of a problem."""
    entry = PROBLEMS[name]
    folder = entry.folder(sets)
    generate(entry, folder)
    bicycle, maneuvers = inputs(entry)
    reference = load_reference(folder)
    found = {"content_sha256": reference.content_sha256, "maneuvers": {}}
    for number, maneuver in enumerate(maneuvers, start=1):
        codes = {}
        for code in CODES:
            columns, count, seconds = run(bicycle, maneuver, code)
            path = sets / f"{name}-{number}-{code.replace(' ', '-')}.txt"
            if not columns.shape[1]:
                codes[code] = {"scd": None, "performance": None, "coverage": 0.0}
            else:
                write(path, maneuver, columns, PRECISIONS.get(code.split()[-1], 17))
                codes[code] = judge(path, number, reference)
            codes[code] |= {"count": count, "cpu": round(seconds, 3)}
            print(name, maneuver.name, code, codes[code], flush=True)
        found["maneuvers"][maneuver.name] = facts(folder, reference, number) | {"codes": codes}
    return found


def rows_of(found):
    """Problem, name of the maneuver and what was found of it, in the order of the page."""
    return [
        (name, maneuver, said)
        for name in PROBLEMS
        if name in found
        for maneuver, said in found[name]["maneuvers"].items()
    ]


def label(name, maneuver):
    return maneuver if maneuver.startswith(name) else f"{name}, {maneuver}"


def digits(said):
    """What a code reaches: correct digits of the worst column, or how far it came."""
    if said["scd"] is None or said["coverage"] < 1:
        return "too long" if not said["coverage"] else f"ends at {100 * said['coverage']:.0f} %"
    return f"{round(said['scd'], 1) + 0.0:.1f}"  # no -0


def energy(said):
    """Eq. (1) [%], no less than what a last digit of the energy makes."""
    if said["performance"] is None:
        return ""
    return f"{said['performance']:.0e}" if said["performance"] >= LAST_DIGIT else "< 2e-14"


def shown(found):
    """The tables of the page, by their markers."""
    rows = rows_of(found)
    return {
        "problems": table(
            ("maneuver", "max abs(roll) [rad]", "max abs(steer) [rad]", "condition",
             "condition at the end", "log10 of the condition", "certified bound", "steps"),
            [
                (label(name, m), f"{s['roll']:.3f}", f"{s['steer']:.3f}", f"{s['condition']:.1e}",
                 f"{s['condition_end']:.1e}", f"{np.log10(s['condition']):.1f}", s["bound"],
                 str(s["steps"]))
                for name, m, s in rows
            ],
        ),
        "codes": table(
            ("maneuver", *CODES.values()),
            [(label(name, m), *(digits(s["codes"][c]) for c in CODES)) for name, m, s in rows],
        ),
        "energies": table(
            ("maneuver", *CODES.values()),
            [(label(name, m), *(energy(s["codes"][c]) for c in CODES)) for name, m, s in rows],
        ),
        "hashes": table(
            ("problem", "`content_sha256`"),
            [
                (n, f"`{found[n]['content_sha256']}`")
                for n in PROBLEMS
                if "content_sha256" in found.get(n, {})
            ],
            left=2,
        ),
        "made": table(
            ("problem", "commit", "on", "dataset version", "columns", "processor time [min]"),
            [
                (n, f"`{m['commit']}`", m["date"], m["dataset_version"], str(m["columns"]),
                 str(m["cpu_minutes"]))
                for n in PROBLEMS
                if (m := found.get(n, {}).get("made"))
            ],
            left=4,
        ),
    }  # fmt: skip


def pages(found):
    """The pages with their generated parts, by file."""
    parts = shown(found)
    tables = {name: parts.pop(name) for name in _IN_TABLES}
    return {
        page: filled(page.read_text(encoding="utf-8"), x)
        for page, x in ((PAGE, parts), (TABLES, tables))
    }


def main():
    p = argparse.ArgumentParser()
    p.add_argument("--sets", metavar="FOLDER", type=Path, default=Path())
    p.add_argument("problems", metavar="PROBLEM", nargs="*", choices=[*PROBLEMS, []])
    args = p.parse_args()
    found = json.loads(FOUND.read_text()) if FOUND.exists() else {}
    for name in args.problems:
        args.sets.mkdir(parents=True, exist_ok=True)
        found[name] = measure(name, args.sets)
        ordered = {n: found[n] for n in PROBLEMS if n in found}
        FOUND.write_text(json.dumps(ordered, indent=1) + "\n")
    for page, text in pages(found).items():
        page.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
