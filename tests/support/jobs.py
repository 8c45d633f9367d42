"""Functions of jobs that run in other processes, which find them by name."""

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
    """End the process on the first call."""
    if not Path(flag).exists():
        Path(flag).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


def die(report):
    os.kill(os.getpid(), signal.SIGKILL)


def begin(folder, seconds, report):
    """Report a start and continue until ended; a file records the number of reports."""
    told = Path(folder) / f"{os.getpid()}"
    for i in range(int(seconds / 0.05)):
        told.write_text(str(i))
        report("integrate", i * 0.05)
        time.sleep(0.05)
    return os.getpid()


def precise(digits, report):
    """Compute one third to this many digits, unless another thread changes the precision."""
    with flint.ctx.workprec(digits):
        time.sleep(0.05)
        return str(flint.arb(1) / 3)


def nothing(stage, t):
    """Ignore a report."""


def imported(name):
    return os.getpid(), name in sys.modules


def memory_limit():
    import resource

    return resource.getrlimit(resource.RLIMIT_AS)[0]
