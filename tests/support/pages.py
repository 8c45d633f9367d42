"""Pages as a browser finds them: their tags and text, and what chromium shows of them."""

import json
import re
import shutil
import subprocess
from functools import cached_property
from html.parser import HTMLParser

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)


def browser(test):
    """Mark a test that starts a browser, which takes more than the second of a fast test."""
    needed = pytest.mark.skipif(CHROMIUM is None, reason="no chromium to look at the page with")
    return pytest.mark.proof(needed(test))


INLINE = {"b", "bdi", "i", "tspan"}
VOID = {"meta", "link", "br", "hr", "img", "input", "wbr"}


class Page(HTMLParser):
    """What a browser would find; complains where tags do not match."""

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
    """A page with a script of its own asks for nothing else, and shows numbers."""
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


# Without a picture chromium asks for frames when it likes; here they come with its virtual time.
FRAMES = (
    "<script>requestAnimationFrame = (f) => setTimeout(() => f(performance.now()), 16);</script>"
)


def look(page, folder, address="", *, what="--dump-dom", flags=(), budget=2500):
    """What chromium says on standard output and on its console."""
    path = folder / "page.html"
    if what == "--dump-dom":
        # The page runs its own script and no other; this one and hands are let in beside it.
        page = re.sub(r"script-src [^\"]*", "script-src 'unsafe-inline'", page)
        page = page.replace("<script type", f"{FRAMES}<script type")
    path.write_text(page, encoding="utf-8")
    run = subprocess.run(
        [
            CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
            f"--user-data-dir={folder / 'profile'}", "--enable-logging=stderr", "--v=0",
            "--window-size=1280,900", f"--virtual-time-budget={budget}", *flags, what,
            f"{path.as_uri()}{address}",
        ],
        capture_output=True, text=True, timeout=120, cwd=folder,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    return run.stdout, [line for line in run.stderr.splitlines() if "CONSOLE" in line]


def widths(page, folder, address):
    """How wide a page is in windows of four widths, and the window."""
    size = "f.contentDocument.documentElement.scrollWidth + '/' + "
    size += "f.contentDocument.documentElement.clientWidth"
    found = framed(page, folder, address, size)
    return [tuple(map(int, pair.split("/"))) for pair in found]


def framed(page, folder, address, asked, budget=3000):
    """What a script says of a page in windows of four widths; `f` is the frame that it is in."""
    # A window of chromium is at least 500 wide: narrower ones are frames in another page.
    frame = folder / "frames.html"
    (folder / "page.html").write_text(page, encoding="utf-8")
    frame.write_text(
        "".join(
            f'<iframe src="page.html{address}" width="{w}" height="900"></iframe>'
            for w in (320, 400, 800, 1280)
        )
        + "<p></p><script>onload = () => setTimeout(() => { document.querySelector('p').textContent"
        f" = [...document.querySelectorAll('iframe')].map((f) => {asked}).join(' '); }}, 1500)"
        "</script>"
    )
    run = subprocess.run(
        [
            CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu",
            f"--user-data-dir={folder / 'profile'}", "--allow-file-access-from-files",
            "--hide-scrollbars", "--window-size=1400,900", f"--virtual-time-budget={budget}",
            "--dump-dom", frame.as_uri(),
        ],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    found = re.search(r"<p>(.*?)</p>", run.stdout)[1].split()
    assert len(found) == 4
    return found
