"""A server in this process, with its own worker processes, and one with small limits."""

from pathlib import Path

import pytest
from starlette.testclient import TestClient

from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.serving.app import Server
from heyoka_bike.workbench.serving.tasks import Limits

EXAMPLE = data_folder() / "peers" / "exudyn-h0.01.txt"


@pytest.fixture(scope="session")
def example() -> Path:
    return EXAMPLE


@pytest.fixture
def serving(tmp_path):
    """Starts servers with given limits, which end with the test."""
    started = []

    def start(hosts=("*",), board=None, root="", **limits):
        folder = tmp_path / f"store-{len(started)}"
        folder.mkdir()
        lines = []
        server = Server(folder, Limits(**{"workers": 1} | limits), hosts, board, lines.append, root)
        client = TestClient(server.app, base_url="http://127.0.0.1", follow_redirects=False)
        client.__enter__()
        client.server, client.folder, client.lines = server, folder, lines
        started.append(client)
        return client

    yield start
    for client in started:
        client.__exit__(None, None, None)


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    """A server with the usual limits."""
    folder = tmp_path_factory.mktemp("store")
    server = Server(folder, Limits(workers=1), log=lambda line: None)
    with TestClient(server.app, base_url="http://127.0.0.1", follow_redirects=False) as found:
        found.server, found.folder = server, folder
        yield found
