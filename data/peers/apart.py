"""A function in a process of its own, which may hang, crash or be absent without harm."""

import contextlib
import os
import signal
import subprocess
from multiprocessing import get_context

# A fork would copy the threads that a library started.
_SPAWN = get_context("spawn")


class AbsentError(Exception):
    """The function could not be made: its program is not here."""


class FailedError(Exception):
    """A call did not come to its end."""


class Apart:
    """What ``make(*inputs)`` gives, to be called elsewhere.

    Parameters
    ----------
    limit
        Of making it, and of each call [s].
    make
        A function of a module, as are its inputs: they are pickled.
    """

    def __init__(self, limit, make, *inputs):
        self.limit, self.made_by, self.process = limit, (make, inputs), None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._end()

    def start(self):
        """Make the function, unless it is there.

        Raises
        ------
        AbsentError
        """
        if self.process is not None:
            return
        self.pipe, other = _SPAWN.Pipe()
        self.process = _SPAWN.Process(target=_serve, args=(other, *self.made_by), daemon=True)
        self.process.start()
        other.close()
        try:
            self._answer()
        except FailedError as e:
            self._end()
            raise AbsentError(str(e)) from None

    def __call__(self, *inputs, **named):
        """Call it.

        Raises
        ------
        AbsentError, FailedError
        """
        self.start()
        self.pipe.send((inputs, named))
        return self._answer()

    def _answer(self):
        try:
            if not self.pipe.poll(self.limit):
                self._end()
                raise FailedError(f"no end after {self.limit:g} s")
            found, failure = self.pipe.recv()
        except (EOFError, OSError):
            self.process.join()
            code = self.process.exitcode
            self._end()
            raise FailedError(f"the process ended with code {code}") from None
        if failure:
            raise FailedError(failure)
        return found

    def _end(self):
        """End the process with all that it started."""
        if self.process is not None:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self.process.pid, signal.SIGKILL)
            self.process.kill()
            self.process.join()
            self.process = None


def _serve(pipe, make, inputs):
    os.setsid()
    # Programs write what they like; what fails is said through the pipe.
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    call, failure = _tried(make, *inputs)
    pipe.send((None, failure))
    while call is not None:
        given, named = pipe.recv()
        pipe.send(_tried(call, *given, **named))


def _tried(function, *inputs, **named):
    """What a function gives, and in a line why it gives nothing."""
    try:
        return function(*inputs, **named), None
    except Exception as e:  # Of a program of others: anything.
        said = e.stderr if isinstance(e, subprocess.CalledProcessError) and e.stderr else str(e)
        lines = [line.strip() for line in str(said).splitlines() if line.strip()]
        telling = next((x for x in lines if "error" in x.lower()), lines[-1] if lines else "")
        return None, f"{type(e).__name__}: {telling[:200]}"
