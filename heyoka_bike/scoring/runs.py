"""Several runs of one program, or several programs, and the evidence of their joint scores."""

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
    """The errors of one column in several runs of a program with different step sizes.

    Attributes
    ----------
    maneuver, key, unit
    definition
        The definition in the last run that has the column; findings report runs that differ.
    errors : tuple of float or None
        Largest absolute error of each run, in the order of the runs [SI unit].
    orders : tuple of float or None
        Observed order between neighbouring runs, log(e1 / e2) / log(h1 / h2); None where an error
        is at its floor or the step sizes are unknown.
    richardson_error
        Largest error of the Richardson extrapolation of the two finest runs, at their common
        times [SI unit]: the error that these runs can reach; None without an order.
    floor
        Smallest error that the digits of the finest run can show [SI unit]; None for several
        programs.
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
        Name of the program or of the run; empty for the name of its file.
    tolerance
        Tolerance of a solver that chooses its steps; None if unknown.
    """

    report: Report
    step: float | None
    cpu: float | None
    name: str = ""
    tolerance: float | None = None


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class Series(Scored):
    """Several runs of one program, the coarsest first, or several programs side by side.

    ``series[0]`` is the first report, ``series["name"]`` the report of that program.

    Attributes
    ----------
    runs : tuple of Run
    convergence : tuple of Convergence
    seen : tuple of Evidence
        Evidence of the runs together; the evidence of one run is in its report.
    is_one_program
        True if the runs are of one program at different steps or tolerances. They share one choice
        of definitions, and have an order of convergence. Several programs are judged separately.
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
        """The findings on the whole series; the findings on a single run are in its report."""
        return tuple(e.finding() for e in self.seen)

    @property
    def passed(self) -> bool:
        """True if every requirement is met by every run."""
        return all(run.report.passed for run in self.runs)
