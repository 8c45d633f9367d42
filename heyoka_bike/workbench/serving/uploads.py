"""Result files as a request brings them: by a form, or as its body."""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from python_multipart.multipart import parse_options_header
from starlette.datastructures import FormData, UploadFile
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.types import Message

from heyoka_bike.errors import InputError, quoted, unknown_word
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.scoring import requirements
from heyoka_bike.workbench.serving.limits import Limits
from heyoka_bike.workbench.serving.store import file_name
from heyoka_bike.workbench.serving.tasks import FILES, Kind, Task

_FILE_FIELD, _PASTED_FIELD, _NAME = "file", "pasted", "filename"
OPTIONS = ("maneuver", "columns", "step", "tolerance", "name", "require")
"""Fields beside the files, or parts of the query; as the options of the command of this name."""

# Around and between the files of a form [bytes].
_BESIDE = 100_000
_MANEUVERS = 3
# The option of which there may be several, and fields in all.
_REPEATED = "require"
_MOST_FIELDS = 50
# Of an option [characters]; and of rows that are pasted, which stand in memory [bytes].
_LONGEST_OPTION = 10_000
_LONGEST_FIELD = 10_000_000
_CHUNK = 1 << 20
_UTF_8 = ("", "utf-8", "utf8", "us-ascii")
# Forms are taken apart beside the loop that answers, and few at once: their fields are in memory.
_FORMS = ThreadPoolExecutor(2, "forms")


class TooLargeError(Exception):
    """More than one request may hold."""


@dataclass(frozen=True, slots=True)
class Upload:
    """The files of a request, written to a folder.

    Attributes
    ----------
    folder : Path
    files
        Their names in it.
    options
        What was told beside them, by names of `OPTIONS`.
    """

    folder: Path
    files: tuple[str, ...]
    options: Mapping[str, Sequence[str]]

    def task(self, kind: Kind) -> Task:
        """What is to be done with them.

        Raises
        ------
        InputError
            An option that cannot be understood.
        """
        count = len(self.files)
        told = {key: texts[0] for key, texts in self.options.items()}
        columns, name = told.get("columns"), told.get("name")
        require = tuple(self.options.get(_REPEATED, ()))
        for text in require:
            requirements.parse(text)
        return Task(
            kind, self.folder, self.files, _maneuver(told.get("maneuver")),
            None if columns is None else tuple(columns.split(",")),
            _numbers("step", told.get("step"), count),
            _numbers("tolerance", told.get("tolerance"), count),
            None if name is None else tuple(x.strip() for x in name.split(",")), require,
        )  # fmt: skip


async def receive(
    request: Request, folder: Path, limits: Limits, arrived: Callable[[int], None]
) -> Upload:
    """Write the files of a request to a folder.

    Parameters
    ----------
    request
    folder
    limits
    arrived
        Called with the size of each part as it arrives [bytes]; what it raises ends the request.

    Raises
    ------
    InputError
        No file, an empty one, too many, or a form that is none.
    TooLargeError
        More bytes than `limits` allows; as soon as it is known, which may be before any arrives.
    ClientDisconnect
        The client went away.
    TimeoutError
        It took too long.
    """
    async with asyncio.timeout(limits.upload_seconds):
        return await _receive(request, folder, limits, arrived)


async def _receive(
    request: Request, folder: Path, limits: Limits, arrived: Callable[[int], None]
) -> Upload:
    told = request.headers.get("content-length", "")
    most = limits.upload + _BESIDE
    if told and (not told.isascii() or not told.isdigit() or int(told[:18]) > most):
        raise TooLargeError
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    _count(request, most, arrived)
    query = request.query_params.multi_items()
    if kind == "multipart/form-data":
        return await _of_form(request, query, folder, limits)
    if kind == "application/x-www-form-urlencoded":
        raise InputError(
            "found a form without files, expected multipart/form-data or the file as the body "
            "(curl -F file=@FILE)"
        )
    options = _options([item for item in query if item[0] != _NAME])
    name = file_name(request.query_params.get(_NAME, ""), set())
    if not await _saved(request, folder / FILES / name):
        raise InputError("found an empty request, expected a result file as its body")
    return Upload(folder, (name,), options)


async def _saved(request: Request, path: Path) -> int:
    """Write the body of a request to a file; its size [bytes]."""
    with path.open("wb") as out:
        async for chunk in request.stream():
            out.write(chunk)
        return out.tell()


def _count(request: Request, most: int, arrived: Callable[[int], None]) -> None:
    """Stop the request where more arrives than it may hold, whatever it said before."""
    get, size = request._receive, 0

    async def counted() -> Message:
        nonlocal size
        message = await get()
        part = len(message.get("body", b""))
        size += part
        if size > most:
            raise TooLargeError
        arrived(part)
        return message

    request._receive = counted


async def _of_form(
    request: Request, query: Sequence[tuple[str, str]], folder: Path, limits: Limits
) -> Upload:
    _, told = parse_options_header(request.headers["content-type"])
    if told.get(b"charset", b"").decode("latin-1").lower() not in _UTF_8:
        # It might name any codec of Python's, some of which take for ever.
        raise InputError("found a form in another encoding, expected UTF-8")
    body = folder / "form"
    await _saved(request, body)
    try:
        return await asyncio.get_running_loop().run_in_executor(
            _FORMS, lambda: asyncio.run(_parsed(request, body, query, folder, limits))
        )
    except HTTPException as e:
        raise InputError(f"found a form that cannot be read ({e.detail})") from None
    finally:
        body.unlink(missing_ok=True)


async def _parsed(
    request: Request, body: Path, query: Sequence[tuple[str, str]], folder: Path, limits: Limits
) -> Upload:
    with body.open("rb") as file:

        async def receive() -> Message:
            chunk = file.read(_CHUNK)
            return {"type": "http.request", "body": chunk, "more_body": bool(chunk)}

        async with Request(request.scope, receive).form(
            max_files=limits.files, max_fields=_MOST_FIELDS, max_part_size=_LONGEST_FIELD
        ) as form:
            return _written(form, query, folder)


def _written(form: FormData, query: Sequence[tuple[str, str]], folder: Path) -> Upload:
    taken: set[str] = set()
    files = []
    for given in form.getlist(_FILE_FIELD):
        # A browser sends a file without name and content where none was chosen.
        if isinstance(given, UploadFile) and (given.filename or given.size):
            name = file_name(given.filename or "", taken)
            with (folder / FILES / name).open("wb") as out:
                while chunk := given.file.read(_CHUNK):
                    out.write(chunk)
            files.append(name)
    pasted = form.get(_PASTED_FIELD)
    if isinstance(pasted, str) and pasted.strip():
        name = file_name("pasted.txt", taken)
        (folder / FILES / name).write_text(pasted, encoding="utf-8", newline="")
        files.append(name)
    if not files:
        raise InputError(
            f"found no file and no pasted rows, expected one of them in the field {_FILE_FIELD} or "
            f"{_PASTED_FIELD}"
        )
    fields = [
        (key, text.strip())
        for key, text in form.multi_items()
        if key not in (_FILE_FIELD, _PASTED_FIELD) and isinstance(text, str)
    ]
    # A form has all of its fields, and those that nobody filled are empty.
    return Upload(folder, tuple(files), _options([*query, *(f for f in fields if f[1])]))


def _options(told: Sequence[tuple[str, str]]) -> dict[str, list[str]]:
    """What is told beside the files, by option.

    Raises
    ------
    InputError
        A name that is no option, one that is told twice, or too much.
    """
    found: dict[str, list[str]] = {}
    if len(told) > _MOST_FIELDS:
        raise InputError(f"found {len(told)} options, expected at most {_MOST_FIELDS}")
    for key, text in told:
        if key not in OPTIONS:
            raise InputError(unknown_word(key, OPTIONS, "the option "))
        if len(text) > _LONGEST_OPTION:
            raise InputError(
                f"{key}: found {len(text)} characters, expected at most {_LONGEST_OPTION}"
            )
        if key in found and key != _REPEATED:
            raise InputError(f"found {key} twice, expected it once")
        found.setdefault(key, []).append(text)
    return found


def _maneuver(text: str | None) -> int | None:
    if text is None:
        return None
    if text not in map(str, range(1, _MANEUVERS + 1)):
        raise InputError(f"maneuver: found {quoted(text)}, expected 1 to {_MANEUVERS}")
    return int(text)


def _numbers(name: str, text: str | None, count: int) -> tuple[float, ...] | None:
    if text is None:
        return None
    found: list[float] = []
    parts = text.split(",")
    if len(parts) != count:
        raise InputError(f"{name}: found {len(parts)} for {count} files, expected one for each")
    for part in parts:
        try:
            value = float(Exact.parse(part))
        except ValueError as e:
            raise InputError(f"{name}: {e}") from None
        if value <= 0:
            raise InputError(f"{name}: found {quoted(part)}, expected more than zero")
        found.append(value)
    return tuple(found)
