"""Machine code of a run, made by LLVM when it is first needed; no compiler has to be installed."""

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import MissingPackageError
from heyoka_bike.motion.fast.step_code import RUN, run_source
from heyoka_bike.numbers.double import Array

_MOST_STEPS = 200_000  # of one run
_LEVEL = 3  # of optimisation
# `simulate` takes microseconds: addresses go to the code as the integers they are.
_ADDRESS, _COUNT = ctypes.c_void_p, ctypes.c_int64
_SIGNATURE = (
    _COUNT, _ADDRESS, _COUNT, _ADDRESS, ctypes.c_double, _COUNT, _ADDRESS, _ADDRESS, _ADDRESS
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Run:
    """One run of a motion.

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
    """

    columns: Array
    steps: int
    time: float
    least_trail: float
    largest_trail: float


class Native:
    """Compiled code for motions of one bicycle, see `step_code`; any thread may call it.

    Raises
    ------
    MissingPackageError
        llvmlite is not installed.
    """

    def __init__(self, bicycle: Bicycle, *, is_regular: bool) -> None:
        source = run_source(Equations.binary64(bicycle, is_regular=is_regular))
        # The engine owns the code: it lives as long as what calls it.
        self._engine = _compiled(source)
        self._run = ctypes.CFUNCTYPE(*_SIGNATURE)(self._engine.get_function_address(RUN))

    def run(self, start: Array, times: Array, tolerance: float, states: Array | None = None) -> Run:
        """A motion from time 0 through ascending times.

        Parameters
        ----------
        start : ndarray, shape (6,)
        times : ndarray, shape (rows,)
            [s]
        tolerance
            Of a step: about the error of the state within it.
        states : ndarray, shape (6, rows), optional
            Gets the states at the rows.
        """
        rows = len(times)
        columns = np.empty((len(BENCHMARK_COLUMNS), rows))
        report = np.empty(3)
        steps = self._run(
            start.ctypes.data, rows, times.ctypes.data, tolerance, _MOST_STEPS,
            columns.ctypes.data, None if states is None else states.ctypes.data,
            report.ctypes.data,
        )  # fmt: skip
        return Run(columns, steps, *report.tolist())


def _compiled(source: str) -> Any:
    try:
        import llvmlite.binding as llvm
    except ModuleNotFoundError as e:
        if e.name != "llvmlite":
            raise
        raise MissingPackageError(
            "llvmlite is not installed; simulate needs it (pip install llvmlite)"
        ) from None
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=_LEVEL
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(source), machine)
    engine.finalize_object()
    return engine
