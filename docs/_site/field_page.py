"""The tables and figures of the pages on compared software, from the runs in docs/field.json.

The pages are docs/field.md and docs/reference/compared-software.md; the README has one sentence.

Run as a script, this writes them: first ``python data/peers/field.py --all -o docs/field.json
--race``.
"""

import json
import math
import re
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from field_figures import KINDS, OTHER, RIGHT, Kind, costs, drifts, is_blind
from field_harder import LEAST, counted, drift, harder, largest, seconds
from field_race import judged, race
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.showing.wording.number_text import one_decimal
from heyoka_bike.workbench.style import render
from speed_page import filled, table

DOCS = Path(__file__).parent.parent
PAGE, RUN = DOCS / "field.md", DOCS / "field.json"
TABLES = DOCS / "reference" / "compared-software.md"
_IN_TABLES = {"best", "default", "H2", "H3", "H4", "harder machine", "harder left out"}
README = DOCS.parent / "README.md"
BLIND = DOCS.parent / "data" / "peers" / "blind.toml"
FIGURES = {"field.svg": costs, "field-drift.svg": drifts}
# The maneuver that the benchmark judges by eq. (1).
JUDGED = 2
# Of eq. (1) [%]: motions whose energy is about equally constant.
ALIKE = 1e-5, 1e-4
# Of eq. (1) [%]: far below its limit.
FINE = 1e-6
# Processor time that the best run may take [s], see data/peers/measured.py.
BUDGET = 30
# Digits between the last two runs of a program whose error still falls.
FALLS = 0.15

Run = Mapping[str, Any]


@dataclass(frozen=True)
class Shown:
    """A program as the page shows it.

    Attributes
    ----------
    name
    kind
    said
        Its entry in the JSON.
    runs
        Those that came to their end.
    best, default
        None if there is none, or it failed.
    family
        Runs that differ from the best one in step or tolerance only, the coarse first.
    """

    name: str
    kind: Kind
    said: Mapping[str, Any]
    runs: Sequence[Run]
    best: Run | None
    default: Run | None
    family: Sequence[Run]

    @property
    def program(self):
        """What it is a way to use, which has a folder of its own; None if it is not counted.

        Linearised equations are no program, and a program of this project does not judge itself.
        """
        return None if self.said["kind"] in ("linear", "own") else self.folder

    @property
    def folder(self):
        """That of its script, which ways to use one program share."""
        return self.said["script"].partition("/")[0]

    @property
    def top(self):
        """The run that its name stands beside."""
        return self.best or self.default

    @property
    def order(self):
        """What halving the step or tolerance gives, where the error still falls; None if unknown.

        The middle one of the orders between neighbours in the family of the best run.
        """
        steps = {r["setting"][self.said["measure"]] for r in self.family}
        found = [
            x["order"] for x in self.said["orders"]
            if x["family"] == (self.best or {}).get("family") and x["order"] > 0
            and {x["from"], x["to"]} <= steps
        ]  # fmt: skip
        return median(found) if found else None


def shown(document):
    """Every program that was run, the most right first."""
    found = []
    for said in document["programs"].values():
        runs = [r for r in said["runs"] if r["failure"] is None]
        best = next((r for r in runs if r["setting"] == said["best"]), None)
        default = next((r for r in runs if r["kind"] == "default"), None)
        family = [r for r in runs if best and r["family"] == best["family"]]
        family.sort(key=lambda r: -r["setting"][said["measure"]])
        kind = KINDS.get(said.get("kind"), OTHER)
        if runs:
            found.append(Shown(said["program"], kind, said, runs, best, default, family))
    return sorted(found, key=lambda p: -p.top["digits"])


def parts(document):
    """The parts of the page, by their markers."""
    programs = shown(document)
    return {
        "machine": machine(document),
        "race": race(document, [p for p in programs if p.said["kind"] != "linear"]),
        "digits": digits_table(programs),
        "best": best_table(programs),
        "falling": falling(programs),
        "left out": left_out(document),
        "default": default_table(programs),
        "passing": passing(programs),
        "below": below(programs),
        "columns": columns(programs),
        "contact": contact(programs),
        "textbook": textbook(programs),
        "blind": blind(),
        "apart": apart(programs),
        **harder(document),
    }


def machine(document):
    m, started = document["machine"], document["started"]
    when = "in one session" if len(started) == 1 else f"in {len(started)} sessions"
    days = sorted({x.partition("T")[0] for x in started})
    return (
        f"Measured on one of {m['cores']} cores of {m['cpu']}, {m['system']}, {when}, "
        f"{' to '.join(sorted({days[0], days[-1]}))}."
    )


def digits_table(programs):
    """Correct digits of each program at its best and at its default settings."""
    return table(
        ("program", f"best run within {BUDGET} s", "default settings"),
        [
            (p.name, *(one_decimal(r["digits"]) if r else "" for r in (p.best, p.default)))
            for p in programs
        ],
    )


def best_table(programs):
    return table(
        ("program", "what it is", "best run", "digits", "worst column", "eq. (1) [%]", "time [s]",
         "steps or calls", "order", "definitions"),
        [
            (_link(p), p.kind.words, p.best["words"], *_result(p.best), counted(p.best),
             _order(p), _definitions(p.best))
            for p in programs if p.best
        ],
        left=3,
    )  # fmt: skip


def falling(programs):
    """Programs whose last run of the best family is more right than all before."""
    names = []
    for p in programs:
        *before, last = (r["digits"] for r in p.family) if p.family else (0.0,)
        if before and last - max(before) > FALLS:
            names.append(p.name)
    said = "The best run of these programs is the run with the finest step or tolerance"
    return f"{said}: {'; '.join(names)}."


def left_out(document):
    """Programs and runs that are not in the tables, and why."""
    programs = document["programs"].values()
    absent = [f"{p['program']} (`{p['install']}`)" for p in programs if p["missing"]]
    failed = [
        f"{p['program']} ({len(runs)}: “{_reason(runs[0])}”)"
        for p in programs if (runs := [r for r in p["runs"] if r["failure"]])
    ]  # fmt: skip
    said = [f"Programs that were not installed: {'; '.join(absent)}."] if absent else []
    if failed:
        what = "These programs have failed runs (number of runs, and message of the first)"
        said.append(f"{what}: {'; '.join(failed)}.")
    return " ".join(said) or "Every program was installed, and every run finished."


def _reason(run):
    """What a run that failed said, without the name of Python's exception."""
    return re.sub(r"^\w+Error: ", "", run["failure"]).rstrip(".:")


def default_table(programs):
    ordered = sorted((p for p in programs if p.default), key=lambda p: -p.default["digits"])
    return table(
        ("program", "default settings", "digits", "worst column", "eq. (1) [%]", "time [s]",
         "steps or calls"),
        [
            (p.name, p.default["words"], *_result(p.default), counted(p.default))
            for p in ordered
        ],
        left=2,
    )  # fmt: skip


def _link(p):
    said = p.said
    return f"[{p.name}](../../data/peers/{said['script']}) {said['version'].partition(',')[0]}"


def _result(run):
    worst = run["worst"]
    return (
        one_decimal(run["digits"]),
        f"{label(worst['column'])}, {worst['maneuver']}",
        drift(judged(run, JUDGED)["performance"]),
        seconds(run["cpu"]),
    )


def _order(p):
    if p.order is None:
        return ""
    return f"{'h' if p.said['measure'] == 'step' else 'tol'}^{p.order:.1f}"


def _definitions(run):
    return ", ".join(f"`{x}`" for x in run["definitions"].values()) or "the default ones"


@dataclass(frozen=True)
class Claim:
    """What constant energy says of a motion, in numbers.

    Attributes
    ----------
    programs
        How many were run; several ways to use one are one.
    blind
        Of those with a run that passes eq. (1) in every maneuver and is not right to a thousandth,
        the errors of these runs [%], the largest first, by name.
    most, between
        The largest of these errors [%], of runs that step to the rows or whose method has an
        interpolation of its own order; and of those that fill rows by a dense output.
    alike
        Correct digits of the runs whose largest eq. (1) is between the limits `ALIKE`, ascending.
    runs
        Number of all runs of these programs.
    """

    programs: int
    blind: Mapping[str, Sequence[float]]
    most: float
    between: float
    alike: Sequence[float]
    runs: int


def claim(programs):
    counted = [p for p in programs if p.program]
    names = {p.program: p.name for p in sorted(counted, key=lambda p: -len(p.name))}
    errors = {
        name: sorted(
            (100 * 10 ** -r["digits"]
             for p in counted if p.program == program for r in p.runs if is_blind(r)),
            reverse=True,
        )
        for program, name in names.items()
    }  # fmt: skip
    blind = sorted((x for x in errors.items() if x[1]), key=lambda x: -x[1][0])
    most = dict.fromkeys((False, True), 0.0)
    for r in (r for p in counted for r in p.runs if is_blind(r)):
        is_dense = "dense output" in r["family"]
        most[is_dense] = max(most[is_dense], 100 * 10 ** -r["digits"])
    low, high = ALIKE
    alike = [r["digits"] for p in counted for r in p.runs if low <= largest(r) < high]
    runs = sum(len(p.runs) for p in counted)
    return Claim(len(names), dict(blind), most[False], most[True], sorted(alike), runs)


def _claimed(found):
    """The claim, with the largest errors."""
    said = (
        f"Of {found.programs} programs, {len(found.blind)} have at least one run that passes "
        "eq. (1) in all three maneuvers, although a column is wrong by more than 0.1 % of its "
        "largest value. "
    )
    if found.between > found.most:
        return said + (
            f"The largest of these errors is {found.between:.2g} %, in a run that interpolates its "
            "rows between its steps. Without interpolated rows, the largest of these errors is "
            f"{found.most:.2g} %."
        )
    return said + f"The largest of these errors is {found.most:.2g} %."


def passing(programs):
    found = claim(programs)
    named = "; ".join(f"{name} {_among(errors)}" for name, errors in found.blind.items())
    typical = [p.name for p in programs if p.program and p.default and is_blind(p.default)]
    told = f" At default settings: {'; '.join(typical)}." if typical else ""
    return f"{_claimed(found)} The errors by program: {named}.{told} {_range(found)}"


def readme_claim(programs):
    found = claim(programs)
    where = "[Compared software](docs/field.md) names the programs."
    return f"{_claimed(found)} {where} {_range(found)}"


def _range(found):
    return (
        f"In {len(found.alike)} of {found.runs} runs, the largest value of eq. (1) in the three "
        "maneuvers is between 1e-5 and 1e-4 %, below the limit by a factor of at least ten. Yet "
        f"these runs have only {one_decimal(found.alike[0])} to {one_decimal(found.alike[-1])} "
        "correct digits."
    )


def _among(errors):
    """Errors [%] of some runs, the largest first."""
    if len(errors) == 1:
        return f"{errors[0]:.2g} %"
    return f"{errors[-1]:.2g} to {errors[0]:.2g} % ({len(errors)} runs)"


def columns(programs):
    found = by_column(programs)
    worst = ", ".join(f"{label(key)} ({n})" for key, n in found.worst.most_common())
    wrong = ", ".join(f"{label(key)} ({n})" for key, n in found.wrong.most_common())
    return (
        f"Worst column in the best run of each of the {found.worst.total()} programs, with the "
        f"number of programs: {worst}. {found.blind} programs have a run that passes eq. (1) in "
        "all maneuvers although columns are wrong by more than a thousandth of their largest "
        f"value. These columns, with the number of programs: {wrong}."
    )


@dataclass(frozen=True)
class ByColumn:
    """Programs, each once, by the column that is wrong.

    Attributes
    ----------
    worst
        Of the best run.
    wrong
        By more than a thousandth in a run that passes eq. (1) in all maneuvers.
    blind
        Programs with such a run.
    """

    worst: Counter[str]
    wrong: Counter[str]
    blind: int


def by_column(programs):
    best, blind = {}, {}
    for p in (p for p in programs if p.program):
        if p.best:
            best.setdefault(p.program, p.best["worst"]["column"])
        for r in filter(is_blind, p.runs):
            wrong = {key for key in BENCHMARK_COLUMNS if r["scd"][key] < RIGHT}
            blind.setdefault(p.program, set()).update(wrong)
    wrong = {key: sum(key in keys for keys in blind.values()) for key in BENCHMARK_COLUMNS}
    return ByColumn(Counter(best.values()), Counter(wrong), len(blind))


def below(programs):
    """Runs by the line on which a motion is as right as its energy is constant."""
    runs = [r for p in programs if p.program for r in p.runs]
    less = sum(r["digits"] < 2 - math.log10(max(largest(r), LEAST)) for r in runs)
    fine = [r["digits"] for r in runs if largest(r) < FINE]
    return (
        "On the dashed line the relative error of a motion equals the variation of its energy. "
        f"{'All' if less == len(runs) else f'{less} of the'} {len(runs)} runs of the programs lie "
        f"below this line. Of the runs with an eq. (1) below {FINE:g} %, the worst has "
        f"{one_decimal(min(fine))} correct digits."
    )


_CONTACT = "implicit, elliptic cone, contact time constant "


def contact(programs):
    """What a contact that yields costs: families of MuJoCo at the shortest step that all have."""
    [p] = [p for p in programs if p.folder == "mujoco"]
    by_step = {}
    for r in p.runs:
        if r["family"].startswith(_CONTACT):
            by_step.setdefault(r["setting"]["step"], []).append(r)
    most = max(map(len, by_step.values()))
    step, runs = min((h, found) for h, found in by_step.items() if len(found) == most)
    said = "; ".join(
        f"{one_decimal(r['digits'])} ({r['family'].removeprefix(_CONTACT)})"
        for r in sorted(runs, key=lambda r: -r["digits"])
    )
    return (
        f"Correct digits of MuJoCo (implicit, elliptic cone) with steps of {step:.3g} s, by the "
        f"time constant of the contact: {said}."
    )


def textbook(programs):
    """The runs of the plain code of this project that pass eq. (1) everywhere and are wrong."""
    [p] = [p for p in programs if p.folder == "maximal"]
    said = [
        f"{r['words']}: the largest eq. (1) is {drift(largest(r))} %, the largest error "
        f"{100 * 10 ** -r['digits']:.2g} %"
        for r in p.runs if is_blind(r)
    ]  # fmt: skip
    best = one_decimal(p.best["digits"])
    return f"{'; '.join(said)}. The best run of the script has {best} correct digits."


def blind():
    """The first files of new codes, and what the judge said of them."""
    told = tomllib.loads(BLIND.read_text(encoding="utf-8"))["file"]
    return table(
        ("program", "first file", "`score`", "`diagnose`", "in truth"),
        [tuple(x[key] for key in ("program", "run", "score", "diagnose", "truth")) for x in told],
        left=5,
    )


def apart(programs):
    found = [(p.best["digits"] - p.default["digits"], p) for p in programs if p.best and p.default]
    least, most = min(found, key=lambda x: x[0]), max(found, key=lambda x: x[0])
    return (
        f"Default settings and the best run differ by {least[0]:.1f} ({least[1].name}) to "
        f"{most[0]:.1f} digits ({most[1].name})."
    )


def pages(document):
    """The pages with their generated parts, by file."""
    found = parts(document)
    tables = {name: found.pop(name) for name in _IN_TABLES}
    claimed = {"claim": readme_claim(shown(document))}
    places = {PAGE: found, TABLES: tables, README: claimed}
    return {page: filled(page.read_text(encoding="utf-8"), x) for page, x in places.items()}


def figures(document):
    programs = shown(document)
    return {name: render(draw(programs), "svg") for name, draw in FIGURES.items()}


if __name__ == "__main__":
    measured = json.loads(RUN.read_text(encoding="utf-8"))
    for page, text in pages(measured).items():
        page.write_text(text, encoding="utf-8")
    for file, data in figures(measured).items():
        (DOCS / file).write_bytes(data)
