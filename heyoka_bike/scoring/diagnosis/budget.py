"""The processor time that a diagnosis may take, how far it goes, and what ends it.

Time is that of the process which diagnoses, in all its threads; it starts no other process. A
diagnosis asks for it before each step that takes long: a fifth of a second of the motions that are
simulated together, a program that is compared. So the last step may end later, by the time that it
takes.

A step that never asks is interrupted from outside: `Watch` is a thread that raises
`BudgetSpentError` in the thread of the diagnosis. Unlike a signal this works in every thread and on
every system. The exception arrives between two instructions of Python, so a loop inside of a
compiled library goes on until it returns. CPython alone can do it, and it needs a thread: elsewhere
the diagnosis ends only where it asks.
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

DEFAULT_BUDGET = 20.0
"""Processor time that a diagnosis takes at most, unless it is told [s]."""


OVERRUN = 5.0
"""Processor time beyond the budget after which a diagnosis is interrupted; it is interrupted again
each time that it continues for as long [s]."""

_SECONDS_BETWEEN_LOOKS = 0.25  # [s]


class BudgetSpentError(Exception):
    """The time of a diagnosis is spent: what was found until then is the result."""


@dataclass(frozen=True, slots=True)
class Deadline:
    """The end of a diagnosis that has begun.

    Attributes
    ----------
    end
        On the clock [s].
    clock : callable
        The processor time of this process [s].
    is_thorough
        As of `Budget`.
    """

    end: float = inf
    clock: Callable[[], float] = time.process_time
    is_thorough: bool = False

    def check(self) -> None:
        """Go on only if time is left.

        Raises
        ------
        BudgetSpentError
            None is left.
        """
        if self.clock() >= self.end:
            raise BudgetSpentError


NEVER = Deadline()


class Watch:
    """Context manager that interrupts its thread if the block runs far past a deadline.

    Parameters
    ----------
    deadline : Deadline
        It is not watched if it has another clock than that of processor time.
    """

    def __init__(self, deadline: Deadline) -> None:
        is_watched = deadline.end < inf and deadline.clock is time.process_time
        self._end = deadline.end + OVERRUN if is_watched else inf
        self._is_over, self._has_raised, self._lock = Event(), False, RLock()

    def __enter__(self) -> None:
        if self._end < inf:
            # RuntimeError: the system has no threads, or allows the process no further one.
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
                    # Cancel an exception that has not arrived yet, or it would be raised later.
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
    """Processor time that a diagnosis may take.

    Attributes
    ----------
    seconds
        More than zero; `math.inf` for as much as it takes [s].
    clock : callable
        As of `Deadline`.
    is_thorough
        True to look on where the equations leave a force that no cause explains.

    Raises
    ------
    InputError
        It is no such number.
    """

    seconds: float = DEFAULT_BUDGET
    clock: Callable[[], float] = time.process_time
    is_thorough: bool = False

    def __post_init__(self) -> None:
        given: object = self.seconds
        if not (isinstance(given, Real) and float(given) > 0):
            found = printable(repr(given))[:60]
            raise InputError(f"budget: found {found}, expected seconds, more than zero")

    def begun(self) -> Deadline:
        """The end of a diagnosis that begins now."""
        return Deadline(self.clock() + self.seconds, self.clock, self.is_thorough)


USUAL = Budget()
