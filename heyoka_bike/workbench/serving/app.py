"""The server: which address gives what."""

import asyncio
import shutil
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
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

from heyoka_bike.errors import InputError
from heyoka_bike.showing.formats.html import SCRIPT as REPORT_SCRIPT
from heyoka_bike.showing.formats.markup import PAGE_STYLE, policy
from heyoka_bike.showing.replay.page import SCRIPT as REPLAY_SCRIPT
from heyoka_bike.showing.replay.page import START
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.serving import pages
from heyoka_bike.workbench.serving.api import api_page, description
from heyoka_bike.workbench.serving.crew import BusyError, Crew, Job
from heyoka_bike.workbench.serving.guard import Guard
from heyoka_bike.workbench.serving.limits import Limits
from heyoka_bike.workbench.serving.store import Kept, Store
from heyoka_bike.workbench.serving.tasks import FILES, MADE, RENDERED, Kind, Task, fault, stem
from heyoka_bike.workbench.serving.uploads import TooLargeError, receive

_KINDS: tuple[Kind, ...] = ("score", "diagnose", "replay")
# A page waits so long for its work before it says that it waits [s].
_AT_ONCE = 1.5
_SWEEP = 5.0  # [s]
# How often a client is looked for that waits for an answer [s].
_LOOK = 0.5
_EXAMPLE = "exudyn-h0.01.txt"
_TYPES = {".json": "application/json", ".csv": "text/csv", ".xml": "application/xml"}
_STATIC = {
    "page.css": (PAGE_STYLE, "text/css"),
    "serve.css": (pages.STATIC / "serve.css", "text/css"),
    "serve.js": (pages.STATIC / "serve.js", "text/javascript"),
}
_NEVER = "frame-ancestors 'none'; base-uri 'none'; form-action 'self'"
# Only files of this package are styles and scripts.
_OWN = (
    "default-src 'none'; style-src 'self'; script-src 'self'; connect-src 'self'; img-src data:; "
    + _NEVER
)


# Of reports and replays, whose scripts are the package's own, word for word.
_REPORTS = f"{policy(REPORT_SCRIPT, REPLAY_SCRIPT.read_text(encoding='utf-8') + START)}; {_NEVER}"


class Server:
    """What a running server holds, and what it answers.

    Parameters
    ----------
    folder
        Of its own, which it fills and empties.
    limits
    hosts
        Names under which it may be asked for; ``*`` for any.
    board
        HTML of the leaderboard, if there is one to show.
    log
        Called with one line.
    """

    def __init__(
        self, folder: Path, limits: Limits, hosts: Sequence[str] = ("*",),
        board: str | None = None, log: Any = print,
    ) -> None:  # fmt: skip
        self.limits, self.board, self.log = limits, board, log
        self.store = Store(folder, limits)
        self.crew = Crew(limits, log)
        self.app = Starlette(
            routes=self._routes(),
            lifespan=self._lifespan,
            middleware=[
                Middleware(Guard, hosts=[name.lower() for name in hosts], log=log),
            ],
            exception_handlers={
                HTTPException: _refused,
                InputError: _unreadable,
                TooLargeError: self._too_large,
                BusyError: _busy,
                TimeoutError: _late,
                ClientDisconnect: _gone,
            },
        )
        # It would lead to the name and scheme that it is asked by, which may be those of a proxy.
        self.app.router.redirect_slashes = False

    def _routes(self) -> list[Route]:
        def get(path: str, endpoint: Any) -> Route:
            return Route(path, endpoint, methods=["GET"])

        def post(path: str, endpoint: Any) -> Route:
            return Route(path, endpoint, methods=["POST"])

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
            await run_in_threadpool(self.crew.close)

    async def _sweep(self) -> None:
        while True:
            await asyncio.sleep(_SWEEP)
            try:
                await run_in_threadpool(self.store.sweep)
            except Exception as e:
                # The next one may find what this one did not.
                self.log(f"sweep: {fault(e)} in the server")

    async def home(self, request: Request) -> Response:
        """The page to drop files on."""
        return _page(pages.home(self.limits, self.board is not None))

    async def static(self, request: Request) -> Response:
        """A style or the script."""
        found = _STATIC.get(request.path_params["name"])
        if found is None:
            raise HTTPException(404)
        return FileResponse(found[0], media_type=found[1], headers={"cache-control": "max-age=300"})

    async def health(self, request: Request) -> Response:
        """Whether it works, and how much it has to do."""
        said = {"status": "ok", "waiting": self.crew.waiting(), "kept": len(self.store)}
        return JSONResponse(said)

    async def leaderboard(self, request: Request) -> Response:
        """The submissions that the server was started with."""
        if self.board is None:
            raise HTTPException(404)
        return _report(pages.with_bar(self.board, pages.bar_of_home()))

    async def api(self, request: Request) -> Response:
        """How programs use the server."""
        return _page(api_page(self.limits, str(request.base_url)))

    async def openapi(self, request: Request) -> Response:
        """The same for programs."""
        return JSONResponse(description(self.limits))

    async def upload(self, request: Request) -> Response:
        """Score files, for a browser: its address is the answer."""
        return await self._begun(request, await self._received(request))

    async def example(self, request: Request) -> Response:
        """Score a file that comes with the package."""
        folder = self.store.room()
        shutil.copy(data_folder() / "peers" / _EXAMPLE, folder / FILES)
        return await self._begun(request, Task("score", folder, (_EXAMPLE,)))

    async def _begun(self, request: Request, task: Task) -> Response:
        kept = self._kept(task)
        await _ended(kept.jobs["score"], _AT_ONCE)
        address = f"/results/{kept.key}/score"
        if _wants_json(request):
            return JSONResponse({"location": address}, 201, {"location": address})
        return RedirectResponse(address, 303)

    async def result(self, request: Request) -> Response:
        """A result without more said."""
        return RedirectResponse(f"/results/{request.path_params['key']}/score", 303)

    async def remove(self, request: Request) -> Response:
        """Remove a result at once."""
        kept = self._found(request)
        await run_in_threadpool(self.store.remove, kept)
        return RedirectResponse("/", 303)

    async def ask(self, request: Request) -> Response:
        """Begin a diagnosis or a replay of a result."""
        kept, kind = self._found(request), _kind(request.path_params["kind"])
        self._check_offered(kind)
        if kind not in kept.jobs:
            kept.jobs[kind] = self.crew.submit(kept.of(kind))
        await _ended(kept.jobs[kind], _AT_ONCE)
        return RedirectResponse(f"/results/{kept.key}/{kind}", 303)

    async def show(self, request: Request) -> Response:
        """A result as a page, or as a file to take away: ``score``, ``score.json`` ..."""
        kept, path = self._found(request), Path(request.path_params["name"])
        kind, suffix = _kind(path.stem), path.suffix
        job = kept.jobs.get(kind)
        if job is None or suffix not in ("", *RENDERED.values()):
            raise HTTPException(404)
        if not job.has_ended:
            if suffix:
                raise HTTPException(404, "not done yet")
            return _page(pages.waiting(kept, kind, job, self.crew.waiting()))
        if job.state != "done":
            title = "Cannot be scored" if kind == "score" else "Cannot be done"
            return _page(pages.error(title, job.message, kept=kept, kind=kind), _status(job))
        made = kept.made(f"{stem(kind)}{suffix or '.html'}")
        if not made.is_file():
            raise HTTPException(404)
        if suffix:
            name = f"{Path(kept.task.files[0]).stem}-{stem(kind)}{suffix}"
            return FileResponse(made, filename=name, media_type=_TYPES.get(suffix, "text/html"))
        text = await run_in_threadpool(made.read_text, encoding="utf-8")
        suffixes = [x for x in RENDERED.values() if kept.made(stem(kind) + x).is_file()]
        diagnosis = (job.answer or {}).get("diagnosis", ())
        return _report(pages.with_bar(text, pages.bar(kept, kind, suffixes), diagnosis))

    async def job(self, request: Request) -> Response:
        """How far a piece of work is."""
        kept, kind = self._found(request), _kind(request.path_params["kind"])
        job = kept.jobs.get(kind)
        if job is None:
            raise HTTPException(404)
        return JSONResponse(_said(kept, kind, job))

    async def score(self, request: Request) -> Response:
        """Score files, for a program: the report is the answer, and nothing is kept."""
        task = await self._received(request)
        try:
            job = self.crew.submit(task)
            await _ended_or_left(request, job)
            if job.state != "done":
                return JSONResponse({"error": job.message, "exit_code": job.code}, _status(job))
            made = task.folder / MADE / f"{stem('score')}.json"
            return Response(await run_in_threadpool(made.read_bytes), media_type="application/json")
        finally:
            await run_in_threadpool(self.store.drop, task.folder)

    async def diagnose(self, request: Request) -> Response:
        """Begin a diagnosis, for a program."""
        self._check_offered("diagnose")
        task = await self._received(request, "diagnose")
        kept = self._kept(task)
        address = f"/jobs/{kept.key}/diagnose"
        said = _said(kept, "diagnose", kept.jobs["diagnose"])
        return JSONResponse(said, 202, {"location": address})

    async def _received(self, request: Request, kind: Kind = "score") -> Task:
        self.crew.check(kind)
        folder = self.store.room()
        try:
            arrived = partial(self.store.grow, folder)
            return (await receive(request, folder, self.limits, arrived)).task(kind)
        except BaseException:
            self.store.drop(folder)
            raise

    def _kept(self, task: Task) -> Kept:
        """Keep a task once it has a place in the queue."""
        try:
            job = self.crew.submit(task)
        except BusyError:
            self.store.drop(task.folder)
            raise
        kept = self.store.keep(task)
        kept.jobs[task.kind] = job
        return kept

    def _found(self, request: Request) -> Kept:
        kept = self.store.get(request.path_params["key"])
        if kept is None:
            raise HTTPException(404, "There is no such result, or its time is over.")
        return kept

    async def _too_large(self, request: Request, error: Exception) -> Response:
        most = self.limits.upload // 1_000_000
        message = f"found more than {most} MB, expected less; 1001 rows of a maneuver are usual"
        # The rest of it is not read.
        return _answer(request, 413, "Too large", message, {"connection": "close"})

    def _check_offered(self, kind: Kind) -> None:
        if kind == "diagnose" and not self.limits.has_diagnosis:
            raise HTTPException(404, "This server does not diagnose.")


def _kind(text: str) -> Kind:
    for kind in _KINDS:
        if kind == text:
            return kind
    raise HTTPException(404)


async def _ended(job: Job, seconds: float | None = None) -> None:
    """Wait for the end of a job, at most so long."""
    await asyncio.wait([asyncio.wrap_future(job.over)], timeout=seconds)


async def _ended_or_left(request: Request, job: Job) -> None:
    """Wait for the end of a job; if the client goes away, nobody wants it any more."""
    over = asyncio.wrap_future(job.over)
    while not (await asyncio.wait([over], timeout=_LOOK))[0]:
        if await request.is_disconnected():
            job.is_unwanted = True


def _status(job: Job) -> int:
    """Of the answer, for how a job ended."""
    return 422 if job.state == "refused" else 500


def _said(kept: Kept, kind: Kind, job: Job) -> dict[str, Any]:
    root = f"/results/{kept.key}/{kind}"
    said: dict[str, Any] = {
        "id": kept.key, "kind": kind, "state": job.state, "progress": job.share,
        "job": f"/jobs/{kept.key}/{kind}",
    }  # fmt: skip
    if job.state == "done":
        said |= {"page": root, "result": f"{root}.{'html' if kind == 'replay' else 'json'}"}
    elif job.has_ended:
        said |= {"error": job.message, "exit_code": job.code}
    return said


def _page(text: str, status: int = 200) -> Response:
    return HTMLResponse(text, status, {"content-security-policy": _OWN})


def _report(text: str) -> Response:
    return HTMLResponse(text, headers={"content-security-policy": _REPORTS})


def _wants_json(request: Request) -> bool:
    accepted = request.headers.get("accept", "")
    return "text/html" not in accepted


def _answer(
    request: Request, status: int, title: str, message: str, headers: dict[str, str] | None = None
) -> Response:
    """An error as the client reads it."""
    if _wants_json(request):
        return JSONResponse({"error": message}, status, headers)
    found = _page(pages.error(title, message), status)
    found.headers.update(headers or {})
    return found


async def _refused(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    said = {404: "There is no such page.", 405: "This address does not take such a request."}
    is_own = error.detail and error.detail not in ("Not Found", "Method Not Allowed")
    message = error.detail if is_own else said.get(error.status_code, error.detail)
    headers = dict(error.headers or {})
    return _answer(request, error.status_code, "Not found", message, headers)


async def _unreadable(request: Request, error: Exception) -> Response:
    return _answer(request, 400, "Cannot be scored", str(error))


async def _busy(request: Request, error: Exception) -> Response:
    assert isinstance(error, BusyError)
    # What has not arrived of it is not read.
    headers = {"retry-after": str(error.seconds), "connection": "close"}
    return _answer(request, 503, "Busy", str(error), headers)


async def _late(request: Request, error: Exception) -> Response:
    message, headers = "the files took too long to arrive", {"connection": "close"}
    return _answer(request, 408, "Too slow", message, headers)


async def _gone(request: Request, error: Exception) -> Response:
    # Nobody reads it.
    return PlainTextResponse("", 400)
