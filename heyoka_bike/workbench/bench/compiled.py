"""Runge-Kutta integrators in C, built on the spot to compare with: see ``runge_kutta.c``.

The right-hand side and the columns are written from the model by `c_source`, for one bicycle. The
compiler is that of `CC`, else gcc, else cc, with `FLAGS`.
"""

import ctypes
import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.bench.c_source import columns_source, quadruple_source, slope_source

METHODS = ("DOPRI5", "DOP853", "RK4")
"""In the order of the C file."""
FLAGS = ("-O3", "-march=native")
"""Without ``-ffast-math``: that would be another arithmetic than the model's."""

_POINTER, _LONG, _DOUBLE = ctypes.c_void_p, ctypes.c_long, ctypes.c_double
_SOLVE = ctypes.CFUNCTYPE(
    _LONG, ctypes.c_int, _POINTER, _LONG, _POINTER, _DOUBLE, _POINTER, _POINTER
)
_EVALUATE = ctypes.CFUNCTYPE(None, _POINTER, _POINTER, _POINTER)
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
        equations = slope_source(bicycle) + columns_source(bicycle)
        library = _built("runge_kutta.c", equations, "-lm")
        # Their prototypes hold the library.
        self._solve = _SOLVE(("solve", library))
        self._evaluate = _EVALUATE(("evaluate", library))

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


class QuadruplePeer:
    """Extrapolation in binary128, by libquadmath, compiled for a bicycle.

    Raises
    ------
    NoCompilerError
        It cannot be compiled here.
    """

    def __init__(self, bicycle: Bicycle) -> None:
        library = _built("extrapolation.c", quadruple_source(bicycle), "-lquadmath", "-lm")
        self._extrapolate = library.extrapolate
        self._extrapolate.restype = ctypes.c_long

    def end(
        self, columns: int, start: Sequence[str], duration: str, tolerance: float
    ) -> tuple[list[str], int]:
        """State at the end, as decimals, and the calls of the right-hand side.

        Parameters
        ----------
        columns
            Of the scheme; its order is twice as many.
        start, duration
            Decimals of the state at time 0, and of the time [s].
        tolerance
            Of a step.
        """
        found = ((ctypes.c_char * 64) * _STATE)()
        given = (ctypes.c_char_p * _STATE)(*(x.encode() for x in start))
        calls = self._extrapolate(
            columns, given, duration.encode(), ctypes.c_double(tolerance), found
        )
        return [bytes(x).split(b"\0")[0].decode() for x in found], calls


def _built(source: str, equations: str, *libraries: str) -> ctypes.CDLL:
    """A C file of this folder, compiled with equations written from the model."""
    compiler = os.environ.get("CC") or shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        raise NoCompilerError("no C compiler")
    # On Windows a library that is loaded cannot be removed.
    with TemporaryDirectory(prefix="heyoka_bike-", ignore_cleanup_errors=True) as folder:
        Path(folder, "equations.h").write_text(equations, encoding="utf-8")
        library = Path(folder) / "peers.so"
        command = [
            compiler, *FLAGS, "-std=gnu11", "-fPIC", "-shared", f"-I{folder}",
            str(Path(__file__).parent / source), "-o", str(library), *libraries,
        ]  # fmt: skip
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=_MOST_SECONDS)
            # Once loaded, the file is no longer needed.
            return ctypes.CDLL(str(library))
        except (OSError, subprocess.SubprocessError):
            raise NoCompilerError("does not compile") from None
