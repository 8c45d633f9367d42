"""Deposit the reference set on Zenodo as a draft, which a person then reads and publishes.

``python .ci/deposit.py 1.5.0`` takes what to say of it from ``.zenodo.json`` and the files from
``reference``, as one archive. ``ZENODO_TOKEN`` may write deposits; ``ZENODO_RECORD`` is the number
of an earlier version, of which this is made the next; ``ZENODO_SERVER`` another server, such as
https://sandbox.zenodo.org. Prints the address of the draft.
"""

import json
import os
import sys
import urllib.request
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

_SERVER = "https://zenodo.org"


def main(version: str, root: Path) -> str:
    """Make the draft; returns its address."""
    found = json.loads((root / "reference" / "manifest.json").read_text(encoding="utf-8"))
    if found["dataset_version"] != version:
        sys.exit(f"reference/manifest.json: found {found['dataset_version']}, expected {version}")
    metadata = json.loads((root / ".zenodo.json").read_text(encoding="utf-8"))
    metadata |= {"upload_type": "dataset", "version": version}
    api = os.environ.get("ZENODO_SERVER", _SERVER).rstrip("/") + "/api/deposit/depositions"
    draft = _draft(api, os.environ.get("ZENODO_RECORD", ""))
    name = f"uncontrolled-bicycle-{version}.zip"
    _ask("PUT", f"{draft['links']['bucket']}/{name}", archive(root / "reference"))
    _ask("PUT", f"{api}/{draft['id']}", json.dumps({"metadata": metadata}).encode())
    return str(draft["links"]["html"])


def archive(folder: Path) -> bytes:
    """The folder as a zip file, the same bytes for the same files."""
    held = BytesIO()
    with zipfile.ZipFile(held, "w") as z:
        for path in sorted(p for p in folder.rglob("*") if p.is_file()):
            entry = zipfile.ZipInfo(path.relative_to(folder.parent).as_posix())
            z.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED)
    return held.getvalue()


def _draft(api: str, record: str) -> Any:
    """A new deposit, or a new version of an earlier one without its files."""
    if not record:
        return _ask("POST", api, b"{}")
    draft = _ask("GET", _ask("POST", f"{api}/{record}/actions/newversion")["links"]["latest_draft"])
    for file in draft["files"]:
        _ask("DELETE", f"{api}/{draft['id']}/files/{file['id']}")
    return draft


def _ask(method: str, address: str, data: bytes | None = None) -> Any:
    is_json = data is not None and data.startswith(b"{")
    kind = "application/json" if is_json else "application/octet-stream"
    headers = {"Authorization": f"Bearer {os.environ['ZENODO_TOKEN']}", "Content-Type": kind}
    request = urllib.request.Request(address, data, headers, method=method)
    with urllib.request.urlopen(request, timeout=300) as answer:
        text = answer.read()
    return json.loads(text) if text else None


if __name__ == "__main__":
    print(main(sys.argv[1], Path(__file__).resolve().parents[1]))
