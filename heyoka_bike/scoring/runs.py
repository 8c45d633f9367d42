"""Several runs of one program, or several programs: what their scores tell together."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from heyoka_bike.errors import unknown_word
from heyoka_bike.scoring.evidence.base import Evidence
from heyoka_bike.scoring.findings import Finding
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scored import Scored


@dataclass(frozen=True, slots=True)
class Convergence:
    """One column over several runs of one program at different step sizes.

    Attributes
    ----------
    maneuver, key, unit
    definition
        Of the last run that has the column; another one of a run is said in the findings.
    errors : tuple of float or None
        Largest absolute error of each run, in the order of the runs [SI unit].
    orders : tuple of float or None
        Observed order between neighbouring runs, log(e1 / e2) / log(h1 / h2); None where an error
        is at its floor or the step sizes are unknown.
    richardson_error
        Largest error of the Richardson extrapolation of the two finest runs, on their common
        times [SI unit]: what is reachable with them; None without an order.
    floor
        What the digits written by the finest run allow [SI unit]; None of several programs.
    """

    maneuver: int
    key: str
    unit: str
    definition: str
    errors: tuple[float | None, ...]
    orders: tuple[float | None, ...]
    richardson_error: float | None
    floor: float | None


@dataclass(frozen=True, eq=False, slots=True)
class Run:
    """One run of a program, or one of several programs, in a series.

    Attributes
    ----------
    report : Report
    step
        Step size [s]; None if unknown.
    cpu
        Processor time [s]; None if not given.
    name
        Of the program or of the run; empty for the name of its file.
    tolerance
        Of a solver that chooses its steps; None if unknown.
    """

    report: Report
    step: float | None
    cpu: float | None
    name: str = ""
    tolerance: float | None = None


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Series(Scored):
    """Several runs of one program, the coarsest first, or several programs side by side.

    ``series[0]`` is the report of the first, ``series["name"]`` that of a program.

    Attributes
    ----------
    runs : tuple of Run
    convergence : tuple of Convergence
    seen : tuple of Evidence
        What the runs tell together; what was seen in one is in its report.
    is_one_program
        Whether the runs are of one program at different steps or tolerances: it has one choice of
        definitions, and an order of convergence. Programs are judged each by itself.
    """

    runs: tuple[Run, ...]
    convergence: tuple[Convergence, ...]
    seen: tuple[Evidence, ...]
    is_one_program: bool = True

    def __getitem__(self, which: int | str) -> Report:
        if isinstance(which, int):
            return self.runs[which].report
        for run in self.runs:
            if run.name == which:
                return run.report
        names = [run.name for run in self.runs if run.name] or ["the number of a run"]
        raise KeyError(unknown_word(which, names, "program "))

    def __iter__(self) -> Iterator[Report]:
        return (run.report for run in self.runs)

    def __len__(self) -> int:
        return len(self.runs)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is said of the series; that of a run is in its report."""
        return tuple(e.finding() for e in self.seen)

    @property
    def passed(self) -> bool:
        """True if every requirement is met by every run."""
        return all(run.report.passed for run in self.runs)
