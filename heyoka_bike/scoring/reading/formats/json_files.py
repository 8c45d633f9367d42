"""Read JSON: columns, rows or records, nested in any way; decimals keep all their digits."""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.names.heading import are_names, group_number, is_known, is_maneuver
from heyoka_bike.scoring.reading.names.paths import without_paths
from heyoka_bike.scoring.reading.not_read import PRINT_ALL
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.text.dialects import DIALECTS
from heyoka_bike.scoring.reading.text.rows import read_text

# Names of the object members that contain the names of the columns, and of those that contain the
# rows.
_WORDS_FOR_NAMES = ("columns", "names", "header", "headers", "fields")
_WORDS_FOR_ROWS = ("data", "rows", "values")
# Maximum depth of nested arrays. Nesting by program, maneuver, column and the structure of a format
# is less deep.
_DEEPEST = 30
_TOO_DEEP = "found arrays nested too deep, expected rows"
_NOT_BLANK = re.compile(r"\S")
# Three dots that replace the part of an array that was not printed.
_ELLIPSIS = re.compile(rb"(?<![.\w])\.\.\.(?![.\w])")


def read(file: ResultFile) -> Any:
    """Return the arrays in a document, or in one document per line; None if the file is a text.

    Columns may be arrays by name, rows may be arrays or objects, as pandas and MATLAB write them;
    maneuvers may be members of an object or of an array.

    Raises
    ------
    InputError
        The file is damaged, contains no arrays, or has a name twice in one object.
    """
    file.content()
    (text,) = file.text()
    try:
        document = _parsed(text, file.encoding, file.request)
    except InputError as error:
        # The heading of a text file may also begin with a bracket, so try to read the file as text.
        with suppress(InputError):
            read_text((text,), file.encoding, file.request)
            return None
        if shortened := _ELLIPSIS.search(text):
            said = f"found {shortened[0].decode()!r}, expected every row: {PRINT_ALL}"
            raise file.request.error(said) from None
        raise error from None
    found = _shaped(document, file.request)
    if found is None:
        raise file.request.error("found JSON without a table, expected columns or rows of numbers")
    return found


def _parsed(text: bytes, encoding: str, request: Request) -> Any:
    """Return the document, or a list of documents; numbers remain texts, so no digit is lost."""
    decoder = json.JSONDecoder(
        parse_float=str, parse_int=str, parse_constant=str, object_pairs_hook=request.by_name
    )
    found, at = [], 0
    try:
        content = text.decode(encoding)
        while match := _NOT_BLANK.search(content, at):
            item, at = decoder.raw_decode(content, match.start())
            found.append(item)
    except json.JSONDecodeError as e:
        said = f"found damaged JSON ({e.msg}), expected columns or rows of numbers"
        raise request.error(said, e.lineno, e.colno) from None
    except UnicodeError:
        raise request.error(f"found damaged text, expected {encoding.upper()}") from None
    except RecursionError:
        raise request.error(_TOO_DEEP) from None
    return found[0] if len(found) == 1 else found


def _shaped(x: Any, request: Request, depth: int = 0) -> Any:
    """Convert arrays to NumPy arrays, and objects to mappings; None if they contain no numbers."""
    if depth > _DEEPEST:
        raise request.error(_TOO_DEEP)
    below = partial(_shaped, request=request, depth=depth + 1)
    if isinstance(x, dict):
        table = _of_pandas(x, request)
        return (
            _known(_member(*item, below, request) for item in x.items()) if table is None else table
        )
    if not isinstance(x, list) or not x:
        return None
    if _are_scalars(x):
        return np.array(x, object)
    if _is_list_of(x, dict):
        return _objects(x, below)
    if not _is_list_of(x, list):
        return None
    if _are_scalars(chain(*x)):
        return _rows(x, request)
    # If all parts are arrays of the same shape, join them into one array. Otherwise each part
    # belongs to a maneuver.
    parts = [below(y) for y in x]
    shapes = {getattr(y, "shape", None) for y in parts}
    if len(shapes) == 1 and None not in shapes:
        return np.stack(parts)
    return _known((f"maneuver_{i}", y) for i, y in enumerate(parts, 1))


def _objects(items: list[dict[str, Any]], below: Callable[[Any], Any]) -> Any:
    """Convert a list of objects to a table with a row per object, or to a group per maneuver."""
    if all(map(_is_flat, items)):
        return _records(items)
    if all(map(_is_flat, flat := [_flattened(x) for x in items])) and len(items) > 1:
        return _records(flat)
    numbers = [_number(x) for x in items]
    if numbers == [None]:
        return below(items[0])
    # If an object does not state the number of its maneuver, its position is the number.
    told = [n or i for i, n in enumerate(numbers, 1)]
    if len(set(told)) < len(told):
        told = list(range(1, len(items) + 1))
    return _known((f"maneuver_{n}", below(x)) for n, x in zip(told, items, strict=True))


def _member(name: str, x: Any, below: Callable[[Any], Any], request: Request) -> tuple[str, Any]:
    """Return the name and the values of an object member; the name includes its unit, if any.

    A member may be an object that contains the values and their unit.
    """
    if is_maneuver(name) and isinstance(x, str):
        return name, np.array(x, object)
    lists = [y for y in x.values() if isinstance(y, list)] if isinstance(x, dict) else []
    if len(lists) != 1 or not is_known(name):
        values, unit = x, None
    else:
        values, unit = lists[0], x.get("unit", x.get("units"))
    found = below(values)
    if found is None and isinstance(values, list) and values and is_known(name):
        # Without this error, the column would be left out and the user would not notice it.
        raise request.error(
            f"{name}: found a list that is not a column, expected one number for each time"
        )
    return f"{name} [{unit}]" if isinstance(unit, str) else name, found


def _known(members: Iterable[tuple[str, Any]]) -> dict[str, Any] | None:
    """Return the members that contain numbers as a mapping; None if no member does."""
    return {name: x for name, x in members if x is not None} or None


def _of_pandas(x: Mapping[str, Any], request: Request) -> Any:
    """Return the table in an object that pandas wrote; None if the object has no such form.

    The object contains names and rows separately, or its members are rows or columns.
    """
    names = next((x[k] for k in _WORDS_FOR_NAMES if _is_list_of(x.get(k), str, list)), None)
    rows = next((x[k] for k in _WORDS_FOR_ROWS if _is_list_of(x.get(k), list)), None)
    if names and rows and len(names) == len(rows[0]):
        words = ["_".join(map(str, n)) if isinstance(n, list) else n for n in names]
        return _rows([words, *rows], request)
    members = list(x.values())
    if members and all(isinstance(y, dict) and y and _is_flat(y) for y in members):
        # The object may contain columns by name, or rows that contain values by name. Check which
        # of the two levels has the names of columns.
        if are_names(without_paths(list(x)), request):
            return {name: np.array([y.get(k) for k in members[0]], object) for name, y in x.items()}
        if are_names(without_paths(list(members[0])), request):
            return _records(members)
    return None


def _rows(rows: list[list[Any]], request: Request) -> Any:
    """Convert rows to a two-dimensional array, or to columns by name if the first row has names."""
    width = len(rows[0])
    for i, row in enumerate(rows, 1):
        if len(row) != width:
            raise request.error(
                f"row {i}: found {len(row)} values, expected {width} as in the first"
            )
    if not width:
        return None
    if not all(isinstance(x, str) and DIALECTS[0].number(x) is None for x in rows[0]):
        return np.array(rows, dtype=object)
    columns: dict[str, Any] = {}
    again: Counter[str] = Counter()
    for name, *values in zip(*rows, strict=True):
        # Columns with the same name are distinguished by a number after the name, as in pandas.
        columns[f"{name}.{again[name]}" if again[name] else name] = np.array(values, object)
        again[name] += 1
    return columns


def _records(items: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    names = dict.fromkeys(chain(*items))
    return {name: np.array([x.get(name) for x in items], object) for name in names}


def _flattened(x: Mapping[str, Any]) -> dict[str, Any]:
    """Return a row without nested objects: their members are named by their paths."""
    found: dict[str, Any] = {}
    for name, y in x.items():
        inner = _flattened(y) if isinstance(y, dict) else {}
        found.update({f"{name}.{n}": z for n, z in inner.items()} or {name: y})
    return found


def _number(x: Mapping[str, Any]) -> int | None:
    """Return the number of the maneuver that an object states; None if it states none."""
    for name, y in x.items():
        if isinstance(y, str) and (is_maneuver(name) or name.lower() in ("name", "id")):
            word = f"maneuver {y}" if y.isdecimal() and is_maneuver(name) else y
            if number := group_number(word):
                return number
    return None


def _are_scalars(items: Any) -> bool:
    return not any(isinstance(x, list | dict) for x in items)


def _is_flat(x: Mapping[str, Any]) -> bool:
    return _are_scalars(x.values())


def _is_list_of(x: Any, *kinds: type) -> bool:
    return isinstance(x, list) and bool(x) and all(isinstance(y, kinds) for y in x)
