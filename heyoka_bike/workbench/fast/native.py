"""Machine code of a run, made by LLVM when it is first needed; no compiler has to be installed."""

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import GENERATE, MissingPackageError
from heyoka_bike.numbers.double import Array
from heyoka_bike.workbench.fast.many_code import ENDS, ends_source
from heyoka_bike.workbench.fast.step_code import RUN, run_source

_MOST_STEPS = 200_000  # of one run
_LEVEL = 3  # of optimisation
# A run takes some ten microseconds, and the address of an array by `ndarray.ctypes` one: those that
# stay are taken once, and the one of the result through the buffer it is.
_Byte, _Report = ctypes.c_char, ctypes.c_double * 5
_ADDRESS, _COUNT = ctypes.c_void_p, ctypes.c_int64
_SIGNATURE = (
    _COUNT, _ADDRESS, _COUNT, _ADDRESS, ctypes.c_double, _COUNT, _ADDRESS, _ADDRESS, _ADDRESS
)  # fmt: skip
_MANY = (
    None, _ADDRESS, _COUNT, _COUNT, _COUNT, ctypes.c_double, ctypes.c_double, _COUNT, _ADDRESS
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
        self._engine = compiled(source)
        address = self._engine.get_function_address(RUN)
        self.function = ctypes.CFUNCTYPE(*_SIGNATURE)(address)

    def motion(self, start: Array, times: Array, tolerance: float) -> "Motion":
        """A motion that is ready to be carried out, again and again."""
        return Motion(self, start, times, tolerance)


class Motion:
    """A motion from time 0 through ascending times.

    Parameters
    ----------
    native
        What carries it out.
    start : ndarray, shape (6,)
    times : ndarray, shape (rows,)
        [s]
    tolerance
        Of a step: about the error of the state within it.
    """

    def __init__(self, native: Native, start: Array, times: Array, tolerance: float) -> None:
        # What is given by its address must not be let go.
        self._kept = native, start, times
        self._run = native.function
        self._shape = len(BENCHMARK_COLUMNS), len(times)
        self._given = start.ctypes.data, len(times), times.ctypes.data, tolerance, _MOST_STEPS

    def sharper(self, tolerance: float) -> "Motion":
        """The same with another tolerance."""
        native, start, times = self._kept
        return Motion(native, start, times, tolerance)

    def __call__(self, states: Array | None = None) -> Run:
        """Carry it out; `states`, shape (6, rows), gets the states at the rows."""
        columns, report = np.empty(self._shape), _Report()
        steps = self._run(
            *self._given, ctypes.byref(_Byte.from_buffer(columns.data)),
            None if states is None else states.ctypes.data, report,
        )  # fmt: skip
        return Run(columns, steps, *report)


class Many:
    """Compiled code for many motions of one bicycle to one time, see `many_code`.

    Raises
    ------
    MissingPackageError
        llvmlite is not installed.
    """

    def __init__(self, bicycle: Bicycle) -> None:
        self._engine = compiled(ends_source(Equations.binary64(bicycle, is_regular=False)))
        address = self._engine.get_function_address(ENDS)
        self._ends = ctypes.CFUNCTYPE(*_MANY)(address)

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


def compiled(source: str) -> Any:
    """LLVM's engine that holds the code of a module: it lives as long as the engine."""
    try:
        import llvmlite.binding as llvm
    except ModuleNotFoundError as e:
        if e.name != "llvmlite":
            raise
        raise MissingPackageError(
            f"llvmlite is not installed; simulate needs it ({GENERATE})"
        ) from None
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=_LEVEL
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(source), machine)
    engine.finalize_object()
    return engine
