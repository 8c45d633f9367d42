"""The directive ``run``: commands of a page are run when it is built, and their output is shown.

On GitHub the block reads as plain commands. Blocks of a page share a folder of their own, with
copies of ``data``, ``docs/examples`` and ``docs/_site/figures``, so nothing of the repository is
ever written to. What follows the name, in any order::

    python            the block is Python, not shell
    code=3            exit code expected (default 0)
    needs=cmake,g++   programs without which the block is shown and not run, and that is said
    lines=12          lines of output shown
    figure=NAME alt="TEXT"   show this picture, which the block made, in place of its output;
    clear             ... on the page's own ground, not on white
    link=NAME         link to this file, which the block made
"""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from pathlib import Path
from typing import Any, ClassVar

from blocks import HangError, carry_out
from docutils import nodes
from docutils.parsers.rst import DirectiveError
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxDirective

_WIDTH = "92"  # of tables, as in the README
_SECONDS = 300.0  # no block takes a tenth of it
_KEYS = frozenset({"python", "code", "needs", "lines", "figure", "alt", "clear", "link"})


class Run(SphinxDirective):
    """A block of commands with its output."""

    has_content = True
    optional_arguments = 1
    final_argument_whitespace = True
    option_spec: ClassVar[dict[str, Any]] = {}

    def run(self) -> list[nodes.Node]:
        words = shlex.split(self.arguments[0] if self.arguments else "")
        asked = {key: value for key, _, value in (word.partition("=") for word in words)}
        if unknown := set(asked) - _KEYS:
            raise self.error(f"run: found {sorted(unknown)}, expected some of {sorted(_KEYS)}")
        source = "\n".join(self.content)
        is_python = "python" in asked
        shown = self._literal(source, "python" if is_python else "bash")
        missing = [x for x in asked.get("needs", "").split(",") if x and not shutil.which(x)]
        if missing:
            note = f"Not run when this page was built: {', '.join(missing)} was not there."
            return [shown, nodes.paragraph("", note, classes=["not-run"])]
        folder = self._folder()
        program = [sys.executable, "-"] if is_python else ["bash", "-e", "-o", "pipefail", "-s"]
        try:
            code, output = carry_out(
                program, source, folder, _environment(), self.config.run_seconds
            )
        except HangError as hung:
            raise self._failed(source, str(hung)) from None
        if code != int(asked.get("code", 0)):
            raise self._failed(source, f"exit code {code}\n{output}")
        found: list[nodes.Node] = [shown]
        if "figure" in asked:
            found.append(self._figure(folder / asked["figure"], asked["alt"], "clear" in asked))
        elif text := _shortened(output, int(asked.get("lines", 0))):
            found.append(self._literal(text, "text", "output"))
        if "link" in asked:
            found.append(self._link(folder / asked["link"]))
        return found

    def _failed(self, block: str, what: str) -> DirectiveError:
        """An error that begins with page and line, and shows the block."""
        page, line = self.get_source_info()
        return self.error(f"run: {page}:{line}: {what}\nThe block:\n{block}")

    def _literal(self, text: str, language: str, *classes: str) -> nodes.literal_block:
        block = nodes.literal_block(text, text, classes=list(classes))
        block["language"] = language
        self.set_source_info(block)
        return block

    def _folder(self) -> Path:
        """The page's own folder, with copies of what its commands may use."""
        folder = _folder_of(self.env, self.env.docname)
        if not folder.exists():
            repository = Path(self.env.srcdir).parent
            for name in ("data", "docs/examples", "docs/_site/figures"):
                shutil.copytree(repository / name, folder / name)
        return folder

    def _from_page(self, file: Path) -> str:
        """The file as seen from the page."""
        if not file.is_file():
            raise self.error(f"run: found no {file.name}, expected the block to make it")
        return os.path.relpath(file, Path(self.env.doc2path(self.env.docname)).parent)

    def _figure(self, picture: Path, alt: str, is_clear: bool) -> nodes.image:
        classes = [] if is_clear else ["on-white"]
        return nodes.image(uri=self._from_page(picture), alt=alt, classes=classes)

    def _link(self, file: Path) -> nodes.paragraph:
        target = self._from_page(file)
        link = addnodes.download_reference("", "", nodes.literal("", file.name), reftarget=target)
        return nodes.paragraph("", "What it wrote: ", link, classes=["output"])


def _folder_of(env: BuildEnvironment, page: str) -> Path:
    return Path(env.doctreedir) / "run" / page


def _remove_folder(_: Sphinx, env: BuildEnvironment, page: str) -> None:
    shutil.rmtree(_folder_of(env, page), ignore_errors=True)


def _shortened(text: str, lines: int) -> str:
    found = [line.rstrip() for line in text.rstrip().splitlines()]
    return "\n".join([*found[:lines], "..."] if 0 < lines < len(found) else found)


def _environment() -> dict[str, str]:
    """As at a terminal of a fixed width, with this environment's programs first."""
    kept = {k: v for k, v in os.environ.items() if k not in ("CI", "FORCE_COLOR", "PYTEST_ADDOPTS")}
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return kept | {"PATH": path, "COLUMNS": _WIDTH, "NO_COLOR": "1"}


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive; a page that is read again starts with a new folder."""
    app.add_directive("run", Run)
    app.add_config_value("run_seconds", _SECONDS, "", types=(int, float))
    app.connect("env-purge-doc", _remove_folder)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
