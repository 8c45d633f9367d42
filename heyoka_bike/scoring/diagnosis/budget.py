"""The processor time that a diagnosis may take, how far it goes, and what ends it.

Time is that of the process which diagnoses, in all its threads; it starts no other process. It is
asked for before each step that takes long: a fifth of a second of the motions that are simulated
together, a program that is compared. So the last step may end later, by the time that it takes.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from numbers import Real

from heyoka_bike.errors import InputError, printable

SECONDS = 20.0
"""Processor time that a diagnosis takes at most, unless it is told [s]."""


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

    seconds: float = SECONDS
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
