"""Text as HTML, and the page that all of it stands in."""

import re
from base64 import b64encode
from collections.abc import Sequence
from hashlib import sha256
from html import escape
from pathlib import Path

# A line must not end within 1e-05, nor before a unit.
_NUMBER = re.compile(r"-?[0-9.]+(?:e[-+]?[0-9]+)?(?: (?:%|s\b|J\b|rad\b(?:/s)?|m/s))?")


PAGE_STYLE = Path(__file__).with_name("page.css")


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


def policy(*scripts: str) -> str:
    """Content security policy of pages: they load nothing, and run nothing but these scripts.

    References
    ----------
    Content Security Policy Level 3, https://www.w3.org/TR/CSP3/.
    """
    hashes = (b64encode(sha256(f"\n{script}".encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{x}'" for x in hashes)
    return f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {allowed}"


def page(
    title: str, body: str, origin: Sequence[tuple[str, str]], *, styles: Sequence[Path],
    script: str, data: str | None = None,
) -> str:  # fmt: skip
    """A page that needs nothing else.

    It says itself what it loads and runs, and a browser keeps it to that: see `policy`.

    Parameters
    ----------
    title
        As text.
    body
        As HTML.
    origin
        Where it comes from: names and what is said of them, as text.
    styles
        Files.
    script
        JavaScript.
    data
        JSON for the script, if it needs any.
    """
    sheets = "".join(file.read_text(encoding="utf-8") for file in styles)
    made = "".join(f"<dt>{escape(a)}</dt><dd>{escape(b)}</dd>" for a, b in origin)
    given = f'<script type="application/json" id="data">\n{data}\n</script>\n' if data else ""
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<meta http-equiv="Content-Security-Policy" content="{policy(script)}">
<link rel="icon" href="data:,">
<title>{escape(title)}</title>
<style>
{sheets}</style>
</head>
<body>
<main>
{body}
</main>
<footer><p>IFToMM benchmark “Uncontrolled bicycle”; SI units throughout.</p>
<dl class="facts">{made}</dl></footer>
{given}<script>
{script}</script>
</body>
</html>
"""
