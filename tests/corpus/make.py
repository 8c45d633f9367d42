"""Compute the runs and store them: ``python -m corpus.make [--full FILE]`` in tests, some minutes.

Needs ``pip install symbrim exudyn scipy h5py``. `runs.h5` has few rows of most runs. With
``--full`` a file of all rows is also written, which `files` accepts as its second argument.
``--only NAME`` computes one run, adds it to `runs.h5` or replaces it there, and needs only the
program of this run.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path

import h5py
import numpy as np

from corpus.benchmark import COLUMNS, MANEUVERS, TIMES, Array, Run

HERE = Path(__file__).resolve().parent
PROGRAMS = ("symbrim", "exudyn", "newton", "linear")
"""Beginnings of the names of runs, and of the modules ``*_runs`` that define them."""

FALLEN = 1.2
"""Roll angle at which a file ends [rad]."""

_WHOLE = {"symbrim-dop853-1e-12": 1, "exudyn-trapezoidal-0.001": 5}
"""Runs stored with all columns, for files with other columns; the value is the row stride."""
_TIGHT = ("1e-12", "1e-13", "1e-10", "exponential")
"""A run with one of these in its method is stored with all bits."""
_ALSO = {"symbrim-rear-not-rotated": ("speed_contact_global_x",)}


def runs_of(program: str) -> Sequence[Run]:
    """The runs of one program, which has to be installed."""
    runs: Sequence[Run] = import_module(f"corpus.{program}_runs").RUNS
    return runs


def run_called(name: str) -> Run:
    """The run with this name."""
    program = name.split("-")[0]
    named = {run.name: run for run in runs_of(program)} if program in PROGRAMS else {}
    if name not in named:
        raise SystemExit(f"{name}: no such run; its name begins with one of {', '.join(PROGRAMS)}")
    return named[name]


def computed(runs: Iterable[Run]) -> Iterator[tuple[Run, Mapping[str, Array]]]:
    """Each run, and its columns of shape (maneuvers, rows)."""
    for run in runs:
        blocks = [run.compute(m) for m in range(len(MANEUVERS))]
        print(run.name, flush=True)
        found = {name: np.array([block[name] for block in blocks]) for name in blocks[0]}
        yield run, until_the_fall(found)


def until_the_fall(found: Mapping[str, Array]) -> Mapping[str, Array]:
    """Replace all rows with NaN from the first one on at which the bicycle lies on its side."""
    stands = np.logical_and.accumulate(abs(found["roll"]) < FALLEN, axis=1)
    return {name: np.where(stands, x, np.nan) for name, x in found.items()}


def rounded(values: Array) -> Array:
    """Round to 40 bits, which compress better; the change is far below the error of most runs."""
    fraction, power = np.frexp(values)
    return np.ldexp(np.round(np.ldexp(fraction, 40)), power - 40)


def store(file: h5py.File, run: Run, found: Mapping[str, Array], is_full: bool) -> None:
    """Store a run in a file, with shape (columns, maneuvers, rows)."""
    if is_full or run.name in _WHOLE:
        columns: Sequence[str] = tuple(found)
    else:
        columns = (*COLUMNS, *_ALSO.get(run.name, ()))
    every = 1 if is_full else _WHOLE.get(run.name, 10 if run.did else 5)
    values = np.array([found[name] for name in columns])[..., ::every]
    if not is_full and not any(tight in run.program for tight in _TIGHT):
        values = rounded(values)
    data = file.create_dataset(
        run.name, data=values, chunks=(1, *values.shape[1:]), compression=9, shuffle=True
    )
    about = {
        "program": run.program, "did": run.did, "expected": run.expected, "columns": columns,
    }  # fmt: skip
    data.attrs["run"] = json.dumps(about)


def main(arguments: Sequence[str]) -> None:
    if arguments[:1] == ["--only"]:
        with h5py.File(HERE / "runs.h5", "a") as few:
            for run, found in computed([run_called(arguments[1])]):
                if run.name in few:
                    del few[run.name]
                store(few, run, found, is_full=False)
        return
    runs = [run for program in PROGRAMS for run in runs_of(program)]
    full = Path(arguments[1]) if arguments[:1] == ["--full"] else None
    with h5py.File(HERE / "runs.h5", "w") as few:
        if full is None:
            for run, found in computed(runs):
                store(few, run, found, is_full=False)
            return
        with h5py.File(full, "w") as every:
            for run, found in computed(runs):
                store(few, run, found, is_full=False)
                store(every, run, found, is_full=True)


if __name__ == "__main__":
    assert len(TIMES) == 1001
    main(sys.argv[1:])
