"""Formulas as MathML, which every browser draws by itself: no script, no font, nothing to ask for."""

import re
from html import escape
from typing import Any

from docutils import nodes
from docutils.utils.math import MathError, latex2mathml
from sphinx.util import logging

_LOG = logging.getLogger(__name__)


def mathml(text: str, *, display: bool) -> str:
    """A formula of TeX as a ``<math>`` element.

    >>> mathml("R^2", display=False)[:6]
    '<math '
    """
    spelled = re.sub(r"\{?°\}?", r"^{\\circ}", text).replace("{gathered}", "{aligned}").replace(r"\dots", r"\ldots")
    if display and r"\\" in spelled and r"\begin" not in spelled:
        spelled = rf"\begin{{aligned}}{spelled}\end{{aligned}}"
    return str(latex2mathml.tex2mathml(spelled, as_block=display))


def _shown(node: Any, *, display: bool) -> str:
    text = node.astext().strip()
    try:
        return mathml(text, display=display)
    except MathError as error:
        _LOG.warning("formula is shown as TeX: %s (%s)", text[:80], error, location=node)
        return f"<code>{escape(text)}</code>"


def _inline(translator: Any, node: Any) -> None:
    translator.body.append(_shown(node, display=False))
    raise nodes.SkipNode


def _block(translator: Any, node: Any) -> None:
    translator.body.append(f'<div class="math" style="overflow-x: auto">{_shown(node, display=True)}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> None:
    """Make it the way in which formulas are written."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
