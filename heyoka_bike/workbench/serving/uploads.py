"""Receive result files: as parts of a form, or as the body of a request."""

import asyncio
import shutil
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from python_multipart.multipart import parse_options_header
from starlette.datastructures import FormData, UploadFile
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.types import Message

from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.errors import InputError, quoted, unknown_word
from heyoka_bike.numbers.exact import positive_numbers
from heyoka_bike.scoring import requirements
from heyoka_bike.workbench.serving.store import file_name
from heyoka_bike.workbench.serving.tasks import FILES, Kind, Limits, Task

_FILE_FIELD, _PASTED_FIELD, _NAME_FIELD = "file", "pasted", "filename"
OPTIONS = ("maneuver", "columns", "step", "tolerance", "name", "require")
"""Form fields in addition to the files, or parts of the query; named like the command's options."""

# Maximum number of bytes of a form in addition to its files.
_BESIDE = 100_000
# The only option that may be given several times, and the maximum number of form fields.
_REPEATED = "require"
_MOST_FIELDS = 50
# Maximum length of an option [characters]. Pasted rows, which stay in memory, are limited by their
# number of bytes instead.
_LONGEST_OPTION = 10_000
_CHUNK = 1 << 20
_UTF_8 = ("", "utf-8", "utf8", "us-ascii")
# Forms are parsed in threads outside of the server's event loop. At most two forms are parsed at a
# time, because the fields of a form are kept in memory.
_PARSERS = ThreadPoolExecutor(2, "forms")
_FORM_FIELD = "form"
_Fields = Sequence[tuple[str, str]]


class TooLargeError(HTTPException):
    """A request has more bytes than the limit allows."""

    def __init__(self, limits: Limits) -> None:
        most = limits.upload // 1_000_000
        said = f"found more than {most} MB, expected less; 1001 rows of a maneuver are usual"
        # The connection is closed, so that the rest of the request need not be read.
        super().__init__(413, said, {"connection": "close"})


async def receive(
    request: Request, kind: Kind, folder: Path, limits: Limits, arrived: Callable[[int], None]
) -> Task:
    """Write the files of a request to a folder.

    Parameters
    ----------
    request
    kind
        Kind of the task for the files.
    folder
    limits
    arrived
        Called with the size of each part as it arrives [bytes]; an exception ends the request.

    Raises
    ------
    InputError
        There is no file, an empty file or too many, or the form or an option is invalid.
    TooLargeError
        The request has more bytes than `limits` allows; this may be known before any arrives.
    ClientDisconnect
        The client disconnected.
    """
    told = request.headers.get("content-length", "")
    most = limits.upload + _BESIDE
    if told and (not told.isascii() or not told.isdigit() or int(told[:18]) > most):
        raise TooLargeError(limits)

    async def save(path: Path) -> int:
        """Write the body to a file; return the received size [bytes], whatever was announced."""
        size = 0
        with path.open("wb") as out:
            async for chunk in request.stream():
                size += len(chunk)
                if size > most:
                    raise TooLargeError(limits)
                arrived(len(chunk))
                out.write(chunk)
        return size

    content, parameters = parse_options_header(request.headers.get("content-type", ""))
    query = request.query_params.multi_items()
    if content.lower() == b"multipart/form-data":
        if parameters.get(b"charset", b"").decode("latin-1").lower() not in _UTF_8:
            # A client could name any codec of Python, and some of them decode extremely slowly. So
            # allow only UTF-8.
            raise InputError("found a form in another encoding, expected UTF-8")
        await save(folder / _FORM_FIELD)
        files, fields = await asyncio.get_running_loop().run_in_executor(
            _PARSERS, lambda: asyncio.run(_parsed(request, folder, limits))
        )
        return _task(kind, folder, files, [*query, *fields])
    if content.lower() == b"application/x-www-form-urlencoded":
        raise InputError(
            "found a form without files, expected multipart/form-data or the file as the body "
            "(curl -F file=@FILE)"
        )
    name = file_name(request.query_params.get(_NAME_FIELD, ""), set())
    task = _task(kind, folder, [name], [item for item in query if item[0] != _NAME_FIELD])
    if not await save(folder / FILES / name):
        raise InputError("found an empty request, expected a result file as its body")
    return task


async def _parsed(request: Request, folder: Path, limits: Limits) -> tuple[list[str], _Fields]:
    """Write the files of a form to a folder; return their names and the fields with a value."""
    body = folder / _FORM_FIELD
    try:
        with body.open("rb") as file:

            async def receive() -> Message:
                chunk = file.read(_CHUNK)
                return {"type": "http.request", "body": chunk, "more_body": bool(chunk)}

            async with Request(request.scope, receive).form(
                max_files=limits.files, max_fields=_MOST_FIELDS, max_part_size=limits.field
            ) as form:
                return _written(form, folder / FILES)
    except HTTPException as e:
        raise InputError(
            f"found a form that cannot be read ({e.detail}), expected multipart/form-data"
        ) from None
    finally:
        body.unlink(missing_ok=True)


def _written(form: FormData, folder: Path) -> tuple[list[str], _Fields]:
    taken: set[str] = set()
    files, fields = [], []
    for key, given in form.multi_items():
        if isinstance(given, UploadFile):
            # A browser sends a file without name and content if none was chosen.
            if key == _FILE_FIELD and (given.filename or given.size):
                name = file_name(given.filename or "", taken)
                with (folder / name).open("wb") as out:
                    shutil.copyfileobj(given.file, out, _CHUNK)
                files.append(name)
        elif key not in (_FILE_FIELD, _PASTED_FIELD) and given.strip():
            # A form contains all of its fields; the fields that were not filled in are empty.
            fields.append((key, given.strip()))
    pasted = form.get(_PASTED_FIELD)
    if isinstance(pasted, str) and pasted.strip():
        name = file_name("pasted.txt", taken)
        (folder / name).write_text(pasted, encoding="utf-8", newline="")
        files.append(name)
    if not files:
        raise InputError(
            f"found no file and no pasted rows, expected one of them in the field {_FILE_FIELD} or "
            f"{_PASTED_FIELD}"
        )
    return files, fields


def _task(kind: Kind, folder: Path, files: Sequence[str], fields: _Fields) -> Task:
    options = _options(fields)
    told = {key: texts[0] for key, texts in options.items()}
    columns, name = told.get("columns"), told.get("name")
    require = tuple(options.get(_REPEATED, ()))
    for text in require:
        requirements.parse(text)
    return Task(
        kind, folder, tuple(files), _maneuver(told.get("maneuver")),
        None if columns is None else tuple(columns.split(",")),
        _numbers("step", told.get("step"), len(files)),
        _numbers("tolerance", told.get("tolerance"), len(files)),
        None if name is None else tuple(x.strip() for x in name.split(",")), require,
    )  # fmt: skip


def _options(told: _Fields) -> dict[str, list[str]]:
    """Return the values of the options that were sent with the files, by name.

    Raises
    ------
    InputError
        A name is not an option or occurs twice, or a value is too long.
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
    count = len(benchmark()[1])
    if text not in map(str, range(1, count + 1)):
        raise InputError(f"maneuver: found {quoted(text)}, expected 1 to {count}")
    return int(text)


def _numbers(name: str, text: str | None, count: int) -> tuple[float, ...] | None:
    if text is None:
        return None
    if (found := text.count(",") + 1) != count:
        raise InputError(f"{name}: found {found} for {count} files, expected one for each")
    return positive_numbers(name, text)
