"""Checks of every request: its host, headers for browsers, no foreign forms, a line of log."""

from collections.abc import Callable, Collection
from time import perf_counter

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from heyoka_bike.system.log import fault

_SAFE = {
    "x-content-type-options": "nosniff",
    # Not to other sites, but with the origin in forms of our own.
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "x-frame-options": "DENY",
    "permissions-policy": "camera=(), geolocation=(), microphone=()",
}
# Only files of the package may be cached on the way.
_CACHE = ("cache-control", "no-store")
_HEALTH = "/health"
# Where a browser says that a page of another site sent the form.
_FOREIGN = ("cross-site", "same-site")


class Guard:
    """An ASGI application inside these rules.

    Parameters
    ----------
    app
    hosts
        Names under which it may be asked for, without ports; ``*`` for any. A page of another site
        whose name is made to lead here is not one of them.
    log
        Called with one line for each request: no address of a result, no names, no contents.
    root
        Path below which the server is hosted. Whether who passes requests on takes it away does not
        matter: the application gets paths without it, and it as the ``root_path``.
    """

    def __init__(
        self, app: ASGIApp, hosts: Collection[str], log: Callable[[str], None], root: str = ""
    ) -> None:
        self._app, self._hosts, self._log, self._root = app, hosts, log, root

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        start, status, size = perf_counter(), 0, 0
        path = scope["path"]
        if f"{path}/".startswith(f"{self._root}/"):
            path = path.removeprefix(self._root) or "/"
        scope = {**scope, "path": path, "root_path": self._root}

        async def guarded(message: Message) -> None:
            nonlocal status, size
            if message["type"] == "http.response.start":
                status = message["status"]
                found = MutableHeaders(scope=message)
                found.update(_SAFE)
                found.setdefault(*_CACHE)
            size += len(message.get("body", b""))
            await send(message)

        app = self._app
        headers = Headers(scope=scope)
        # Whoever watches over the server asks by whatever name it has inside.
        is_told = "*" in self._hosts or _host(headers) in self._hosts or path == _HEALTH
        if not is_told:
            app = JSONResponse({"error": "found another host, expected one told by --name"}, 400)
        elif scope["method"] == "POST" and self._is_foreign(headers):
            app = JSONResponse({"error": "found a form of another site"}, 403)
        try:
            await app(scope, receive, guarded)
        except Exception as e:
            # Whoever raised it may have put names and places into it, which the log must not have.
            self._log(f"{fault(e)} in the server")
            if status:
                raise RuntimeError("an answer was broken off") from None
            said = {"error": "the server could not do it; this is a fault of the server"}
            await JSONResponse(said, 500, {"connection": "close"})(scope, receive, guarded)
        finally:
            place = "/" + path.lstrip("/").partition("/")[0][:20]
            place = place if place.isascii() and place.isprintable() else "/?"
            milliseconds = 1e3 * (perf_counter() - start)
            self._log(f"{scope['method'][:8]} {place} {status} {size} B {milliseconds:.0f} ms")

    def _is_foreign(self, headers: Headers) -> bool:
        """True if a browser says that a page of another site sent this."""
        site = headers.get("sec-fetch-site")
        if site is not None:
            return site in _FOREIGN
        # Browsers of before 2023, and all of them where there is no TLS, say less.
        origin = headers.get("origin")
        is_told = origin is not None and "*" not in self._hosts
        return is_told and _name((origin or "").partition("://")[2]) not in self._hosts


def _host(headers: Headers) -> str:
    """The host that is asked for."""
    return _name(headers.get("host", ""))


def _name(host: str) -> str:
    """A host without its port and the brackets of IPv6."""
    host = host.lower()
    if host.startswith("["):
        return host[1:].partition("]")[0]
    return host.partition(":")[0]
