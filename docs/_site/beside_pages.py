"""What lies beside the pages of the site: the judge, the reference files and the schema of a score.

``judge/`` is the page of ``export --page`` with the header and a file to try, ``data/`` the
reference set with its hashes and a page, on which each value has an address. The site is then all
that its build wrote; served from any folder it needs nothing else.

Run as a script with the name of a folder, this writes these parts alone.
"""

from __future__ import annotations

import json
import shutil
import sys
from hashlib import sha256
from html import escape
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from certified_texts import DIGITS, texts
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reference.description import FILES
from heyoka_bike.reference.layout import TEXT_50
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.manifest import MANIFEST
from heyoka_bike.showing.document.html import PAGE_STYLE, page
from heyoka_bike.showing.wording.origin_text import reference_words
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.checker.header import checker_header
from heyoka_bike.workbench.checker.page import checker_page

if TYPE_CHECKING:
    from sphinx.application import Sphinx

_HERE = Path(__file__).parent / "data_page"
_SCHEMA = Path(__file__).parents[2] / "heyoka_bike/showing/formats/score-1.schema.json"
EXAMPLE = "exudyn-h0.01.txt"
"""A file to try, beside the judge."""
CITED = "2.roll_angle@7.31"
"""A value whose address is shown."""


def write(site: Path) -> None:
    """Write these parts into the folder of a site."""
    _write_judge(site / "judge")
    _write_data(site / "data")
    shutil.copyfile(_SCHEMA, site / "score.schema.json")
    # GitHub would leave out folders whose names begin with an underscore.
    (site / ".nojekyll").touch()


def _write_judge(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "index.html").write_bytes(checker_page().encode())
    (folder / "uncontrolled_bicycle.h").write_bytes(checker_header(load_reference()))
    shutil.copyfile(data_folder() / "peers" / EXAMPLE, folder / EXAMPLE)


def _write_data(folder: Path) -> None:
    reference = load_reference()
    source = reference.folder
    manifest = json.loads((source / MANIFEST).read_text(encoding="utf-8"))
    listed = {MANIFEST, *(entry["file"] for entry in manifest["files"])}
    names = [name for name in FILES if name in listed]
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source / name, folder / name)
    pages = texts(reference, source)
    for name, text in pages.items():
        (folder / name).write_text(text, "ascii")
    hashes = {name: sha256((folder / name).read_bytes()).hexdigest() for name in (*names, *pages)}
    lines = "".join(f"{digest}  {name}\n" for name, digest in hashes.items())
    (folder / "SHA256SUMS").write_text(lines, "ascii")
    (folder / "index.html").write_text(_page(reference, folder, names, pages, hashes), "utf-8")


def _page(
    reference: Any, folder: Path, names: list[str], pages: dict[str, str], hashes: dict[str, str]
) -> str:
    fields = {
        "version": escape(reference.dataset_version),
        "text": TEXT_50,
        "example": CITED,
        "digits": DIGITS,
        "maneuvers": "".join(f"<option>{n}</option>" for n in reference),
        "columns": "".join(f"<option>{key}</option>" for key in BENCHMARK_COLUMNS),
        "pages": "".join(_listed(folder, name, hashes[name], "") for name in pages),
        "files": "".join(
            _listed(folder, x, hashes[x], FILES[x].summary.replace("This page", "Card"))
            for x in names
        ),
    }
    times = (folder / TEXT_50).read_text("ascii").splitlines()
    data = {
        "text": TEXT_50,
        "keys": BENCHMARK_COLUMNS,
        "units": [DEFINITIONS[key][0].unit for key in BENCHMARK_COLUMNS],
        "maneuvers": len(reference),
        "version": reference.dataset_version,
        "spacing": times[1].split()[0],
        "end": times[-1].split()[0],
    }
    made = page(
        "Uncontrolled bicycle: reference data",
        Template((_HERE / "page.html").read_text(encoding="utf-8")).substitute(fields),
        reference_words(reference.bicycle, reference.dataset_version),
        styles=(PAGE_STYLE, _HERE / "page.css"),
        script=(_HERE / "page.js").read_text(encoding="utf-8"),
        data=json.dumps(data),
    )
    # The script reads the text beside the page.
    return made.replace("default-src 'none';", "default-src 'none'; connect-src 'self';", 1)


def _listed(folder: Path, name: str, digest: str, about: str) -> str:
    size = (folder / name).stat().st_size
    said = f"<span>{escape(about)}</span>" if about else ""
    return (
        f'<li><a href="{name}">{name}</a> {size:,} bytes{said}'
        f"<span>sha256 <code>{digest}</code></span></li>"
    )


def _write_when_built(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        write(Path(app.outdir))


def setup(app: Sphinx) -> dict[str, Any]:
    """Write them when the pages are built."""
    app.connect("build-finished", _write_when_built)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


if __name__ == "__main__":
    write(Path(sys.argv[1]))
