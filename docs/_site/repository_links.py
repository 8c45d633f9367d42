"""Links of the pages to folders and Markdown files of the repository, shown as plain names.

On GitHub such a link opens the folder or file; on the site there is nothing behind it. Links to
other files need no help: Sphinx copies the file. Files of the repository that a page includes, such
as the changelog, have links from its root.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx


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


def setup(app: Sphinx) -> dict[str, Any]:
    """Connect to pages as they are read."""
    app.connect("doctree-read", _plain)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
