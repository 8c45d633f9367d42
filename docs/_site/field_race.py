"""The race of docs/field.md: what the benchmark asks for, the cheapest run that passes eq. (1)."""

import tomllib
from pathlib import Path

from field_figures import PASSES, RIGHT
from field_harder import times
from speed_page import table

from heyoka_bike.showing.wording import number, one_decimal

FIELD = Path(__file__).parent.parent.parent / "data" / "peers" / "field.toml"
# Maneuver 2, which the benchmark judges by eq. (1).
MANEUVER = 2


def race(programs):
    """The table, the programs that have no run which passes, and how many are right.

    Several ways to use one program are one: the cheapest.
    """
    said = tomllib.loads(FIELD.read_text(encoding="utf-8"))
    entries_of = {e["program"]: e for e in said.values()}
    fastest, others = {}, {}
    for p in programs:
        others.setdefault(p.folder, p.name)
        for run in p.runs:
            if run["performance"][MANEUVER - 1] < PASSES:
                known = fastest.get(p.folder)
                if known is None or cost(run) < cost(known[1]):
                    fastest[p.folder] = p, run
    groups = {}
    for p, run in sorted(fastest.values(), key=lambda x: cost(x[1])):
        groups.setdefault(_language(entries_of[p.name], run), []).append((p, run))
    rows = [
        (language, p.name, settings(p.said, run), number(run["performance"][MANEUVER - 1]),
         _digits(run), times(cost(run)))
        for language, found in groups.items() for p, run in found
    ]  # fmt: skip
    failing = [name for folder, name in others.items() if folder not in fastest]
    head = ("right-hand side", "program", "cheapest run that passes", "eq. (1) [%]", "digits",
            "time")  # fmt: skip
    runs = [run for _, run in fastest.values()]
    return f"{table(head, rows, left=3)}\n\n{_summary(runs, failing)}"


def cost(run):
    """Processor time of the maneuver, over that of the peer's for as long a motion.

    Where a run has the time of all its maneuvers only, it is that of all.
    """
    own = _judged(run).get("cpu")
    share = 1 if own is None else len(run["performance"]) * own / run["cpu"]
    return run["ratio"] * share


def digits(run):
    """Correct digits of the maneuver, and whether there may be more.

    The worst of all maneuvers has no more digits than this one.
    """
    known = _judged(run).get("digits")
    if known is not None:
        return known, False
    return run["digits"], run["worst"]["maneuver"] != MANEUVER


def settings(said, run):
    """A run in words: those that it has, else its step or tolerance and the rest."""
    if run["words"]:
        return run["words"]
    measure, others = said["measure"], dict(run["setting"])
    first = f"{'h' if measure == 'step' else measure} = {others.pop(measure):g}"
    return ", ".join([first, *(f"{name} = {value}" for name, value in others.items())])


def _judged(run):
    return next((m for m in run.get("maneuvers", ()) if m["maneuver"] == MANEUVER), {})


def _digits(run):
    found, is_least = digits(run)
    return f"at least {one_decimal(found)}" if is_least else one_decimal(found)


def _language(entry, run):
    return entry.get(f"{run['kind']}_language", entry["language"])


def _summary(runs, failing):
    found = [digits(run) for run in runs]
    wrong = sum(x < RIGHT and not is_least for x, is_least in found)
    unknown = sum(x < RIGHT and is_least for x, is_least in found)
    whole = sum("cpu" not in _judged(run) for run in runs)
    said = [f"Fewer than three correct digits in maneuver 2: {wrong} of these {len(runs)} runs"]
    said[0] += f", and up to {unknown} more." if unknown else "."
    if any(is_least for _, is_least in found):
        said.append(
            '"At least" stands where only the worst digits of all three maneuvers were recorded.'
        )
    if whole:
        said.append(f"The times of {whole} runs are of all three maneuvers, for the same reason.")
    said += [f"No run that passes: {'; '.join(failing)}."] if failing else []
    return " ".join(said)
