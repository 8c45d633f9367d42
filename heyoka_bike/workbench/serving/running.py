"""A server that runs until it is stopped."""

import logging
import os
import re
import shutil
import signal
import socket
import sys
import tempfile
import webbrowser
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from multiprocessing.util import get_temp_dir
from pathlib import Path
from threading import Timer
from time import time

import uvicorn

from heyoka_bike.errors import InputError
from heyoka_bike.workbench.serving.app import Server
from heyoka_bike.workbench.serving.connections import Connection, most_requests
from heyoka_bike.workbench.serving.limits import Limits

_ANY = ("0.0.0.0", "::")
_GRACE = 5  # [s]
_BACKLOG = 2048
_OPENED_AFTER = 0.5  # [s]
# Of the folder of what is kept; one this old is held if its server lives [s].
_PREFIX = "heyoka-bike-serve-"
_NEW = 60.0
# In it, the name of the folder that multiprocessing has, and removes unless it is killed.
_PROCESSES = "processes"


def serve(
    host: str, port: int, names: Sequence[str], limits: Limits, board: str | None,
    is_opened: bool, root: str = "",
) -> None:  # fmt: skip
    """Serve until interrupted; what was kept is removed then.

    Parameters
    ----------
    host, port
        To listen on; port 0 is any that is free.
    names
        By which it may be asked for.
    limits
    board
        HTML of the leaderboard, if there is one to show.
    is_opened
        Whether to open it in the browser.
    root
        Path below which it is hosted, without a slash at its end.

    Raises
    ------
    InputError
        The address cannot be listened on.
    """
    # It would write pieces of what was sent.
    logging.getLogger("python_multipart").setLevel(logging.CRITICAL)
    # It says which requests it refused before they were anybody's.
    refused = logging.getLogger("uvicorn.error")
    refused.addHandler(_Refusals(logging.WARNING))
    refused.propagate = False
    # Who asks it to end gets it ended as by the keyboard: what it keeps is removed.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    bound = _bound(host, port)
    # On every address there is, it answers to its names only.
    named = names[0] if host in _ANY and names[0] != "*" else host
    shown = f"[{named}]" if ":" in named else named
    address = f"http://{shown}:{bound.getsockname()[1]}{root}/"
    _sweep()
    with tempfile.TemporaryDirectory(prefix=_PREFIX, ignore_cleanup_errors=True) as folder:
        held = _hold(folder)
        results = Path(folder) / "results"
        results.mkdir(mode=0o700)
        (Path(folder) / _PROCESSES).write_text(Path(get_temp_dir()).name)
        server = Server(results, limits, names, board, _log, root)
        config = uvicorn.Config(
            server.app, log_config=None, access_log=False, http=Connection,
            # Most of them wait: more are answered 503.
            limit_concurrency=most_requests(),
            timeout_graceful_shutdown=_GRACE, server_header=False,
        )  # fmt: skip
        print(f"Drop result files on {address} (Ctrl-C ends it)", flush=True)
        if is_opened:
            Timer(_OPENED_AFTER, webbrowser.open, (address,)).start()
        try:
            uvicorn.Server(config).run(sockets=[bound])
        finally:
            if held is not None:
                os.close(held)


def _hold(folder: str) -> int | None:
    """Show other servers that this one lives: an open file, if there is nobody who holds it."""
    try:
        import fcntl
    except ImportError:
        # Windows: nothing is removed of which it is not known whether it is used.
        return None
    # A file of such a name that somebody else put there may be a pipe, or lead elsewhere.
    found = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(found, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(found)
        return None
    return found


def _sweep() -> None:
    """Remove what servers kept that were killed, or that the machine went down under."""
    place = Path(tempfile.gettempdir())
    for folder in place.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            # A new one is about to be held.
            if time() - folder.stat().st_mtime > _NEW and (held := _hold(str(folder))) is not None:
                with suppress(OSError, UnicodeDecodeError):
                    name = (folder / _PROCESSES).read_text()
                    if re.fullmatch(r"pymp-\w+", name) and os.fstat(held).st_uid == os.geteuid():
                        shutil.rmtree(place / name, ignore_errors=True)
                shutil.rmtree(folder, ignore_errors=True)
                os.close(held)


def _bound(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    bound = socket.socket(family)
    bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        bound.bind((host, port))
        # Who comes before the server is ready waits.
        bound.listen(_BACKLOG)
    except OSError as e:
        bound.close()
        raise InputError(
            f"{host}, port {port}: cannot be listened on ({e.strerror or e}), expected a free "
            "port (--port 0 finds one)"
        ) from None
    return bound


class _Refusals(logging.Handler):
    """Warnings of uvicorn, without traces, as lines of our log."""

    def emit(self, record: logging.LogRecord) -> None:
        """Log one."""
        _log(record.getMessage())


def _log(line: str) -> None:
    print(f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} {line}", file=sys.stderr, flush=True)
