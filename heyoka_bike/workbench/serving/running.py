"""A server that runs until it is stopped, with so many connections and no more.

A connection is ended where its client neither asks nor reads. h11 takes heads whose lines end with
a line feed alone, which RFC 9112 allows (section 2.2). After a request with both a length and
chunks it keeps the connection, which is not allowed (section 6.1;
https://github.com/python-hyper/h11/issues/90). A proxy before it may see other requests in these.
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
# Requests at once; each has a connection and a file. Beyond the other ones files are needed, too.
_OTHER_FILES = 100
_WANTED_FILES = 3 * _MOST_CONNECTIONS_WAITING + _OTHER_FILES
_LONGEST_HEAD = 1 << 14  # [bytes]
_BARE = re.compile(rb"(?<!\r)\n")
# Read at once [bytes]: of pieces of one byte each a tenth of a second's work.
_BYTES_AT_ONCE = 1 << 14
# Held by the system of an answer [bytes]: what is in there is taken as read.
_SENT = 1 << 18


def most_requests() -> int:
    """The largest number of requests at once: 1000, or as many as the system gives files for."""
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
    """Refuses requests that two servers may understand differently."""

    def next_event(self) -> Any:
        """The next event; raises `h11.RemoteProtocolError` for such a request."""
        if self.their_state is h11.IDLE:
            head = self.trailing_data[0].partition(b"\r\n\r\n")[0]
            if _BARE.search(head):
                raise h11.RemoteProtocolError("a line feed alone")
        event = super().next_event()
        if isinstance(event, h11.Request):
            names = {name for name, _ in event.headers}
            if {b"content-length", b"transfer-encoding"} <= names:
                raise h11.RemoteProtocolError("both a length and chunks")
        return event


class Connection(H11Protocol):
    """A connection that is ended where its client lets it wait for nothing.

    Of more than may ask at once, those that have not asked for longest make room; those beyond
    twice as many are ended unheard, for each of them takes one of the files that the system gives.

    Attributes
    ----------
    patience : float
        Within which a client has to send a whole head, or to read some of its answer [s].
    """

    patience = 30.0
    _looking: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """A client is there."""
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
        """It is gone."""
        if self._looking is not None:
            self._looking.cancel()
        super().connection_lost(exc)

    @property
    def is_waiting(self) -> bool:
        """True if its client has asked for nothing, or has all of its answer."""
        # None until something is asked for.
        cycle: RequestResponseCycle | None = self.cycle
        return cycle is None or cycle.response_complete

    def _look(self, before: tuple[Any, int] | None) -> None:
        """End the connection if its client has had time enough and done nothing with it."""
        # None until something is asked for.
        cycle: RequestResponseCycle | None = self.cycle
        unread = self.transport.get_write_buffer_size()
        is_ours = cycle is not None and not cycle.response_complete and not unread
        now = None if is_ours else (cycle, unread)
        if now is not None and now == before:
            self.transport.abort()
            return
        self._looking = self.loop.call_later(self.patience, self._look, now)


_ALL_ADDRESSES = ("0.0.0.0", "::")
_GRACE = 5  # [s]
_BACKLOG = 2048
_OPENED_AFTER = 0.5  # [s]
# Of the folder of what is kept.
_PREFIX = "heyoka-bike-serve-"
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


def sweep(place: Path, *, new: float = 60.0) -> None:
    """Remove what servers kept in a folder that were killed, or that the machine went down under.

    A folder older than `new` [s] is held if its server lives.
    """
    for folder in place.glob(f"{_PREFIX}*"):
        with suppress(OSError):
            # A new one is about to be held.
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
