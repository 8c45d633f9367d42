"""Links that are others on the site than on a code host.

Links of the pages to folders and Markdown files of the repository are shown as plain names: on a
code host they open the folder or file, on the site there is nothing behind them. Links to other
files need no help: Sphinx copies the file. Files of the repository that a page includes, such as
the changelog, have links from its root. A link with the address of the site leads to the place in
the copy that is read, wherever that is served.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

from addresses import addresses


def _plain(app: Sphinx, document: nodes.document) -> None:
    folder = Path(app.env.doc2path(app.env.docname)).parent
    for link in list(document.findall(addnodes.pending_xref)):
        if link.get("reftype") != "myst":
            continue
        is_elsewhere = (
            link.get("refdomain") == "doc" and link["reftarget"] not in app.env.found_docs
        )
        is_from_root = (Path(app.srcdir).parent / link["reftarget"].partition("#")[0]).is_file()
        if is_elsewhere or is_from_root or (folder / link["reftarget"]).is_dir():
            link.replace_self(nodes.literal("", link.astext()))


def _within(app: Sphinx, document: nodes.document) -> None:
    _, site = addresses()
    up = "../" * app.env.docname.count("/") or "./"
    for link in document.findall(nodes.reference):
        address = link.get("refuri", "")
        if address == site or address.startswith(f"{site}/"):
            link["refuri"] = up + address.removeprefix(site).lstrip("/")


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to pages as they are read."""
    app.connect("doctree-read", _plain)
    app.connect("doctree-read", _within)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
