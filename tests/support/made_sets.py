"""Small reference sets made by `generate`, and bringing their manifest in line with damage."""

import json

from heyoka_bike.cli import main
from heyoka_bike.reference.layout import content_sha256
from heyoka_bike.reference.manifest import MANIFEST, sha256


def make(where, *maneuvers):
    """A set of the benchmark bicycle; each maneuver is (duration, spacing)."""
    text = 'name = "short"\n' + "".join(
        f'[[maneuver]]\nname = "short {i}"\nspeed = "4.6"\nroll_rate = "0.5"\n'
        f'duration = "{duration}"\nspacing = "{spacing}"\n'
        for i, (duration, spacing) in enumerate(maneuvers, start=1)
    )
    (where / "m.toml").write_text(text)
    out = where / "set"
    assert main(["generate", "--maneuvers", str(where / "m.toml"), "--out", str(out)]) == 0
    return out


def manifest(folder, **changes):
    """Write entries of the manifest, in the form that it has."""
    path = folder / MANIFEST
    document = json.loads(path.read_text()) | changes
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")


def accept(folder):
    """Bring sizes and hashes in the manifest in line with the files."""
    document = json.loads((folder / MANIFEST).read_text())
    for entry in document["files"]:
        data = (folder / entry["file"]).read_bytes()
        entry |= {"bytes": len(data), "sha256": sha256(data)}
    manifest(folder, files=document["files"])


def accept_numbers(folder, f):
    """Bring content_sha256 in line with the numbers of an open HDF5 file."""
    content = content_sha256(f)
    f.attrs["content_sha256"] = content
    manifest(folder, content_sha256=content)
