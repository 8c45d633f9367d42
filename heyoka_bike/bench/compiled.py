"""Runge-Kutta integrators in C, built on the spot to compare with: see ``runge_kutta.c``.

The right-hand side and the columns are written from the model by `c_source`, for one bicycle. The
compiler is that of `CC`, else gcc, else cc, with `FLAGS`.
"""

import ctypes
import os
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from heyoka_bike.bench.c_source import columns_source, slope_source
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.double import Array

METHODS = ("DOPRI5", "DOP853", "RK4")
"""In the order of the C file."""
FLAGS = ("-O3", "-march=native")
"""Without ``-ffast-math``: that would be another arithmetic than the model's."""

_SOURCE = Path(__file__).parent / "runge_kutta.c"
_STATE = 6
_MOST_SECONDS = 120  # of compiling; it takes about one


class NoCompilerError(Exception):
    """There is no C compiler, or it does not compile; the text says it in a few words."""


class CompiledPeers:
    """The integrators, compiled for a bicycle.

    Raises
    ------
    NoCompilerError
        They cannot be compiled here.
    """

    def __init__(self, bicycle: Bicycle) -> None:
        compiler = os.environ.get("CC") or shutil.which("gcc") or shutil.which("cc")
        if compiler is None:
            raise NoCompilerError("no C compiler")
        with TemporaryDirectory(prefix="heyoka_bike-") as folder:
            equations = Path(folder) / "equations.h"
            equations.write_text(slope_source(bicycle) + columns_source(bicycle), encoding="utf-8")
            library = Path(folder) / "peers.so"
            command = [
                compiler, *FLAGS, "-std=gnu11", "-fPIC", "-shared", f"-I{folder}",
                str(_SOURCE), "-o", str(library), "-lm",
            ]  # fmt: skip
            try:
                subprocess.run(command, check=True, capture_output=True, timeout=_MOST_SECONDS)
                # Once loaded, the file is no longer needed.
                self._library = ctypes.CDLL(str(library))
            except (OSError, subprocess.SubprocessError):
                raise NoCompilerError("does not compile") from None
        pointer = ctypes.c_void_p
        self._solve = self._library.solve
        self._solve.restype = ctypes.c_long
        self._solve.argtypes = [
            ctypes.c_int, pointer, ctypes.c_long, pointer, ctypes.c_double, pointer, pointer,
        ]  # fmt: skip
        self._evaluate = self._library.evaluate
        self._evaluate.restype = None
        self._evaluate.argtypes = [pointer, pointer, pointer]

    def solve(
        self, method: str, start: Array, times: Array, tolerance: float
    ) -> tuple[Array, Array, int]:
        """States and columns at ascending times, and the calls of the right-hand side.

        Parameters
        ----------
        method
            One of `METHODS`.
        tolerance
            Relative and absolute; for RK4 the longest step [s].

        Returns
        -------
        states : ndarray, shape (6, times)
        columns : ndarray, shape (8, times)
        calls : int
            -1 for a run that did not get to its end.
        """
        states = np.empty((_STATE, len(times)))
        columns = np.empty((len(BENCHMARK_COLUMNS), len(times)))
        calls = self._solve(
            METHODS.index(method), start.ctypes.data, len(times), times.ctypes.data, tolerance,
            states.ctypes.data, columns.ctypes.data,
        )  # fmt: skip
        return states, columns, calls

    def evaluate(self, state: Array) -> tuple[Array, Array]:
        """Time derivatives, shape (6,), and columns, shape (8,), of a state."""
        rates, columns = np.empty(_STATE), np.empty(len(BENCHMARK_COLUMNS))
        self._evaluate(state.ctypes.data, rates.ctypes.data, columns.ctypes.data)
        return rates, columns
