"""Many clients at once: what a server of this machine answers, how fast, with how much memory.

Run as ``python -m heyoka_bike.workbench.bench.serving_load --clients 50 --files 500``. It starts a
server of its own on 127.0.0.1 and asks nothing else.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import closing, suppress
from http.client import HTTPConnection, HTTPException
from pathlib import Path
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
    args = p.parse_args()
    body = _form((data_folder() / "peers" / _FILE).read_bytes())
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as log:
        server = subprocess.Popen(
            [sys.executable, "-m", "heyoka_bike", "serve", "--port", "0", "--queue",
             str(args.queue)],
            stdout=subprocess.PIPE, stderr=log, text=True, env=os.environ | {"TMPDIR": folder},
        )  # fmt: skip
        try:
            assert server.stdout is not None
            found = re.search(r":(\d+)/", server.stdout.readline())
            assert found is not None
            port = int(found[1])
            _ask(port, body)
            print(json.dumps(_load(port, body, args.clients, args.files, server.pid, folder)))
        finally:
            server.terminate()
            server.wait()


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


def _load(
    port: int, body: bytes, clients: int, files: int, pid: int, folder: str
) -> dict[str, object]:
    most, start = 0, perf_counter()
    with ThreadPoolExecutor(clients) as pool:
        asked = [pool.submit(_ask, port, body) for _ in range(files)]
        while wait(asked, _LOOK).not_done:
            most = max(most, _memory(pid))
    took = perf_counter() - start
    codes = Counter(x.result()[0] for x in asked)
    seconds = sorted(x.result()[1] for x in asked)
    left = list(Path(folder).glob("heyoka-bike-*/*"))
    return {
        "clients": clients,
        "answers": {str(code): n for code, n in sorted(codes.items())},
        "files per second and processor": round(codes[200] / took / processors(), 2),
        "seconds, median": round(seconds[len(seconds) // 2], 2),
        "seconds, longest": round(seconds[-1], 2),
        "MB of all processes, most": round(most / 1e6),
        "folders left": len(left),
    }


def _memory(pid: int) -> int:
    """What a process and those below it have to themselves [bytes], where /proc says it."""
    total, waiting = 0, [pid]
    while waiting:
        one = waiting.pop()
        try:
            text = Path(f"/proc/{one}/smaps_rollup").read_text(encoding="ascii")
            total += 1024 * sum(int(x) for x in re.findall(r"^Pss:\s+(\d+)", text, re.MULTILINE))
            for task in Path(f"/proc/{one}/task").iterdir():
                waiting += map(int, (task / "children").read_text(encoding="ascii").split())
        except OSError:
            continue
    return total


if __name__ == "__main__":
    main()
