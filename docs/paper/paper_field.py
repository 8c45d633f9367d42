"""Numbers of the paper from long runs: what programs reach, what it costs, who falls."""

import math
from functools import cache

from field_figures import PASSES, RIGHT, is_blind
from field_harder import LEAST
from field_page import ALIKE, BUDGET, JUDGED, by_column, claim, shown
from field_race import judged
from heyoka_bike.workbench.bench.race import CLASSES
from paper_fact import among, document, fact, part, power, text_of

FIELD = "python data/peers/field.py --all -o docs/field.json"
SPEED = "python docs/_site/speed_page.py --measure"
ATLAS = "python docs/_site/atlas_page.py --store FOLDER"

ROLLING = {
    "multibody": "constraint",
    "algorithms": "constraint, by hand",
    "symbolic": "own equations",
    "solver": "given equations",
    "engine": "contact, friction",
    "linear": "linearised",
    "own": "given equations",
}
BLIND = "‡"
"""Beside an eq. (1) that is passed, in all maneuvers, by a motion not right to a thousandth."""


@cache
def _programs():
    return shown(document("docs/field.json"))


def _runs():
    """Those of the programs that are counted."""
    return [r for p in _programs() if p.program for r in p.runs]


@fact("docs/field.json", FIELD)
def field(what):
    """Counts: programs, those with a run that passes eq. (1) and is wrong, runs alike in it."""
    found = claim(_programs())
    best = sorted(p.best["digits"] for p in _programs() if p.program and p.best)
    return {
        "lowest": lambda: f"{best[0]:.1f}",
        "highest": lambda: f"{best[-1]:.1f}",
        "programs": lambda: f"{found.programs}",
        "budget": lambda: f"{BUDGET}",
        "ways": lambda: f"{len(_programs())}",
        "blind": lambda: f"{sum(map(is_blind, _runs()))}",
        "blind programs": lambda: f"{len(found.blind)}",
        "most": lambda: f"{found.most:.2g}",
        "between": lambda: f"{found.between:.2g}",
        "alike": lambda: f"{len(found.alike)}",
        "least right": lambda: f"{found.alike[0]:.1f}",
        "most right": lambda: f"{found.alike[-1]:.1f}",
        "thousandth": lambda: f"{100 * 10**-RIGHT:g} %",
        "limits": lambda: f"{power(ALIKE[0], 1)} to {power(ALIKE[1], 1)}",
        "limit": lambda: f"$10^{{{round(math.log10(PASSES))}}}$",
    }[what]()


@fact("docs/field.json", FIELD)
def worst(column):
    """Of how many programs a column is the worst of the best run."""
    return str(by_column(_programs()).worst[column])


@fact("docs/field.json", FIELD)
def blind_in(column):
    """Of the programs with a run that passes eq. (1) and is wrong, in how many a column is."""
    return str(by_column(_programs()).wrong[column])


@fact("docs/field.json", FIELD)
def reaches(program, kind="best"):
    """Correct digits of a program at its best, or at default settings (default)."""
    said = document("docs/field.json")["programs"][program]
    return f"{getattr(next(p for p in _programs() if p.said is said), kind)['digits']:.1f}"


@fact("docs/field.json", FIELD)
def between(end):
    """Digits between default settings and the best run: least or most."""
    found = [p.best["digits"] - p.default["digits"] for p in _programs() if p.best and p.default]
    return f"{(min if end == 'least' else max)(found):.1f}"


@fact("docs/field.json", FIELD)
def machine():
    """On what the programs were timed."""
    found = document("docs/field.json")["machine"]
    return f"{found['cpu']}, {found['cores']} cores, {found['system']}"


@fact("docs/field.json", FIELD)
def programs():
    """The programs in a table, the most right first."""
    lines = [
        "| program | rolling | digits: best | default | eq. (1): best | default | order |",
        "|:--|:--|--:|--:|--:|--:|--:|",
    ]
    for p in _programs():
        cells = [
            f"{p.name} {p.said['version'].partition(',')[0]}", ROLLING[p.said["kind"]],
            *(_digits(r) for r in (p.best, p.default)),
            *(_drift(r) for r in (p.best, p.default)), _order(p),
        ]  # fmt: skip
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _digits(run):
    return f"${run['digits']:.1f}$" if run else ""


def _drift(run):
    if not run:
        return ""
    found = judged(run, JUDGED)["performance"]
    # Less is what the last digit of an energy in binary64 makes.
    words = f"below {power(LEAST, 1)}" if found < LEAST else power(found)
    return f"{words} {BLIND}" if is_blind(run) else words


def _order(program):
    if program.order is None:
        return ""
    base = "h" if program.said["measure"] == "step" else r"\varepsilon"
    return f"${base}^{{{program.order:.1f}}}$"


@fact("docs/speed.json", SPEED)
def race(accuracy, code):
    """Of maneuver 2 at an accuracy: time of `simulate` [µs], or how many times as long a code."""
    run = document("docs/speed.json")
    times = {
        x["code"]: x["median_ms"] for x in run["results"]
        if (x["maneuver"], x["class"]) == (run["maneuver"], accuracy)
        and (x["status"], x["precision"]) == ("ok", "binary64")
    }  # fmt: skip
    ours = times["heyoka_bike simulate"]
    if code == "simulate":
        return f"{1e3 * ours:.0f}"
    if code == "best in C":
        return f"{min(x for name, x in times.items() if name.startswith('C ')) / ours:.1f}"
    return f"{times[code] / ours:,.0f}"


@fact("heyoka_bike/workbench/bench/race.py", "heyoka-bike bench --help")
def accuracy(name):
    """Limit of a class of the race."""
    return power(among(CLASSES[name], r"under ([0-9e-]+)"))


@fact("docs/speed.json", SPEED)
def making(what):
    """Making the reference: elapsed time [s], processors."""
    run = document("docs/speed.json")
    return f"{run['generate']['wall_s']:.0f}" if what == "time" else str(run["machine"]["cores"])


@fact("docs/atlas.md", ATLAS)
def atlas(what):
    """Starts of the map, what falls in the stable range, what recovers from how much."""
    page, inside, energy = (
        text_of("docs/atlas.md"),
        part("atlas.md", "inside"),
        part("atlas.md", "energy"),
    )
    return {
        "starts": lambda: f"{int(among(page, r'([0-9]+) × [0-9]+ points')) ** 2:,}",
        "duration": lambda: among(page, r"followed for at most ([0-9]+) s"),
        "falls": lambda: among(inside, r"range ([0-9]+) %"),
        "rate": lambda: among(inside, r"more than ([0-9.]+) rad/s"),
        "lean": lambda: among(inside, r"\(([0-9]+)°\)"),
        "push": lambda: among(energy, r"At ([0-9.]+) rad/s"),
        "from": lambda: among(energy, r"from ([0-9.]+) m/s"),
    }[what]()
