"""Text as HTML."""

from __future__ import annotations

import re
from html import escape

# A line must not end within 1e-05, nor before a unit.
_NUMBER = re.compile(r"-?[0-9.]+(?:e[-+]?[0-9]+)?(?: (?:%|s\b|J\b|rad\b(?:/s)?|m/s))?")


def prose(text: str) -> str:
    """Text as HTML, every number with its unit kept on one line."""
    return "".join(
        f"<bdi>{escape(part)}</bdi>" if is_number else escape(part)
        for part, is_number in _parts(text)
    )


def _parts(text: str) -> list[tuple[str, bool]]:
    parts, end = [], 0
    for found in _NUMBER.finditer(text):
        if "e" not in found[0] and " " not in found[0]:
            continue  # nothing to break
        parts += [(text[end : found.start()], False), (found[0], True)]
        end = found.end()
    return [*parts, (text[end:], False)]
