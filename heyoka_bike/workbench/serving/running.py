"""Run a server until it is stopped, with a limited number of connections.

A connection is closed if its client neither sends nor reads. h11 accepts heads whose lines end with
only a line feed, which RFC 9112 allows (section 2.2). After a request with both a length and chunks
it keeps the connection open, which is not allowed (section 6.1;
https://github.com/python-hyper/h11/issues/90). A proxy in front of the server may see other
requests in such bytes, so this module rejects them.
"""

import asyncio
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
from time import monotonic, time
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle

from heyoka_bike.errors import InputError
from heyoka_bike.workbench.serving.app import Server
from heyoka_bike.workbench.serving.tasks import Limits

_MOST_CONNECTIONS_WAITING = 1000
# Number of open files that the server needs in addition to those of its connections.
_OTHER_FILES = 100
_WANTED_FILES = 3 * _MOST_CONNECTIONS_WAITING + _OTHER_FILES
_LONGEST_HEAD = 1 << 14  # maximum length of a request's head [bytes]
_BARE = re.compile(rb"(?<!\r)\n")
# Maximum number of bytes read from a connection at once. If they arrive as chunks of one byte each,
# processing them blocks the server for a tenth of a second.
_BYTES_AT_ONCE = 1 << 14
# Size of the system's send buffer of a connection [bytes]. The part of an answer that is in this
# buffer counts as read by the client, so the buffer must be small.
_SENT = 1 << 18


def most_requests() -> int:
    """Return the maximum number of requests at once: 1000, or fewer if the file limit is low."""
    try:
        import resource
    except ImportError:
        return _MOST_CONNECTIONS_WAITING
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    unlimited = resource.RLIM_INFINITY
    wanted = _WANTED_FILES if hard == unlimited else min(_WANTED_FILES, hard)
    if soft != unlimited and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    return min(_MOST_CONNECTIONS_WAITING, max(1, (wanted - _OTHER_FILES) // 3))


class StrictParser(h11.Connection):
    """HTTP parser that rejects requests that a proxy and this server may read differently."""

    def next_event(self) -> Any:
        """Return the next event of h11; raise `h11.RemoteProtocolError` for ambiguous requests."""
        if self.their_state is h11.IDLE:
            head = self.trailing_data[0].partition(b"\r\n\r\n")[0]
            if _BARE.search(head):
                raise h11.RemoteProtocolError("a line feed without carriage return")
        event = super().next_event()
        if isinstance(event, h11.Request):
            names = {name for name, _ in event.headers}
            if {b"content-length", b"transfer-encoding"} <= names:
                raise h11.RemoteProtocolError("both a length and chunks")
        return event


class Connection(H11Protocol):
    """A connection that is closed if its client is idle.

    Above the limit of requests at once, the connections that have been idle longest are closed. New
    connections above twice the limit are closed at once, because each uses one of the process's
    files.

    Attributes
    ----------
    patience : float
        Time within which a client has to send a whole head, or to read part of its answer [s].
    """

    patience = 30.0
    _looking: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Set up the connection of a new client."""
        super().connection_made(transport)
        self.conn = StrictParser(h11.SERVER, _LONGEST_HEAD)
        self.since = monotonic()
        if self.limit_concurrency and len(self.connections) >= self.limit_concurrency:
            others = [x for x in self.connections if isinstance(x, Connection) and x is not self]
            oldest = min((x for x in others if x.is_waiting), key=lambda x: x.since, default=None)
            if oldest is not None:
                oldest.transport.abort()
                self.connections.discard(oldest)
            if len(self.connections) > 2 * self.limit_concurrency:
                transport.abort()
                return
        transport.max_size = _BYTES_AT_ONCE
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SENT)
        self._look(None)

    def connection_lost(self, exc: Exception | None) -> None:
        """Clean up after the connection has ended."""
        if self._looking is not None:
            self._looking.cancel()
        super().connection_lost(exc)

    @property
    def is_waiting(self) -> bool:
        """True if the client has no open request, or if its request has been answered."""
        # The cycle is None before the first request.
        cycle: RequestResponseCycle | None = self.cycle
        return cycle is None or cycle.response_complete

    def _look(self, before: tuple[Any, int] | None) -> None:
        """Close the connection if the client has made no progress since the previous call."""
        # The cycle is None before the first request.
        cycle: RequestResponseCycle | None = self.cycle
        unread = self.transport.get_write_buffer_size()
        is_ours = cycle is not None and not cycle.response_complete and not unread
        now = None if is_ours else (cycle, unread)
        if now is not None and now == before:
            self.transport.abort()
            return
        self._looking = self.loop.call_later(self.patience, self._look, now)


_ALL_ADDRESSES = ("0.0.0.0", "::")
_GRACE = 5  # [s], time for open requests to end when the server stops
_BACKLOG = 2048
_OPENED_AFTER = 0.5  # [s], delay before the browser opens the page
# Prefix of the name of the folder for stored results.
_PREFIX = "heyoka-bike-serve-"
# Subfolder for the temporary files of multiprocessing, which remain if the process is killed.
_PROCESSES = "processes"


def serve(
    host: str, port: int, names: Sequence[str], limits: Limits, board: str | None,
    is_opened: bool, root: str = "",
) -> None:  # fmt: skip
    """Serve until interrupted, then remove everything that was stored.

    Parameters
    ----------
    host, port
        Address to listen on; port 0 means any free port.
    names
        Allowed host names.
    limits
    board
        HTML of the leaderboard, if there is one.
    is_opened
        True to open the page in the browser.
    root
        Path below which the server is hosted, without a trailing slash.

    Raises
    ------
    InputError
        The server cannot listen on the address.
    """
    # Disable this logger, because it would write parts of the uploaded data.
    logging.getLogger("python_multipart").setLevel(logging.CRITICAL)
    # Requests that uvicorn rejects do not reach the application. This logger reports them.
    refused = logging.getLogger("uvicorn.error")
    refused.addHandler(_Refusals(logging.WARNING))
    refused.propagate = False
    # A termination request is handled like a keyboard interrupt, so that the stored results are
    # removed.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    bound = _bound(host, port)
    # A server that listens on all addresses answers only requests for its own names.
    named = names[0] if host in _ALL_ADDRESSES and names[0] != "*" else host
    shown = f"[{named}]" if ":" in named else named
    address = f"http://{shown}:{bound.getsockname()[1]}{root}/"
    sweep(Path(tempfile.gettempdir()))
    with tempfile.TemporaryDirectory(prefix=_PREFIX, ignore_cleanup_errors=True) as folder:
        held = _hold(folder)
        results = Path(folder) / "results"
        results.mkdir(mode=0o700)
        (Path(folder) / _PROCESSES).write_text(Path(get_temp_dir()).name, encoding="utf-8")
        server = Server(results, limits, names, board, _log, root)
        config = uvicorn.Config(
            server.app, log_config=None, access_log=False, http=Connection,
            # Most of these connections wait. Connections beyond this number get the answer 503.
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
    """Lock a folder to show that its server is alive; None if another process has locked it."""
    try:
        import fcntl
    except ImportError:
        # Windows lacks such locks. There a folder may be in use without a lock, so no folder is
        # ever removed.
        return None
    # Another user may have made a pipe or a link of this name, so open only a real folder.
    found = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(found, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(found)
        return None
    return found


def sweep(place: Path, *, new: float = 60.0) -> None:
    """Remove the folders of servers that were killed, or that a crash of the machine stopped.

    A folder older than `new` [s] is locked if its server is alive.
    """
    for folder in place.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            # Skip a new folder, because its server may not have locked it yet.
            if time() - folder.stat().st_mtime > new and (held := _hold(str(folder))) is not None:
                with suppress(OSError, UnicodeDecodeError):
                    name = (folder / _PROCESSES).read_text(encoding="utf-8")
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
        # Clients that connect before the server is ready wait in this queue.
        bound.listen(_BACKLOG)
    except OSError as e:
        bound.close()
        raise InputError(
            f"cannot listen on {host}, port {port} ({e.strerror or e}); --port 0 finds a free port"
        ) from None
    return bound


class _Refusals(logging.Handler):
    """Log handler that writes uvicorn's warnings as lines of our log, without tracebacks."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write the message of a warning to our log."""
        _log(record.getMessage())


def _log(line: str) -> None:
    print(f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S} {line}", file=sys.stderr, flush=True)
