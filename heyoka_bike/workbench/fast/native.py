"""Machine code of a run, made by LLVM when it is first needed; no compiler has to be installed."""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import GENERATE, required
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.fast.many_code import ENDS, ends_source
from heyoka_bike.workbench.fast.step_code import RUN, run_source

_MOST_STEPS = 200_000  # of one run
_LEVEL = 3  # of optimisation
_Byte, _Report = ctypes.c_char, ctypes.c_double * 5
_ADDRESS, _COUNT, _NUMBER = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
_RUN = _COUNT, _ADDRESS, _COUNT, _ADDRESS, _NUMBER, _COUNT, _ADDRESS, _ADDRESS, _ADDRESS
_ENDS = None, _ADDRESS, _COUNT, _COUNT, _COUNT, _NUMBER, _NUMBER, _COUNT, _ADDRESS


@dataclass(frozen=True, slots=True)
class Solution:
    """A motion at its rows.

    Attributes
    ----------
    columns : ndarray, shape (8, rows)
        Those of the benchmark, SI units.
    steps
        How many were taken; negative for a motion that cannot be continued.
    time
        Reached [s].
    least_trail, largest_trail
        Of the rows: the mechanical trail over the front wheel's radius.
    least_energy, largest_energy
        Of the rows: the mechanical energy [J].
    """

    columns: Array
    steps: int
    time: float
    least_trail: float
    largest_trail: float
    least_energy: float
    largest_energy: float


class MotionCode:
    """Compiled code for motions of one bicycle, see `step_code`; any thread may call it.

    Raises
    ------
    MissingPackageError
        llvmlite is not installed.
    """

    def __init__(self, bicycle: Bicycle, *, is_regular: bool) -> None:
        source = run_source(Equations.binary64(bicycle, is_regular=is_regular))
        self._run = function(source, RUN, *_RUN)

    def motion(self, start: Array, times: Array, tolerance: float) -> Callable[..., Solution]:
        """A motion from time 0 through ascending times, to be carried out again and again.

        Parameters
        ----------
        start : ndarray, shape (6,)
        times : ndarray, shape (rows,)
            [s]
        tolerance
            Of a step: about the error of the state within it.

        Returns
        -------
        callable
            Carries it out; its argument, shape (6, rows), gets the states if it is there.
        """
        # A run takes some ten microseconds, and the address of an array by `ndarray.ctypes` one:
        # those that stay are taken once, and the one of the result through the buffer it is.
        given = start.ctypes.data, len(times), times.ctypes.data, tolerance, _MOST_STEPS
        return partial(self._carry_out, (start, times), given)

    def _carry_out(
        self, arrays: tuple[Array, Array], given: tuple[Any, ...], states: Array | None = None
    ) -> Solution:
        columns, report = np.empty((len(BENCHMARK_COLUMNS), len(arrays[1]))), _Report()
        steps = self._run(
            *given, ctypes.byref(_Byte.from_buffer(columns.data)),
            None if states is None else states.ctypes.data, report,
        )  # fmt: skip
        return Solution(columns, steps, *report)


class EnsembleCode:
    """Compiled code for many motions of one bicycle to one time, see `many_code`.

    Raises
    ------
    MissingPackageError
        llvmlite is not installed.
    """

    def __init__(self, bicycle: Bicycle) -> None:
        source = ends_source(Equations.binary64(bicycle, is_regular=False))
        self._ends = function(source, ENDS, *_ENDS)

    def ends(
        self, states: Array, columns: Array, part: range, duration: float, tolerance: float
    ) -> None:
        """Carry out a part of the motions; several threads may do so at the same time.

        Parameters
        ----------
        states : ndarray, shape (6, motions)
            At time 0, one variable after the other in memory.
        columns : ndarray, shape (8, motions)
            Gets those of the benchmark; NaN for a motion that cannot be continued.
        part
            Of the motions: whole vectors of them.
        duration
            [s]
        tolerance
            Of a step.
        """
        self._ends(
            states.ctypes.data, states.shape[1], part.start, part.stop, duration, tolerance,
            _MOST_STEPS, columns.ctypes.data,
        )  # fmt: skip


def function(source: str, name: str, *signature: Any) -> Any:
    """A function of a module in LLVM's language, compiled, for ctypes.

    Raises
    ------
    MissingPackageError
        llvmlite is not installed.
    """
    said = f"llvmlite is not installed; simulate needs it ({GENERATE})"
    llvm: Any = required("llvmlite.binding", said)
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=_LEVEL
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(source), machine)
    engine.finalize_object()
    found: Any = ctypes.CFUNCTYPE(*signature)(engine.get_function_address(name))
    # The engine owns the code: it lives as long as what calls it.
    found.engine = engine
    return found
