"""Gaps of a file: rows not there, errors that energy hides, digits not written."""

from collections.abc import Iterator

from heyoka_bike.scoring.findings import Finding, info, maneuvers, named, warning
from heyoka_bike.scoring.judge.single_precision import single_precision
from heyoka_bike.scoring.report import Report

# Fewer digits than binary64 holds are worth mentioning where they are what limits the score.
_DIGITS_OF_BINARY64 = 15
# An error of this part of the scale is seen in a plot; the benchmark's measure may miss it.
_VISIBLE = 1e-2
# An error of up to this many floors is that of the digits written.
_LIMITED = 2.0


def coverage(report: Report) -> Iterator[Finding]:
    """Parts of the run that no rows show; maneuvers with the same rows are named together."""
    said = set()
    for m in report.maneuvers:
        duration = float(m.part.reference.duration)
        slack = 1.5 * (m.step or 0.0) / duration
        ends = (m.t_start, m.t_end, m.gap)
        if ends in said or (m.coverage and m.coverage + 2 * slack >= 1.0):
            continue
        said.add(ends)
        which = [n.maneuver for n in report.maneuvers if (n.t_start, n.t_end, n.gap) == ends]
        rows = f"complete rows of maneuver {', '.join(map(str, which))}"
        what = f"{rows} cover {m.t_start:.6g} to {m.t_end:.6g} s only; the rest of the run is"
        if m.coverage < (m.t_end - m.t_start) / duration - slack or not m.coverage:
            what = f"{rows} are up to {m.gap:.3g} s apart; what the motion does meanwhile is"
        evidence = {"maneuvers": which, "t_start": m.t_start, "t_end": m.t_end, "gap": m.gap}
        yield warning("coverage", f"{what} not judged", **evidence)


def energy_hides_error(report: Report) -> Iterator[Finding]:
    """Maneuvers that meet eq. (1), although something else of them is visibly wrong."""
    limit = next((m.performance_limit for m in report.maneuvers if m.performance_limit), None)
    hidden = {}
    for m in report.maneuvers:
        if m.performance is None or limit is None or m.claim(limit)[0] >= limit:
            continue
        wrong = {
            c.key: c.max_rel_error or 0.0
            for c in m.columns
            if c.is_known and not c.is_at_floor(_LIMITED)
        }
        key = max(wrong, key=wrong.__getitem__, default="")
        worst = wrong.get(key, 0.0)
        # Where the energy itself is wrong, it shows the error, but eq. (1) does not ask for it.
        if worst > _VISIBLE and wrong.get("mechanical_energy", 0.0) < _VISIBLE:
            hidden[m.maneuver] = worst, key, m.performance
    if hidden:
        number = max(hidden, key=hidden.__getitem__)
        worst, key, performance = hidden[number]
        part = f"{100 * worst:.0f}" if worst >= 0.1 else f"{100 * worst:.2g}"
        said = (
            f"{maneuvers(hidden)}: eq. (1) is met, and yet {key} is wrong by up to {part} % of its "
            "scale; energy alone does not show this error"
        )
        evidence = {"maneuvers": [*hidden], "maneuver": number, "performance": performance}
        yield warning("energy_hides_error", said, **evidence, column=key, max_rel_error=worst)


def digits_written(report: Report) -> Iterator[Finding]:
    """Where not the program but the digits it wrote limit the score, if not for their precision."""
    digits = report.file.significant_digits
    if digits is None or digits >= _DIGITS_OF_BINARY64:
        return
    single = [key for f in single_precision(report) for key in f.evidence["columns"]]
    limited = [
        key
        for key, places in report.by_column().items()
        if key not in single and all(c.is_at_floor(_LIMITED) for _, c in places)
    ]
    if limited:
        said = (
            f"{named(limited)}: the error is that of the digits written ({digits} in the "
            "column with the fewest); write 17 to show what the program can do"
        )
        yield info("digits_written", said, columns=limited, significant_digits=digits)
