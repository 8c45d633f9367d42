"""The tables and figures of the pages on speed, from a run of `heyoka-bike bench`.

The run is docs/speed.json, the pages are docs/speed.md and docs/reference/speed-tables.md.

Run as a script, this writes them; with ``--measure`` it first carries out ``heyoka-bike bench --all
--costs --format json -o docs/speed.json`` and makes the reference in a folder that goes again, on a
machine that has nothing else to do.
"""

import json
import sys
import time
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.figure import Figure

import heyoka_bike
import marked_parts
from heyoka_bike.bicycle.parameters import Maneuver, read_bicycle, read_maneuvers
from heyoka_bike.cli import main
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.load import load_reference
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers
from heyoka_bike.workbench.bench.problem import ReferenceProblem
from heyoka_bike.workbench.bench.race import CLASSES
from heyoka_bike.workbench.bench.summary import COLOURS, MARKERS, draw
from heyoka_bike.workbench.fast.simulate import ACCURACIES, simulate
from heyoka_bike.workbench.style import render, style

DOCS = Path(__file__).parent.parent
PAGE, RUN = DOCS / "speed.md", DOCS / "speed.json"
TABLES = DOCS / "reference" / "speed-tables.md"
_IN_TABLES = {
    "one-state_error", "one-roundoff", "all-performance", "all-state_error", "all-roundoff",
    "precise", "digits", "durations", "generate", "floor",
}  # fmt: skip
FIGURES = {"speed.svg": "work_precision", "speed-costs.svg": "digits"}

TUNED, TAYLOR = "heyoka_bike simulate", "heyoka unrolled"
RACE = ("code", "min [ms]", "median [ms]", "over `simulate`", "eq. (1) [%]", "state error")
STAGE_NAMES = {
    "integrate": "integrated in 70 digits",
    "certify": "enclosed",
    "rows": "rows rounded, dense output",
    "motion": "places and forces",
    "vary": "derivatives",
}
STATE_COLUMNS = ("roll_angle", "steer_angle", "roll_rate", "steer_rate", "forward_speed")
SEED = 7
# The example of a code that keeps the energy: the implicit midpoint rule at this step [s].
STEP = 0.125
COST_SIZE = (7.0, 3.2)  # [inch]


def table(headings, rows, left=1):
    """Lines of a table in Markdown; the first columns are aligned to the left."""
    rule = ["---"] * left + ["---:"] * (len(headings) - left)
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (headings, rule, *rows))


def races(run):
    """The tables of the codes, by the marker of their place."""
    found = {}
    for maneuver, short in ((run["maneuver"], "one"), ("all maneuvers", "all")):
        for name in CLASSES:
            lines = [
                x
                for x in run["results"]
                if (x["maneuver"], x["class"]) == (maneuver, name) and x["status"] == "ok"
            ]
            ours = next(x for x in lines if x["code"] == TUNED)["median_ms"]
            found[f"{short}-{name}"] = table(
                RACE,
                [
                    (
                        x["code"] + (" in binary128" if x["precision"] == "binary128" else ""),
                        f"{x['min_ms']:.3g}", f"{x['median_ms']:.3g}",
                        f"{x['median_ms'] / ours:.2f}" if x["median_ms"] < 10 * ours
                        else f"{x['median_ms'] / ours:.0f}",
                        f"{x['performance_percent']:.1e}", f"{x['max_state_error']:.1e}",
                    )
                    for x in sorted(lines, key=lambda x: x["median_ms"])
                ],
            )  # fmt: skip
    return found


def floor_seconds(order, steps, *, products_per_second, products, scales):
    """Of the products alone of so many Taylor steps of an order."""
    return steps * (order + 1) * (products * (order + 2) / 2 + scales) / products_per_second


def floor_table(run):
    """Times over that of the products alone of heyoka's Taylor steps, maneuver 2."""
    rows = []
    for name in CLASSES:
        lines = {
            x["code"]: x
            for x in run["results"]
            if (x["maneuver"], x["class"]) == (run["maneuver"], name)
            and x["precision"] == "binary64"
        }
        taylor, c = lines[TAYLOR], [x for x in lines.values() if x["code"].startswith("C ")]
        floor = 1e3 * floor_seconds(taylor["order"], taylor["steps"], **run["floor"])
        best = min((x for x in c if x["status"] == "ok"), key=lambda x: x["min_ms"])
        rows.append((
            name.replace("_", " "), f"{taylor['steps']} of order {taylor['order']}",
            f"{floor:.4f}", f"{taylor['min_ms'] / floor:.1f}",
            f"{lines[TUNED]['min_ms'] / floor:.1f}",
            f"{best['min_ms'] / floor:.1f} ({best['code']})",
        ))  # fmt: skip
    headings = ("class", "Taylor steps", "floor [ms]", TAYLOR, "`simulate`", "best in C")
    return table(headings, rows, left=2)


def generate():
    """How long it takes to make the reference [s]: in all, and by maneuver and job."""
    with TemporaryDirectory() as folder:
        start = time.monotonic()
        made = heyoka_bike.generate(folder)
        wall = time.monotonic() - start
    return {"wall_s": wall, "cpu_s": {t.maneuver.name: dict(t.seconds) for t in made.tables}}


def generate_table(found):
    """Processor time of each job and maneuver [s]."""
    jobs = found["cpu_s"]
    rows = [
        (STAGE_NAMES[stage], *(f"{x[stage]:.1f}" for x in jobs.values())) for stage in STAGE_NAMES
    ]
    sums = [f"{sum(x.values()):.1f}" for x in jobs.values()]
    return table(("processor time [s]", *jobs), [*rows, ("all", *sums)])


def shown(run):
    """The parts of the page that show the run, by their markers."""
    m, versions = run["machine"], run["versions"]
    first = run["first_result"]
    return races(run) | {
        "machine": f"{m['cpu']}, {m['cores']} cores, {m['system']}; "
        + ", ".join(f"{name} {v}" for name, v in versions.items())
        + f"; {run['runs']} runs of each code, fewer of a slow one.",
        "floor": floor_table(run),
        "ensembles": table(
            ("accuracy", "threads", "motions of 10 s per second"),
            [
                (str(x["accuracy"]), str(x["threads"]), f"{x['motions_per_second']:,.0f}")
                for x in run["ensembles"]
            ],
        ),
        "first": f"{first['result_s']:.2f} s, after {first['import_numpy_s']:.2f} s of importing "
        "NumPy",
        "generate": generate_table(run["generate"]),
        "generate-wall": f"{run['generate']['wall_s']:.0f} s",
        "precise": table(
            ("code", "digits", "time [s]", "measured over [s]", "error"),
            [
                (x["code"], f"{x['digits']:.0f}", f"{x['seconds']:.3g}",
                 f"{x['measured_over']:.2g}", f"{x['error']:.0e}")
                for x in run["precise"]
            ],
        ),
        "digits": table(
            ("digits", "order", "steps timed", "a step [s]", "10 s [s]"),
            [
                (f"{x['digits']:.0f}", str(x["order"]), str(x["steps"]),
                 f"{x['seconds_per_step']:.2g}", f"{x['seconds']:.3g}")
                for x in run["digits"]
            ],
        ),
        "durations": table(
            ("duration [s]", "accuracy", "steps", "time [ms]", "eq. (1) [%]", "error at the end"),
            [
                (f"{x['duration']:,}", str(x["accuracy"]), f"{x['steps']:,}",
                 f"{1e3 * x['time']:.3g}", f"{x['performance']:.1e}", f"{x['error']:.0e}")
                for x in run["durations"]
            ],
        ),
    }  # fmt: skip


def computed():
    """The parts of the page that have no times in them."""
    return {
        "energy": energy_table(energy_alone()),
        "accuracies": accuracy_table(accuracies()),
    }


def energy_alone():
    """Eq. (1) [%] and relative error of the roll angle, by maneuver: the implicit midpoint rule."""
    bicycle, reference = read_bicycle(benchmark_bicycle()), load_reference()
    found = []
    for number, maneuver in enumerate(read_maneuvers(benchmark_maneuvers()), start=1):
        problem = ReferenceProblem(bicycle, maneuver, reference[number])
        states = midpoint(problem.slope[0], problem.start(float), float(maneuver.duration))
        roll, energy = problem.columns()(states)[[0, 5]]
        right = reference[number].evaluate(STEP * np.arange(len(roll)), ("roll_angle",))
        largest = np.abs(reference[number].rows["roll_angle"]).max()
        wrong = np.abs(roll - right["roll_angle"]).max() / largest
        found.append((100 * np.ptp(energy) / energy[0], wrong))
    return found


def midpoint(slope, start, duration):
    """States of the implicit midpoint rule at steps of `STEP`, by Newton's method."""
    states = [start]
    for _ in range(round(duration / STEP)):
        y, z = states[-1], states[-1]
        for _ in range(20):
            middle = (y + z) / 2
            matrix = np.eye(6) - STEP / 2 * jacobian(slope, middle)
            change = np.linalg.solve(matrix, y + STEP * slope(0.0, middle) - z)
            z = z + change
            # Newton's method has converged to the rounding of a state near 5.
            if np.abs(change).max() < 1e-13:
                break
        states.append(z)
    return np.array(states)


def jacobian(slope, y, step=1e-6):
    """By central differences: Newton's method needs it to a few digits."""
    unit = step * np.eye(6)
    return np.array([(slope(0, y + e) - slope(0, y - e)) / (2 * step) for e in unit]).T


def accuracies():
    """Largest error of the state and eq. (1) [%], by accuracy: three maneuvers and 20 other starts.

    The error is against the reference in the maneuvers, and against `simulate`'s own run at
    roundoff elsewhere.
    """
    random = np.random.default_rng(SEED)
    maneuvers = [
        *read_maneuvers(benchmark_maneuvers()),
        *(
            Maneuver(
                "other", decimal(random.uniform(4.3, 9)), decimal(random.uniform(-0.5, 0.5)),
                Fraction(10), Fraction(1, 100), steer_rate=decimal(random.uniform(-0.4, 0.4)),
            )
            for _ in range(20)
        ),
    ]  # fmt: skip
    right = [
        *(m.rows.hi for m in load_reference().values()),
        *(simulate(m, accuracy="roundoff") for m in maneuvers[3:]),
    ]
    found = {}
    for accuracy in ACCURACIES:
        wrong, drift = [], []
        for m, exact in zip(maneuvers, right, strict=True):
            run = simulate(m, accuracy=accuracy)
            wrong += [np.abs(run[name] - exact[name]).max() for name in STATE_COLUMNS]
            energy = run["mechanical_energy"]
            drift.append(100 * np.ptp(energy) / energy[0])
        found[accuracy] = max(wrong), max(drift)
    return found


def decimal(x):
    return Exact(Fraction(round(1000 * x), 1000))


def accuracy_table(found):
    return table(
        ("accuracy", "tolerance of a step", "largest error", "largest eq. (1) [%]"),
        [
            (str(a), f"{ACCURACIES[a]:g}", f"{wrong:.1e}", f"{drift:.1e}")
            for a, (wrong, drift) in found.items()
        ],
    )  # fmt: skip


def energy_table(found):
    return table(
        ("maneuver", "eq. (1) [%]", "largest error of the roll angle, of its largest value"),
        [
            (str(i), f"{performance:.1e}", f"{100 * wrong:.0f} %")
            for i, (performance, wrong) in enumerate(found, start=1)
        ],
    )


def filled(page, found):
    """The page with its generated parts replaced."""
    for name, text in found.items():
        page = marked_parts.filled(page, name, text)
    return page


def pages(found):
    """The pages with their generated parts replaced, by file."""
    tables = {name: found[name] for name in _IN_TABLES & found.keys()}
    rest = {name: text for name, text in found.items() if name not in _IN_TABLES}
    return {
        page: filled(page.read_text(encoding="utf-8"), parts)
        for page, parts in ((PAGE, rest), (TABLES, tables))
    }


def draw_costs(digits, durations):
    """Time against digits and against duration, all axes logarithmic."""
    with style():
        figure = Figure(figsize=COST_SIZE, layout="constrained")
        left, right = figure.subplots(1, 2)
        left.loglog(
            [x["digits"] for x in digits], [x["seconds"] for x in digits], color=COLOURS[2],
            marker="o", markersize=3,
        )  # fmt: skip
        left.set_xlabel("decimal digits of the significand")
        left.set_ylabel("time of 10 s of maneuver 2 [s]")
        for i, accuracy in enumerate(dict.fromkeys(x["accuracy"] for x in durations)):
            line = [x for x in durations if x["accuracy"] == accuracy]
            right.loglog(
                [x["duration"] for x in line], [1e3 * x["time"] for x in line],
                color=COLOURS[2 * i % len(COLOURS)], marker=MARKERS[i], markersize=3,
                label=str(accuracy),
            )  # fmt: skip
        right.set_xlabel("duration [s]")
        right.set_ylabel("time, 1001 rows included [ms]")
        right.legend(title="accuracy", title_fontsize=7.5)
    return figure


def figures(run):
    title = f"{run['maneuver']}, 1001 rows, {run['machine']['cpu']}"
    drawn = (draw(run["work_precision"], title), draw_costs(run["digits"], run["durations"]))
    return {name: render(x, "svg") for name, x in zip(FIGURES, drawn, strict=True)}


if __name__ == "__main__":
    if sys.argv[1:] == ["--measure"]:
        made = generate()
        main(["bench", "--all", "--costs", "--format", "json", "-o", str(RUN)])
        RUN.write_text(
            json.dumps(json.loads(RUN.read_text()) | {"generate": made}, indent=2) + "\n"
        )
    document = json.loads(RUN.read_text())
    for page, text in pages(shown(document) | computed()).items():
        page.write_text(text, encoding="utf-8")
    for file, data in figures(document).items():
        (DOCS / file).write_bytes(data)
