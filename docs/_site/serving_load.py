"""Many clients at once: what a server of this machine answers, how fast, with how much memory.

Run as ``python docs/_site/serving_load.py --clients 50 --files 500``. It starts a
server of its own on 127.0.0.1 and asks nothing else. With ``--minutes 10 --kill-every 5`` it is a
soak: clients ask until the time is over, and meanwhile processes that score a file are killed, one
every so often. A kill may cost one answer, 422 as if memory had run out; none may be lost, and
memory may not grow.
"""

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import closing, suppress
from http.client import HTTPConnection, HTTPException
from math import inf
from pathlib import Path
from statistics import median
from time import perf_counter

from heyoka_bike.system.parallel import processors
from heyoka_bike.system.resources import data_folder

_FILE = "exudyn-h0.01.txt"
_BOUNDARY = "a-line-that-no-file-has"
_LOOK = 0.2  # [s]


def main() -> None:
    """Measure and print."""
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("--clients", type=int, default=50)
    p.add_argument("--files", type=int, default=500, help="in all (default 500)")
    p.add_argument("--queue", type=int, default=100)
    p.add_argument("--minutes", type=float, help="in place of a number of files")
    p.add_argument("--kill-every", type=float, metavar="S", help="a process that scores [s]")
    args = p.parse_args()
    body = _form((data_folder() / "peers" / _FILE).read_bytes())
    words = [
        sys.executable,
        "-m",
        "heyoka_bike",
        "serve",
        "--port",
        "0",
        "--queue",
        str(args.queue),
    ]
    with (
        tempfile.TemporaryDirectory() as folder,
        tempfile.TemporaryFile() as log,
        subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=log, text=True,
            env=os.environ | {"TMPDIR": folder},
        ) as server,
    ):  # fmt: skip
        try:
            assert server.stdout is not None
            found = re.search(r":(\d+)/", server.stdout.readline())
            assert found is not None
            port = int(found[1])
            _ask(port, body)
            load = _Load(port, body, server.pid)
            load.put(args.clients, args.files, args.minutes, args.kill_every)
            left = list(Path(folder).glob("heyoka-bike-*/*/*"))
            print(json.dumps(load.said() | {"clients": args.clients, "folders left": len(left)}))
        finally:
            server.terminate()


def _form(content: bytes) -> bytes:
    said = f'Content-Disposition: form-data; name="file"; filename="{_FILE}"'
    return (
        f"--{_BOUNDARY}\r\n{said}\r\n\r\n".encode() + content + f"\r\n--{_BOUNDARY}--\r\n".encode()
    )


def _ask(port: int, body: bytes) -> tuple[int, float]:
    """Status of the answer, 0 if there was none, and how long it took [s]."""
    start = perf_counter()
    status = 0
    kind = {"Content-Type": f"multipart/form-data; boundary={_BOUNDARY}"}
    with (
        suppress(OSError, HTTPException),
        closing(HTTPConnection("127.0.0.1", port, timeout=300)) as connection,
    ):
        connection.request("POST", "/score", body, kind)
        answer = connection.getresponse()
        answer.read()
        status = answer.status
    return status, perf_counter() - start


class _Load:
    """Requests of clients to a server, and its answers."""

    def __init__(self, port: int, body: bytes, pid: int) -> None:
        self.port, self.body, self.pid = port, body, pid
        self.answers: list[tuple[int, float]] = []
        # Of all processes, from time to time [bytes].
        self.memory: list[int] = []
        self.kills, self.took = 0, 0.0

    def put(
        self, clients: int, files: int, minutes: float | None, kill_every: float | None
    ) -> None:
        """So many files, or as many as there is time for."""
        start, left = perf_counter(), iter(range(files))
        end = start + (60 * minutes if minutes else inf)
        killed = start

        def client() -> None:
            while perf_counter() < end and (minutes or next(left, None) is not None):
                self.answers.append(_ask(self.port, self.body))

        with ThreadPoolExecutor(clients) as pool:
            asked = [pool.submit(client) for _ in range(clients)]
            self.memory.append(_memory(self.pid))
            while wait(asked, _LOOK).not_done:
                self.memory.append(_memory(self.pid))
                if kill_every and perf_counter() > killed + kill_every:
                    killed = perf_counter()
                    self.kills += _kill_one(self.pid)
        self.took = perf_counter() - start

    def said(self) -> dict[str, object]:
        """The measured numbers by name."""
        codes = Counter(code for code, _ in self.answers)
        seconds = sorted(took for _, took in self.answers)
        sizes = [size / 1e6 for size in self.memory]
        tenths = [sizes[len(sizes) * i // 10 : len(sizes) * (i + 1) // 10] for i in range(10)]
        return {
            "answers": {str(code): n for code, n in sorted(codes.items()) if code},
            "answers lost": codes[0],
            "processes killed": self.kills,
            "files per second and processor": round(codes[200] / self.took / processors(), 2),
            "seconds, median": round(seconds[len(seconds) // 2], 2),
            "seconds, longest": round(seconds[-1], 2),
            "MB of all processes, most": round(max(sizes)),
            "MB, median of each tenth of the time": [round(median(x)) for x in tenths if x],
        }


def _below(pid: int) -> list[tuple[int, int]]:
    """A process and those below it, with their depths, where /proc says it."""
    found = [(pid, 0)]
    for one, depth in found:
        with suppress(OSError):
            for task in Path(f"/proc/{one}/task").iterdir():
                children = (task / "children").read_text(encoding="ascii").split()
                found += [(int(child), depth + 1) for child in children]
    return found


def _memory(pid: int) -> int:
    """Private memory of a process and its children [bytes]."""
    total = 0
    for one, _ in _below(pid):
        with suppress(OSError):
            text = Path(f"/proc/{one}/smaps_rollup").read_text(encoding="ascii")
            total += 1024 * sum(int(x) for x in re.findall(r"^Pss:\s+(\d+)", text, re.MULTILINE))
    return total


def _kill_one(pid: int) -> int:
    """Kill a process that scores, one forked by another than the server; how many it was."""
    for one, depth in _below(pid):
        if depth > 1:
            with suppress(OSError):
                os.kill(one, signal.SIGKILL)
                return 1
    return 0


if __name__ == "__main__":
    main()
