"""Connections that send no complete head, or read no answer, are closed; their
number is limited."""

import socket
import threading
import time
from contextlib import suppress
from types import SimpleNamespace

import pytest

pytest.importorskip("uvicorn")

import uvicorn

from heyoka_bike.workbench.serving.running import Connection, most_requests

resource = pytest.importorskip("resource")
pytestmark = pytest.mark.timeout(60)
HEAD = b"GET / HTTP/1.1\r\nHost: localhost\r\n"
SHORT = HEAD.replace(b"/", b"/short", 1).replace(b"Host", b"Connection: close\r\nHost")
PAGE = b"x" * 20_000_000


async def page(scope, receive, send):
    if scope["type"] == "http":
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send(
            {"type": "http.response.body", "body": b"short" if scope["path"] == "/short" else PAGE}
        )


@pytest.fixture
def port(request):
    """A server of at most two requests at once, which waits a tenth of a second for clients."""

    class Impatient(Connection):
        patience = getattr(request, "param", 0.1)

    bound = socket.socket()
    bound.bind(("127.0.0.1", 0))
    config = uvicorn.Config(
        page, log_config=None, lifespan="off", http=Impatient, limit_concurrency=2
    )
    running = uvicorn.Server(config)
    thread = threading.Thread(target=running.run, kwargs={"sockets": [bound]}, daemon=True)
    thread.start()
    while not running.started:
        time.sleep(0.01)
    yield bound.getsockname()[1]
    running.should_exit = running.force_exit = True
    thread.join(timeout=20)


def connected(port):
    client = socket.socket()
    # The client has a small buffer, so that an unread answer remains in the server.
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.settimeout(20)
    client.connect(("127.0.0.1", port))
    return client


def received(client):
    size = 0
    try:
        while part := client.recv(1 << 20):
            size += len(part)
    except ConnectionError:
        pass
    return size


def answer_of(client):
    answer = b""
    while part := client.recv(1 << 20):
        answer += part
    return answer


@pytest.mark.parametrize("sent", [b"", HEAD, HEAD + b"X: "])
def test_clients_that_send_no_request_are_closed(port, sent):
    with connected(port) as client:
        client.sendall(sent)
        assert received(client) == 0


def test_clients_that_read_no_answer_are_closed(port):
    with connected(port) as client:
        client.sendall(HEAD + b"\r\n")
        # Data that is already on its way still arrives at the client.
        time.sleep(1.0)
        assert received(client) < len(PAGE)


class Client:
    """A transport whose amount of unread data is the next of these numbers at each check."""

    def __init__(self, *unread):
        self.unread = iter(unread)
        self.is_ended = False

    def get_write_buffer_size(self):
        return next(self.unread)

    def abort(self):
        self.is_ended = True


@pytest.mark.parametrize(
    ("unread", "is_complete", "is_ended"),
    [
        ((300, 200, 100, 1), True, False),
        ((300, 200, 200), True, True),
        # The client sends a file in several parts.
        ((300, 200, 200), False, True),
        # The client waits for a task.
        ((0, 0, 0), False, False),
        ((0, 0), True, True),
    ],
)
def test_clients_that_read_slowly_are_served(unread, is_complete, is_ended):
    found = Connection.__new__(Connection)
    found.transport = Client(*unread)
    found.cycle = SimpleNamespace(response_complete=is_complete)
    calls = []
    found.loop = SimpleNamespace(call_later=lambda seconds, *call: calls.append(call))
    found._look(None)
    for _ in unread[1:]:
        assert not found.transport.is_ended
        look, before = calls.pop()
        look(before)
    assert found.transport.is_ended == is_ended


def test_clients_beyond_the_limit_are_refused(port):
    held = [connected(port) for _ in range(4)]
    with connected(port) as fifth:
        assert received(fifth) == 0
    for client in held:
        client.close()


@pytest.mark.parametrize("port", [30.0], indirect=True)
def test_slow_heads_make_room(port):
    """A request is answered at once, however many other clients send only a part of one."""
    held = [connected(port) for _ in range(20)]
    for client in held:
        client.sendall(HEAD)
    for _ in range(3):
        with connected(port) as client:
            client.sendall(SHORT + b"\r\n")
            assert b"\r\nshort\r\n" in answer_of(client)
    for client in held:
        client.close()


TWO = [
    ("bare", b"GET / HTTP/1.1\nHost: localhost\n\n"),
    ("leading", b"\n" + HEAD + b"\r\n"),
    ("one of them", HEAD + b"X: y\nZ: a\r\n\r\n"),
    ("both", HEAD + b"Content-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
    ("both", HEAD + b"Transfer-Encoding: chunked\r\nContent-Length: 4\r\n\r\n0\r\n\r\n"),
]


@pytest.mark.parametrize(("what", "sent"), TWO)
@pytest.mark.parametrize("port", [30.0], indirect=True)
@pytest.mark.parametrize("pieces", [1, 2])
def test_what_may_be_two_requests_is_refused(port, what, sent, pieces):
    with connected(port) as client:
        half = len(sent) // pieces
        client.sendall(sent[:half])
        time.sleep(0.05)
        with suppress(ConnectionError):
            client.sendall(sent[half:] + HEAD + b"\r\n")
        answer = answer_of(client)
    assert answer.startswith(b"HTTP/1.1 400 ")
    assert answer.count(b"HTTP/1.1 ") == 1


@pytest.mark.parametrize("port", [30.0], indirect=True)
@pytest.mark.parametrize("rest", [b"\r\n", b"Content-Length: 4\r\n\r\na\nb\n"])
def test_what_is_one_request_is_answered(port, rest):
    with connected(port) as client:
        client.sendall(SHORT + rest)
        assert b"\r\nshort\r\n" in answer_of(client)


def test_there_are_files_for_as_many_as_may_ask(monkeypatch):
    given = []
    monkeypatch.setattr(resource, "setrlimit", lambda kind, limits: given.append(limits))
    monkeypatch.setattr(resource, "getrlimit", lambda kind: (1024, 100_000))
    assert most_requests() == 1000
    assert given == [(3100, 100_000)]
    monkeypatch.setattr(resource, "getrlimit", lambda kind: (1024, 1024))
    assert most_requests() == 308
    assert len(given) == 1
