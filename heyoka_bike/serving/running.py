"""A server that runs until it is stopped."""

import logging
import signal
import socket
import sys
import tempfile
import webbrowser
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from threading import Timer

import uvicorn

from heyoka_bike.errors import InputError
from heyoka_bike.serving.app import Server
from heyoka_bike.serving.limits import Limits

# Requests at once, most of which wait: more are answered 503.
_AT_ONCE = 1000
_GRACE = 5  # [s]
_BACKLOG = 2048
_OPENED_AFTER = 0.5  # [s]


def serve(
    host: str, port: int, names: Sequence[str], limits: Limits, board: str | None, is_opened: bool
) -> None:
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

    Raises
    ------
    InputError
        The address cannot be listened on.
    """
    # It would write pieces of what was sent.
    logging.getLogger("python_multipart").setLevel(logging.CRITICAL)
    # Who asks it to end gets it ended as by the keyboard: what it keeps is removed.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    bound = _bound(host, port)
    shown = f"[{host}]" if ":" in host else host
    address = f"http://{shown}:{bound.getsockname()[1]}/"
    with tempfile.TemporaryDirectory(prefix="heyoka-bike-", ignore_cleanup_errors=True) as folder:
        server = Server(Path(folder), limits, names, board, _log)
        config = uvicorn.Config(
            server.app, log_config=None, access_log=False, limit_concurrency=_AT_ONCE,
            timeout_graceful_shutdown=_GRACE, server_header=False,
        )  # fmt: skip
        print(f"Drop result files on {address} (Ctrl-C ends it)", flush=True)
        if is_opened:
            Timer(_OPENED_AFTER, webbrowser.open, (address,)).start()
        uvicorn.Server(config).run(sockets=[bound])


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


def _log(line: str) -> None:
    print(f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} {line}", file=sys.stderr, flush=True)
