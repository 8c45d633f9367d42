"""A site as a static host serves it, and the targets of its links."""

import threading
from collections import deque
from contextlib import contextmanager
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from urllib.error import HTTPError
from urllib.parse import unquote, urldefrag, urljoin, urlsplit
from urllib.request import urlopen


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@contextmanager
def served(root):
    """Serve a folder and return the address."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=str(root))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()


class _Links(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.found, self.places = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for key, value in attrs:
            if key in ("href", "src") and value:
                self.found.append(value)
            if key in ("id", "name") and value:
                self.places.add(value)


def broken(address, root, starts):
    """Return visited addresses, and links by page that are broken or leave the folder.

    All links of the start pages within the folder are followed. A fragment with ``@`` is read by a
    script and is not part of a page.
    """
    pages, found = {}, []

    def page(url):
        if url not in pages:
            try:
                with urlopen(url, timeout=30) as answer:
                    is_html = answer.headers.get_content_type() == "text/html"
                    content = answer.read()
                    # The address after redirection is stored, because the address of a folder is
                    # redirected.
                    pages[url] = (answer.url, _Links(content.decode("utf-8")) if is_html else None)
            except HTTPError:
                pages[url] = None
        return pages[url]

    waiting, seen = deque(f"{address}{start}" for start in starts), set()
    while waiting:
        url = waiting.popleft()
        if url in seen:
            continue
        seen.add(url)
        opened = page(url)
        assert opened is not None, url
        here, links = opened
        for link in links.found if links else ():
            to, place = urldefrag(urljoin(here, link))
            if urlsplit(to).scheme not in ("http", "https") or not to.startswith(f"{address}/"):
                continue
            target = page(to) if to.startswith(f"{address}{root}") else None
            is_there = target is not None
            if is_there and place and "@" not in place and target[1] is not None:
                is_there = unquote(place) in target[1].places
            if not is_there:
                found.append((here.removeprefix(address), link))
            elif is_there and target[1] is not None:
                waiting.append(to)
    return {url for url, opened in pages.items() if opened}, found
