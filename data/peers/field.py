"""Run the benchmark with a program of `field.toml`, and score what it gives.

``python data/peers/field.py mujoco`` runs all settings of MuJoCo and prints their true errors;
``--submit`` also writes its best and its default run into ``data/results``. A program is a folder
here with a script ``bicycle.py``, whose ``simulate`` gives the rows of a maneuver, or with
``bicycle.cpp``, which reads lines "name value" from standard input and writes the rows.
"""

import argparse
import gzip
import hashlib
import importlib.util
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np

from heyoka_bike import load_reference, read_results, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS

HERE = Path(__file__).resolve().parent
RESULTS = HERE.parent / "results"
SAID = ("program", "version", "method", "coordinates", "precision", "model", "contact")


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
    program = Path(tempfile.mkdtemp()) / "bicycle"
    line = [sys.executable if word == "python" else word for word in build.split()]
    subprocess.run([*line, "-o", program], cwd=HERE / folder, check=True)

    def simulate(p, speed, roll_rate, **setting):
        said = {**p, "speed": speed, "roll_rate": roll_rate, **setting}
        lines = "".join(f"{name} {value}\n" for name, value in said.items())
        done = subprocess.run(
            [program], input=lines, capture_output=True, text=True, check=True, timeout=300
        )
        rows = np.array([line.split() for line in done.stdout.splitlines()], float)
        return rows, float(done.stderr)

    return simulate


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
    """Correct digits of the worst value with its place, and eq. (1) of each maneuver."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.txt"
        path.write_text(text, encoding="utf-8")
        report = score([read_results(path)], load_reference())
    worst = min(
        (c.as_understood.measures.scd or 0.0, c.key, m.maneuver)
        for m in report.maneuvers
        for c in m.columns
        if c.key in BENCHMARK_COLUMNS
    )
    taken = {
        c.key: c.as_understood.definition
        for c in report.maneuvers[0].columns
        if c.as_understood.definition != c.as_written.definition
    }
    return worst, [m.performance for m in report.maneuvers], taken


def submit(entry, name, kind, setting, text, cpu):
    """Write a result file and its submission."""
    path = RESULTS / f"{name}-{kind}.txt.gz"
    path.write_bytes(gzip.compress(text.encode(), 9, mtime=0))
    said = {key: entry.get(f"{kind}_{key}", entry[key]) for key in SAID}
    said["name"] = f"{entry['program']}, {kind}: {entry[kind + '_words']}"
    said["problem"] = "H1"
    measure = "step" if entry["measure"] == "step" else "tolerance"
    said[measure] = f"{setting[entry['measure']]:.10g}"
    said["processor_time"] = f"{cpu:.3g}"
    said["machine"] = "AMD EPYC, 1 processor of 2 that others used as well, Linux x86-64"
    said["licence"] = "CC0-1.0"
    lines = [f'{key} = "{value}"' for key, value in said.items()]
    sha256 = hashlib.sha256(path.read_bytes()).hexdigest()
    lines += ["", "[[file]]", f'path = "{path.name}"', f'sha256 = "{sha256}"']
    path.with_name(f"{name}-{kind}.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")


def main():
    """Run the settings of a program, print a line for each, and submit two of them if asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", help="program of field.toml")
    parser.add_argument("--submit", action="store_true", help="best and default run only, kept")
    asked = parser.parse_args()
    entry = tomllib.loads((HERE / "field.toml").read_text(encoding="utf-8"))[asked.name]
    simulate = simulator(entry.get("folder", asked.name), entry.get("build"))
    kept = {kind: entry[kind] for kind in ("best", "default") if kind in entry}
    settings = kept if asked.submit else dict(enumerate(entry["sweep"])) | kept
    for kind, setting in settings.items():
        try:
            text, cpu = run(simulate, setting, entry["digits"])
        except (ArithmeticError, RuntimeError, subprocess.SubprocessError) as e:
            print(setting, "fails:", e, flush=True)
            continue
        (digits, key, maneuver), drifts, taken = judge(text)
        print(
            kind, setting, f"scd {digits:.2f} ({key} of {maneuver}), eq. (1)",
            *(f"{x:.1e}" for x in drifts), f"CPU {cpu:.3g} s", taken, flush=True,
        )  # fmt: skip
        if asked.submit:
            submit(entry, asked.name, kind, setting, text, cpu)


if __name__ == "__main__":
    sys.exit(main())
