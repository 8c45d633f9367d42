"""JSON files: columns, rows or records, in whatever nesting; their decimals as they are written."""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from heyoka_bike.errors import InputError
from heyoka_bike.scoring.reading.array_tables import tables
from heyoka_bike.scoring.reading.column_names import are_names, group_number, is_maneuver, recognise
from heyoka_bike.scoring.reading.dialects import DIALECTS
from heyoka_bike.scoring.reading.expected import Expected
from heyoka_bike.scoring.reading.written import WrittenTable

# Names of the columns of rows, and of the rows.
_NAMES = ("columns", "names", "header", "headers", "fields")
_ROWS = ("data", "rows", "values")
# Arrays in arrays: of programs, maneuvers, columns and what a format puts around them.
_DEEPEST = 30
_TOO_DEEP = "found arrays in too many others, expected rows"
_NOT_BLANK = re.compile(r"\S")


def read_json(document: Any, path: str, expected: Expected) -> list[WrittenTable]:
    """The tables in what `parse_json` returned.

    Columns may be arrays by name, rows may be arrays or objects, as pandas and MATLAB write them;
    maneuvers may be members of an object or of an array.

    Parameters
    ----------
    document
        Objects and arrays.
    path
        Name of the file, for errors.
    expected
        What columns there may be.

    Raises
    ------
    InputError
        Not columns of real numbers.
    """
    found = _shaped(document, path)
    if found is None:
        raise InputError(
            "found JSON without a table, expected columns or rows of numbers", file=path
        )
    return tables(found, path, expected)


def parse_json(text: bytes, encoding: str, path: str) -> Any:
    """A document, or the list of documents in lines, with numbers as their text.

    Parameters
    ----------
    text
        Without the mark of its encoding.
    encoding
        See `text_lines.encoding_of`.
    path
        Name of the file, for errors.

    Raises
    ------
    InputError
        Damaged JSON.
    """
    # So no digit is lost.
    decoder = json.JSONDecoder(parse_float=str, parse_int=str, parse_constant=str)
    try:
        content = text.decode(encoding)
        try:
            return decoder.decode(content)
        except json.JSONDecodeError as e:
            if e.msg != "Extra data":
                raise
        return _lines(content, decoder)
    except json.JSONDecodeError as e:
        raise InputError(
            f"found damaged JSON ({e.msg}), expected columns or rows of numbers",
            file=path,
            line=e.lineno,
            column=e.colno,
        ) from None
    except UnicodeError:
        raise InputError(f"found damaged text, expected {encoding.upper()}", file=path) from None
    except RecursionError:
        raise InputError(_TOO_DEEP, file=path) from None


def _lines(content: str, decoder: json.JSONDecoder) -> list[Any]:
    """Documents one after the other."""
    found, at = [], 0
    while match := _NOT_BLANK.search(content, at):
        item, at = decoder.raw_decode(content, match.start())
        found.append(item)
    return found


def _shaped(x: Any, path: str, depth: int = 0) -> Any:
    """Arrays and objects as NumPy's arrays and mappings; None if there is no number in it."""
    if depth > _DEEPEST:
        raise InputError(_TOO_DEEP, file=path)
    if isinstance(x, Mapping):
        return _object(x, path, depth + 1)
    if isinstance(x, list) and x:
        return _array(x, path, depth + 1)
    return None


def _array(items: list[Any], path: str, depth: int) -> Any:
    if not any(isinstance(x, list | dict) for x in items):
        return _vector(items)
    if all(isinstance(x, list) for x in items):
        if not any(isinstance(y, list | dict) for x in items for y in x):
            return _rows(items, path)
        parts = [_shaped(x, path, depth) for x in items]
        shapes = {x.shape if isinstance(x, np.ndarray) else None for x in parts}
        if len(shapes) == 1 and None not in shapes:
            return np.stack(parts)
        return {f"maneuver_{i}": x for i, x in enumerate(parts, 1) if x is not None}
    if all(isinstance(x, dict) for x in items):
        if not any(isinstance(y, list | dict) for x in items for y in x.values()):
            return _records(items)
        numbers = [_number(x) for x in items]
        if numbers == [None]:
            return _shaped(items[0], path, depth)
        # A number that is not told is the place.
        told = [n or i for i, n in enumerate(numbers, 1)]
        if len(set(told)) < len(told):
            told = list(range(1, len(items) + 1))
        each = {f"maneuver_{n}": _shaped(x, path, depth) for n, x in zip(told, items, strict=True)}
        return {name: x for name, x in each.items() if x is not None} or None
    return None


def _object(x: Mapping[str, Any], path: str, depth: int) -> Any:
    names = next((x[k] for k in _NAMES if _is_list_of(x.get(k), (str, list))), None)
    rows = next((x[k] for k in _ROWS if _is_list_of(x.get(k), (list,))), None)
    if names and rows and len(names) == len(rows[0]):
        words = ["_".join(map(str, n)) if isinstance(n, list) else n for n in names]
        return _rows([words, *rows], path)
    if _is_list_of(list(x.values()), (dict,)) and all(map(_is_flat, x.values())):
        # pandas writes the index of the rows as names, outside or inside.
        first = next(iter(x.values()))
        if are_names(list(x)):
            return {name: _vector([column.get(k) for k in first]) for name, column in x.items()}
        if are_names(list(first)):
            return _records(list(x.values()))
    found = {}
    for name, y in x.items():
        lists = [z for z in y.values() if isinstance(z, list)] if isinstance(y, Mapping) else []
        if recognise(name) and isinstance(y, Mapping) and len(lists) == 1:
            unit = y.get("unit", y.get("units"))
            label = f"{name} [{unit}]" if isinstance(unit, str) else name
            found[label] = _shaped(lists[0], path, depth)
        elif is_maneuver(name) and isinstance(y, str):
            found[name] = np.array(y, dtype=object)
        else:
            found[name] = _shaped(y, path, depth)
    return {name: y for name, y in found.items() if y is not None} or None


def _rows(rows: list[list[Any]], path: str) -> Any:
    """Arrays of values as one of two axes, or as columns if the first one has their names."""
    width = len(rows[0])
    for i, row in enumerate(rows, 1):
        if len(row) != width:
            raise InputError(
                f"row {i}: found {len(row)} values, expected {width} as in the first", file=path
            )
    if not width:
        return None
    if not _is_heading(rows[0]):
        return np.array(rows, dtype=object)
    names = [str(name) for name in rows[0]]
    seen: dict[str, int] = {}
    for j, name in enumerate(names):
        # Equal names differ by their number, as pandas makes them.
        seen[name] = seen.get(name, -1) + 1
        names[j] = f"{name}.{seen[name]}" if seen[name] else name
    return {name: _vector([row[j] for row in rows[1:]]) for j, name in enumerate(names)}


def _records(records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    names = dict.fromkeys(name for record in records for name in record)
    return {name: _vector([record.get(name) for record in records]) for name in names}


def _vector(items: list[Any]) -> Any:
    found = np.empty(len(items), dtype=object)
    found[:] = items
    return found


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


def _is_heading(row: list[Any]) -> bool:
    number: Callable[[str], str | None] = DIALECTS[0].number
    return all(isinstance(x, str) and number(x) is None for x in row)


def _is_flat(x: Mapping[str, Any]) -> bool:
    return bool(x) and not any(isinstance(y, list | dict) for y in x.values())


def _is_list_of(x: Any, kinds: tuple[type, ...]) -> bool:
    return isinstance(x, list) and bool(x) and all(isinstance(y, kinds) for y in x)
