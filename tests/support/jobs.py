"""Work for jobs that run in other processes, which find it by its name."""

import os
import signal
import sys
import time
from pathlib import Path

import flint


def add(a, b, report):
    report("integrate", 1.0)
    return a + b


def fail(report):
    raise ZeroDivisionError("by nothing")


def die_once(flag, report):
    """Ends its process the first time."""
    if not Path(flag).exists():
        Path(flag).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


def die(report):
    os.kill(os.getpid(), signal.SIGKILL)


def begin(folder, seconds, report):
    """Says that it runs, and goes on until it is ended; how often it told is in a file."""
    told = Path(folder) / f"{os.getpid()}"
    for i in range(int(seconds / 0.05)):
        told.write_text(str(i))
        report("integrate", i * 0.05)
        time.sleep(0.05)
    return os.getpid()


def precise(digits, report):
    """One third to so many digits, if nobody else changes the precision meanwhile."""
    with flint.ctx.workprec(digits):
        time.sleep(0.05)
        return str(flint.arb(1) / 3)


def nothing(stage, t):
    """A report that nobody hears."""


def imported(name):
    return os.getpid(), name in sys.modules


def memory_limit():
    import resource

    return resource.getrlimit(resource.RLIMIT_AS)[0]
