"""Pages as a browser interprets them: their tags, text and data."""

import json
import re
from functools import cached_property
from html.parser import HTMLParser

INLINE = {"b", "bdi", "i", "tspan"}
VOID = {"meta", "link", "br", "hr", "img", "input", "wbr"}


class Page(HTMLParser):
    """Parses a page like a browser; fails if tags do not match."""

    def __init__(self, text):
        super().__init__(convert_charrefs=True)
        self.open, self.tags, self.words = [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        assert len(dict(attrs)) == len(attrs), (tag, attrs)
        self.tags.append((tag, dict(attrs)))
        self.words.append("" if tag in INLINE else " ")
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        assert "svg" in self.open, tag
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open, tag
        assert self.open.pop() == tag, self.getpos()
        self.words.append("" if tag in INLINE else " ")

    def handle_data(self, data):
        if not self.open or self.open[-1] not in ("script", "style"):
            self.words.append(data)

    @cached_property
    def text(self):
        return " ".join("".join(self.words).split())

    def all(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


def assert_runs_alone(text):
    """Check that a page requests nothing but its own script, and shows numbers."""
    page = Page(text)
    urls = set(re.findall(r"https?://[^\s\"'<>)]+", text))
    assert urls <= {"https://jfly.uni-koeln.de/color/.", "http://www.w3.org/2000/svg"}
    assert not re.search(r"url\(|@import|\bfetch\b|XMLHttpRequest|\bimport\b|\beval\b", text)
    for tag, attributes in page.tags:
        for key, value in attributes.items():
            assert not key.startswith("on"), (tag, key)
            if key in ("src", "href", "xlink:href", "srcset", "action", "style"):
                assert value.startswith(("#", "data:")), (tag, key, value)
    policy = [a["content"] for a in page.all("meta") if "http-equiv" in a]
    assert policy[0].startswith("default-src 'none';")
    assert not re.search(r"\bNone\b|(?i:\bnan\b|\binf\b|\binfinity\b)", page.text)


def data(page):
    found = re.search(r'<script type="application/json" id="data">\n(.*?)\n</script>', page, re.S)
    return json.loads(found[1])
