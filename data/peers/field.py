"""Run the benchmark with the programs of `field.toml`, and score what they give.

``python data/peers/field.py mujoco`` runs all settings of MuJoCo and prints their true errors;
``--all`` runs every program that is here, one after the other. ``-o docs/field.json`` writes
what was measured, from which ``python docs/_site/field_page.py`` makes the page and the figures;
what stands there already of this machine and these versions is kept. ``--submit`` also writes the
best and the default run into ``data/results``. A program is a folder here with a script
``bicycle.py``, whose ``simulate`` gives the rows of a maneuver, or with ``bicycle.cpp`` or
``bicycle.mjs``, which reads lines "name value" from standard input and writes the rows.
"""

import argparse
import gzip
import hashlib
import importlib.util
import shutil
import signal
import subprocess
import sys
import tempfile
import tomllib
from functools import partial
from pathlib import Path

import numpy as np
from apart import AbsentError, Apart, FailedError
from measured import Document, described, fingerprint, lacking, named, orders, settings
from peer import Peer

from heyoka_bike import load_reference, read_results, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import BicycleError
from heyoka_bike.scoring.leaderboard import correct_digits, other_definitions
from heyoka_bike.system.console import stage_bar
from heyoka_bike.system.machine import machine

HERE = Path(__file__).resolve().parent
RESULTS = HERE.parent / "results"
SUBMITTED = ("program", "version", "method", "coordinates", "precision", "model", "contact")
LIMIT = 900  # of a run of three maneuvers, and of deriving or compiling a program [s]


def number(text):
    """Value of a decimal, or of a quotient with pi on top, such as ``pi/10``."""
    top, _, bottom = text.partition("/")
    return (np.pi if top.strip() == "pi" else float(top)) / float(bottom or 1)


def inputs():
    """Parameters of the bicycle, and speed and roll rate of the maneuvers; z is down."""
    read = [
        tomllib.loads((HERE.parent / folder / "benchmark.toml").read_text(encoding="utf-8"))
        for folder in ("bicycles", "maneuvers")
    ]
    bicycle = {name: number(entry["value"]) for name, entry in read[0]["parameters"].items()}
    starts = [[number(m[x]["value"]) for x in ("speed", "roll_rate")] for m in read[1]["maneuver"]]
    return bicycle, starts


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
        said = {**p, "speed": speed, "roll_rate": roll_rate, **setting}
        lines = "".join(f"{name} {value}\n" for name, value in said.items())
        done = subprocess.run(command, input=lines, capture_output=True, text=True, check=True)
        rows = np.array([line.split() for line in done.stdout.splitlines()], float)
        return rows, float(done.stderr)

    return simulate


def _built(line, place):
    subprocess.run(line, cwd=place, check=True, capture_output=True, text=True)


def run(simulate, setting, digits):
    """Text of a result file, and the processor time of its three maneuvers."""
    bicycle, starts = inputs()
    found = [simulate(bicycle, *start, **setting) for start in starts]
    values = np.hstack([rows for rows, _ in found]) + 0.0
    lines = (
        " ".join([f"{i / 100:g}", *(f"{x:.{digits}g}" for x in row)])
        for i, row in enumerate(values)
    )
    return "\n".join(lines) + "\n", sum(cpu for _, cpu in found)


def judge(text):
    """Correct digits of each column and of the worst, eq. (1), definitions of a result file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.txt"
        path.write_text(text, encoding="utf-8")
        report = score([read_results(path)], load_reference())
    scores = correct_digits(report)
    worst = min(scores, key=scores.__getitem__)
    drifts = [m.performance for m in report.maneuvers]
    if not np.isfinite([scores[worst], *drifts]).all():
        raise FailedError(f"{worst[1]} of maneuver {worst[0]}, or its energy, is infinite")
    return {
        "digits": round(scores[worst], 3),
        "worst": {"maneuver": worst[0], "column": worst[1]},
        "scd": {
            key: round(min(x for (_, k), x in scores.items() if k == key), 3)
            for key in BENCHMARK_COLUMNS
        },
        "performance": drifts,
        "definitions": other_definitions(report),
    }


def submit(entry, name, kind, setting, text, cpu):
    """Write a result file and its submission."""
    path = result_file(name, kind)
    path.write_bytes(gzip.compress(text.encode(), 9, mtime=0))
    said = {key: entry.get(f"{kind}_{key}", entry[key]) for key in SUBMITTED}
    said["name"] = f"{entry['program']}, {kind}: {entry[kind + '_words']}"
    said["problem"] = "H1"
    measure = "step" if entry["measure"] == "step" else "tolerance"
    said[measure] = f"{setting[entry['measure']]:.10g}"
    said["processor_time"] = f"{cpu:.3g}"
    m = machine()
    said["machine"] = f"{m['cpu']}, 1 of {m['cores']} processors, {m['system']}"
    said["licence"] = "CC0-1.0"
    lines = [f'{key} = "{value}"' for key, value in said.items()]
    sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
    lines += ["", "[[file]]", f'path = "{path.name}"', f'sha256 = "{sha256}"']
    path.with_name(f"{name}-{kind}.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


def result_file(name, kind):
    """Where a submission's rows are."""
    return RESULTS / f"{name}-{kind}.txt.gz"


def running(name):
    """The function that runs a setting of a program and gives text and processor time."""
    entry = read_field()[name]
    # Asked for by name: a folder here that is called like a package can be imported as well.
    if names := lacking(entry["install"]):
        raise ImportError(f"no package {', '.join(names)}")
    return partial(run, simulator(entry.get("folder", name), entry.get("build")))


def read_field():
    """The programs of `field.toml`, by their names."""
    return tomllib.loads((HERE / "field.toml").read_text(encoding="utf-8"))


def digits(entry, kind):
    """How many are written of each number: some more than are right."""
    return entry.get(f"{kind}_digits", entry["digits"])


def measure(program, setting, written, against):
    """What a run gives, or why it fails; and the text of its result file."""
    try:
        text, cpu = program(setting, written)
        found = {"failure": None} | judge(text)
    except (FailedError, BicycleError) as e:
        return {"failure": str(e)}, ""
    beside = against.time()
    times = {"cpu": round(cpu, 5), "peer": round(beside, 5), "ratio": float(f"{cpu / beside:.3g}")}
    return found | times | {"sha256": hashlib.sha256(text.encode()).hexdigest()}, text


def is_submitted(name, line):
    """Whether the result file of a run is that of this line."""
    path = result_file(name, line["kind"])
    if not path.is_file():
        return False
    return hashlib.sha256(gzip.decompress(path.read_bytes())).hexdigest() == line["sha256"]


def all_runs(name, entry, asked, document, tell, against):
    """Run the settings of a program that are not written down already, and write them down."""
    said = described(entry, HERE / entry.get("folder", name))
    found = said | {"missing": None, "runs": [], "orders": []}
    with Apart(asked.limit, running, name) as program:
        for kind, setting in settings(entry):
            is_sent = asked.submit and kind != "sweep"
            made_of = fingerprint(said, setting, digits(entry, kind))
            line = None if asked.again else document.line(name, kind, made_of)
            if line is None or (is_sent and not is_submitted(name, line)):
                tell(f"{entry['program']}, {kind}", None)
                try:
                    program.start()
                except AbsentError as e:
                    found = document.absent(name, found, str(e))
                    document.keep(name, found)
                    return found
                more, text = measure(program, setting, digits(entry, kind), against)
                line = {"kind": kind, "started": document.started, "made_of": made_of, **more}
                if is_sent and line["failure"] is None:
                    submit(entry, name, kind, setting, text, line["cpu"])
            about = named(entry, kind, setting)
            found["runs"].append({**about, **line, **about})
            found["orders"] = orders(found["runs"], entry["measure"])
            document.keep(name, found)
            tell(f"{entry['program']}, {kind}", found["runs"][-1])
    return found


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
        "--limit", type=float, default=LIMIT, metavar="SECONDS", help="of a run (default: 900)"
    )
    asked, field = parser.parse_args(), read_field()
    names = list(field) if asked.all else asked.names
    if unknown := [x for x in names if x not in field]:
        parser.error(f"found '{unknown[0]}', expected some of {', '.join(field)}")
    if not names:
        parser.error("found no program, expected --all or some of " + ", ".join(field))
    # Ended from outside, it ends what it runs.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    against = Peer()
    document = Document.of(asked.output, machine(), against.said(), list(field))
    total, done, absent = sum(len(settings(field[x])) for x in names), 0, []
    with stage_bar() as bar:

        def tell(doing, line):
            nonlocal done
            if line is not None:
                done += 1
                print(doing.partition(",")[0], words(line), flush=True)
            bar(doing, done / total)

        for name in names:
            found = all_runs(name, field[name], asked, document, tell, against)
            if found["missing"]:
                absent.append(f"{field[name]['program']} is not here ({found['install']})")
                print(absent[-1], found["missing"], sep=": ", flush=True)
    for line in absent:
        print(line, file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
