"""The extended problem set in docs/reference/compared-software.md, from docs/field.json."""

from collections.abc import Mapping, Sequence
from typing import Any

from speed_page import table

from heyoka_bike.showing.wording import label, number, one_decimal

ALONE, EDGE = ("H2", "H4"), tuple(f"H3{x}" for x in "abcdef")
"""Problems with a table of their own, and those that share one."""
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
        "harder left out": left_out(document),
    }


def runs(document: Mapping[str, Any], problem: str) -> Sequence[tuple[Mapping[str, Any], Run]]:
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
        ("program", "run", "digits", "worst column", "eq. (1) [%]", "time", "steps or calls"),
        [
            (said["program"] + KINDS[r["kind"]], r["words"], _digits(r), _place(r),
             _drift(max(r["performance"])), times(r["ratio"]), counted(r))
            for said, r in runs(document, problem)
        ],
        left=2,
    )  # fmt: skip


def edge(document):
    """The table of H3: digits of each of its problems, and what all of them cost."""
    rows = {}
    for problem in EDGE:
        for said, r in _all(document, problem):
            rows.setdefault((said["program"], r["kind"]), {})[problem] = r
    ordered = sorted(rows.items(), key=lambda x: [-r.get("digits", -99) for r in x[1].values()])
    return table(
        ("program", "run", *EDGE, "time"),
        [
            (program + KINDS[kind], next(iter(found.values()))["words"],
             *(_digits(found[p]) if p in found else "" for p in EDGE),
             times(max(r.get("ratio", 0) for r in found.values())))
            for (program, kind), found in ordered
        ],
        left=2,
    )  # fmt: skip


def when(document):
    """Days of the runs."""
    days = {r["started"].partition("T")[0] for p in (*ALONE, *EDGE) for _, r in _all(document, p)}
    return f"Measured on the same machine, {' to '.join(sorted({min(days), max(days)}))}."


def left_out(document):
    """Runs that came to no end."""
    failed = {}
    for problem in (*ALONE, *EDGE):
        for said, r in _all(document, problem):
            if r["failure"]:
                failed.setdefault(said["program"] + KINDS[r["kind"]], []).append(problem)
    listed = "; ".join(f"{name} ({', '.join(found)})" for name, found in failed.items())
    return f"Came to no end: {listed}." if listed else "Every run came to its end."


def beside(document):
    """How far what a program reaches in H4 is from what it reaches in H1, at its best."""
    found = []
    for said, r in runs(document, "H4"):
        h1 = next((x for x in said["runs"] if x["kind"] == r["kind"] == "best"), None)
        if h1 and not h1["failure"]:
            found.append((r["digits"] - h1["digits"], said["program"]))
    least, most = min(found), max(found)
    return (
        f"At their best the {len(found)} programs reach in H4 between {-least[0]:.1f} digits less "
        f"({least[1]}) and {most[0]:.1f} more ({most[1]}) than in H1: none is tuned to one bicycle."
    )


def _all(document, problem):
    programs = document["programs"].values()
    return [(said, r) for said in programs for r in said.get("harder", {}).get(problem, ())]


def _digits(run):
    if run["failure"]:
        return "no end"
    return one_decimal(run["digits"]) if run["digits"] >= 0 else "none"


def _place(run):
    worst = run["worst"]
    return f"{label(worst['column'])}, {worst['maneuver']}"


def _drift(drift):
    return number(drift) if drift >= LEAST else f"< {LEAST:.0e}"
