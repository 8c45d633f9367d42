"""Checks that the files of a reference folder have the format of docs/files.md.

The module `form` checks HDF5 files. Every function yields problems in words, and an `Unchecked` for
each item that cannot be compared because the dataset is older. The functions assume only that the
bytes match the manifest.
"""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.numbers.exact import shortest_decimal
from heyoka_bike.reference import hdf5, layout
from heyoka_bike.reference.form import (
    STATES_OF_FORM,
    SetForm,
    Unchecked,
    UnusableError,
    of_instants,
)
from heyoka_bike.reference.manifest import DATASET_VERSION, MANIFEST
from heyoka_bike.reference.proof.certificate import BOUND, STATEMENT_1_5_0, statement_of
from heyoka_bike.reference.proof.certificate import document as expected_document
from heyoka_bike.reference.proof.instants import states_differ
from heyoka_bike.reference.proof.rows import TEXT_DIGITS
from heyoka_bike.reference.verification.outcome import Text

_NUMBER_50 = re.compile(
    rf"-?[1-9](\.[0-9]{{1,{TEXT_DIGITS - 1}}})?e[+-](0|[1-9][0-9]*)|0(e[+-](0|[1-9][0-9]*))?"
)
"""Entry of the text with 50 digits. Fewer digits, or a zero with an exponent, mean undecided."""
_UNDECIDED_ZERO = re.compile(r"0e[+-](0|[1-9][0-9]*)")
_ANY_VALUE = object()
"""Placeholder in an expected document for a number or text that is not checked here."""


def content_differs(raw: bytes, e: SetForm) -> Iterator[str]:
    """Yield a problem if the manifest's content_sha256 is not the hash of the numbers."""
    with hdf5.opened(raw) as f:
        found = layout.content_sha256(f)
    if found != e.manifest.content_sha256:
        yield (
            f"the numbers have content_sha256 {found[:12]}..., but the manifest states "
            f"{e.manifest.content_sha256:.12}..."
        )


def of_certificate(raw: bytes, e: SetForm) -> Iterator[str]:
    """Yield the problems of the certificate's structure, but not of its numbers."""
    document = json.loads(raw)
    if raw != layout.as_json(document):
        yield "the layout of the text is not the one that 'heyoka-bike generate' writes"
    later: tuple[str, ...] = ("integration",) if _is_before_2(document) else ()
    later += () if e.has_bounds else ("motion", "sensitivities", "integration")
    entries = [_entry(e, entry, later) for entry in document["maneuvers"][: len(e.maneuvers)]]
    is_decided = not any(
        said["ambiguous"] or said.get("motion", {}).get("ambiguous")
        for said in document["maneuvers"]
    )
    statement = STATEMENT_1_5_0 if _is_before_2(document) else statement_of(is_decided=is_decided)
    maneuvers = [*entries, *e.maneuvers[len(entries) :]]
    form = expected_document(e.manifest.inputs, e.manifest.files, maneuvers, e.columns, statement)
    form["software"] = dict.fromkeys(form["software"], _ANY_VALUE)
    if not e.has_bounds:
        yield Unchecked("its sentences")
        form |= dict.fromkeys(("statement", "proved", "computed", "trusted"), _ANY_VALUE)
        form = {key: x for key, x in form.items() if key in document or x is not _ANY_VALUE}
    yield from _differences(document, form)


def _is_before_2(certificate: Mapping[str, Any]) -> bool:
    """True if a certificate has the statement of the datasets before 2.0.0."""
    return bool(certificate["statement"] == STATEMENT_1_5_0)


def _entry(e: SetForm, found: Mapping[str, Any], later: Sequence[str]) -> dict[str, Any]:
    """Return the expected form of a maneuver's entry; the found one may lack keys of `later`."""
    bounds = {name: {c.name: BOUND for c in e.columns[name] if c.is_dense} for name in e.columns}
    form: dict[str, Any] = {
        **dict.fromkeys(("maneuver", "steps", "entries", "ambiguous"), _ANY_VALUE),
        **dict.fromkeys(("bound", "bound_end"), BOUND),
        "state_bounds": {x: {"interval": BOUND, "end": BOUND} for x in found["state_bounds"]},
        "dense_relative_bounds": bounds[layout.HDF5],
        "motion": {"entries": _ANY_VALUE, "dense_relative_bounds": bounds[layout.MOTION]},
        "sensitivities": {
            "entries": _ANY_VALUE, "ambiguous": _ANY_VALUE,
            "relative_bounds": bounds[layout.SENSITIVITIES],
        },
        "integration": dict.fromkeys(("performance_percent", "energy", "contact"), BOUND),
    }  # fmt: skip
    if list(found["state_bounds"]) not in STATES_OF_FORM.values():
        raise UnusableError("state_bounds: the state variables are not those of a candidate")
    if "ambiguous" in found.get("motion", {}):
        entries, *others = form["motion"].items()
        form["motion"] = dict([entries, ("ambiguous", _ANY_VALUE), *others])
    return {key: x for key, x in form.items() if key in found or key not in later}


def _differences(found: Any, form: Any, where: str = "") -> Iterator[str]:
    """Yield the differences of a document from its form: other entries or texts, invalid bounds."""
    if isinstance(form, dict):
        if list(found) != list(form):
            raise UnusableError(f"{where}expected the entries {', '.join(form)}")
        for key, inner in form.items():
            yield from _differences(found[key], inner, f"{where}{key}: ")
    elif isinstance(form, re.Pattern):
        if not form.fullmatch(found):
            raise UnusableError(f"{where}found {found!r:.40}, expected a bound")
    elif isinstance(form, list):
        if len(found) != len(form):
            yield f"found {len(found)} {where.rstrip(': ')}, expected {len(form)}"
        for i, (x, inner) in enumerate(zip(found, form, strict=False), start=1):
            yield from _differences(x, inner, f"{where}{i}: ")
    elif form is not _ANY_VALUE and found != form:
        yield f"{where}found {found!r:.80}, expected {form!r:.80}"


def of_states(raw: bytes, e: SetForm, name: str, bicycle: Bicycle) -> Iterator[str]:
    """Yield the problems of a file of states: its form, and values that differ from a new proof."""
    if name == layout.STATES_HDF5:
        yield from of_instants(raw, e)
    yield from states_differ(name, raw, bicycle)


def of_description(raw: bytes, e: SetForm, text: bytes) -> Iterator[str]:
    """Yield a problem if a file that describes the dataset differs from the expected text."""
    if e.manifest.dataset_version != DATASET_VERSION:
        yield Unchecked("the text of another version")
    elif raw != text:
        yield f"does not follow from {MANIFEST}"


def of_text(raw: bytes, e: SetForm, file: layout.TextFile) -> Iterator[str]:
    """Yield the problems of a text file: lines, fields, form of the numbers, times."""
    maneuver = e.maneuvers[file.numbers[0] - 1]
    lines = raw.decode("ascii").split("\n")
    if lines.pop() != "" or len(lines) != maneuver.rows:
        yield f"found {len(lines)} lines, expected {maneuver.rows}, each with a line end"
        return
    count = 1 + len(BENCHMARK_COLUMNS) * len(file.numbers)
    for i, line in enumerate(lines):
        fields = line.split(" ")
        if len(fields) != count:
            yield f"line {i + 1}: found {len(fields)} fields, expected {count}"
        elif fields[0] != shortest_decimal(maneuver.time(i), TEXT_DIGITS):
            expected = float(maneuver.time(i))
            yield f"line {i + 1}: found time {fields[0]:.60} s, expected {expected:.17g} s"
        elif wrong := [x for x in fields[1:] if not _is_number(x, file)]:
            yield f"line {i + 1}: found {wrong[0]!r:.80}, expected a number in the file's format"


def _is_number(text: str, file: layout.TextFile) -> bool:
    if file.is_long:
        return bool(_NUMBER_50.fullmatch(text))
    return bool(_UNDECIDED_ZERO.fullmatch(text)) or f"{float(text):.17g}" == text


def read_text(raw: bytes, file: layout.TextFile) -> Text:
    """Return the numbers of a text file in which no problem was found."""
    fields = [line.split(" ") for line in raw.decode("ascii").splitlines()]
    names = [(number, name) for number in file.numbers for name in BENCHMARK_COLUMNS]
    _, *columns = (tuple(column) for column in zip(*fields, strict=True))
    return Text(file, dict(zip(names, columns, strict=True)))
