"""Several runs of one program: order of convergence, and what extrapolation reaches.

With errors e1, e2 at step sizes h1 > h2 the observed order is log(e1 / e2) / log(h1 / h2). The
Richardson extrapolation of the two finest runs, f2 + (f2 - f1) / ((h1/h2)^p - 1) with the observed
order p rounded to an integer, cancels the leading term of the error; its distance from the
reference is what these runs can reach without a smaller step.

References
----------
L. F. Richardson (1911), doi:10.1098/rsta.1911.0009; P. J. Roache (1994), doi:10.1115/1.2910291.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf
from os import PathLike
from typing import Any, NamedTuple

import numpy as np

from heyoka_bike.bicycle.columns import Column
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.double import median
from heyoka_bike.reference.load import Reference, load_reference
from heyoka_bike.scoring.alignment import Alignment, Part, merge
from heyoka_bike.scoring.definitions import Understanding, Understandings, understand
from heyoka_bike.scoring.findings import Finding, warning
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.reading.source import results_of, several
from heyoka_bike.scoring.report import Convergence, Report, Run, Series
from heyoka_bike.scoring.score import aligned, scored
from heyoka_bike.scoring.series.convergence import columns_of, converge, falling, nothing_shared
from heyoka_bike.scoring.series.side_by_side import check_names, side_by_side, total

# Steps that differ by less than this are the same for a program.
_SAME_STEP = 1e-6
# No step or time of a run of seconds [s] is less or more.
_SHORTEST, _LONGEST = 1e-9, 1e9


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
        One for each run or file, what `score` takes; files of different maneuvers and the same step
        or tolerance make one run.
    reference
        From `load_reference`, or the folder of a set; the published one by default.
    steps
        Step size of each file [s], None where unknown; by default the median distance of its rows
        if there are no tolerances either.
    tolerances
        Of a solver that chooses its steps, for each file; None where unknown.
    cpu
        Processor time of each file [s], None where unknown.
    require
        A requirement that every run has to meet, or several, see `requirements`.

    Returns
    -------
    Series
        A report of each run, and the order of convergence of each column.

    Raises
    ------
    InputError, NothingScoredError
        See `scoring.score`; or steps or times that do not match the files.
    """
    known = load_reference(reference)
    told = {"step": steps, "tolerance": tolerances, "cpu": cpu}
    return _series(_files(several(results), known, told), known, told, require)


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
    """A `Report` if the files hold different maneuvers of one run, a `Series` otherwise.

    Parameters and errors are those of `score_series` and `side_by_side.compare`. The series
    is of runs of one program if that is said, by default if there are steps or tolerances, and of
    programs side by side otherwise.
    """
    known = load_reference(reference)
    check_names(names, len(results))
    told = {"step": steps, "tolerance": tolerances, "cpu": cpu}
    files = _files(results, known, told)
    held = [p.number for a in files for p in a.parts]
    if len(set(held)) == len(held) and len(set(names or ())) < 2:
        return scored(merge(files), known, require)
    if is_one_program is None:
        is_one_program = steps is not None or tolerances is not None
    if not is_one_program:
        return side_by_side(files, known, names=names, cpu=cpu, require=require)
    if names is not None:
        raise InputError("name: found with runs of one program, expected it with several programs")
    return _series(files, known, told, require)


# Steps, tolerances and processor times of the files, by the name of the option.
_Told = Mapping[str, Sequence[float | None] | None]


def _files(results: Sequence[Any], reference: Reference, told: _Told) -> list[Alignment]:
    """The files laid beside the reference, once what is told of them fits them."""
    for name, given in told.items():
        if given is None:
            continue
        if len(given) != len(results):
            count = f"{len(given)} for {len(results)} files"
            raise InputError(f"{name}: found {count}, expected as many")
        if name != "tolerance" and not all(x is None or _SHORTEST <= x <= _LONGEST for x in given):
            raise InputError(
                f"{name}: found {list(given)}, expected positive numbers of seconds, "
                f"{_SHORTEST:g} to {_LONGEST:g}"
            )
    return [aligned(results_of(r, len(reference)), reference) for r in results]


def _series(
    files: Sequence[Alignment], known: Reference, told: _Told, require: str | Sequence[str]
) -> Series:
    unknown: Sequence[float | None] = [None] * len(files)
    steps, tolerances, cpu = told["step"], told["tolerance"], told["cpu"]
    is_told = steps is not None or tolerances is not None
    apart = unknown if is_told else [_rows_apart(a) for a in files]
    runs = _runs(files, steps or apart, tolerances or unknown, cpu or unknown)
    told_by = [x for x in ("step", "tolerance") if not _are_unknown([getattr(r, x) for r in runs])]
    if told_by:
        runs.sort(key=lambda run: -getattr(run, told_by[0]))
    if "step" not in told_by:
        runs = [run._replace(step=None) for run in runs]
    findings: list[Finding] = []
    if not told_by and (steps is None or tolerances is not None or set(steps) != {None}):
        findings.append(_steps_unknown(is_told))
    understood = [understand(run.alignment.parts) for run in runs]
    found = _score(runs, understood, known, require)
    convergence = converge(found)
    extrapolated = _extrapolate(runs, convergence)
    # What a definition changes may only show below the errors of the runs themselves.
    understood_better = [*understood, understand(extrapolated)]
    if _definitions(understood_better) != _definitions(understood):
        found = _score(runs, understood_better, known, require)
        convergence = converge(found)
    findings += nothing_shared(convergence, "files share; those of one run go in one file")
    findings += _disagreement(found)
    findings += falling(found, convergence)
    return Series(found, convergence, tuple(findings))


def _steps_unknown(is_told: bool) -> Finding:
    apart = "the rows of several files are equally far apart"
    why = "several files are given as alike" if is_told else apart
    said = (
        f"{why}, so the step sizes do not tell the runs apart; give those of the integrator "
        "(--step) to see the order of convergence, or the tolerances of its solver (--tolerance)"
    )
    return warning("steps_unknown", said)


class _Sized(NamedTuple):
    """A run with its step size [s], tolerance and processor time [s]."""

    alignment: Alignment
    step: float | None
    tolerance: float | None
    cpu: float | None


def _rows_apart(a: Alignment) -> float | None:
    """Median distance of the rows [s]."""
    steps = []
    for p in a.parts:
        apart = np.diff(p.time) + np.diff(p.time_lo)
        if (apart > 0).any():
            steps.append(float(median(apart[apart > 0])))
    return min(steps) if steps else None


def _are_unknown(steps: Sequence[float | None]) -> bool:
    """True if the steps do not tell the runs apart."""
    known = sorted(step for step in steps if step is not None)
    return len(known) < len(steps) or any(b - a <= _SAME_STEP * b for a, b in pairwise(known))


def _runs(files: Sequence[Alignment], *sizes: Sequence[float | None]) -> list[_Sized]:
    """Files of different maneuvers and the same step or tolerance belong to one run."""
    groups: list[list[_Sized]] = []
    for one in (_Sized(*x) for x in zip(files, *sizes, strict=True)):
        group = next((g for g in groups if _belongs(one, g)), None)
        if group is None:
            groups.append(group := [])
        group.append(one)
    return [
        group[0]._replace(
            alignment=merge([run.alignment for run in group]),
            cpu=total([run.cpu for run in group]),
        )
        for group in groups
    ]


def _belongs(one: _Sized, group: Sequence[_Sized]) -> bool:
    held = {p.number for run in group for p in run.alignment.parts}
    is_alike = _same(one.step, group[0].step) or _same(one.tolerance, group[0].tolerance)
    return is_alike and not held & {p.number for p in one.alignment.parts}


def _same(a: float | None, b: float | None) -> bool:
    return a is not None and b is not None and abs(a - b) <= _SAME_STEP * max(a, b)


def _clearest(understood: Sequence[Understandings]) -> dict[str, Understanding]:
    """Each column as taken by the run that leaves the fewest definitions open, the finest such."""
    found: dict[str, Understanding] = {}
    for run in understood:
        for key, u in run.items():
            known = found.get(key)
            if known is None or len(u.indistinguishable) <= len(known.indistinguishable):
                found[key] = u
    return found


def _definitions(understood: Sequence[Understandings]) -> dict[str, Column]:
    return {key: u.column for key, u in _clearest(understood).items()}


def _shared(own: Understandings, clearest: Understandings) -> dict[str, Understanding]:
    """One choice of definitions for the program, unless a run says more against it."""
    shared = {}
    for key, u in own.items():
        clear = clearest[key]
        against = u.odds.get(clear.column.definition)
        is_open = clear.column.definition in u.indistinguishable
        if against is not None and (is_open or against < clear.odds.get(u.column.definition, -inf)):
            u = u.taken_as(clear.column)
        shared[key] = u
    return shared


def _score(
    runs: Sequence[_Sized],
    understood: Sequence[Understandings],
    reference: Reference,
    require: str | Sequence[str],
) -> tuple[Run, ...]:
    """The runs, with the definitions that the clearest of `understood` has."""
    clearest = _clearest(understood)
    return tuple(
        Run(
            scored(run.alignment, reference, require, _shared(own, clearest)),
            run.step,
            run.cpu,
            tolerance=run.tolerance,
        )
        for run, own in zip(runs, understood, strict=False)
    )


def _extrapolate(runs: Sequence[_Sized], convergence: Sequence[Convergence]) -> list[Part]:
    """Richardson extrapolation of the two finest runs, at the times that both have."""
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


def _disagreement(runs: Sequence[Run]) -> list[Finding]:
    """Columns that are taken in different ways: perhaps the files are not of one program."""
    taken: dict[str, set[tuple[str, int, str]]] = {}
    for (_, key), columns in columns_of(runs).items():
        ways = (c.as_understood for c in columns if c is not None)
        taken.setdefault(key, set()).update((u.definition, u.sign, u.unit) for u in ways)
    different = [key for key, ways in taken.items() if len(ways) > 1]
    said = (
        f"{', '.join(different)} of these files have different definitions, signs or units; are "
        "they of one program?"
    )
    return [warning("definitions_differ", said, columns=different)] if different else []
