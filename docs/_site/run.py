"""The directive ``run``: commands of a page are run when it is built, and their output is shown.

On GitHub the block reads as plain commands, with the output below where that is committed. Blocks
of a page share a folder of their own, with copies of ``data``, ``docs/examples`` and
``docs/_site/figures``, so nothing of the repository is ever written to. What follows the name, in
any order::

    python            the block is Python, not shell
    code=3            exit code expected (default 0)
    needs=cmake,g++   programs without which the block is shown and not run, and that is said
    modules=mujoco    the same of Python modules
    long              it races, generates or proves: built with -D run_long=0, the site shows what
                      the page has below the block
    lines=12          lines of output shown
    shown             the output is committed, as a block of text below this one, by outputs.py:
                      it has to be what the commands print; of a figure, a picture of the gallery.
                      A block without it prints nothing
    shown=example     ... and may be another each time: times that it took, versions, addresses
    figure=NAME alt="TEXT"   show this picture, which the block made, in place of its output;
    clear             ... on the page's own ground, not on white
    link=NAME         link to this file, which the block made
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import DirectiveError
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxDirective

from blocks import SECONDS, HangError, absent, committed, fill, options, result, without_outputs
from blocks import picture as picture_of

_KEYS = frozenset({
    "python", "code", "needs", "modules", "long", "lines", "figure", "alt", "clear", "link",
    "shown",
})  # fmt: skip


class Run(SphinxDirective):
    """A block of commands with its output."""

    has_content = True
    optional_arguments = 1
    final_argument_whitespace = True
    option_spec: ClassVar[dict[str, Any]] = {}

    def run(self) -> list[nodes.Node]:
        asked = options(self.arguments[0] if self.arguments else "")
        if unknown := set(asked) - _KEYS:
            raise self.error(f"run: found {sorted(unknown)}, expected some of {sorted(_KEYS)}")
        source = "\n".join(self.content)
        shown = self._literal(source, "python" if "python" in asked else "bash")
        missing = absent(asked)
        if not self.config.run_long and "long" in asked:
            missing.append("it takes long")
        if missing:
            return [shown, *self._not_run(missing, asked, source)]
        folder = self._folder()
        try:
            code, output = result(source, asked, folder, self.config.run_seconds)
        except HangError as hung:
            raise self._failed(source, str(hung)) from None
        if code != int(asked.get("code", 0)):
            raise self._failed(source, f"exit code {code}\n{output}")
        if "figure" not in asked:
            self._compare(asked, source, output)
        found: list[nodes.Node] = [shown]
        if "figure" in asked:
            found.append(self._figure(folder / asked["figure"], asked["alt"], "clear" in asked))
        elif output:
            found.append(self._literal(output, "text", "output"))
        if "link" in asked:
            found.append(self._link(folder / asked["link"]))
        return found

    def _compare(self, asked: dict[str, str], source: str, output: str) -> None:
        """Raise an error if the page as it is committed shows another output, or none."""
        below = committed(self._page(), source)
        if output and "shown" not in asked:
            raise self._failed(source, f"found an output, expected the option shown:\n{output}")
        if asked.get("shown") == "example":
            is_shown = bool(below) == bool(output)
        else:
            is_shown = (below or "") == output
        if not is_shown:
            raise self._failed(source, "another output than below: run docs/_site/outputs.py")

    def _not_run(self, why: list[str], asked: dict[str, str], source: str) -> list[nodes.Node]:
        """What stands in place of an output, where a program fails or time is short."""
        below = committed(self._page(), source)
        picture = picture_of(self._page(), source) if "figure" in asked else ""
        before = " Below is what it made before." if below or picture else ""
        note = f"Not run when this page was built: {', '.join(why)}.{before}"
        found: list[nodes.Node] = [nodes.paragraph("", note, classes=["not-run"])]
        if below:
            found.append(self._literal(below, "text", "output"))
        if picture:
            found.append(nodes.image(uri=picture, alt=asked["alt"]))
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
            fill(folder, Path(self.env.srcdir).parent)
        return folder

    def _page(self) -> str:
        """The page as it is committed."""
        return Path(self.env.doc2path(self.env.docname)).read_text(encoding="utf-8")

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


def _drop_outputs(_: Sphinx, __: str, source: list[str]) -> None:
    """Outputs come from the run here."""
    source[0] = without_outputs(source[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive; a page that is read again starts with a new folder."""
    app.add_directive("run", Run)
    app.add_config_value("run_seconds", SECONDS, "", types=(int, float))
    app.add_config_value("run_long", True, "env", types=(bool,))
    app.connect("env-purge-doc", _remove_folder)
    app.connect("source-read", _drop_outputs)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
