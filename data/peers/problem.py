"""The problem that programs get, of the benchmark or the extended set, and their true errors."""

import math
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from apart import FailedError

from heyoka_bike import load_reference, read_results, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.reference.manifest import MANIFEST
from heyoka_bike.workbench.leaderboard.ranking import PROBLEMS, correct_digits, other_definitions

DATA = Path(__file__).resolve().parent.parent
H1 = "H1"
# Neither its roll rate nor a digit of its result is of binary64, in which the programs compute.
BEYOND = "H3g"
ALL_DIGITS = 17
# Digits that a result file has beyond those that are right, and at least.
SPARE, FEWEST = 2, 3


def problems(name):
    """Those that a name stands for: H3 is six."""
    return [x for x in PROBLEMS if x.startswith(name) and x != BEYOND]


def number(text):
    """Value of a decimal, or of a quotient with pi on top, such as ``pi/10``."""
    top, _, bottom = text.partition("/")
    return (np.pi if top.strip() == "pi" else float(top)) / float(bottom or 1)


@dataclass(frozen=True)
class Problem:
    """Inputs of a problem; z is down.

    Attributes
    ----------
    name
    bicycle : dict of str to float
        Parameters.
    starts : list of list of float
        Speed and roll rate of each maneuver.
    numbers : tuple of int
        Of the maneuvers in their set.
    rate, rows : int
        Rows per second, and of each maneuver.
    seconds
        Of all maneuvers.
    """

    name: str
    bicycle: dict
    starts: list
    numbers: tuple
    rate: int
    rows: int
    seconds: float

    @classmethod
    def of(cls, name):
        """The problem that is called so."""
        asked = PROBLEMS[name]
        read = [
            tomllib.loads((DATA / folder / f"{file}.toml").read_text(encoding="utf-8"))
            for folder, file in zip(("bicycles", "maneuvers"), asked.inputs, strict=True)
        ]
        numbers = asked.numbers(len(read[1]["maneuver"]))
        maneuvers = [
            {key: number(m[key]["value"]) for key in ("speed", "roll_rate", "duration", "spacing")}
            for m in (read[1]["maneuver"][n - 1] for n in numbers)
        ]
        return cls(
            name,
            {key: number(entry["value"]) for key, entry in read[0]["parameters"].items()},
            [[m["speed"], m["roll_rate"]] for m in maneuvers],
            numbers,
            round(1 / maneuvers[0]["spacing"]),
            round(maneuvers[0]["duration"] / maneuvers[0]["spacing"]) + 1,
            sum(m["duration"] for m in maneuvers),
        )

    @property
    def only(self):
        """The number of its maneuver if it has one; what a file of nine columns does not say."""
        return self.numbers[0] if len(self.numbers) == 1 else None

    def reference(self, sets, how=None):
        """That of this problem, below a folder of sets if it does not come with the project.

        Where it is not there its rows may be made instead, and kept there: `rows_alone`.
        """
        if self.name == H1:
            return load_reference()
        names = PROBLEMS[self.name].inputs
        folder = sets / names[1]
        if how and not (folder / MANIFEST).exists():
            from rows_alone import rows_alone

            return rows_alone(*names, self.numbers, folder, how)
        return load_reference(folder)

    def text(self, rows, digits):
        """A result file: rows of the columns of all maneuvers, each column in digits of its own."""
        lines = [" ".join(f"{x:.{n}g}" for x, n in zip(row, digits, strict=True)) for row in rows]
        return "".join(f"{i / self.rate:g} {line}\n" for i, line in enumerate(lines))

    def report(self, text, reference):
        """What `score` says of a result file."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "run.txt"
            path.write_text(text, encoding="utf-8")
            return score([read_results(path, maneuver=self.only, count=len(reference))], reference)

    def judge(self, text, reference):
        """Correct digits of columns, maneuvers and the worst, eq. (1), definitions of a file.

        Raises
        ------
        FailedError
            A column or its energy is infinite.
        """
        report = self.report(text, reference)
        scores = correct_digits(report)
        worst = min(scores, key=scores.__getitem__)
        drifts = [m.performance for m in report.maneuvers]
        if None in drifts or not np.isfinite([scores[worst], *drifts]).all():
            raise FailedError(f"{worst[1]} of maneuver {worst[0]}, or its energy, is infinite")
        return {
            "digits": round(scores[worst], 3),
            "worst": {"maneuver": worst[0], "column": worst[1]},
            "scd": {
                key: round(min(x for (_, k), x in scores.items() if k == key), 3)
                for key in BENCHMARK_COLUMNS
            },
            "maneuvers": [
                {**_worst_of(m.maneuver, scores), "performance": m.performance}
                for m in report.maneuvers
            ],
            "definitions": other_definitions(report),
        }

    def shortened(self, text, reference):
        """A result file with the digits that are right and two more.

        The mechanical energy has those that show eq. (1) as well.
        """
        report, digits = self.report(text, reference), []
        right = correct_digits(report)
        for m in report.maneuvers:
            constant = -math.log10(max(m.performance / 100, 10.0**-ALL_DIGITS))
            for key in BENCHMARK_COLUMNS:
                here = right[m.maneuver, key]
                told = max(here, constant) if key == "mechanical_energy" else here
                digits.append(min(max(math.ceil(told) + SPARE, FEWEST), ALL_DIGITS))
        rows = ([float(x) for x in line.split()[1:]] for line in text.splitlines())
        return self.text(rows, digits)


def _worst_of(maneuver, scores):
    """Correct digits of a maneuver, those of its worst column."""
    digits, column = min((x, key) for (number, key), x in scores.items() if number == maneuver)
    return {"maneuver": maneuver, "digits": round(digits, 3), "worst": column}
