"""Report the comparison of codes as JSON values, as text, and as a figure."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.showing.document import Block, Chapter, Paragraph, TableBlock
from heyoka_bike.showing.document.text import render
from heyoka_bike.system.machine import installed, machine
from heyoka_bike.system.resources import reference_folder
from heyoka_bike.workbench import style as s
from heyoka_bike.workbench.bench import race
from heyoka_bike.workbench.bench.batches import first_result, floor, long_runs, throughput
from heyoka_bike.workbench.bench.compiled import FLAGS
from heyoka_bike.workbench.bench.precise import costs, precise
from heyoka_bike.workbench.bench.problem import ReferenceProblem, judged
from heyoka_bike.workbench.bench.race import CLASSES, OnPart, Timing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA_VERSION = 1
_ALL_MANEUVERS = "all maneuvers"
_PACKAGES = ("heyoka_bike", "heyoka", "scipy", "scikit-sundae", "exudyn", "numpy")
_TABLE_WIDTH = 170


def measure(
    main: ReferenceProblem, every: Sequence[ReferenceProblem], runs: int, progress: OnPart, *,
    is_quick: bool, with_points: bool, with_costs: bool, folder: str | None,
) -> dict[str, Any]:  # fmt: skip
    """Time every code, and return the measurements as JSON values.

    Parameters
    ----------
    main
        Problems that are timed one by one.
    every
        Problems that are timed together, with other measurements of the fast path and beyond
        binary64; an empty sequence skips all of these.
    runs
        Timed runs of each code.
    is_quick
        True to leave out codes that are slow to build.
    with_points
        True to also measure time over error.
    with_costs
        True to also measure time over duration and over digits.
    folder
        Folder of the reference dataset; None for the published one.
    """
    tasks = {main.maneuver.name: [main]} | ({_ALL_MANEUVERS: list(every)} if every else {})
    results = []
    for name, chosen in tasks.items():
        lines = race.bench(chosen, runs, is_quick=is_quick, progress=progress)
        results += [_result(line, lines, name) for line in lines]
    found = {
        "schema_version": SCHEMA_VERSION,
        "maneuver": main.maneuver.name,
        "rows": main.maneuver.rows,
        "runs": runs,
        "quick": is_quick,
        "machine": machine(),
        "versions": {"python": platform.python_version()}
        | {name: installed(name) or "not installed" for name in _PACKAGES},
        "results": results,
    }
    if every:
        found["floor"] = floor(main.bicycle)
    if with_points:
        found["work_precision"] = race.work_precision(main, progress)
    if every:
        progress("ensembles", 0.3)
        found["ensembles"] = throughput()
        progress("first result of a new process", 0.7)
        found["first_result"] = first_result()
        progress("34 and 70 digits", 0.0)
        found["precise"] = precise(_published(folder))
    if with_costs:
        progress("long runs", 0.0)
        found["durations"] = long_runs(main.bicycle, main.maneuver)
        progress("up to 1000 digits", 0.1)
        found["digits"] = costs(_published(folder))
    return found


def _published(folder: str | None) -> Trajectory:
    return read_candidate(reference_folder() if folder is None else folder)[judged() - 1]


def _result(line: Timing, lines: Sequence[Timing], maneuver: str) -> dict[str, Any]:
    """Return the measurements of a code in a class as JSON values; None marks unknown ones."""
    result: dict[str, Any] = {
        "maneuver": maneuver,
        "class": line.accuracy_class,
        "code": line.code.name,
        "precision": line.code.precision,
        "status": line.status,
    }
    t = line.trial
    result |= {
        "tolerance": t and t.tolerance,
        "order": t and t.order,
        "steps": t and t.count if line.code.counts == "steps" else None,
        "rhs_calls": t and t.count if line.code.counts == "rhs_calls" else None,
        "build_s": t and t.build,
        "performance_percent": t and t.performance,
        "max_state_error": t and t.error,
        "runs": len(line.times),
    }
    if not line.times:
        unknown = ("min_ms", "median_ms", "cold_ms", "ratio_to_fastest")
        return result | dict.fromkeys(unknown)
    group = (x for x in lines if x.times and x.accuracy_class == line.accuracy_class)
    fastest = min(min(x.times) for x in group)
    return result | {
        "min_ms": 1e3 * min(line.times),
        "median_ms": 1e3 * median(line.times),
        "cold_ms": 1e3 * median(line.cold),
        "ratio_to_fastest": min(line.times) / fastest,
    }


def as_text(document: Mapping[str, Any], has_colors: bool = False) -> str:
    """Return the report of a comparison as text."""
    return render(list(_blocks(document)), _TABLE_WIDTH, has_colors)


def _blocks(document: Mapping[str, Any]) -> Iterator[Block]:
    for maneuver in dict.fromkeys(x["maneuver"] for x in document["results"]):
        for name, title in CLASSES.items():
            own = [
                x for x in document["results"] if (x["maneuver"], x["class"]) == (maneuver, name)
            ]
            yield Chapter(f"{maneuver}: {title}", (_timings(own),))
    machine, versions = document["machine"], document["versions"]
    said = (
        *_besides(document),
        f"{document['rows']} rows of all eight columns; times of one run without building; "
        f"the codes of a class run in turns, {document['runs']} times each, slow codes less often",
        "min, median: after runs of the same code; cold: with the processor's caches filled by "
        "other data",
        "ratio: shortest time over that of the fastest code in the class",
        "state error: largest error in the rows of roll and steer [rad], their rates [rad/s] "
        "and the forward speed [m/s]",
        "tolerance: for heyoka_bike about the error of a step; for C RK4 and Exudyn the "
        "step [s]; otherwise relative and absolute (SciPy's relative one at least 2.2e-14)",
        f"C: {' '.join(FLAGS)}",
        f"machine: {machine['cpu']}, {machine['cores']} cores, {machine['system']}",
        "versions: " + ", ".join(f"{k} {v}" for k, v in versions.items()),
    )
    yield from map(Paragraph, said)


def _timings(results: Sequence[Mapping[str, Any]]) -> TableBlock:
    headings = (
        "code", "precision", "tolerance", "count", "runs", "build [s]", "min [ms]",
        "median [ms]", "cold [ms]", "eq. (1) [%]", "state error", "ratio",
    )  # fmt: skip
    rows: list[tuple[str, ...]] = []
    for x in results:
        if x["status"] != "ok":
            blank = ("",) * (len(headings) - 3)
            rows.append((x["code"], x["precision"], x["status"], *blank))
            continue
        count = f"{x['steps']} steps" if x["rhs_calls"] is None else f"{x['rhs_calls']} calls"
        rows.append((
            x["code"], x["precision"], f"{x['tolerance']:.1e}", count, str(x["runs"]),
            f"{x['build_s']:.2f}", f"{x['min_ms']:.3f}", f"{x['median_ms']:.3f}",
            f"{x['cold_ms']:.3f}",
            f"{x['performance_percent']:.1e}", f"{x['max_state_error']:.1e}",
            f"{x['ratio_to_fastest']:.1f}",
        ))  # fmt: skip
    return TableBlock(headings, rows, left=2)


def _besides(document: Mapping[str, Any]) -> Iterator[str]:
    """Yield sentences about the measurements beyond the timings, if the report contains any."""
    yield from (
        f"ensemble, accuracy {x['accuracy']}, {x['threads']} threads: "
        f"{x['motions_per_second']:.0f} motions of 10 s per second"
        for x in document.get("ensembles", ())
    )
    if "first_result" in document:
        first = document["first_result"]
        yield (
            f"first result of a new process: {first['result_s']:.2f} s, after "
            f"{first['import_numpy_s']:.2f} s of importing NumPy"
        )
    yield from (
        f"{x['code']}, {x['digits']:.0f} digits: {x['seconds']:.3g} s, error {x['error']:.0e} "
        f"(measured over {x['measured_over']:.2g} s)"
        for x in document.get("precise", ())
    )
    yield from (
        f"{x['duration']} s at accuracy {x['accuracy']}: {1e3 * x['time']:.3g} ms, {x['steps']} "
        f"steps, eq. (1) {x['performance']:.1e} %, error at the end {x['error']:.0e}"
        for x in document.get("durations", ())
    )
    yield from (
        f"{x['digits']:.0f} digits: order {x['order']}, {x['seconds_per_step']:.3g} s a step, "
        f"{x['seconds']:.3g} s for the maneuver ({x['steps']} steps timed)"
        for x in document.get("digits", ())
    )


_FIGURE_SIZE = (7.0, 4.6)  # [inch], as wide as the text of a printed page
COLOURS = (s.VERMILLION, s.ORANGE, s.BLUE, s.SKY, s.GREEN, s.PURPLE, s.BLACK, s.GREY)
MARKERS = "osD^vP*X"


def draw(points: Sequence[Mapping[str, Any]], title: str) -> Figure:
    """Draw the points of a report's ``work_precision``, one line for each code.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed.
    """
    with s.style():
        from matplotlib.figure import Figure

        figure = Figure(figsize=_FIGURE_SIZE, layout="constrained")
        ax = figure.subplots()
        for i, name in enumerate(dict.fromkeys(x["code"] for x in points)):
            line = [x for x in points if x["code"] == name]
            ax.loglog(
                [x["max_state_error"] for x in line],
                [x["min_ms"] for x in line],
                color=COLOURS[i % len(COLOURS)],
                marker=MARKERS[i % len(MARKERS)],
                markersize=3,
                label=name,
            )
        # Invert the axis, so that higher accuracy is to the right.
        ax.invert_xaxis()
        ax.set_xlabel("largest error of roll, steer [rad], their rates [rad/s] and speed [m/s]")
        ax.set_ylabel("shortest time, rows included [ms]")
        ax.set_title(title, parse_math=False)
        ax.legend()
    return figure
