"""What a score costs beside importing NumPy and h5py, in processor time of whole processes.

    python -m heyoka_bike.bench.start_up [FILE] [--runs N]

Both processes run in turns, so that what else the machine does touches both alike. The first pair
is not counted: it writes the bytecode. On Unix only, whose kernels tell the time of each process.
"""

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median

from heyoka_bike.system.resources import data_folder

_RUNS = 20


@dataclass(frozen=True, slots=True)
class StartUp:
    """Processor times of pairs of processes [s].

    Attributes
    ----------
    score, imports : tuple of float
        Of a score, and of importing NumPy and h5py just after it.
    """

    score: tuple[float, ...]
    imports: tuple[float, ...]

    @property
    def ratio(self) -> float:
        """Median of the ratios of the pairs."""
        return median(a / b for a, b in zip(self.score, self.imports, strict=True))


def measure(file: str, runs: int = _RUNS) -> StartUp:
    """Score a file so many times, each followed by the imports alone."""
    score = [sys.executable, "-m", "heyoka_bike", "score", file]
    imports = [sys.executable, "-c", "import numpy, h5py"]
    pairs = [(_seconds(score), _seconds(imports)) for _ in range(runs + 1)][1:]
    return StartUp(tuple(a for a, _ in pairs), tuple(b for _, b in pairs))


def _seconds(command: Sequence[str]) -> float:
    """Processor time of a process, user and system [s]."""
    # Without bytecode every run would compile the package.
    kept = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, env=kept) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return used.ru_utime + used.ru_stime


def main(argv: Sequence[str] | None = None) -> None:
    """Measure, and print medians and their ratio."""
    p = argparse.ArgumentParser(description="processor time of a score, over that of its imports")
    p.add_argument("file", nargs="?", default=str(data_folder() / "peers" / "scipy-rtol1e-10.txt"))
    p.add_argument("--runs", type=int, default=_RUNS)
    args = p.parse_args(argv)
    found = measure(args.file, args.runs)
    for name, times in (("score", found.score), ("import numpy, h5py", found.imports)):
        print(f"{name:<20}{1e3 * median(times):8.1f} ms, least {1e3 * min(times):.1f} ms")
    print(f"{'ratio':<20}{found.ratio:8.2f}, median of {len(found.score)} pairs")


if __name__ == "__main__":
    main()
