"""Run the benchmark with the programs of `field.toml`, and score what they give.

``python data/peers/field.py mujoco`` runs MuJoCo by the rules of PROTOCOL.md and prints its true
errors; ``--all`` runs every program that is here, one after the other. ``-o docs/field.json``
writes what was measured, from which ``python docs/_site/field_page.py`` makes the pages; what
stands there already of this machine and these versions is kept. ``--submit`` also writes the best
and the default run into ``data/results``. ``--race`` then times the cheapest run of each program
that passes eq. (1); alone with ``-o`` it runs nothing else, for a machine that is quiet later.
``--problem H4`` runs a problem of the extended problem set instead, at the best and the default
settings of the JSON; its reference is below ``--sets`` (docs/harder-tier.md has the line that makes
it).

A program is a folder here with a script ``bicycle.py``, whose ``simulate`` gives the rows of a
maneuver, the processor time and, where it can tell, the number of its steps or calls; or with
``bicycle.cpp`` or ``bicycle.mjs``, which reads lines "name value" from standard input and writes
the rows, and as an error message the others.
"""

import argparse
import gzip
import hashlib
import importlib.util
import os
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
from measured import BUDGET, H1, Document, best, described, fingerprint, lacking, told
from problem import ALL_DIGITS, Problem, problems
from race import race

from heyoka_bike.errors import BicycleError
from heyoka_bike.system.console import stage_bar
from heyoka_bike.system.machine import machine

HERE = Path(__file__).resolve().parent
RESULTS = HERE.parent / "results"
SUBMITTED = ("program", "version", "method", "coordinates", "precision", "model", "contact")
COUNTED = ("steps", "calls")
LIMIT = 300  # of a run of all maneuvers, and of deriving or compiling a program [s]
# A sweep ends after so many refinements in a row that fail, or gain less than this [digits].
IDLE, GAIN = 2, 0.15
# By how much a step or a tolerance is divided, and the finest [s] and without unit.
STEP, TOLERANCE = (2, 1e-6), (10, np.finfo(float).eps)


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


def run(simulate, name, setting, only=None):
    """Text of a result file of a problem; of each maneuver processor time, steps or calls.

    Only one of its maneuvers, if one is named.
    """
    problem = Problem.of(name)
    # Rows are 0.01 s apart unless a script is told otherwise.
    more = {} if problem.rate == 100 else {"rate": problem.rate}
    starts = problem.starts if only is None else [problem.starts[only - 1]]
    found = [simulate(problem.bicycle, *start, **setting, **more) for start in starts]
    for rows, *_ in found:
        if len(rows) != problem.rows:
            raise ArithmeticError(f"ends at {(len(rows) - 1) / problem.rate:g} s")
    values = np.hstack([rows for rows, *_ in found]) + 0.0
    text = problem.text(values, [ALL_DIGITS] * values.shape[1])
    return text, [{"cpu": cpu} | dict(*counted) for _, cpu, *counted in found]


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


def measure(entry, run, problem, setting, reference):
    """What a run gives, or why it fails; and the text of its result file."""
    try:
        text, costs = run(problem.name, setting)
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


def sweep(measure, family, tried):
    """Refine the settings of a family as far as that helps, and as the budget allows.

    ``tried`` gives the line of a value of the step or tolerance. A step is halved until that gains
    nothing more, a tolerance divided by 10 down to the rounding unit: where steps end at the rows,
    a loose one does not act. Failures before the first run that comes to its end do not count: a
    coarse step may be too coarse for a program.
    """
    factor, finest = STEP if measure == "step" else TOLERANCE
    value, most, idle, before = family["from"], -np.inf, 0, None
    while value > finest and idle < IDLE:
        line = tried(value)
        if line["failure"] is not None:
            idle += most > -np.inf
        else:
            gains = line["digits"] - most >= GAIN or measure != "step"
            idle = 0 if gains else idle + 1
            most, cpu = max(most, line["digits"]), line["cpu"]
            growth = 2 if measure == "step" else cpu / (before or cpu)
            if cpu * growth > BUDGET:
                return
            before = cpu
        value = float(f"{value / factor:.12g}")


class Runs:
    """Runs of one program, each written down when it is there.

    Parameters
    ----------
    name, entry
        Of the program.
    program : Apart
        That runs it.
    document : Document
    again
        Whether runs that are written down are run anew.
    tell
        Is given what is done, and the line of it.
    """

    def __init__(self, name, entry, program, document, again, tell):
        self.name, self.entry, self.program = name, entry, program
        self.document, self.again, self.tell = document, again, tell
        self.said = described(entry, HERE / entry.get("folder", name))

    def line(self, problem, reference, about, fresh=False):
        """The line of a run and its text; the text is empty if the line was there."""
        of = () if problem.name == H1 else (problem.name,)
        made_of = fingerprint(self.said, about["setting"], *of)
        line, text = None, ""
        if not (self.again or fresh):
            line = self.document.line(self.name, problem.name, made_of)
        if line is None:
            self.tell(f"{self.entry['program']}, {problem.name}, {about['kind']}", None)
            self.program.start()
            found, text = measure(self.entry, self.program, problem, about["setting"], reference)
            line = {"started": self.document.started, "made_of": made_of, **found}
        line = {**about, **line, **about}
        self.tell(f"{self.entry['program']}, {problem.name}, {about['kind']}", line)
        return line, text

    def benchmark(self, problem, reference):
        """Lines of the default and of every sweep; a setting that two have is run once."""
        lines = []

        def tried(kind, family, value):
            about = told(self.entry, kind, family, value)
            line = next((x for x in lines if x["setting"] == about["setting"]), None)
            if line is None:
                line, _ = self.line(problem, reference, about)
                lines.append(line)
                self.document.keep_runs(self.name, self.said, lines)
            return line

        default = self.entry["default"]
        tried("default", default, default["at"])
        for family in self.entry["sweep"]:
            sweep(self.entry["measure"], family, partial(tried, "sweep", family))
        return lines

    def harder(self, problem, reference, submit):
        """Lines of the best and the default setting, as far as the program is to do the problem."""
        known = self.document.content["programs"].get(self.name, {"runs": []})
        lines, asked = [], self.entry.get("harder", {})
        for kind, line in published(known["runs"]).items():
            if problem.name.startswith(tuple(asked.get(kind, ()))):
                of = ("words", "family", "setting", "language")
                about = {"kind": kind, **{key: line[key] for key in of}}
                found, text = self.line(problem, reference, about)
                found["beside"] = line["digits"]
                wanted = tuple(asked.get("submitted", ()))
                if submit and kind == "best" and problem.name.startswith(wanted):
                    self.submit(problem, reference, found, kind, text)
                lines.append(found)
                self.document.keep_harder(self.name, self.said, problem.name, lines)

    def submit(self, problem, reference, line, kind, text=""):
        """Write a result file and its submission, unless they are there."""
        path, entry, about = result_file(self.name, kind, problem.name), self.entry, line
        if is_submitted(path, line):
            return
        if not text:
            _, text = self.line(problem, reference, about, fresh=True)
        text = problem.shortened(text, reference)
        found = problem.judge(text, reference)
        for old, new in zip(line["maneuvers"], found.pop("maneuvers"), strict=True):
            old |= new
        line |= found | {"sha256": hashlib.sha256(text.encode()).hexdigest()}
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(gzip.compress(text.encode(), 9, mtime=0))
        of = [*entry["sweep"], entry["default"]]
        family = next(x for x in of if x["words"] == line["family"])
        said = {key: family.get(key, entry[key]) for key in SUBMITTED}
        said["name"] = f"{entry['program']}, {kind}: {line['words']}"
        said["problem"] = problem.name
        measure = "step" if entry["measure"] == "step" else "tolerance"
        said[measure] = f"{line['setting'][entry['measure']]:.10g}"
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


def published(runs):
    """The best and the default run that came to their end, by kind."""
    default = next((r["setting"] for r in runs if r["kind"] == "default"), None)
    chosen = {"best": best(runs), "default": default}
    ended = [r for r in runs if r["failure"] is None]
    return {kind: r for kind, x in chosen.items() for r in ended if r["setting"] == x}


def result_file(name, kind, problem=H1):
    """Where a submission's rows are."""
    if problem == H1:
        return RESULTS / f"{name}-{kind}.txt.gz"
    return RESULTS / "harder" / f"{problem}-{name}-{kind}.txt.gz"


def is_submitted(path, line):
    """Whether a result file is that of a line."""
    if not path.is_file():
        return False
    return hashlib.sha256(gzip.decompress(path.read_bytes())).hexdigest() == line.get("sha256")


def all_runs(name, entry, todo, asked, document, tell):
    """Run a program on problems, with their references; give why not, if it is not here."""
    with Apart(asked.limit, running, name) as program:
        runs = Runs(name, entry, program, document, asked.again, tell)
        try:
            for problem, reference in todo:
                if problem.name != H1:
                    runs.harder(problem, reference, asked.submit)
                    continue
                lines = runs.benchmark(problem, reference)
                if asked.submit:
                    for kind, line in published(lines).items():
                        runs.submit(problem, reference, line, kind)
                    document.keep_runs(name, runs.said, lines)
        except AbsentError as e:
            document.absent(name, runs.said, str(e))
            return str(e)
    return None


def words(line):
    """A run in a line."""
    if line["failure"]:
        return f"{line['kind']} {line['words']} fails: {line['failure']}"
    worst, drifts = line["worst"], " ".join(f"{m['performance']:.1e}" for m in line["maneuvers"])
    return (
        f"{line['kind']} {line['words']}: {line['digits']:.2f} digits ({worst['column']} of "
        f"{worst['maneuver']}), eq. (1) {drifts}, CPU {line['cpu']:.3g} s, {line['definitions']}"
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
    parser.add_argument("--race", action="store_true", help="time the cheapest runs that pass")
    parser.add_argument(
        "--problem", action="append", choices=["H1", "H2", "H3", "H4"], default=[],
        help="of the extended problem set, may be repeated (default: H1, the benchmark)",
    )  # fmt: skip
    parser.add_argument(
        "--sets", type=Path, default=Path("sets"), metavar="FOLDER",
        help="where the references of the extended problem set are (default: sets)",
    )  # fmt: skip
    parser.add_argument(
        "--rows", choices=["prove", "compute"],
        help="where a reference is not there, prove its rows alone, or take them of a run in 70 "
        "digits: minutes or seconds in place of hours",
    )  # fmt: skip
    parser.add_argument(
        "--limit", type=float, default=LIMIT, metavar="SECONDS",
        help=f"of a run, and of what is compiled before (default: {LIMIT})",
    )  # fmt: skip
    asked, field = parser.parse_args(), read_field()
    names = list(field) if asked.all else asked.names
    if unknown := [x for x in names if x not in field]:
        parser.error(f"found '{unknown[0]}', expected some of {', '.join(field)}")
    if not names and not (asked.race and asked.output):
        parser.error("found no program, expected --all or some of " + ", ".join(field))
    # Ended from outside, it ends what it runs.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    # One core for all, so that nothing is moved while it is timed.
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    wanted = [Problem.of(x) for name in asked.problem or [H1] for x in problems(name)]
    try:
        todo = [(problem, problem.reference(asked.sets, asked.rows)) for problem in wanted]
    except BicycleError as e:
        parser.error(str(e))
    document = Document.of(asked.output, machine(), list(field))
    absent = {}
    with stage_bar() as bar:
        for done, name in enumerate(names):

            def tell(doing, line, done=done):
                if line is not None:
                    print(doing.rpartition(",")[0], words(line), flush=True)
                bar(doing, done / len(names))

            if why := all_runs(name, field[name], todo, asked, document, tell):
                absent[name] = f"{field[name]['program']} is not here ({field[name]['install']})"
                print(absent[name], why, sep=": ", flush=True)
    for line in absent.values():
        print(line, file=sys.stderr)
    if asked.race:
        race(document, partial(Apart, asked.limit, running), names or list(field))


if __name__ == "__main__":
    sys.exit(main())
