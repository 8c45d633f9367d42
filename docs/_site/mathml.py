"""Formulas as MathML, which browsers draw by themselves: no script, no network."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

_FUNCTION = re.compile(r"<mi>([a-z]{2,})</mi>")


def _mathml(node: nodes.Element, *, as_block: bool) -> str:
    """The formula, with names of functions told from variables, for the space around them.

    Where no mathematical font is installed, browsers draw the dot of an accent into its letter.
    """
    formula = tex2mathml(node.astext(), as_block=as_block).replace(' accent="true"', "")
    return _FUNCTION.sub(r'<mi class="function">\1</mi>', formula)


def _inline(translator: HTML5Translator, node: nodes.math) -> None:
    translator.body.append(_mathml(node, as_block=False))
    raise nodes.SkipNode


def _block(translator: HTML5Translator, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="formula">{_mathml(node, as_block=True)}</div>')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
