"""The web server: its addresses, and its answers to requests.

Every request passes the `Guard`, which checks the host, adds headers for browsers, rejects forms of
other sites, and logs a line.
"""

import asyncio
import re
import shutil
from collections.abc import AsyncIterator, Callable, Collection, Mapping, Sequence
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import (
    FileResponse,
    HTMLResponse,
    JSONResponse,
    PlainTextResponse,
    RedirectResponse,
    Response,
)
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from heyoka_bike.errors import InputError
from heyoka_bike.showing.document.html import PAGE_STYLE, policy
from heyoka_bike.showing.document.html import SCRIPT as REPORT_SCRIPT
from heyoka_bike.system.log import fault
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.replay.page import SCRIPT as REPLAY_SCRIPT
from heyoka_bike.workbench.replay.page import START
from heyoka_bike.workbench.serving import pages
from heyoka_bike.workbench.serving.pages import description
from heyoka_bike.workbench.serving.queue import BusyError, QueuedTask, TaskQueue
from heyoka_bike.workbench.serving.store import ResultStore, StoredResult
from heyoka_bike.workbench.serving.tasks import (
    FILES,
    FULL,
    NO_ROOM,
    RENDERED,
    Kind,
    Limits,
    Task,
    TaskEnding,
)
from heyoka_bike.workbench.serving.uploads import receive

_SAFE = {
    "x-content-type-options": "nosniff",
    # Browsers then send no referrer to other sites, but forms of this site still send their origin.
    "referrer-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "x-frame-options": "DENY",
    "permissions-policy": "camera=(), geolocation=(), microphone=()",
}
# Nothing may be cached, except for files of the package, which set their own header.
_NO_CACHE_HEADER = ("cache-control", "no-store")
_HEALTH = "/health"
# Values of Sec-Fetch-Site with which a browser reports that a page of another site sent a form.
_FOREIGN = ("cross-site", "same-site")


class Guard:
    """ASGI middleware that checks and logs every request before the application gets it.

    Parameters
    ----------
    app
    hosts
        Allowed host names, without ports; ``*`` for any. They exclude pages of other sites whose
        name is made to resolve to this server.
    log
        Called with one line for each request, without addresses of results, names or contents.
    root
        Path below which the server is hosted. A proxy may remove it or not: the application gets
        paths without it, and the path itself as ``root_path``.
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
                found.setdefault(*_NO_CACHE_HEADER)
            size += len(message.get("body", b""))
            await send(message)

        app = self._app
        headers = Headers(scope=scope)
        # Health checks may use any host name, because a supervisor uses a name inside its own
        # network.
        is_told = "*" in self._hosts or _host(headers) in self._hosts or path == _HEALTH
        if not is_told:
            app = JSONResponse({"error": "unknown host name: start the server with --name"}, 400)
        elif scope["method"] == "POST" and _is_foreign(headers):
            app = JSONResponse({"error": "the form comes from another site"}, 403)
        try:
            await app(scope, receive, guarded)
        except asyncio.CancelledError:
            # The server is stopping, and its time limit for the running tasks has passed.
            if status:
                raise
            said = {"error": f"the server is being stopped, try again in {_SECONDS_OF_RESTART} s"}
            again = {"retry-after": str(_SECONDS_OF_RESTART), "connection": "close"}
            await JSONResponse(said, 503, again)(scope, receive, guarded)
        except Exception as e:
            # The message of the exception is not logged, because it may contain names and paths.
            self._log(f"{fault(e)} in the server")
            if status:
                raise RuntimeError("an answer ended early") from None
            said = {"error": "internal error of the server"}
            await JSONResponse(said, 500, {"connection": "close"})(scope, receive, guarded)
        finally:
            place = "/" + path.lstrip("/").partition("/")[0][:20]
            place = place if place.isascii() and place.isprintable() else "/?"
            milliseconds = 1e3 * (perf_counter() - start)
            self._log(f"{scope['method'][:8]} {place} {status} {size} B {milliseconds:.0f} ms")


def _is_foreign(headers: Headers) -> bool:
    """True if a browser says that a page of another site sent the request."""
    site = headers.get("sec-fetch-site")
    if site is not None:
        return site in _FOREIGN
    # Browsers from before 2023, and all browsers without TLS, do not send Sec-Fetch-Site. They send
    # the origin, so compare it with the requested host.
    origin = headers.get("origin")
    if origin is None:
        return False
    scheme, _, place = origin.lower().partition("://")
    port = _USUAL_PORTS.get(scheme, "")
    asked = headers.get("host", "").lower()
    return not place or _with_port(place, port) != _with_port(asked, port)


_USUAL_PORTS = {"http": "80", "https": "443"}


def _with_port(place: str, usual: str) -> str:
    """Return a host with its port; `usual` is the port if the text contains none."""
    return place if re.search(r":[0-9]+\Z", place) else f"{place}:{usual}"


def _host(headers: Headers) -> str:
    """Return the host name in a request, without its port."""
    return _name(headers.get("host", ""))


def _name(host: str) -> str:
    """Return a host without its port, and without the brackets of an IPv6 address."""
    host = host.lower()
    if host.startswith("["):
        return host[1:].partition("]")[0]
    return host.partition(":")[0]


_KINDS_OF_TASKS: tuple[Kind, ...] = ("score", "diagnose", "replay")
_EXAMPLE_FILE = "exudyn-h0.01.txt"
_TYPES = {".json": "application/json", ".csv": "text/csv", ".xml": "application/xml"}
_STATIC = {
    "page.css": (PAGE_STYLE, "text/css"),
    "serve.css": (pages.STATIC / "serve.css", "text/css"),
    "serve.js": (pages.STATIC / "serve.js", "text/javascript"),
}
# Time after which a client may try again [s]. By then a supervisor has restarted the server.
_SECONDS_OF_RESTART = 10
_TITLES = {400: "Cannot be scored", 408: "Too slow", 413: "Too large", 503: "Busy", 507: "Full"}
# Messages that replace Starlette's brief messages.
_USUAL = {
    "Not Found": "There is no such page.",
    "Method Not Allowed": "This address does not take such a request.",
}
_NEVER = "frame-ancestors 'none'; base-uri 'none'; form-action 'self'"
# Content security policy of the pages: styles and scripts come only from files of the package.
_HEADERS_OF_PAGES = (
    "default-src 'none'; style-src 'self'; script-src 'self'; connect-src 'self'; img-src data:; "
    + _NEVER
)


# Content security policy of reports and replays: their scripts must be exactly those of the
# package.
_REPORTS = f"{policy(REPORT_SCRIPT, REPLAY_SCRIPT.read_text(encoding='utf-8') + START)}; {_NEVER}"


class Server:
    """The state of a running server, and its request handlers.

    Parameters
    ----------
    folder
        Folder for the server's exclusive use, which it fills and empties.
    limits
    hosts
        Allowed host names; ``*`` for any.
    board
        HTML of the leaderboard, if there is one.
    log
        Called with each line of the log.
    root
        Path below which the server is hosted, without a trailing slash.
    """

    def __init__(
        self, folder: Path, limits: Limits, hosts: Sequence[str] = ("*",),
        board: str | None = None, log: Any = print, root: str = "",
    ) -> None:  # fmt: skip
        self.limits, self.board, self.log = limits, board, log
        self.store = ResultStore(folder, limits)
        self.queue = TaskQueue(limits, log)
        self.app = Starlette(
            routes=self._routes(),
            lifespan=self._lifespan,
            middleware=[
                Middleware(Guard, hosts=[name.lower() for name in hosts], log=log, root=root),
            ],
            exception_handlers=dict.fromkeys(
                (HTTPException, InputError, ClientDisconnect, OSError), _refused
            ),
        )  # fmt: skip
        # Behind a proxy, the host and scheme of a request are not those of the browser, so a
        # redirect to the address with a slash would be wrong.
        self.app.router.redirect_slashes = False

    def _routes(self) -> list[Route]:
        get, post = partial(Route, methods=["GET"]), partial(Route, methods=["POST"])
        return [
            get("/", self.home),
            get("/static/{name}", self.static),
            get("/health", self.health),
            get("/leaderboard", self.leaderboard),
            get("/api", self.api),
            get("/openapi.json", self.openapi),
            post("/example", self.example),
            post("/results", self.upload),
            get("/results/{key}", self.result),
            post("/results/{key}/remove", self.remove),
            get("/results/{key}/{name}", self.show),
            post("/results/{key}/{kind}", self.ask),
            get("/jobs/{key}/{kind}", self.job),
            post("/score", self.score),
            post("/diagnose", self.diagnose),
        ]

    @asynccontextmanager
    async def _lifespan(self, app: Starlette) -> AsyncIterator[None]:
        sweeping = asyncio.create_task(self._sweep())
        try:
            yield
        finally:
            sweeping.cancel()
            await self.queue.close()

    async def _sweep(self) -> None:
        while True:
            await asyncio.sleep(self.limits.sweep_seconds)
            try:
                await run_in_threadpool(self.store.sweep)
            except Exception as e:
                # An error ends this sweep only. The next sweep may remove the remaining files.
                self.log(f"sweep: {fault(e)} in the server")

    async def home(self, request: Request) -> Response:
        """Show the page to drop files on."""
        return _page(pages.home(_root(request), self.limits, self.board is not None))

    async def static(self, request: Request) -> Response:
        """Send a style sheet or the script."""
        found = _STATIC.get(request.path_params["name"])
        if found is None:
            raise HTTPException(404)
        return FileResponse(found[0], media_type=found[1], headers={"cache-control": "max-age=300"})

    async def health(self, request: Request) -> Response:
        """Report the health of the server, and the length of its queue."""
        is_full = self.store.is_full()
        said = {
            "status": "full" if is_full else "ok",
            "waiting": self.queue.waiting(),
            "kept": len(self.store),
        }
        return JSONResponse(said, 507 if is_full else 200)

    async def leaderboard(self, request: Request) -> Response:
        """Show the submissions that the server was started with."""
        if self.board is None:
            raise HTTPException(404)
        return _report(pages.with_bar(self.board, pages.bar_of_home(_root(request))))

    async def api(self, request: Request) -> Response:
        """Show the documentation of the interface for programs."""
        return _page(pages.api(_root(request), self.limits, str(request.base_url)))

    async def openapi(self, request: Request) -> Response:
        """Send the OpenAPI description of the interface for programs."""
        return JSONResponse(description(self.limits, _root(request)))

    async def upload(self, request: Request) -> Response:
        """Score files from a browser; the answer is the address of the result."""
        return await self._begun(request, await self._received(request))

    async def example(self, request: Request) -> Response:
        """Score an example file of the package."""
        folder = self.store.room()
        shutil.copy(data_folder() / "peers" / _EXAMPLE_FILE, folder / FILES)
        return await self._begun(request, Task("score", folder, (_EXAMPLE_FILE,)))

    async def _begun(self, request: Request, task: Task) -> Response:
        result = self._stored(task)
        await asyncio.wait([result.jobs["score"].over], timeout=self.limits.page_seconds)
        address = f"{_root(request)}/results/{result.key}/score"
        if _wants_json(request):
            return JSONResponse({"location": address}, 201, {"location": address})
        return RedirectResponse(address, 303)

    async def result(self, request: Request) -> Response:
        """Show the report of a result."""
        return RedirectResponse(f"{_root(request)}/results/{request.path_params['key']}/score", 303)

    async def remove(self, request: Request) -> Response:
        """Remove a result at once."""
        result = self._found(request)
        await run_in_threadpool(self.store.remove, result)
        return RedirectResponse(f"{_root(request)}/", 303)

    async def ask(self, request: Request) -> Response:
        """Start a diagnosis or a replay of a result."""
        result, kind = self._found(request), _kind(request.path_params["kind"])
        self._check_offered(kind)
        if kind not in result.jobs:
            result.jobs[kind] = self.queue.submit(result.of(kind))
        await asyncio.wait([result.jobs[kind].over], timeout=self.limits.page_seconds)
        return RedirectResponse(f"{_root(request)}/results/{result.key}/{kind}", 303)

    async def show(self, request: Request) -> Response:
        """Show a result as a page, or send it as a file: ``score``, ``score.json`` ..."""
        result, path = self._found(request), Path(request.path_params["name"])
        kind, suffix = _kind(path.stem), path.suffix
        job = result.jobs.get(kind)
        if job is None or suffix not in ("", *RENDERED.values()):
            raise HTTPException(404)
        if job.ending is None:
            if suffix:
                raise HTTPException(404, "not done yet")
            return _page(pages.waiting(_root(request), result, kind, job, self.queue.waiting()))
        if job.state != "done":
            title = "Cannot be scored" if kind == "score" else "Cannot be done"
            text = pages.error(_root(request), title, job.ending.message, result=result, kind=kind)
            return _page(text, _status(job.ending))
        made = job.task.made(suffix or ".html")
        if not made.is_file():
            raise HTTPException(404)
        if suffix:
            name = f"{Path(job.task.files[0]).stem}-{made.name}"
            return FileResponse(made, filename=name, media_type=_TYPES.get(suffix, "text/html"))
        text = await run_in_threadpool(made.read_text, encoding="utf-8")
        suffixes = [x for x in RENDERED.values() if job.task.made(x).is_file()]
        return _report(
            pages.with_bar(
                text, pages.bar(_root(request), result, kind, suffixes), job.ending.diagnosis
            )
        )

    async def job(self, request: Request) -> Response:
        """Report the progress of a task."""
        result, kind = self._found(request), _kind(request.path_params["kind"])
        job = result.jobs.get(kind)
        if job is None:
            raise HTTPException(404)
        return JSONResponse(_said(request, result, kind, job))

    async def score(self, request: Request) -> Response:
        """Score files for a program; the answer is the report, and nothing is stored."""
        task = await self._received(request)
        try:
            job = self.queue.submit(task)
            ending = await _ended_or_left(request, job, self.limits.look_seconds)
            if ending.state != "done":
                return JSONResponse(_error(ending), _status(ending))
            made = await run_in_threadpool(task.made(".json").read_bytes)
            return Response(made, media_type="application/json")
        finally:
            await run_in_threadpool(self.store.drop, task.folder)

    async def diagnose(self, request: Request) -> Response:
        """Start a diagnosis, for a program."""
        self._check_offered("diagnose")
        task = await self._received(request, "diagnose")
        result = self._stored(task)
        said = _said(request, result, "diagnose", result.jobs["diagnose"])
        return JSONResponse(said, 202, {"location": said["job"]})

    async def _received(self, request: Request, kind: Kind = "score") -> Task:
        self.queue.check(kind)
        folder = self.store.room()
        try:
            arrived = partial(self.store.grow, folder)
            async with asyncio.timeout(self.limits.upload_seconds):
                return await receive(request, kind, folder, self.limits, arrived)
        except BaseException as e:
            self.store.drop(folder)
            if not isinstance(e, TimeoutError):
                raise
            said, close = "the files took too long to arrive", {"connection": "close"}
            raise HTTPException(408, said, close) from None

    def _stored(self, task: Task) -> StoredResult:
        """Append a task to the queue, and keep its files as a stored result."""
        try:
            job = self.queue.submit(task)
        except BusyError:
            self.store.drop(task.folder)
            raise
        return self.store.keep(job)

    def _found(self, request: Request) -> StoredResult:
        result = self.store.get(request.path_params["key"])
        if result is None:
            raise HTTPException(404, "There is no such result, or it has expired.")
        return result

    def _check_offered(self, kind: Kind) -> None:
        if kind == "diagnose" and not self.limits.has_diagnosis:
            raise HTTPException(404, "This server does not diagnose.")


def _root(request: Request) -> str:
    """Return the path below which the server is hosted, see `Guard`."""
    return str(request.scope["root_path"])


def _kind(text: str) -> Kind:
    for kind in _KINDS_OF_TASKS:
        if kind == text:
            return kind
    raise HTTPException(404)


async def _ended_or_left(request: Request, job: QueuedTask, look_seconds: float) -> TaskEnding:
    """Wait for the end of a job; cancel the job if the client disconnects first."""
    while not (await asyncio.wait([job.over], timeout=look_seconds))[0]:
        if await request.is_disconnected():
            job.cancel()
    return job.over.result()


def _status(ending: TaskEnding) -> int:
    """Return the HTTP status of the answer about a task that was not done."""
    if ending.is_full:
        return 507
    return 422 if ending.state == "refused" else 500


def _error(ending: TaskEnding) -> dict[str, Any]:
    return {"error": ending.message, "exit_code": ending.code}


def _said(request: Request, result: StoredResult, kind: Kind, job: QueuedTask) -> dict[str, Any]:
    root = _root(request)
    page = f"{root}/results/{result.key}/{kind}"
    said: dict[str, Any] = {
        "id": result.key, "kind": kind, "state": job.state, "progress": job.share,
        "job": f"{root}/jobs/{result.key}/{kind}",
    }  # fmt: skip
    if job.state == "done":
        said |= {"page": page, "result": f"{page}.{'html' if kind == 'replay' else 'json'}"}
    elif job.ending is not None:
        said |= _error(job.ending)
    return said


def _page(text: str, status: int = 200) -> Response:
    return HTMLResponse(text, status, {"content-security-policy": _HEADERS_OF_PAGES})


def _report(text: str) -> Response:
    return HTMLResponse(text, headers={"content-security-policy": _REPORTS})


def _wants_json(request: Request) -> bool:
    accepted = request.headers.get("accept", "")
    return "text/html" not in accepted


def _answer(
    request: Request, status: int, message: str, headers: Mapping[str, str] | None = None
) -> Response:
    """Return an error as JSON or as a page, as the client accepts it."""
    if _wants_json(request):
        return JSONResponse({"error": message}, status, headers)
    found = _page(pages.error(_root(request), _TITLES.get(status, "Not found"), message), status)
    found.headers.update(headers or {})
    return found


async def _refused(request: Request, error: Exception) -> Response:
    """Return the answer to a request that cannot be carried out."""
    match error:
        case HTTPException():
            said = _USUAL.get(error.detail, error.detail)
            return _answer(request, error.status_code, said, error.headers)
        case InputError():
            return _answer(request, 400, str(error))
        case ClientDisconnect():
            # The client has disconnected, so nobody reads the answer.
            return PlainTextResponse("", 400)
        case OSError(errno=number) if number in NO_ROOM:
            # The connection is closed, so that the rest of the request need not be read.
            return _answer(request, 507, FULL, {"connection": "close"})
    raise error
