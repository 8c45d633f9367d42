"""A real Dask scheduler and its workers, as processes of this machine."""

import os
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

TESTS = Path(__file__).parents[1]

HEARS = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
"""First line of a script that reacts to Ctrl-C even if its parent ignores it, as in a process that
a shell put in the background."""


class Processes:
    """Processes started by `scheduler` and `worker`, which end with the test."""

    def __init__(self, folder):
        self.folder = folder
        self.file = folder / "scheduler.json"
        self.all = []

    @property
    def address(self):
        return str(self.file)

    def start(self, *words, **environment):
        with (self.folder / f"{len(self.all)}.log").open("w") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "dask", *words], stdout=log, stderr=log, cwd=self.folder,
                env={**os.environ, "PYTHONPATH": str(TESTS), **environment},
            )  # fmt: skip
        self.all.append(process)
        return process

    def scheduler(self):
        self.file.unlink(missing_ok=True)
        process = self.start(
            "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
            "--scheduler-file", str(self.file),
        )  # fmt: skip
        wait_for(self.file.exists)
        return process

    def worker(self, threads=1, **environment):
        """Start a worker without a nanny, which would replace a killed worker."""
        return self.start(
            "worker", "--scheduler-file", str(self.file), "--nthreads", str(threads),
            "--no-nanny", "--no-dashboard", **environment,
        )  # fmt: skip


@contextmanager
def started(folder, workers=2):
    """Start a scheduler with this many workers."""
    processes = Processes(folder)
    try:
        processes.scheduler()
        for _ in range(workers):
            processes.worker()
        yield processes
    finally:
        for process in processes.all:
            process.kill()
        for process in processes.all:
            process.wait()


def wait_for(condition, seconds=120, every=0.05):
    """Wait until a condition is true."""
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, f"the condition is not true after {seconds} s"
        time.sleep(every)
