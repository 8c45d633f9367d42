"""The limit of the processor time of a diagnosis, and how it ends the diagnosis.

The time is that of the whole process, in all its threads; a diagnosis starts no other process. The
diagnosis checks the time before each long step, such as simulating a fifth of a second of several
motions, or comparing a program. So it may exceed the limit by the time of one step.

A step that never checks the time is interrupted from outside: `Watch` is a thread that raises
`BudgetSpentError` in the thread of the diagnosis. Unlike a signal this works in every thread and on
every system. The exception arrives between two instructions of Python, so a loop inside a compiled
library continues until it returns. This needs CPython and threads. Without them, the diagnosis ends
only where it checks the time.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from math import inf
from numbers import Real
from threading import Event, RLock, Thread, get_ident
from types import TracebackType

from heyoka_bike.errors import InputError, printable

DEFAULT_BUDGET = 18.0
"""Default limit of the processor time of a diagnosis [s]. The command also reads and scores the
file, and takes about 20 s at most."""


OVERRUN = 5.0
"""Processor time beyond the limit after which a diagnosis is interrupted [s]. It is interrupted
again whenever it continues for this time."""

_SECONDS_BETWEEN_LOOKS = 0.25  # [s], time between two checks of the time limit


class BudgetSpentError(Exception):
    """The time limit of a diagnosis is reached: the causes found so far are the result."""


@dataclass(frozen=True, slots=True)
class Deadline:
    """The time at which a running diagnosis must end.

    Attributes
    ----------
    end
        Reading of the clock at the end [s].
    clock : callable
        Returns the processor time of this process [s].
    is_thorough
        As in `Budget`.
    """

    end: float = inf
    clock: Callable[[], float] = time.process_time
    is_thorough: bool = False

    def check(self) -> None:
        """Raise an error if the time limit is reached.

        Raises
        ------
        BudgetSpentError
            The time limit is reached.
        """
        if self.clock() >= self.end:
            raise BudgetSpentError


NEVER = Deadline()


class Watch:
    """Context manager that interrupts its thread if the block runs far past a deadline.

    Parameters
    ----------
    deadline : Deadline
        It is not watched if its clock is not `time.process_time`.
    """

    def __init__(self, deadline: Deadline) -> None:
        is_watched = deadline.end < inf and deadline.clock is time.process_time
        self._end = deadline.end + OVERRUN if is_watched else inf
        self._is_over, self._has_raised, self._lock = Event(), False, RLock()

    def __enter__(self) -> None:
        if self._end < inf:
            # start() raises RuntimeError if the system has no threads, or does not allow one more.
            with suppress(RuntimeError):
                Thread(target=self._look, args=(get_ident(),), daemon=True).start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:  # fmt: skip
        self.end()

    def end(self) -> None:
        """Stop watching; call it in the watched thread. A second call does nothing."""
        while True:
            with suppress(BudgetSpentError), self._lock:
                self._is_over.set()
                if self._has_raised:
                    # Cancel an exception that was requested but has not been raised yet. Otherwise
                    # it would be raised later.
                    _raise_in(get_ident(), None)
                return

    def _look(self, thread: int) -> None:
        end = self._end
        while not self._is_over.wait(_SECONDS_BETWEEN_LOOKS):
            if time.process_time() < end:
                continue
            with self._lock:
                if not self._is_over.is_set():
                    self._has_raised = True
                    _raise_in(thread, BudgetSpentError)
            end = time.process_time() + OVERRUN


def _raise_in(thread: int, error: type[Exception] | None) -> None:
    """Raise an exception in a thread; None cancels one that has not arrived yet."""
    import ctypes

    with suppress(AttributeError):
        raised = None if error is None else ctypes.py_object(error)
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread), raised)


@dataclass(frozen=True, slots=True)
class Budget:
    """Limit of the processor time of a diagnosis.

    Attributes
    ----------
    seconds
        The limit, greater than zero; `math.inf` for no limit [s].
    clock : callable
        As in `Deadline`.
    is_thorough
        True to continue the search even if the file shows a force that no single cause explains.

    Raises
    ------
    InputError
        `seconds` is not a number greater than zero.
    """

    seconds: float = DEFAULT_BUDGET
    clock: Callable[[], float] = time.process_time
    is_thorough: bool = False

    def __post_init__(self) -> None:
        given: object = self.seconds
        if not (isinstance(given, Real) and float(given) > 0):
            found = printable(repr(given))[:60]
            raise InputError(f"budget: found {found}, expected seconds above zero")

    def begun(self) -> Deadline:
        """Return the deadline of a diagnosis that begins now."""
        return Deadline(self.clock() + self.seconds, self.clock, self.is_thorough)


USUAL = Budget()
