"""Cost of starting, reading and judging, in processor time and memory of whole processes.

    python docs/_site/start_up.py [FILE] [--runs N] [--rows N]

Everything runs in turns, so that what else the machine does touches all alike. The first turn is
not counted: it writes the bytecode and the compiled code. With ``--rows`` a file of so many rows of
25 columns is made in a temporary folder, and scored beside what other programs take to read it. On
Unix only, whose kernels tell the time of each process.
"""

import argparse
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from heyoka_bike.system.resources import data_folder

_RUNS = 20
_IMPORTS, _SCORE = "import numpy, h5py", "score"
# The error of the program that is judged, relative to the size of each column.
_ERROR = 1e-8
_READERS = {
    "pandas": "import pandas; pandas.read_csv({!r}, sep=' ', header=None, dtype=float)",
    "polars": "import polars; polars.read_csv({!r}, separator=' ', has_header=False)",
    "numpy": "import numpy; numpy.loadtxt({!r})",
}


@dataclass(frozen=True, slots=True)
class Used:
    """Resources that a process used.

    Attributes
    ----------
    seconds : float
        Processor time, user and system [s].
    memory : float
        Largest amount of memory [MiB].
    """

    seconds: float
    memory: float


def measure(commands: Mapping[str, Sequence[str]], runs: int) -> dict[str, list[Used]]:
    """Carry out commands in turns, so many times each, and once before that is not counted."""
    turns = [{name: _used(c) for name, c in commands.items()} for _ in range(runs + 1)][1:]
    return {name: [turn[name] for turn in turns] for name in commands}


def commands_of_a_file(file: str) -> dict[str, list[str]]:
    """Commands on a file of the usual size, and the imports that scoring needs."""
    ours = [sys.executable, "-m", "heyoka_bike"]
    found = {
        _IMPORTS: [sys.executable, "-c", _IMPORTS],
        "--help": [*ours, "--help"],
        _SCORE: [*ours, "score", file],
        "score, as HTML": [*ours, "score", file, "--format", "html"],
    }
    return found | ({"diagnose": [*ours, "diagnose", file]} if find_spec("heyoka") else {})


def commands_of_many_rows(stem: Path) -> dict[str, list[str]]:
    """Commands on the files that `write_rows` made, and other readers of the text."""
    found = {
        f"score, {suffix}": [sys.executable, "-m", "heyoka_bike", "score", f"{stem}.{suffix}"]
        for suffix in ("txt", "npy")
    }
    for name, code in _READERS.items():
        if find_spec(name):
            found[f"{name} reads txt"] = [sys.executable, "-c", code.format(f"{stem}.txt")]
    return found


def write_rows(stem: Path, rows: int) -> None:
    """Results of so many rows, evenly over the benchmark's ten seconds, as text and as .npy."""
    import numpy as np

    from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
    from heyoka_bike.reference.load import load_reference

    reference = load_reference()
    names = [DEFINITIONS[key][0].name for key in BENCHMARK_COLUMNS]
    time = np.arange(rows) * float(reference[1].duration) / max(rows - 1, 1)
    columns = [time]
    for number in reference:
        exact = reference[number].approximate(time, names)
        scales = {name: _ERROR * reference[number].scale(name) for name in names}
        columns += [exact[name] + scales[name] * np.sin(time) for name in names]
    table = np.column_stack(columns)
    np.save(f"{stem}.npy", table)
    np.savetxt(f"{stem}.txt", table, fmt="%.17g")


def _used(command: Sequence[str]) -> Used:
    # Without bytecode every run would compile the package.
    kept = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, env=kept) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    # Kilobytes, but bytes on macOS.
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return Used(used.ru_utime + used.ru_stime, used.ru_maxrss / unit)


def _lines(found: Mapping[str, Sequence[Used]], beside: str | None) -> Iterator[str]:
    """A table, with the median of the ratios to one of its lines."""
    head = f"{'processor time':<22}{'median [s]':>12}{'least [s]':>12}{'memory [MiB]':>14}"
    yield head + (f"   over {beside}" if beside else "")
    for name, runs in found.items():
        seconds = [run.seconds for run in runs]
        ratio = ""
        if beside:
            pairs = zip(seconds, (run.seconds for run in found[beside]), strict=True)
            ratio = f"{median(a / b for a, b in pairs):>8.2f}"
        memory = max(run.memory for run in runs)
        yield f"{name:<22}{median(seconds):>12.3f}{min(seconds):>12.3f}{memory:>14.0f}{ratio}"


def main(argv: Sequence[str] | None = None) -> None:
    """Measure, and print medians and their ratios."""
    p = argparse.ArgumentParser(description="processor time of commands, over that of imports")
    p.add_argument("file", nargs="?", default=str(data_folder() / "peers" / "scipy-rtol1e-10.txt"))
    p.add_argument("--runs", type=int, default=_RUNS)
    p.add_argument("--rows", type=int, help="score a file of so many rows, too, such as 1000000")
    args = p.parse_args(argv)
    if args.runs < 1 or (args.rows is not None and args.rows < 2):
        p.error("--runs: expected 1 or more; --rows: 2 or more")
    print("\n".join(_lines(measure(commands_of_a_file(args.file), args.runs), _IMPORTS)))
    if args.rows is not None:
        with TemporaryDirectory() as folder:
            stem = Path(folder) / "rows"
            write_rows(stem, args.rows)
            print(f"\n{args.rows} rows, {Path(f'{stem}.txt').stat().st_size / 1e6:.0f} MB of text")
            found = measure(commands_of_many_rows(stem), args.runs)
            beside = next((f"{x} reads txt" for x in _READERS if f"{x} reads txt" in found), None)
            print("\n".join(_lines(found, beside)))


if __name__ == "__main__":
    main()
