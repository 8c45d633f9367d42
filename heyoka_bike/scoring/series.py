"""Several runs of one program, and several programs side by side.

Several programs are judged separately, with their errors in one table. The runs of one program have
an order of convergence. With errors e1, e2 at step sizes h1 > h2 the observed order is
log(e1 / e2) / log(h1 / h2). The Richardson extrapolation of the two finest runs,
f2 + (f2 - f1) / ((h1/h2)^p - 1) with the observed order p rounded to an integer, cancels the
leading term of the error. Its distance from the reference is the error that these runs can reach
without a smaller step.

If the same curve of errors remains with a smaller step, the integrator does not cause it: the
model, its parameters, the initial conditions or the output differ. If a different curve of the same
size remains, it is noise, from the arithmetic or from iterations that stop early. An error near the
last digits of the arithmetic always counts as rounding.

A list of runs is a small TOML file with result files, step sizes and processor times:

    [[run]]
    file = "h0.01.txt"
    step = "0.01"
    cpu = "0.53"

``file`` is relative to the list; ``step`` [s] and ``cpu`` [s] are decimals, and both are optional.
With a ``tolerance``, for solvers that choose their steps, the exponent with which the error follows
the tolerance is determined instead of the order.

References
----------
L. F. Richardson (1911), doi:10.1098/rsta.1911.0009; P. J. Roache (1994), doi:10.1115/1.2910291.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, repeat
from math import inf, log
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.bicycle.toml_source import TomlSource
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import Array, median, with_usual_errors
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.alignment import MEANINGLESS_ERROR, Alignment, Part, merge
from heyoka_bike.scoring.definitions import Understanding, Understandings, understand
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.evidence.several_runs import (
    DefinitionsOfPrograms,
    DefinitionsOfRuns,
    ErrorFalls,
    ErrorStays,
    Grouping,
    ManeuversDiffer,
    NoSharedColumns,
    OrderNotSettled,
    Staying,
    StepsUnknown,
)
from heyoka_bike.scoring.evidence.words import counted
from heyoka_bike.scoring.grades import RIGHT
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.measures import ROUNDING, rms
from heyoka_bike.scoring.reading.given import results_of, several
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.reading.source import ARRAY
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Convergence, Run, Series
from heyoka_bike.scoring.score import aligned, scored
from heyoka_bike.scoring.scores import ColumnScore


def read_runs(path: str | Path) -> tuple[list[Path], dict[str, list[float | None]]]:
    """Read a list of runs.

    Returns
    -------
    list of Path
        The file of each run.
    dict of str to list of float or None
        The ``step`` [s], the ``tolerance`` and the ``cpu`` time [s] of each run; None where the
        list does not give it.

    Raises
    ------
    InputError
        The list cannot be read, or contains an unknown entry or a value that is not a positive
        decimal. The error names the file and the key.
    """
    source = TomlSource.load(path)
    source.refuse_unknown(source.tree, {"run"}, ())
    files: list[Path] = []
    numbers: dict[str, list[float | None]] = {"step": [], "tolerance": [], "cpu": []}
    for i, table in enumerate(source.tables("run")):
        where = ("run", i)
        source.refuse_unknown(table, {"file", *numbers}, where, ("file",))
        files.append(Path(path).parent / source.line_of_text(table, "file", where, limit=4000))
        for key, values in numbers.items():
            values.append(source.positive(table, key, where) if key in table else None)
    return files, numbers


# Difference between two successive observed orders of convergence of a column, above which its
# order has not settled.
_ORDERS_APART = 0.3
# Errors that fall more slowly than this power of the step or tolerance count as constant.
_LEAST_EXPONENT = 0.2


def columns_of(runs: Sequence[Run]) -> Mapping[tuple[int, str], list[ColumnScore | None]]:
    """Return the scores of each column of each maneuver, one per run; None if a run lacks it."""
    found: dict[tuple[int, str], list[ColumnScore | None]] = {}
    for i, run in enumerate(runs):
        for m in run.report.maneuvers:
            for c in m.columns:
                found.setdefault((m.maneuver, c.key), [None] * len(runs))[i] = c
    order = list(COMPARED)
    return dict(sorted(found.items(), key=lambda x: (x[0][0], order.index(x[0][1]))))


def converge(runs: Sequence[Run]) -> tuple[Convergence, ...]:
    """Return the convergence of every column that more than one run contains."""
    steps = [run.step for run in runs]
    return tuple(
        _converge(maneuver, key, columns, steps)
        for (maneuver, key), columns in columns_of(runs).items()
        if sum(c is not None for c in columns) > 1
    )


def _converge(
    maneuver: int, key: str, columns: Sequence[ColumnScore | None], steps: Sequence[float | None]
) -> Convergence:
    sized = list(zip(columns, steps, strict=True))
    orders = tuple(_order(*both) for both in pairwise(sized))
    (coarse, step), (fine, next_step) = sized[-2:]
    extrapolated = None
    if coarse and fine and step and next_step and (order := round(orders[-1] or 0.0)) >= 1:
        e1, e2 = _errors_of_both(coarse, fine)
        # If fewer than half of the times are common, they do not represent the run.
        if 2 * len(e1) >= len(coarse.trace.time):
            # Richardson extrapolation is linear, so it can be applied to the errors directly.
            rest = e2 + (e2 - e1) / ((step / next_step) ** order - 1.0)
            extrapolated = float(np.max(np.abs(rest)))
    last = next(c for c in reversed(columns) if c is not None)
    return Convergence(
        maneuver=maneuver,
        key=key,
        unit=last.unit,
        definition=last.definition,
        errors=tuple(None if c is None else c.max_abs_error for c in columns),
        orders=orders,
        richardson_error=extrapolated,
        floor=last.floor,
    )


# A column of a run, with the step or tolerance of that run.
_OfRun = tuple[ColumnScore | None, float | None]


def _order(of_coarse: _OfRun, of_fine: _OfRun) -> float | None:
    """Return the observed order log(e1 / e2) / log(h1 / h2); None if the errors do not show it."""
    (coarse, step), (fine, next_step) = of_coarse, of_fine
    if coarse is None or fine is None or step is None or next_step is None:
        return None
    before, after = coarse.max_abs_error, fine.max_abs_error
    if coarse.definition != fine.definition or not before or not after:
        return None
    if coarse.is_hidden or fine.is_hidden:
        return None
    return log(before / after) / log(step / next_step)


def _errors_of_both(a: ColumnScore, b: ColumnScore) -> tuple[Array, Array]:
    """Return the errors of a column in two runs, at their common times."""
    _, i, j = np.intersect1d(a.trace.time, b.trace.time, return_indices=True)
    return a.trace.error[i], b.trace.error[j]


def falling(runs: Sequence[Run], convergence: Sequence[Convergence]) -> Iterator[Evidence]:
    """Yield evidence of how the errors fall over the runs, the coarsest first."""
    yield from _orders(convergence)
    sizes = [run.tolerance if run.step is None else run.step for run in runs[-2:]]
    if len(sizes) < 2 or sizes[0] is None or sizes[1] is None or sizes[0] <= sizes[1]:
        return
    exponents: list[float] = []
    staying: dict[Staying, dict[str, float]] = {how: {} for how in Staying}
    for (maneuver, key), (a, b) in columns_of(runs[-2:]).items():
        exponent = _order((a, sizes[0]), (b, sizes[1]))
        if a is None or b is None or exponent is None:
            continue
        if exponent > _LEAST_EXPONENT:
            exponents.append(exponent)
            continue
        how = Staying.SAME_CURVE if _is_same(*_errors_of_both(a, b)) else Staying.NOISE
        staying[Staying.ROUNDING if b.error < ROUNDING else how][f"{maneuver}.{key}"] = b.error
    by = "tolerance" if runs[-1].step is None else "step"
    if exponents and by == "tolerance":
        yield _exponent(by, exponents)
    for how, errors in staying.items():
        if errors:
            yield ErrorStays(how, tuple(errors), max(errors.values()), by)


def _exponent(by: str, found: Sequence[float]) -> ErrorFalls:
    return ErrorFalls(by, float(median(found)), min(found), max(found), len(found))


def _is_same(a: Array, b: Array) -> bool:
    """True if the errors of two runs are the same curve."""
    return bool(len(a)) and rms(a - b) < MEANINGLESS_ERROR * rms(b)


def _orders(convergence: Sequence[Convergence]) -> Iterator[Evidence]:
    """Yield evidence of the order of the program, and of columns whose order has not settled."""
    found = [c.orders[-1] for c in convergence if c.orders[-1] is not None]
    if not found:
        return
    yield _exponent("step", found)
    unsteady = tuple(
        f"{c.maneuver}.{c.key}"
        for c in convergence
        if len(c.orders) > 1
        and c.orders[-1] is not None
        and c.orders[-2] is not None
        and abs(c.orders[-1] - c.orders[-2]) > _ORDERS_APART
    )
    if unsteady:
        yield OrderNotSettled(unsteady)


_ARRAYS = repeat(ARRAY)


@with_usual_errors
def compare(
    *programs: Any,
    reference: Reference | str | PathLike[str] | None = None,
    require: str | Sequence[str] = (),
    cpu: Mapping[str, float] | None = None,
    **named: Any,
) -> Series:
    """Compare several programs side by side, as the command ``score`` does with several files.

    Parameters
    ----------
    programs
        A mapping from names of programs to results, or several results as arguments or as a list;
        files then give their names. Results are anything that `score` accepts.
    reference
        The result of `load_reference`, or the folder of a dataset; by default the published one.
    require
        A requirement that every program has to meet, or several, see `requirements`.
    cpu
        Processor time of each program by its name [s].
    named
        Results by name: ``compare(mine=x, theirs="theirs.txt")``.

    Returns
    -------
    Series
        A report on each program in the order given. Definitions, signs and units are determined
        separately for each program.

    Raises
    ------
    InputError, NothingScoredError
        As in `score`; or there are fewer than two programs.
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
    files = [
        _aligned_program(x, name, known) for x, name in zip(every, names or _ARRAYS, strict=False)
    ]
    times = None if cpu is None else _by_name(cpu, names or _file_names(files))
    return side_by_side(files, known, names=names, cpu=times, require=require)


def _aligned_program(given: Any, name: str, reference: Reference) -> Alignment:
    """Align results with the reference; arrays are named after the program."""
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
        raise InputError(f"cpu: found {unknown[0]!r:.60}, expected one of {', '.join(names)}")
    return [cpu.get(name) for name in names]


def check_names(names: Sequence[str] | None, count: int) -> None:
    """Raise `InputError` if names are given, but not one name for each file."""
    if names is None:
        return
    if len(names) != count:
        raise InputError(
            f"name: found {counted(len(names), 'name')} for {counted(count, 'file')}, expected one "
            "for each file"
        )
    if not all(name.strip() for name in names):
        raise InputError(f"name: found an empty name in {','.join(names)!r:.60}, expected text")


def side_by_side(
    files: Sequence[Alignment],
    reference: Reference,
    *,
    names: Sequence[str] | None = None,
    cpu: Sequence[float | None] | None = None,
    require: str | Sequence[str] = (),
) -> Series:
    """Compare programs whose files are aligned; `cpu` is the processor time of each file [s]."""
    named = zip(files, cpu or repeat(None), names or _file_names(files), strict=False)
    every = [_Files(file, cpu=time, name=name) for file, time, name in named]
    merged = _merged(every, lambda one, group: one.name == group[0].name)
    programs = tuple(x.scored(reference, require) for x in merged)
    # Different programs use different steps and write different digits, so only their errors are
    # compared.
    errors = tuple(replace(c, floor=None) for c in converge(programs))
    seen: list[Evidence] = [*_maneuvers(programs), *_defined(programs)]
    if not errors:
        seen.insert(0, NoSharedColumns(Grouping.PROGRAMS))
    return Series(programs, errors, tuple(seen), is_one_program=False)


def _file_names(files: Sequence[Alignment]) -> list[str]:
    """Return the name of each file, with its folders if several files have the same name."""
    paths = [a.file.path for a in files]
    short = [Path(path).name or path for path in paths]
    names = [s if short.count(s) == 1 else path for s, path in zip(short, paths, strict=True)]
    return [
        name if names.count(name) == 1 else f"{name} ({names[: i + 1].count(name)})"
        for i, name in enumerate(names)
    ]


class _Files(NamedTuple):
    """The files of one run or program, and the user's data on it.

    Attributes
    ----------
    alignment : Alignment
    step, cpu
        Step size and processor time [s].
    tolerance
        Tolerance of a solver that chooses its steps.
    name
        Name of the program.
    """

    alignment: Alignment
    step: float | None = None
    tolerance: float | None = None
    cpu: float | None = None
    name: str = ""

    def scored(
        self,
        reference: Reference,
        require: str | Sequence[str],
        understood: Understandings | None = None,
    ) -> Run:
        report = scored(self.alignment, reference, require, understood)
        return Run(report, self.step, self.cpu, self.name, self.tolerance)


def _merged(
    files: Sequence[_Files], belongs: Callable[[_Files, Sequence[_Files]], bool]
) -> list[_Files]:
    """Merge files that belong together; their total time is unknown if any time is unknown."""
    groups: list[list[_Files]] = []
    for one in files:
        group = next((g for g in groups if belongs(one, g)), None)
        if group is None:
            groups.append(group := [])
        group.append(one)
    merged = []
    for group in groups:
        times = [one.cpu for one in group if one.cpu is not None]
        cpu = sum(times) if len(times) == len(group) else None
        alignment = merge([one.alignment for one in group])
        merged.append(group[0]._replace(alignment=alignment, cpu=cpu))
    return merged


def _maneuvers(programs: Sequence[Run]) -> Iterator[ManeuversDiffer]:
    """Yield evidence of programs with different maneuvers: their worst columns are incomparable."""
    held = {program.name: tuple(program.report) for program in programs}
    if len(set(held.values())) > 1:
        yield ManeuversDiffer(held)


def _defined(programs: Sequence[Run]) -> Iterator[DefinitionsOfPrograms]:
    """Yield evidence of columns that programs define differently. This is not an error."""
    taken = grouped(
        (key, (c.definition, program.name))
        for (_, key), columns in columns_of(programs).items()
        for program, c in zip(programs, columns, strict=True)
        if c is not None and c.values
    )
    for key, uses in taken.items():
        by = grouped(dict.fromkeys(uses))
        if len(by) > 1:
            who = {definition: tuple(names) for definition, names in by.items()}
            yield DefinitionsOfPrograms(key, who)


# Smallest and largest step size or processor time that are accepted [s].
_SHORTEST_SECONDS, _LONGEST_SECONDS = 1e-9, 1e9


@with_usual_errors
def score_series(
    results: Sequence[Any],
    reference: Reference | str | PathLike[str] | None = None,
    *,
    steps: Sequence[float | None] | None = None,
    tolerances: Sequence[float | None] | None = None,
    cpu: Sequence[float | None] | None = None,
    require: str | Sequence[str] = (),
) -> Series:
    """Compare several runs of one program, at different steps or tolerances, with the reference.

    Parameters
    ----------
    results
        Results of each run or file, anything that `score` accepts; files with different maneuvers
        and the same step or tolerance make one run.
    reference
        The result of `load_reference`, or the folder of a dataset; by default the published one.
    steps
        Step size of each file [s], None where unknown; by default the median distance of its rows
        if there are no tolerances either.
    tolerances
        Tolerance of each file, for solvers that choose their steps; None where unknown.
    cpu
        Processor time of each file [s], None where unknown.
    require
        A requirement that every run has to meet, or several, see `requirements`.

    Returns
    -------
    Series
        A report on each run, and the order of convergence of each column.

    Raises
    ------
    InputError, NothingScoredError
        As in `score`; or there is not one step, tolerance or time for each file.
    """
    known = load_reference(reference)
    options = {"step": steps, "tolerance": tolerances, "cpu": cpu}
    return _series(_files(several(results), known, options), known, options, require)


def score_files(
    results: Sequence[Results],
    reference: Reference | None = None,
    *,
    steps: Sequence[float | None] | None = None,
    tolerances: Sequence[float | None] | None = None,
    cpu: Sequence[float | None] | None = None,
    require: Sequence[str] = (),
    names: Sequence[str] | None = None,
    is_one_program: bool | None = None,
) -> Report | Series:
    """Return a `Report` if the files contain different maneuvers of one run, otherwise a `Series`.

    Parameters and errors are those of `score_series` and `compare`. The series contains runs of one
    program if `is_one_program`, by default if there are steps or tolerances; otherwise it contains
    several programs.
    """
    known = load_reference(reference)
    check_names(names, len(results))
    options = {"step": steps, "tolerance": tolerances, "cpu": cpu}
    files = _files(results, known, options)
    held = [p.number for a in files for p in a.parts]
    if len(set(held)) == len(held) and len(set(names or ())) < 2:
        return scored(merge(files), known, require)
    if is_one_program is None:
        is_one_program = steps is not None or tolerances is not None
    if not is_one_program:
        return side_by_side(files, known, names=names, cpu=cpu, require=require)
    if names is not None:
        raise InputError("name: found for runs of one program, expected only for several programs")
    return _series(files, known, options, require)


# Steps, tolerances and processor times of the files, by the name of the option that sets them.
_Options = Mapping[str, Sequence[float | None] | None]


def _files(results: Sequence[Any], reference: Reference, options: _Options) -> list[Alignment]:
    """Check the steps and times given for files, and align the files with the reference."""
    for name, given in options.items():
        if given is None:
            continue
        if len(given) != len(results):
            count = len(results)
            raise InputError(
                f"{name}: found {counted(len(given), 'value')} for {counted(count, 'file')}, "
                "expected one for each file"
            )
        if name != "tolerance" and not all(
            x is None or _SHORTEST_SECONDS <= x <= _LONGEST_SECONDS for x in given
        ):
            raise InputError(
                f"{name}: found {list(given)}, expected positive times, "
                f"{_SHORTEST_SECONDS:g} to {_LONGEST_SECONDS:g} s"
            )
    return [aligned(results_of(r, len(reference)), reference) for r in results]


def _series(
    files: Sequence[Alignment], known: Reference, options: _Options, require: str | Sequence[str]
) -> Series:
    unknown: Sequence[float | None] = [None] * len(files)
    steps, tolerances, cpu = options["step"], options["tolerance"], options["cpu"]
    is_size_given = steps is not None or tolerances is not None
    by_rows = unknown if is_size_given else [_rows_apart(a) for a in files]
    each = zip(files, steps or by_rows, tolerances or unknown, cpu or unknown, strict=True)
    runs = _merged([_Files(*x) for x in each], _is_of_run)
    sorted_by = [
        x for x in ("step", "tolerance") if not _are_unknown([getattr(r, x) for r in runs])
    ]
    if sorted_by:
        runs.sort(key=lambda run: -getattr(run, sorted_by[0]))
    if "step" not in sorted_by:
        runs = [run._replace(step=None) for run in runs]
    seen: list[Evidence] = []
    if not sorted_by and (steps is None or tolerances is not None or set(steps) != {None}):
        seen.append(StepsUnknown(is_size_given))
    understood = [understand(run.alignment.parts) for run in runs]

    def score_all(clearest: Understandings) -> tuple[tuple[Run, ...], tuple[Convergence, ...]]:
        both = zip(runs, understood, strict=True)
        found = tuple(run.scored(known, require, _shared(own, clearest)) for run, own in both)
        return found, converge(found)

    clearest = _clearest(understood)
    found, convergence = score_all(clearest)
    # Two definitions may differ by less than the errors of the runs. The extrapolation of the runs
    # has smaller errors, so it distinguishes the definitions better.
    better = _clearest([*understood, understand(_extrapolate(runs, convergence))])
    if any(u.column != clearest[key].column for key, u in better.items()):
        found, convergence = score_all(better)
    if not convergence:
        seen.append(NoSharedColumns(Grouping.FILES))
    seen += _disagreement(found)
    seen += falling(found, convergence)
    return Series(found, convergence, tuple(seen))


def _rows_apart(a: Alignment) -> float | None:
    """Return the smallest median distance of rows in any maneuver [s]; None if unknown."""
    each = (np.diff(p.time) + np.diff(p.time_lo) for p in a.parts)
    return min((float(median(x[x > 0])) for x in each if (x > 0).any()), default=None)


def _are_unknown(steps: Sequence[float | None]) -> bool:
    """True if a step is unknown or two steps are equal, so they do not order the runs."""
    known = sorted(step for step in steps if step is not None)
    return len(known) < len(steps) or any(b - a <= RIGHT * b for a, b in pairwise(known))


def _is_of_run(one: _Files, group: Sequence[_Files]) -> bool:
    """True if a file adds maneuvers to a run with the same step or tolerance."""
    held = {p.number for run in group for p in run.alignment.parts}
    is_alike = _same(one.step, group[0].step) or _same(one.tolerance, group[0].tolerance)
    return is_alike and not held & {p.number for p in one.alignment.parts}


def _same(a: float | None, b: float | None) -> bool:
    return a is not None and b is not None and abs(a - b) <= RIGHT * max(a, b)


def _clearest(understood: Sequence[Understandings]) -> dict[str, Understanding]:
    """Return each column's interpretation from the run with the fewest open definitions.

    Of several such runs, the last (finest) one counts.
    """
    found: dict[str, Understanding] = {}
    for run in understood:
        for key, u in run.items():
            known = found.get(key)
            if known is None or len(u.indistinguishable) <= len(known.indistinguishable):
                found[key] = u
    return found


def _shared(own: Understandings, clearest: Understandings) -> dict[str, Understanding]:
    """Return the interpretations of a run, with the definitions that all runs share.

    A run keeps its own definition if it has stronger odds against the shared one.
    """
    shared = {}
    for key, u in own.items():
        clear = clearest[key]
        against = u.odds.get(clear.column.definition)
        is_open = clear.column.definition in u.indistinguishable
        if against is not None and (is_open or against < clear.odds.get(u.column.definition, -inf)):
            u = u.taken_as(clear.column)
        shared[key] = u
    return shared


def _extrapolate(runs: Sequence[_Files], convergence: Sequence[Convergence]) -> list[Part]:
    """Return the Richardson extrapolation of the two finest runs, at their common times."""
    orders = [c.orders[-1] for c in convergence if c.orders[-1] is not None]
    order = round(float(median(orders))) if orders else 0
    coarse, fine = (runs[-2], runs[-1]) if len(runs) > 1 else (None, None)
    if order < 1 or not (coarse and coarse.step and fine and fine.step):
        return []
    weight = 1.0 / ((coarse.step / fine.step) ** order - 1.0)
    by_number = {p.number: p for p in coarse.alignment.parts}
    parts = []
    for b in fine.alignment.parts:
        a = by_number.get(b.number, b.only(()))
        time, i, j = np.intersect1d(a.time, b.time, return_indices=True)
        shared = a.values.keys() & b.values.keys()
        values = {k: b.values[k][j] + weight * (b.values[k][j] - a.values[k][i]) for k in shared}
        if 2 * len(time) >= len(a.time) and values:
            parts.append(replace(b, time=time, time_lo=b.time_lo[j], values=values, lo={}))
    return parts


def _disagreement(runs: Sequence[Run]) -> Iterator[DefinitionsOfRuns]:
    """Yield evidence of columns that the runs write differently: there may be several programs."""
    taken = grouped(
        (key, (c.definition, c.as_understood.sign, c.as_understood.unit))
        for (_, key), columns in columns_of(runs).items()
        for c in columns
        if c is not None
    )
    different = tuple(key for key, forms in taken.items() if len(set(forms)) > 1)
    if different:
        yield DefinitionsOfRuns(different)
