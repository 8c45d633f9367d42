"""The table of docs/how-to/cluster.md: several bicycles' short sets on more and more workers.

Run as a script on an idle machine, this makes the sets anew for each number of processes, and once
on a Dask scheduler with two workers, checks that all bytes are the same, and writes the table::

    python docs/_site/workers_table.py
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from heyoka_bike.system.machine import machine
from speed_page import filled
from timed import content, processor_time, timed

PAGE = Path(__file__).parent.parent / "how-to" / "cluster.md"
BICYCLES = ["browser", "pista", "silver", "stratos"]
DASK = "Dask, 2 workers"


def made(folder, *options):
    """Wall and processor time [s] of the command."""
    words = [sys.executable, "-m", "heyoka_bike", "generate", "--bicycle", *BICYCLES, "--until"]
    return timed([*words, "0.2", "--out", str(folder), *options])


def on_dask(place, folder):
    """The same on a scheduler and workers that are started and ended for it."""
    file = place / "scheduler.json"
    dask = [sys.executable, "-m", "dask"]
    said = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = [*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard"]
    worker = [*dask, "worker", "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    processes = [subprocess.Popen([*scheduler, "--scheduler-file", str(file)], **said)]
    try:
        while not file.exists():
            time.sleep(0.1)
        found = [*worker, "--scheduler-file", str(file)]
        processes += [subprocess.Popen(found, **said) for _ in range(2)]
        wall, _ = made(folder, "--cluster", str(file))
    finally:
        before = processor_time()
        for process in processes:
            process.kill()
        for process in processes:
            process.wait()
    return wall, processor_time() - before


def main():
    with tempfile.TemporaryDirectory() as place:
        place, rows, contents = Path(place), [], []
        for workers in (1, 2, 4):
            folder = place / str(workers)
            rows.append((f"`--workers {workers}`", *made(folder, "--workers", str(workers))))
            contents.append(content(folder))
        rows.append((DASK, *on_dask(place, place / "dask")))
        contents.append(content(place / "dask"))
    assert all(content == contents[0] for content in contents)
    first = rows[0][1]
    lines = ["| workers | wall time [s] | processor time [s] | times as fast |",
             "|---|---:|---:|---:|"]  # fmt: skip
    lines += [f"| {n} | {wall:.0f} | {cpu:.0f} | {first / wall:.2f} |" for n, wall, cpu in rows]
    here = machine()
    where = f"{here['cpu']}, {here['cores']} processors, {here['system']}"
    lines += [
        "",
        f"{where}. Times include the start of Python, heyoka's compilation and the writing of "
        "files; all outputs were identical.",
    ]
    print("\n".join(lines))
    PAGE.write_text(filled(PAGE.read_text(), {"workers": "\n".join(lines)}))


if __name__ == "__main__":
    main()
