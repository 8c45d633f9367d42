"""JSON: columns, rows or records, in whatever nesting; their decimals as they are written."""

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import chain
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.arrays.tables import tables
from heyoka_bike.scoring.reading.names.columns import (
    are_names,
    group_number,
    is_maneuver,
    recognise,
)
from heyoka_bike.scoring.reading.request import Request
from heyoka_bike.scoring.reading.result_file import ResultFile
from heyoka_bike.scoring.reading.text.dialects import DIALECTS
from heyoka_bike.scoring.reading.text.table import read_text
from heyoka_bike.scoring.reading.vectors import Vectors

# Names of the columns of rows, and of the rows.
_NAMES = ("columns", "names", "header", "headers", "fields")
_ROWS = ("data", "rows", "values")
# Arrays in arrays: of programs, maneuvers, columns and what a format puts around them.
_DEEPEST = 30
_TOO_DEEP = "found arrays in too many others, expected rows"
_NOT_BLANK = re.compile(r"\S")


def read(file: ResultFile) -> list[Vectors] | None:
    """The tables in a document, or in the list of documents in lines; None if it is a text.

    Columns may be arrays by name, rows may be arrays or objects, as pandas and MATLAB write them;
    maneuvers may be members of an object or of an array.

    Raises
    ------
    InputError
        Damaged, or not columns of real numbers.
    """
    file.content()
    (text,) = file.text()
    try:
        document = _parsed(text, file.encoding, file.request)
    except InputError as error:
        # A heading may begin with a bracket, too.
        with suppress(InputError):
            read_text((text,), file.encoding, file.request)
            return None
        raise error from None
    found = _shaped(document, file.request)
    if found is None:
        raise file.request.error("found JSON without a table, expected columns or rows of numbers")
    return tables(found, file.request)


def _parsed(text: bytes, encoding: str, request: Request) -> Any:
    """The document, or a list of them, with numbers as their text: so no digit is lost."""
    decoder = json.JSONDecoder(parse_float=str, parse_int=str, parse_constant=str)
    try:
        content = text.decode(encoding)
        try:
            return decoder.decode(content)
        except json.JSONDecodeError as e:
            if e.msg != "Extra data":
                raise
        return _one_after_the_other(content, decoder)
    except json.JSONDecodeError as e:
        said = f"found damaged JSON ({e.msg}), expected columns or rows of numbers"
        raise request.error(said, e.lineno, e.colno) from None
    except UnicodeError:
        raise request.error(f"found damaged text, expected {encoding.upper()}") from None
    except RecursionError:
        raise request.error(_TOO_DEEP) from None


def _one_after_the_other(content: str, decoder: json.JSONDecoder) -> list[Any]:
    found, at = [], 0
    while match := _NOT_BLANK.search(content, at):
        item, at = decoder.raw_decode(content, match.start())
        found.append(item)
    return found


def _shaped(x: Any, request: Request, depth: int = 0) -> Any:
    """Arrays and objects as NumPy's arrays and mappings; None if there is no number in it."""
    if depth > _DEEPEST:
        raise request.error(_TOO_DEEP)
    if isinstance(x, Mapping):
        return _object(x, request, depth + 1)
    if not isinstance(x, list) or not x:
        return None
    if _are_scalars(x):
        return _vector(x)
    if all(isinstance(y, list) for y in x):
        return _lists(x, request, depth + 1)
    if all(isinstance(y, dict) for y in x):
        return _objects(x, request, depth + 1)
    return None


def _lists(items: list[list[Any]], request: Request, depth: int) -> Any:
    """Rows, or an array for each maneuver."""
    if _are_scalars(chain.from_iterable(items)):
        return _rows(items, request)
    parts = [_shaped(x, request, depth) for x in items]
    shapes = {getattr(x, "shape", None) for x in parts}
    if len(shapes) == 1 and None not in shapes:
        return np.stack(parts)
    return {f"maneuver_{i}": x for i, x in enumerate(parts, 1) if x is not None}


def _objects(items: list[dict[str, Any]], request: Request, depth: int) -> Any:
    """Rows by name, or an object for each maneuver."""
    if all(map(_is_flat, items)):
        return _records(items)
    numbers = [_number(x) for x in items]
    if numbers == [None]:
        return _shaped(items[0], request, depth)
    # A number that is not told is the place.
    told = [n or i for i, n in enumerate(numbers, 1)]
    if len(set(told)) < len(told):
        told = list(range(1, len(items) + 1))
    return _known(
        {f"maneuver_{n}": _shaped(x, request, depth) for n, x in zip(told, items, strict=True)}
    )


def _object(x: Mapping[str, Any], request: Request, depth: int) -> Any:
    """A table that pandas writes as an object, or members."""
    if (table := _of_pandas(x, request)) is not None:
        return table
    found = {}
    for name, y in x.items():
        label, member = _with_its_unit(name, y)
        is_told = is_maneuver(name) and isinstance(y, str)
        found[label] = np.array(y, object) if is_told else _shaped(member, request, depth)
    return _known(found)


def _of_pandas(x: Mapping[str, Any], request: Request) -> Any:
    """Names beside rows, or objects of which the members are rows or columns; None if neither."""
    names = next((x[k] for k in _NAMES if _is_list_of(x.get(k), str, list)), None)
    rows = next((x[k] for k in _ROWS if _is_list_of(x.get(k), list)), None)
    if names and rows and len(names) == len(rows[0]):
        words = ["_".join(map(str, n)) if isinstance(n, list) else n for n in names]
        return _rows([words, *rows], request)
    members = list(x.values())
    if members and all(isinstance(y, dict) and y and _is_flat(y) for y in members):
        # The index of the rows has names, outside or inside.
        if are_names(list(x), request):
            return {name: _vector([y.get(k) for k in members[0]]) for name, y in x.items()}
        if are_names(list(members[0]), request):
            return _records(members)
    return None


def _with_its_unit(name: str, x: Any) -> tuple[str, Any]:
    """Name and values of a column that is an object of its values and their unit."""
    lists = [y for y in x.values() if isinstance(y, list)] if isinstance(x, Mapping) else []
    if len(lists) != 1 or not recognise(name):
        return name, x
    unit = x.get("unit", x.get("units"))
    return f"{name} [{unit}]" if isinstance(unit, str) else name, lists[0]


def _rows(rows: list[list[Any]], request: Request) -> Any:
    """Arrays of values as one of two axes, or as columns if the first one has their names."""
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
        # Equal names differ by their number, as pandas makes them.
        columns[f"{name}.{again[name]}" if again[name] else name] = _vector(values)
        again[name] += 1
    return columns


def _records(records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    names = dict.fromkeys(name for record in records for name in record)
    return {name: _vector([record.get(name) for record in records]) for name in names}


def _vector(items: list[Any]) -> Any:
    found = np.empty(len(items), dtype=object)
    found[:] = items
    return found


def _known(members: dict[str, Any]) -> dict[str, Any] | None:
    return {name: x for name, x in members.items() if x is not None} or None


def _number(x: Mapping[str, Any]) -> int | None:
    """Number of the maneuver that an object says it is of."""
    for name, y in x.items():
        if isinstance(y, str) and (is_maneuver(name) or name.lower() in ("name", "id")):
            number = group_number(y)
            if number is None and is_maneuver(name) and y.isascii() and y.isdecimal():
                number = int(y[:4])
            if number is not None:
                return number
    return None


def _are_scalars(items: Any) -> bool:
    return not any(isinstance(x, list | dict) for x in items)


def _is_flat(x: Mapping[str, Any]) -> bool:
    return _are_scalars(x.values())


def _is_list_of(x: Any, *kinds: type) -> bool:
    return isinstance(x, list) and bool(x) and all(isinstance(y, kinds) for y in x)
