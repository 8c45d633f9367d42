"""Reports constructed from the reference, for the tests of the output formats."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reference.load import Reference, ReferenceManeuver, load_reference
from heyoka_bike.scoring.alignment import FileInfo, Part
from heyoka_bike.scoring.evidence.as_read import NotFinite
from heyoka_bike.scoring.evidence.base import LostColumn
from heyoka_bike.scoring.evidence.column_meaning import (
    OtherDefinition,
    OtherSign,
    TakenDefinition,
    UnitContradicted,
)
from heyoka_bike.scoring.evidence.several_runs import DefinitionsOfPrograms, ErrorFalls
from heyoka_bike.scoring.measures import growth, measures
from heyoka_bike.scoring.outcomes import LeftOut, Requirement, WorstValue
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Convergence, Run, Series
from heyoka_bike.scoring.scores import (
    Alternative,
    ColumnScore,
    Consistency,
    ManeuverScore,
    Measures,
    Reading,
    Trace,
)
from heyoka_bike.scoring.verdict import meets_limit

NOTHING = Measures(None, None, None, None, None, None, None)
HOSTILE = "a<script>alert(1)</script><b onclick=alert(1)>&\"'\x1b[31m\x00\udcff￾\n.txt"
"""A file name that every format must treat as text."""

_DEFINITION = {"roll_angle": "tait_bryan_xyz", "forward_speed": "wheel_spin"}
_MANEUVERS = (1, 2, 3)
_FLOOR = 5e-13


def sample(size: float = 1e-5, path: str = "runs/other-h0.001.txt") -> Report:
    """Return a report on three maneuvers with growing errors and all kinds of findings."""
    reference = _reference()
    return _report(reference, path, tuple(_maneuver(reference, n, size) for n in _MANEUVERS))


def perfect() -> Report:
    """Return a report on a file without errors."""
    return sample(0.0)


def rough() -> Report:
    """Return a report with faults other than wrong values, which fails its requirements."""
    report = sample(3.0)
    failed = Requirement("scd >= 6", False, -0.5, WorstValue(-0.5, 1, "roll_angle"))
    return replace(report, requirements=(*report.requirements, failed))


def one_row() -> Report:
    """Return a report on a file with a single row."""
    return _cut(sample(), slice(500, 501))


def half() -> Report:
    """Return a report on the first half of the run only."""
    return _cut(sample(), slice(0, 501))


def without_columns() -> Report:
    """Return a report on a maneuver without comparable columns, and one without columns."""
    report = sample()
    first, second, third = report.maneuvers
    columns = tuple(_uncompared(c) for c in first.columns)
    empty = Consistency(None, None, None, None)
    return replace(
        report,
        maneuvers=(
            replace(first, columns=columns, performance=None, step=None, consistency=empty),
            replace(second, columns=(), performance=None, consistency=empty),
            replace(third, columns=third.columns[2:5]),
        ),
    )


def nothing() -> Report:
    """Return a report in which everything that can be unknown is unknown."""
    report = without_columns()
    file = replace(report.file, significant_digits=None)
    return replace(report, file=file, maneuvers=report.maneuvers[:2], seen=())


def no_maneuvers() -> Report:
    """Return a report without maneuvers."""
    return replace(sample(), maneuvers=(), seen=(), requirements=())


def hostile() -> Report:
    """Return a report with markup and control characters in every text from files or users."""
    report = sample(path=HOSTILE)
    requirement = Requirement(HOSTILE, False, None, LeftOut((LostColumn(HOSTILE),)))
    odd = UnitContradicted(HOSTILE, HOSTILE, HOSTILE)
    maneuvers = tuple(replace(m, name=HOSTILE) for m in report.maneuvers)
    return replace(
        report, bicycle=HOSTILE, maneuvers=maneuvers, seen=(odd,), requirements=(requirement,)
    )


def many_rows(rows: int) -> Report:
    """Return a report on a file of many rows: a trace with a single outlier."""
    report = sample()
    return replace(
        report,
        maneuvers=tuple(
            replace(m, rows=rows, columns=tuple(_stretched(c, rows) for c in m.columns))
            for m in report.maneuvers
        ),
    )


def series(cpu: bool = True, steps: bool = True) -> Series:
    """Return four runs of a method of order 4, whose energies reach their floor."""
    sizes = (0.01, 0.005, 0.0025, 0.00125)
    runs = tuple(
        Run(
            sample(1e3 * h**4, f"runs/other-h{h:g}.txt"),
            h if steps else None,
            0.02 / h if cpu else None,
        )
        for h in sizes
    )
    falls = ErrorFalls("step", exponent=4.0, least=3.9, most=4.1, columns=24)
    convergence = []
    for i, m in enumerate(runs[-1].report.maneuvers):
        for j, c in enumerate(m.columns):
            errors = tuple(
                r.report.maneuvers[i].columns[j].as_understood.measures.max_abs_error for r in runs
            )
            orders = tuple(
                float(np.log2(a / b)) if steps and b > 1e-6 else None for a, b in pairwise(errors)
            )
            convergence.append(
                Convergence(
                    m.maneuver, c.key, c.unit, c.as_understood.definition, errors, orders,
                    errors[-1] / 40 if steps else None, c.floor,
                )
            )  # fmt: skip
    return Series(runs, tuple(convergence), (falls,))


def programs() -> Series:
    """Return three programs: a right one, one with a hostile name, and a wrong one."""
    runs = tuple(
        Run(sample(size, f"runs/{i}.txt"), None, None, name)
        for i, (size, name) in enumerate(((1e-9, "Fine"), (1e-5, HOSTILE), (3.0, "Rough")))
    )
    convergence = tuple(
        Convergence(
            m.maneuver, c.key, c.unit, c.as_understood.definition,
            tuple(
                r.report.maneuvers[i].columns[j].as_understood.measures.max_abs_error for r in runs
            ),
            (None, None), None, None,
        )
        for i, m in enumerate(runs[0].report.maneuvers)
        for j, c in enumerate(m.columns)
    )  # fmt: skip
    differ = DefinitionsOfPrograms("roll_angle", {"lean": ("Fine",), HOSTILE: ("Rough",)})
    return Series(runs, convergence, (differ,), is_one_program=False)


@cache
def _reference() -> Reference:
    return load_reference()


def _report(reference: Reference, path: str, maneuvers: tuple[ManeuverScore, ...]) -> Report:
    both = (1e-05, 2e-05, 3e-05), (0.057, 0.031, 0.0049)
    taken = TakenDefinition("roll_angle", "tait_bryan_xyz", None, ())
    seen = (
        OtherDefinition("roll_angle", *both, taken, "lean", (0.057, 0.031, 0.0049)),
        OtherSign("steer_angle", *both),
        NotFinite(3, counted_by="row", line=7, column=2),
    )
    requirements = (
        Requirement("2.roll_angle.scd >= 3", True, 3.9, WorstValue(3.9, 2, "roll_angle")),
        Requirement("performance < 1e-3", True, 5.3e-6, WorstValue(5.3e-6, 1)),
    )
    info = FileInfo(path, "text", 1001, 0.0, 10.0, 12)
    return Report(
        reference.dataset_version, reference.bicycle, info, maneuvers, seen, requirements,
        reference_sha256=reference.content_sha256,
    )  # fmt: skip


def _maneuver(reference: Reference, number: int, size: float) -> ManeuverScore:
    m = reference[number]
    columns = tuple(_column(m, key, size) for key in BENCHMARK_COLUMNS)
    found = ManeuverScore(
        maneuver=number, name=m.name, rows=len(m.time), t_start=0.0, t_end=10.0, coverage=1.0,
        gap=0.01, step=0.01, performance=0.53 * size,
        performance_limit=1e-3 if number == 2 else None,
        consistency=Consistency(1e-9, 5e-10, 1.2e-5, None), columns=columns,
        part=Part(m.time, m.time_lo, {}, maneuver=number, reference=m),
    )  # fmt: skip
    return replace(found, meets_limit=meets_limit(found))


def _column(m: ReferenceManeuver, key: str, size: float) -> ColumnScore:
    definitions = DEFINITIONS[key]
    name = _DEFINITION.get(key, definitions[0].definition)
    column = next(c for c in definitions if c.definition == name)
    right = m.rows[column.name]
    scale = float(np.max(np.abs(right)))
    t = m.time
    phase = BENCHMARK_COLUMNS.index(key)
    error = size * scale * np.expm1(0.4 * t) / np.expm1(4) * np.sin(2.0 * t + phase) * (1 + phase)
    if "energy" in key:
        error = 1e-3 * error
    turned = key in ("steer_angle", "steer_rate")
    shifted = key in ("potential_energy", "mechanical_energy")
    found = measures(t, error, right, scale)
    understood = Reading(
        name, -1 if turned else 1, column.unit, -794.1195 if shifted else 0.0, found
    )
    if key == "roll_rate":
        understood = replace(understood, unit="deg s-1")
    default = definitions[0]
    written = -right - error if turned else right + error
    as_written = Reading(
        default.definition, 1, default.unit, 0.0,
        measures(t, written - m.rows[default.name], right, scale),
    )  # fmt: skip
    return ColumnScore(
        key=key,
        unit=column.unit,
        as_written=as_written,
        as_understood=understood,
        floor=_FLOOR * scale,
        alternatives=tuple(
            Alternative(c.definition, float(np.max(np.abs(right + error - m[c.name]))))
            for c in definitions
            if c is not column
        ),
        indistinguishable=("zyx_rate",) if key == "roll_rate" else (),
        growth=growth(t, error, 10.0),
        values=len(t),
        missing=0,
        trace=Trace(t, right + error, error),
        scale=scale,
        unexplained=max(float(np.max(np.abs(error))) - _FLOOR * scale, 0.0),
        resolution=_FLOOR * scale,
    )


def _cut(report: Report, rows: slice) -> Report:
    return replace(report, maneuvers=tuple(_cut_maneuver(m, rows) for m in report.maneuvers))


def _cut_maneuver(m: ManeuverScore, rows: slice) -> ManeuverScore:
    columns = []
    for c in m.columns:
        t = c.trace
        cut = Trace(t.time[rows], t.value[rows], t.error[rows])
        scale = float(np.max(np.abs(t.reference)))
        found = measures(cut.time, cut.error, cut.reference, scale)
        columns.append(
            replace(
                c, trace=cut, values=len(cut.time),
                as_understood=replace(c.as_understood, measures=found),
            )
        )  # fmt: skip
    start, end = float(cut.time[0]), float(cut.time[-1])
    return replace(
        m, columns=tuple(columns), rows=len(cut.time), t_start=start, t_end=end,
        coverage=(end - start) / 10, step=0.01 if len(cut.time) > 1 else None,
    )  # fmt: skip


def _uncompared(c: ColumnScore) -> ColumnScore:
    none = np.empty(0)
    return replace(
        c,
        as_written=replace(c.as_written, measures=NOTHING),
        as_understood=replace(c.as_understood, measures=NOTHING),
        floor=None,
        alternatives=tuple(replace(a, max_abs_error=None) for a in c.alternatives),
        growth=tuple(replace(g, max_abs_error=None) for g in c.growth),
        values=0,
        missing=1001,
        trace=Trace(none, none, none),
    )


def _stretched(c: ColumnScore, rows: int) -> ColumnScore:
    t = np.linspace(0.0, 10.0, rows)
    value, reference, error = (
        np.interp(t, c.trace.time, v) for v in (c.trace.value, c.trace.reference, c.trace.error)
    )
    # Add rounding errors, and one bad row that must remain visible in the chart.
    error = error + 1e-7 * np.sin(1e6 * t)
    error[rows // 3] = 5.0
    value[rows // 3] = reference[rows // 3] + 5.0
    scale = float(np.max(np.abs(reference)))
    found = replace(c.as_understood, measures=measures(t, error, reference, scale))
    return replace(c, as_understood=found, values=rows, trace=Trace(t, value, error))
