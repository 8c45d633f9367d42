"""What the package says of itself on an index, where nothing lies beside its README.

``HEYOKA_BIKE_REPOSITORY``, the address of the repository on its server, makes links and images of
the README absolute, those of the tag of this version, and adds its pages to the metadata. Without
it links become plain words and images are left out: no address is made up. ``HEYOKA_BIKE_SITE`` is
the address of the site, of which the same holds.
``HEYOKA_BIKE_EMAIL`` is the address of the authors, if they give one.
"""

import os
import re
import tomllib
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

_AUTHORS = "The heyoka_bike developers"
_PROBLEM = "https://www.iftomm-multibody.org/benchmark/problem/Uncontrolled_bicycle/"

_FENCED = re.compile(r"^(```.*?^```$)", re.MULTILINE | re.DOTALL)
# What is behind a link and is not elsewhere or on the same page.
_BESIDE = r"(?![a-z]+:|#|/)[^)\s\"]+"
_TITLE = r"((?:\s+\"[^\"]*\")?)"
_IMAGE = re.compile(rf"!\[([^\]]*)\]\(({_BESIDE}){_TITLE}\)")
_LINK = re.compile(rf"(?<!!)\[((?:!\[[^\]]*\]\([^)]*\)|[^\[\]])*)\]\(({_BESIDE}){_TITLE}\)")
_IMAGE_TAG = re.compile(rf"(<(?:img|source)\b[^>]*?\bsrc(?:set)?=\")({_BESIDE})(\"[^>]*>)")
_LINK_TAG = re.compile(rf"(<a\b[^>]*?\bhref=\")({_BESIDE})(\"[^>]*>)(.*?)(</a>)", re.DOTALL)


class PackagePage(MetadataHookInterface):
    """Fills the fields that ``pyproject.toml`` calls dynamic."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the readme, the addresses and the authors."""
        repository = os.environ.get("HEYOKA_BIKE_REPOSITORY", "").rstrip("/")
        site = os.environ.get("HEYOKA_BIKE_SITE", "").rstrip("/")
        email = os.environ.get("HEYOKA_BIKE_EMAIL", "")
        readme = Path(self.root, "README.md").read_text(encoding="utf-8")
        project = tomllib.loads(Path(self.root, "pyproject.toml").read_text(encoding="utf-8"))
        named = project["tool"]["heyoka_bike"]
        readme = told(told(readme, named["repository"], repository), named["site"], site)
        tag = f"v{metadata['version']}"
        metadata["readme"] = {
            "content-type": "text/markdown",
            "text": page(readme, repository, tag),
        }
        metadata["urls"] = {"Benchmark": _PROBLEM, **addresses(repository, tag, site)}
        metadata["authors"] = [{"name": _AUTHORS} | ({"email": email} if email else {})]


def addresses(repository: str, tag: str, site: str = "") -> dict[str, str]:
    """Pages of the repository and the site by what they are; none whose address is not known."""
    found = {}
    if repository:
        found = {
            "Repository": repository,
            "Issues": f"{repository}/issues",
            "Documentation": f"{repository}/blob/{tag}/docs/index.md",
            "Changelog": f"{repository}/blob/{tag}/CHANGELOG.md",
        }
    return found | ({"Documentation": f"{site}/"} if site else {})


def told(readme: str, placeholder: str, address: str) -> str:
    """The README with the address that is told in place of that of ``pyproject.toml``.

    Without one, links become plain words, and a command that names it is left to its reader.
    """
    if address:
        return readme.replace(placeholder, address)
    return re.sub(rf"\[([^\[\]]*)\]\({re.escape(placeholder)}[^)]*\)", r"\1", readme)


def page(readme: str, repository: str, tag: str) -> str:
    """The README with absolute links and images, or with none that lead nowhere."""
    parts = _FENCED.split(readme)
    parts[::2] = [_absolute(part, repository, tag) for part in parts[::2]]
    return re.sub(r"\n{3,}", "\n\n", "".join(parts))


def _absolute(text: str, repository: str, tag: str) -> str:
    if not repository:
        text = _IMAGE_TAG.sub("", _IMAGE.sub("", text))
        return _LINK_TAG.sub(r"\4", _LINK.sub(r"\1", text))
    raw, blob = f"{repository}/raw/{tag}/", f"{repository}/blob/{tag}/"
    text = _IMAGE_TAG.sub(rf"\1{raw}\2\3", _IMAGE.sub(rf"![\1]({raw}\2\3)", text))
    return _LINK_TAG.sub(rf"\1{blob}\2\3\4\5", _LINK.sub(rf"[\1]({blob}\2\3)", text))
