"""Several programs side by side: each judged by itself, their errors in one table."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import repeat
from os import PathLike
from pathlib import Path
from typing import Any

from heyoka_bike.errors import InputError
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.alignment import Alignment, merge
from heyoka_bike.scoring.findings import Finding, info, warning
from heyoka_bike.scoring.reading.source import ARRAY, results_of, several
from heyoka_bike.scoring.report import Run, Series
from heyoka_bike.scoring.score import aligned, scored
from heyoka_bike.scoring.series.convergence import columns_of, converge, nothing_shared

_ARRAYS = repeat(ARRAY)


def compare(
    *programs: Any,
    reference: Reference | str | PathLike[str] | None = None,
    require: str | Sequence[str] = (),
    cpu: Mapping[str, float] | None = None,
    **named: Any,
) -> Series:
    """Several programs side by side, as the command ``score`` shows several files.

    Parameters
    ----------
    programs
        Results by name of the program, or files, one by one or as a list, which are named like
        these. Results are what `score` takes.
    reference
        From `load_reference`, or the folder of a set; the published one by default.
    require
        A requirement that every program has to meet, or several, see `requirements`.
    cpu
        Processor times by name of the program [s].
    named
        Results by name: ``compare(mine=x, theirs="theirs.txt")``.

    Returns
    -------
    Series
        A report of each program in the order given. Definitions, signs and units are found for each
        by itself.

    Raises
    ------
    InputError, NothingScoredError
        See `score`; or fewer than two programs.
    """
    known = load_reference(reference)
    one = programs[0] if len(programs) == 1 else None
    if not programs or isinstance(one, Mapping):
        given = {**(one or {}), **named}
        names, every = list(map(str, given)), list(given.values())
    elif named:
        raise InputError("found programs with and without names, expected names for all or none")
    else:
        names, every = None, several(list(programs) if len(programs) > 1 else one)
    if len(every) < 2:
        count = f"{len(every)} program{'s' if len(every) != 1 else ''}"
        raise InputError(f"found {count}, expected two or more; score() judges one")
    check_names(names, len(every))
    files = [_beside(x, name, known) for x, name in zip(every, names or _ARRAYS, strict=False)]
    times = None if cpu is None else _by_name(cpu, names or _file_names(files))
    return side_by_side(files, known, names=names, cpu=times, require=require)


def _beside(given: Any, name: str, reference: Reference) -> Alignment:
    """Results beside the reference; of arrays with the name of the program."""
    try:
        found = results_of(given, len(reference))
    except InputError as e:
        if e.file not in (None, ARRAY):
            raise
        raise InputError(e.message, file=name, line=e.line, column=e.column) from None
    named = [replace(r, path=name) if r.format == ARRAY else r for r in found]
    return aligned(named, reference)


def _by_name(cpu: Mapping[str, float], names: Sequence[str]) -> list[float | None]:
    unknown = [name for name in cpu if name not in names]
    if unknown:
        raise InputError(f"cpu: found {unknown[0]!r:.60}, expected some of {', '.join(names)}")
    return [cpu.get(name) for name in names]


def check_names(names: Sequence[str] | None, count: int) -> None:
    """Raise `InputError` unless there is a name for each file, if any are given."""
    if names is None:
        return
    if len(names) != count:
        raise InputError(f"name: found {len(names)} for {count} files, expected as many")
    if not all(name.strip() for name in names):
        raise InputError(f"name: found an empty one in {','.join(names)!r:.60}, expected a name")


def side_by_side(
    files: Sequence[Alignment],
    reference: Reference,
    *,
    names: Sequence[str] | None = None,
    cpu: Sequence[float | None] | None = None,
    require: str | Sequence[str] = (),
) -> Series:
    """`compare` of files that lie beside the reference; cpu is that of each file [s]."""
    groups: dict[str, list[int]] = {}
    for i, name in enumerate(_file_names(files) if names is None else names):
        groups.setdefault(name, []).append(i)
    programs = tuple(
        Run(
            scored(merge([files[i] for i in group]), reference, require),
            None,
            total([cpu[i] for i in group]) if cpu is not None else None,
            name,
        )
        for name, group in groups.items()
    )
    # Programs have no step in common, and each its own digits: only the errors are side by side.
    errors = tuple(replace(c, floor=None) for c in converge(programs))
    nothing = nothing_shared(errors, "programs share: nothing is side by side")
    findings = (*nothing, *_maneuvers(programs), *_definitions(programs))
    return Series(programs, errors, findings, is_one_program=False)


def _file_names(files: Sequence[Alignment]) -> list[str]:
    """A name for each file: its own, with its folders where others have the same."""
    paths = [a.file.path for a in files]
    short = [Path(path).name or path for path in paths]
    names = [s if short.count(s) == 1 else path for s, path in zip(short, paths, strict=True)]
    return [
        name if names.count(name) == 1 else f"{name} ({names[: i + 1].count(name)})"
        for i, name in enumerate(names)
    ]


def total(times: Sequence[float | None]) -> float | None:
    """Processor time of several files; None if that of one is not known."""
    known = [t for t in times if t is not None]
    return sum(known) if len(known) == len(times) else None


def _maneuvers(programs: Sequence[Run]) -> list[Finding]:
    """Programs that hold different maneuvers: their worst columns do not compare."""
    who: dict[str, list[str]] = {}
    for program in programs:
        who.setdefault(", ".join(map(str, program.report)), []).append(program.name)
    if len(who) < 2:
        return []
    held = "; ".join(f"{', '.join(names)}: {numbers or 'none'}" for numbers, names in who.items())
    said = (
        f"the programs cover different maneuvers ({held}), so that the digits of their worst "
        "columns do not compare: look at the maneuvers that they share"
    )
    numbers = {program.name: list(program.report) for program in programs}
    return [warning("maneuvers_differ", said, maneuvers=numbers)]


def _definitions(programs: Sequence[Run]) -> Iterator[Finding]:
    """Columns that the programs define in different ways: no error of any of them."""
    ways: dict[str, dict[str, list[str]]] = {}
    for (_, key), columns in columns_of(programs).items():
        for program, c in zip(programs, columns, strict=True):
            if c is not None and c.values:
                who = ways.setdefault(key, {}).setdefault(c.definition, [])
                who += [program.name] * (program.name not in who)
    for key, by in ways.items():
        if len(by) > 1:
            each = "; ".join(f"{definition} in {', '.join(who)}" for definition, who in by.items())
            said = f"{key} is {each}: each is compared with its own definition, so this is no error"
            yield info("definitions_differ", said, column=key, definitions=by)
