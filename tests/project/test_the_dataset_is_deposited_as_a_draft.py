"""The deposit contains the dataset under its own version, and remains a draft."""

import importlib.util
import io
import json
import shutil
import threading
import zipfile
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("deposit", ROOT / ".ci/deposit.py")
    found = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found


class Zenodo(BaseHTTPRequestHandler):
    """A server that answers like Zenodo's interface for deposits, and records the requests."""

    def do_POST(self):
        base = f"http://127.0.0.1:{self.server.server_port}"
        length = int(self.headers["Content-Length"] or 0)
        self.server.asked.append((self.command, self.path, self.rfile.read(length)))
        answer = {
            "id": 8,
            "links": {
                "bucket": f"{base}/bucket",
                "html": f"{base}/deposit/8",
                "latest_draft": f"{base}/api/deposit/depositions/8",
            },
            "files": [{"id": "old"}],
        }
        text = json.dumps(answer).encode()
        self.send_response(200)
        self.send_header("Content-Length", str(len(text)))
        self.end_headers()
        self.wfile.write(text)

    do_GET = do_PUT = do_DELETE = do_POST  # noqa: N815

    def log_message(self, *words):
        """Print nothing to standard error."""


@pytest.fixture
def server(monkeypatch):
    with HTTPServer(("127.0.0.1", 0), Zenodo) as found:
        found.asked = []
        monkeypatch.setenv("ZENODO_SERVER", f"http://127.0.0.1:{found.server_port}")
        monkeypatch.setenv("ZENODO_TOKEN", "token")
        monkeypatch.delenv("ZENODO_RECORD", raising=False)
        thread = threading.Thread(target=found.serve_forever)
        thread.start()
        yield found
        found.shutdown()
        thread.join()


@pytest.fixture
def root(tmp_path, folder):
    (tmp_path / "reference").mkdir()
    shutil.copy(folder / "manifest.json", tmp_path / "reference")
    (tmp_path / ".zenodo.json").write_text('{"title": "A bicycle"}')
    return tmp_path


def version_of(root):
    return json.loads((root / "reference/manifest.json").read_text())["dataset_version"]


@pytest.mark.parametrize("is_first", [True, False])
def test_the_draft_has_the_set_and_its_version(script, server, root, monkeypatch, is_first):
    if not is_first:
        monkeypatch.setenv("ZENODO_RECORD", "7")
    version = version_of(root)
    assert script.main(version, root).endswith("/deposit/8")
    asked = {(method, path): data for method, path, data in server.asked}
    archive = asked["PUT", f"/bucket/uncontrolled-bicycle-{version}.zip"]
    with zipfile.ZipFile(io.BytesIO(archive)) as z:
        manifest = (root / "reference/manifest.json").read_bytes()
        assert {name: z.read(name) for name in z.namelist()} == {
            "reference/manifest.json": manifest
        }
    said = json.loads(asked["PUT", "/api/deposit/depositions/8"])["metadata"]
    assert said == {"title": "A bicycle", "upload_type": "dataset", "version": version}
    assert (("DELETE", "/api/deposit/depositions/8/files/old") in asked) is not is_first
    assert not any(path.endswith("/actions/publish") for _, path in asked)


def test_another_version_is_refused(script, server, root):
    with pytest.raises(SystemExit, match=f"found {version_of(root)}, expected 99"):
        script.main("99", root)
    assert server.asked == []
