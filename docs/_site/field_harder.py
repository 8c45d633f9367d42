"""The extended problem set in docs/reference/compared-software.md, from docs/field.json."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.showing.wording.number_text import number, one_decimal
from speed_page import table

ALONE, EDGE = ("H2", "H4"), tuple(f"H3{x}" for x in "abcdef")
"""Problems with a table of their own, and those that share one."""
TIER = Path(__file__).parent.parent / "harder-tier.json"
ON_SYMBRIM = {
    "SymBRiM, SciPy solve_ivp", "GNU Scientific Library", "Boost.odeint", "SUNDIALS CVODE",
    "RADAU of Hairer and Wanner", "diffrax",
}  # fmt: skip
"""Programs that integrate SymBRiM's equations."""
KINDS = {"best": "", "default": ", default settings"}
# Of eq. (1) [%]: what a last digit of an energy in binary64 makes.
LEAST = 2e-14

Run = Mapping[str, Any]


def harder(document):
    """The parts of the page, by their markers."""
    return {name: alone(document, name) for name in ALONE} | {
        "H3": edge(document),
        "harder machine": when(document),
        "harder beside": beside(document),
        "harder H2": longer(document),
        "harder left out": left_out(document),
        "harder absent": absent(document),
    }


def runs(document: Mapping[str, Any], problem: str) -> Sequence[tuple[str, Run]]:
    """Programs and runs of a problem that came to their end, the most right first."""
    found = _all(document, problem)
    return sorted((x for x in found if not x[1]["failure"]), key=lambda x: -x[1]["digits"])


def counted(run):
    """Steps or calls of a run."""
    said = (f"{run[key]:,} {key}" for key in ("steps", "calls") if key in run)
    return next(said, "")


def times(ratio):
    """How many times as long, in two digits."""
    return f"{ratio:.2g}" if ratio < 100 else f"{round(ratio, 2 - len(str(int(ratio)))):,.0f}"


def alone(document, problem):
    """The table of a problem."""
    return table(
        ("program", "run", "digits", "worst column", "eq. (1) [%]", "time [s]", "steps or calls"),
        [
            (name + KINDS[r["kind"]], r["words"], _digits(r), _place(r),
             drift(largest(r)), seconds(r["cpu"]), counted(r))
            for name, r in runs(document, problem)
        ],
        left=2,
    )  # fmt: skip


def edge(document):
    """The table of H3: digits of each of its problems, and what all of them cost."""
    rows = {}
    for problem in EDGE:
        for name, r in _all(document, problem):
            rows.setdefault((name, r["kind"]), {})[problem] = r
    ordered = sorted(rows.items(), key=lambda x: [-r.get("digits", -99) for r in x[1].values()])
    return table(
        ("program", "run", *EDGE, "time [s]"),
        [
            (program + KINDS[kind], next(iter(found.values()))["words"],
             *(_digits(found[p]) if p in found else "" for p in EDGE),
             seconds(max(r.get("cpu", 0) for r in found.values())))
            for (program, kind), found in ordered
        ],
        left=2,
    )  # fmt: skip


def when(document):
    """Days of the runs."""
    days = {r["started"].partition("T")[0] for p in (*ALONE, *EDGE) for _, r in _all(document, p)}
    m = document["harder"]["machine"]
    same = "the same machine as above" if m == document["machine"] else "another machine than above"
    return (
        f"Measured on {m['cpu']}, {m['cores']} cores, {m['system']}, {same}, "
        f"{' to '.join(sorted({min(days), max(days)}))}."
    )


def left_out(document):
    """Runs that came to no end."""
    failed = {}
    for problem in (*ALONE, *EDGE):
        for name, r in _all(document, problem):
            if r["failure"]:
                failed.setdefault(name + KINDS[r["kind"]], []).append(problem)
    listed = "; ".join(f"{name} ({', '.join(found)})" for name, found in failed.items())
    return f"Failed: {listed}." if listed else "Every run finished."


def absent(document):
    """Programs that were not run on these problems."""
    programs, done = document["programs"], document["harder"]["programs"]
    none = [said["program"] for name, said in programs.items() if name not in done]
    some = [
        x["program"] for x in done.values()
        if "H4" in x["problems"] and not {"H2", *EDGE} & x["problems"].keys()
    ]  # fmt: skip
    return f"- {len(none)} programs did not run on this set, and {len(some)} ran on H4 only."


def beside(document):
    """How far what a program reaches in H4 is from what it reaches in H1, at the same setting."""
    best = [(name, r) for name, r in _all(document, "H4") if r["kind"] == "best"]
    found = [(r["digits"] - r["beside"], name) for name, r in best if not r["failure"]]
    failed = [name for name, r in best if r["failure"]]
    least, most = min(found), max(found)
    said = f" Failed in H4: {'; '.join(failed)}." if failed else ""
    return (
        f"H4 has another bicycle than H1. With the best settings of that time the programs reach "
        f"from {-least[0]:.1f} digits fewer ({least[1]}) to {most[0]:.1f} digits more ({most[1]}) "
        f"in H4 than in H1.{said}"
    )


def longer(document):
    """What rounding leaves in SymBRiM's equations over 100 s, and in those of this project."""
    ends = [
        r["digits"] for name, r in runs(document, "H2")
        if r["kind"] == "best" and name in ON_SYMBRIM
    ]  # fmt: skip
    ours = json.loads(TIER.read_text(encoding="utf-8"))["H2"]["maneuvers"]
    [digits] = [m["codes"]["heyoka binary64"]["scd"] for m in ours.values()]
    return (
        f"- In H2 the {len(ends)} integrators on SymBRiM's equations end at "
        f"{one_decimal(min(ends))} to {one_decimal(max(ends))} digits. Rounding "
        f"limits these equations to that accuracy over 100 s. heyoka keeps {one_decimal(digits)} "
        "digits in binary64, on [equations of its own](harder-tier.md#how-hard-they-are)."
    )


def _all(document, problem):
    programs = document["harder"]["programs"].values()
    return [(said["program"], r) for said in programs for r in said["problems"].get(problem, ())]


def _digits(run):
    if run["failure"]:
        return "no end"
    return one_decimal(run["digits"]) if run["digits"] >= 0 else "none"


def _place(run):
    worst = run["worst"]
    return f"{label(worst['column'])}, {worst['maneuver']}"


def largest(run):
    """Eq. (1) [%] of the maneuver in which it is largest."""
    return max(m["performance"] for m in run["maneuvers"])


def drift(value):
    """An eq. (1) [%] in words."""
    return number(value) if value >= LEAST else f"< {LEAST:.0e}"


def seconds(cpu):
    """A processor time [s], in two digits."""
    return times(float(f"{cpu:.2g}"))
