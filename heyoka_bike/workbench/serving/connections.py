"""Connections: so many and no more, and none for a client that neither asks nor reads.

h11 takes heads whose lines end with a line feed alone, which RFC 9112 allows (section 2.2). After a
request with both a length and chunks it keeps the connection, which is not allowed (section 6.1;
https://github.com/python-hyper/h11/issues/90). A proxy before it may see other requests in these.
"""

import asyncio
import re
import socket
from time import monotonic
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol, RequestResponseCycle

_MOST = 1000
# Requests at once; each has a connection and a file. Beyond the other ones files are needed, too.
_OTHER_FILES = 100
_WANTED_FILES = 3 * _MOST + _OTHER_FILES
# Within which a client has to send a whole head, or to read some of its answer [s].
_PATIENCE = 30.0
_LONGEST_HEAD = 1 << 14  # [bytes]
_BARE = re.compile(rb"(?<!\r)\n")
# Read at once [bytes]: of pieces of one byte each a tenth of a second's work.
_AT_ONCE = 1 << 14
# Held by the system of an answer [bytes]: what is in there is taken as read.
_SENT = 1 << 18


def most_requests() -> int:
    """The largest number of requests at once: 1000, or as many as the system gives files for."""
    try:
        import resource
    except ImportError:
        return _MOST
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    unlimited = resource.RLIM_INFINITY
    wanted = _WANTED_FILES if hard == unlimited else min(_WANTED_FILES, hard)
    if soft != unlimited and soft < wanted:
        resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))
    return min(_MOST, max(1, (wanted - _OTHER_FILES) // 3))


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
    """

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
        transport.max_size = _AT_ONCE
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
        self._looking = self.loop.call_later(_PATIENCE, self._look, now)
