"""Run the benchmark with the programs of `field.toml`, and score what they give.

``python data/peers/field.py mujoco`` runs all settings of MuJoCo and prints their true errors;
``--all`` runs every program that is here, one after the other. ``-o docs/field.json`` writes
what was measured, from which ``python docs/_site/field_page.py`` makes the page and the figures;
what stands there already of this machine and these versions is kept. ``--submit`` also writes the
best and the default run into ``data/results``. ``--problem H4`` runs a problem of the harder tier
instead, whose reference is below ``--sets`` (docs/harder-tier.md has the line that makes it). A
program is a folder here with a script ``bicycle.py``, whose ``simulate`` gives the rows of a
maneuver, the processor time and, where it can tell, the number of its steps or calls; or with
``bicycle.cpp`` or ``bicycle.mjs``, which reads lines "name value" from standard input and writes
the rows, and as an error message the others.
"""

import argparse
import gzip
import hashlib
import importlib.util
import json
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
from apart import AbsentError, Apart, FailedError
from measured import (
    H1,
    Document,
    described,
    fingerprint,
    lacking,
    named,
    settings,
    submitted,
    write,
)
from peer import Peer
from problem import ALL_DIGITS, Problem, problems

from heyoka_bike.errors import BicycleError
from heyoka_bike.system.console import stage_bar
from heyoka_bike.system.machine import machine

HERE = Path(__file__).resolve().parent
RESULTS = HERE.parent / "results"
SUBMITTED = ("program", "version", "method", "coordinates", "precision", "model", "contact")
COUNTED = ("steps", "calls")
LIMIT = 900  # of a run of all maneuvers, and of deriving or compiling a program [s]


def simulator(folder, build):
    """The function of a program's script, or one that starts the program built here."""
    sys.path.append(str(HERE))  # scripts share the folder `equations`
    if not build:
        spec = importlib.util.spec_from_file_location(
            f"{folder}_bicycle", HERE / folder / "bicycle.py"
        )
        script = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(script)
        return script.simulate
    place, script = Path(tempfile.mkdtemp()), HERE / folder / "bicycle.mjs"
    if script.exists():  # "build" installs what it imports, where node looks for it
        _built(build.split(), place)
        command = ["node", shutil.copy(script, place)]
    else:
        line = [sys.executable if word == "python" else word for word in build.split()]
        command = [place / "bicycle"]
        _built([*line, "-o", *command], HERE / folder)

    def simulate(p, speed, roll_rate, **setting):
        said = {**p, "speed": speed, "roll_rate": roll_rate, "rate": 100, **setting}
        lines = "".join(f"{name} {value}\n" for name, value in said.items())
        done = subprocess.run(command, input=lines, capture_output=True, text=True, check=True)
        rows = np.array([line.split() for line in done.stdout.splitlines()], float)
        cpu, *counted = done.stderr.split()
        return rows, float(cpu), dict(zip(counted[::2], map(int, counted[1::2]), strict=True))

    return simulate


def _built(line, place):
    subprocess.run(line, cwd=place, check=True, capture_output=True, text=True)


def run(simulate, name, setting, digits):
    """Text of a result file of a problem; of each maneuver processor time, steps or calls."""
    problem = Problem.of(name)
    # Rows are 0.01 s apart unless a script is told otherwise.
    more = {} if problem.rate == 100 else {"rate": problem.rate}
    found = [simulate(problem.bicycle, *start, **setting, **more) for start in problem.starts]
    for rows, *_ in found:
        if len(rows) != problem.rows:
            raise ArithmeticError(f"ends at {(len(rows) - 1) / problem.rate:g} s")
    values = np.hstack([rows for rows, *_ in found]) + 0.0
    text = problem.text(values, [digits] * values.shape[1])
    return text, [{"cpu": cpu} | dict(*counted) for _, cpu, *counted in found]


def submit(entry, name, problem, setting, text, line):
    """Write a result file and its submission."""
    kind, path = line["kind"], result_file(name, line["kind"], problem.name)
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(gzip.compress(text.encode(), 9, mtime=0))
    said = {key: entry.get(f"{kind}_{key}", entry[key]) for key in SUBMITTED}
    said["name"] = f"{entry['program']}, {kind}: {entry[kind + '_words']}"
    said["problem"] = problem.name
    measure = "step" if entry["measure"] == "step" else "tolerance"
    said[measure] = f"{setting[entry['measure']]:.10g}"
    said["processor_time"] = f"{line['cpu']:.3g}"
    said |= {key: str(line[key]) for key in COUNTED if key in line}
    m = machine()
    said["machine"] = f"{m['cpu']}, 1 of {m['cores']} processors, {m['system']}"
    said["licence"] = "CC0-1.0"
    lines = [f'{key} = "{value}"' for key, value in said.items()]
    sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
    lines += ["", "[[file]]", f'path = "{path.name}"', f'sha256 = "{sha256}"']
    lines += [f"maneuver = {problem.only}"] if problem.only else []
    path.with_name(path.name.replace(".txt.gz", ".toml")).write_text(
        "\n".join(lines) + "\n", encoding="utf-8"
    )


def result_file(name, kind, problem=H1):
    """Where a submission's rows are."""
    if problem == H1:
        return RESULTS / f"{name}-{kind}.txt.gz"
    return RESULTS / "harder" / f"{problem}-{name}-{kind}.txt.gz"


def running(name):
    """The function that runs a setting of a program, see `run`."""
    entry = read_field()[name]
    # Asked for by name: a folder here that is called like a package can be imported as well.
    if names := lacking(entry["install"]):
        raise ImportError(f"no package {', '.join(names)}")
    return partial(run, simulator(entry.get("folder", name), entry.get("build")))


def read_field():
    """The programs of `field.toml`, by their names."""
    return tomllib.loads((HERE / "field.toml").read_text(encoding="utf-8"))


def digits(entry, kind, problem=H1):
    """How many are written of each number: some more than are right."""
    return entry.get(f"{kind}_digits", entry["digits"]) if problem == H1 else ALL_DIGITS


def measure(entry, run, problem, kind, setting, reference):
    """What a run gives, or why it fails; and the text of its result file."""
    written = digits(entry, kind, problem.name)
    try:
        text, costs = run(problem.name, setting, written)
        found = problem.judge(text, reference)
        if kind != "sweep":
            text = problem.shortened(text, reference, written)
            found = problem.judge(text, reference)
    except (FailedError, BicycleError) as e:
        return {"failure": str(e)}, ""
    of_all = Counter()
    for maneuver, cost in zip(found["maneuvers"], costs, strict=True):
        of_all.update(cost)
        maneuver |= cost | {"cpu": significant(cost["cpu"])}
    if not set(COUNTED) & set(of_all) and entry["measure"] == "step":
        of_all["steps"] = round(problem.seconds / setting["step"])
    return {"failure": None} | found | of_all | {"cpu": significant(of_all["cpu"])}, text


def significant(seconds):
    """In four digits: the shortest runs take less than a millisecond."""
    return float(f"{seconds:.4g}")


def is_submitted(name, problem, line):
    """Whether the result file of a run is that of this line."""
    path = result_file(name, line["kind"], problem)
    if not path.is_file():
        return False
    return hashlib.sha256(gzip.decompress(path.read_bytes())).hexdigest() == line["sha256"]


def judge_again(path, reference):
    """Judge the published result files of the benchmark, and write what each maneuver has.

    Only of a run whose file is still that of its line, and whose digits are still those; gives a
    line for each. Nothing is run.
    """
    content = json.loads(path.read_text(encoding="utf-8"))
    problem, said = Problem.of(H1), []
    for name, program in content["programs"].items():
        for line in program["runs"]:
            if line["failure"] or line["kind"] == "sweep" or not is_submitted(name, H1, line):
                continue
            text = gzip.decompress(result_file(name, line["kind"]).read_bytes()).decode()
            found, of = problem.judge(text, reference), f"{program['program']}, {line['kind']}"
            if found["digits"] != line["digits"]:
                said.append(f"{of}: found {found['digits']} digits, expected {line['digits']}")
                continue
            known = {m["maneuver"]: m for m in line.get("maneuvers", ())}
            line["maneuvers"] = [known.get(m["maneuver"], {}) | m for m in found["maneuvers"]]
            digits = ", ".join(f"{m['digits']:.2f}" for m in line["maneuvers"])
            said.append(f"{of}: {digits} digits in maneuvers 1, 2, 3")
    write(path, content)
    return said


def all_runs(name, entry, problem, reference, asked, document, tell, against):
    """Run the settings of a program that are not written down already, and write them down.

    Gives why not, if it is not here.
    """
    said = described(entry, HERE / entry.get("folder", name))
    lines = []
    with Apart(asked.limit, running, name) as program:
        for kind, setting in settings(entry, problem.name):
            is_sent = asked.submit and kind in submitted(entry, problem.name)
            of = () if problem.name == H1 else (problem.name,)
            made_of = fingerprint(said, setting, digits(entry, kind, problem.name), *of)
            line = None if asked.again else document.line(name, problem.name, kind, made_of)
            if line is None or (is_sent and not is_submitted(name, problem.name, line)):
                tell(f"{entry['program']}, {problem.name}, {kind}", None)
                try:
                    program.start()
                except AbsentError as e:
                    document.absent(name, said, str(e))
                    return str(e)
                found, text = measure(entry, program, problem, kind, setting, reference)
                line = {"kind": kind, "started": document.started, "made_of": made_of, **found}
                if line["failure"] is None:
                    line |= against.beside(line["cpu"], problem.seconds)
                    line |= {"sha256": hashlib.sha256(text.encode()).hexdigest()}
                    if is_sent:
                        submit(entry, name, problem, setting, text, line)
            about = named(entry, kind, setting)
            lines.append({**about, **line, **about})
            document.keep_runs(name, said, problem.name, lines)
            tell(f"{entry['program']}, {problem.name}, {kind}", lines[-1])
    return None


def words(line):
    """A run in a line."""
    if line["failure"]:
        return f"{line['kind']} {line['setting']} fails: {line['failure']}"
    worst, drifts = line["worst"], " ".join(f"{x:.1e}" for x in line["performance"])
    return (
        f"{line['kind']} {line['setting']} {line['digits']:.2f} digits ({worst['column']} of "
        f"{worst['maneuver']}), eq. (1) {drifts}, CPU {line['cpu']:.3g} s, {line['ratio']:g} times "
        f"the peer's, {line['definitions']}"
    )


def main():
    """Run, print a line for each run, write the JSON after each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("names", metavar="NAME", nargs="*", help="programs of field.toml")
    parser.add_argument("--all", action="store_true", help="all of them")
    parser.add_argument("-o", "--output", metavar="FILE", type=Path, help="write this JSON")
    parser.add_argument("--again", action="store_true", help="keep nothing that the JSON has")
    parser.add_argument("--submit", action="store_true", help="best and default into data/results")
    parser.add_argument(
        "--judge", action="store_true",
        help="run nothing: judge the files of data/results, write the digits of each maneuver",
    )  # fmt: skip
    parser.add_argument(
        "--problem", action="append", choices=["H1", "H2", "H3", "H4"], default=[],
        help="of the harder tier, may be repeated (default: H1, the benchmark)",
    )  # fmt: skip
    parser.add_argument(
        "--sets", type=Path, default=Path("sets"), metavar="FOLDER",
        help="where the references of the harder tier are (default: sets)",
    )  # fmt: skip
    parser.add_argument(
        "--rows", choices=["prove", "compute"],
        help="where a reference is not there, prove its rows alone, or take them of a run in 70 "
        "digits: minutes or seconds in place of hours",
    )  # fmt: skip
    parser.add_argument(
        "--limit", type=float, default=LIMIT, metavar="SECONDS", help="of a run (default: 900)"
    )
    asked, field = parser.parse_args(), read_field()
    if asked.judge:
        if asked.output is None or not asked.output.exists():
            parser.error("--judge: found no file, expected -o with the JSON of an earlier run")
        print(*judge_again(asked.output, Problem.of(H1).reference(asked.sets)), sep="\n")
        return
    names = list(field) if asked.all else asked.names
    if unknown := [x for x in names if x not in field]:
        parser.error(f"found '{unknown[0]}', expected some of {', '.join(field)}")
    if not names:
        parser.error("found no program, expected --all or some of " + ", ".join(field))
    # Ended from outside, it ends what it runs.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    todo = [Problem.of(x) for wanted in asked.problem or [H1] for x in problems(wanted)]
    try:
        references = [problem.reference(asked.sets, asked.rows) for problem in todo]
    except BicycleError as e:
        parser.error(str(e))
    against = Peer()
    document = Document.of(asked.output, machine(), against.said(), list(field))
    total = sum(len(settings(field[x], problem.name)) for x in names for problem in todo)
    done, absent = 0, {}
    with stage_bar() as bar:

        def tell(doing, line):
            nonlocal done
            if line is not None:
                done += 1
                print(doing.rpartition(",")[0], words(line), flush=True)
            bar(doing, done / total)

        for name in names:
            for problem, reference in zip(todo, references, strict=True):
                why = all_runs(
                    name, field[name], problem, reference, asked, document, tell, against
                )
                if why:
                    absent[name] = (
                        f"{field[name]['program']} is not here ({field[name]['install']})"
                    )
                    print(absent[name], why, sep=": ", flush=True)
                    break
    for line in absent.values():
        print(line, file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
