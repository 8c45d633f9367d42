"""How often the right mistake is named: the table of docs/reference/mistakes.md.

Every usual mistake is made by another integrator (`mistaken_programs`), with a smooth error of each
level of the columns' scales added, and diagnosed. Run as a script, this writes the table, which
takes long; `--kept` lets it go on where it was ended. `--new` diagnoses only the mistakes that the
page lacks, and keeps the other answers of the page.
"""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from textwrap import fill

sys.path.append(str(Path(__file__).parents[2] / "tests"))

from generators.mistaken_programs import SEEN, columns_of, distance, results
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.alignment import align
from heyoka_bike.scoring.diagnosis.explain import explain
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES
from heyoka_bike.scoring.diagnosis.programs.program import clock_mistake, output_mistake
from heyoka_bike.scoring.diagnosis.programs.simulator import Simulator
from heyoka_bike.system.parallel import processors
from heyoka_bike.system.threads import one_thread_of_linear_algebra
from marked_parts import filled, split

PAGE = Path(__file__).parent.parent / "reference" / "mistakes.md"

LEVELS = {"none": 0.0, "1e-6": 1e-6, "1e-4": 1e-4}
# Number of characters in a line of the pages.
WIDTH = 150
# Without an error of the integrator, that of the two simulations is left.
LEAST = 1e-11


def order(says, **sources):
    """Columns in each other's place: by the key written, the key computed."""
    sources = {key: sources[key] for key in BENCHMARK_COLUMNS if key in sources}
    return output_mistake(
        "columns_" + "_".join(f"{source}_as_{key}" for key, source in sources.items()),
        says,
        "",
        lambda c, _: {**c, **{key: c[source] for key, source in sources.items()}},
    )


READ_OFF_THE_FILE = (
    order("roll and steer angle are exchanged", roll_angle="steer_angle", steer_angle="roll_angle"),
    order("roll and steer rate are exchanged", roll_rate="steer_rate", steer_rate="roll_rate"),
    order("steer angle and rate are exchanged", steer_angle="steer_rate", steer_rate="steer_angle"),
    order("kinetic and potential energy are exchanged", kinetic_energy="potential_energy",
          potential_energy="kinetic_energy"),
    order("the mechanical energy comes first", potential_energy="mechanical_energy",
          kinetic_energy="potential_energy", mechanical_energy="kinetic_energy"),
    order("steer angle and rate come before all others",
          **dict(zip(BENCHMARK_COLUMNS, BENCHMARK_COLUMNS[-2:] + BENCHMARK_COLUMNS[:-2],
                     strict=True))),
    clock_mistake("time_scaled", "the step is 1 % longer than written", "", scale=1.01),
)  # fmt: skip
HYPOTHESES = (*MISTAKES, *READ_OFF_THE_FILE)


def alike(files, names, limit, scales):
    """Of each file, those that are as close to it as that, itself among them."""
    return {
        a: {b for b in names if b == a or distance(files[a], files[b], scales) < limit}
        for a in names
    }


def outcome(code, level, files, close, reference, simulator):
    """What is expected and what is said, in a word or two, and whether that is right."""
    parts = align(results(reference, files[code], level), reference).parts
    found = explain(parts, reference, simulator=simulator)
    first = {h.codes for h in found.classes[0]} if found.classes else set()
    is_named = any((c,) in first for c in close)
    if "" in close:
        return "not visible" if not first or is_named else f"not visible, named {sorted(first)}"
    if is_named:
        return "right" if len(close) == 1 else "right class"
    return f"wrong: {sorted(first)}" if first else "nothing named"


_SHARED = {}
"""Files, close ones by level, reference and simulator, inherited by the processes."""


def _outcome(case):
    """Outcome of a level and a code."""
    name, code = case
    close = _SHARED["close"][name][code]
    files, reference, simulator = (_SHARED[k] for k in ("files", "reference", "simulator"))
    return outcome(code, _SHARED["levels"][name], files, close, reference, simulator)


def is_right(said):
    return said in ("right", "right class", "not visible")


def table(reference, hypotheses=HYPOTHESES, levels=LEVELS, report=lambda *_: None, known=()):
    """Of each hypothesis, how far it is from the correct file and what is said at each level.

    What is said is reported as it is found, by level and code; what is `known` is not found again.
    """
    scales = {(n, k): reference[n].scale(k) for n in reference for k in BENCHMARK_COLUMNS}
    files = {"": columns_of(reference, [])}
    files |= {m.code: columns_of(reference, [m]) for m in hypotheses}
    close = {
        name: alike(files, list(files), SEEN * max(level, LEAST), scales)
        for name, level in levels.items()
    }
    _SHARED.update(
        files=files, close=close, levels=levels, reference=reference, simulator=Simulator()
    )
    classes = {name: {frozenset(c) for c in x.values() if len(c) > 1} for name, x in close.items()}
    found, cases = dict(known), [(name, m.code) for name in levels for m in hypotheses]
    asked = [case for case in cases if case not in found]
    pool = ProcessPoolExecutor(processors(), get_context("fork"))
    with one_thread_of_linear_algebra(), pool:
        for case, told in zip(asked, pool.map(_outcome, asked), strict=True):
            found[case] = told
            report(*case, told)
    said = {m.code: {name: found[name, m.code] for name in levels} for m in hypotheses}
    far = {m.code: distance(files[m.code], files[""], scales) for m in hypotheses}
    return said, far, classes


def markdown(said, far, classes):
    lines = [
        "| error of the integrator | right, of the visible mistakes | not visible |",
        "|---|---|---|",
    ]
    for name in LEVELS:
        visible = [s[name] for s in said.values() if not s[name].startswith("not visible")]
        hidden = [c for c, s in said.items() if s[name].startswith("not visible")]
        listed = ", ".join(f"`{c}`" for c in hidden)
        lines.append(f"| {name} | {sum(map(is_right, visible))} of {len(visible)} | {listed} |")
    lines += [
        "",
        "Mistakes whose files differ by less than three times the error form one class:",
        "",
    ]
    for name, found in classes.items():
        groups = sorted(sorted(c) for c in found if "" not in c)
        told = "; ".join(", ".join(f"`{c}`" for c in g) for g in groups)
        if told:
            listed = f"- error {name}: {told}"
            lines.append(fill(listed, WIDTH, subsequent_indent="  ", break_on_hyphens=False))
    lines += [
        "",
        "| mistake | what the program does | moves | " + " | ".join(LEVELS) + " |",
        "|---|---|---|" + "---|" * len(LEVELS),
    ]
    for m in HYPOTHESES:
        cells = " | ".join(said[m.code][name] for name in LEVELS)
        lines.append(f"| `{m.code}` | {m.says} | {far[m.code]:.0e} | {cells} |")
    return "\n".join(lines)


def committed():
    """What the page says: by code, the words of each level."""
    _, text, _ = split(PAGE.read_text(encoding="utf-8"), "recognised")
    rows = [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| `")]
    return {row[0].strip("`"): dict(zip(LEVELS, row[3:], strict=True)) for row in rows}


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("reference", nargs="?", help="folder of the set (that of this repository)")
    words.add_argument(
        "--kept",
        type=Path,
        help="file of what was said, a line each: what is in it is not made again",
    )
    words.add_argument(
        "--new", action="store_true", help="diagnose only the mistakes that the page lacks"
    )
    asked = words.parse_args()
    lines = asked.kept.read_text("ascii").splitlines() if asked.kept and asked.kept.exists() else []
    known = {tuple(head.split(" ")): told for head, told in (x.split(": ", 1) for x in lines)}
    if asked.new:
        known |= {
            (name, code): told for code, of in committed().items() for name, told in of.items()
        }

    def report(name, code, told):
        line = f"{name} {code}: {told}"
        print(line, flush=True)
        if asked.kept:
            with asked.kept.open("a", encoding="ascii") as file:
                file.write(f"{line}\n")

    reference = load_reference(asked.reference) if asked.reference else load_reference()
    made = markdown(*table(reference, report=report, known=known))
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(filled(page, "recognised", made), encoding="utf-8")


if __name__ == "__main__":
    main()
