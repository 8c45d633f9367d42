"""The race of docs/field.md: what the benchmark asks for, the cheapest run that passes eq. (1)."""

from field_figures import PASSES, RIGHT
from field_harder import counted, times
from heyoka_bike.showing.wording.number_text import number, one_decimal
from speed_page import table


def judged(run, maneuver):
    """What a run has of a maneuver."""
    return next(m for m in run["maneuvers"] if m["maneuver"] == maneuver)


def race(document, programs):
    """The table, what is said below it, and on what it was measured."""
    found = document["race"]
    named = {name: p for p in programs for name, x in document["programs"].items() if x is p.said}
    rows = []
    for name, timed in sorted(found["rows"].items(), key=lambda x: x[1]["ratio"]):
        run = next(r for r in named[name].runs if r["setting"] == timed["setting"])
        rows.append((named[name], run, timed, judged(run, found["maneuver"])))
    groups = {}
    for row in rows:
        groups.setdefault(row[1]["language"], []).append(row)
    shown = [
        (language, p.name, run["words"], number(of["performance"]), one_decimal(of["digits"]),
         counted(of), times(timed["ratio"]), spread(timed["times"]))
        for language, group in groups.items() for p, run, timed, of in group
    ]  # fmt: skip
    head = ("right-hand side", "program", "coarsest passing run of the cheapest family",
            "eq. (1) [%]", "digits", "steps or calls", "time", "spread")  # fmt: skip
    said = _summary(rows, programs, found["maneuver"])
    return f"{table(head, shown, left=3)}\n\n{said} {_measured(found)}"


def spread(measured):
    """How much longer than the shortest the longest time is."""
    return f"{100 * (max(measured) / min(measured) - 1):.0f} %"


def _summary(rows, programs, maneuver):
    wrong = sum(of["digits"] < RIGHT for _, _, _, of in rows)
    passing = {
        p.folder for p in programs for r in p.runs if judged(r, maneuver)["performance"] < PASSES
    }
    none = dict.fromkeys(p.name for p in programs if p.folder not in passing)
    said = f"{wrong} of these {len(rows)} runs have fewer than three correct digits in maneuver "
    said += f"{maneuver}."
    own = [p.name for p, *_ in rows if p.said["kind"] == "own"]
    if own:
        said += " These runs are from this project, and do not count as programs: "
        said += f"{'; '.join(own)}."
    return f"{said} Programs without a passing run: {'; '.join(none)}." if none else said


def _measured(found):
    machine, load = found["machine"], [timed["load"] for timed in found["rows"].values()]
    beside = [x for timed in found["rows"].values() for x in timed["peer"]]
    return (
        f"Measured on one of {machine['cores']} cores of {machine['cpu']}, {machine['system']}, "
        f"{found['started'].partition('T')[0]}, at a load average of {min(load):.0f} to "
        f"{max(load):.0f}. Time is the fastest repetition divided by the fastest of "
        f"{found['peer']['name']}, which ran before and after each program, in "
        f"{1e3 * min(beside):.2g} to {1e3 * max(beside):.2g} ms and with "
        f"{found['peer']['digits']:.1f} digits. Spread is the slowest repetition divided by the "
        "fastest, minus one."
    )
