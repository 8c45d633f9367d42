"""Check requirements on results in a program's own tests, and explain failures.

The pytest plugin uses this module once a test needs it; nothing here depends on pytest.
"""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import NoReturn

import numpy as np

from heyoka_bike.errors import BicycleError, InputError, printable
from heyoka_bike.reference.load import Reference
from heyoka_bike.scoring.diagnosis.diagnose import diagnosed
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.outcomes import InPart, Requirement
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.requirements import ENOUGH, OF_COLUMN, OF_MANEUVER, Parsed, check, parse
from heyoka_bike.scoring.scores import ColumnScore, ManeuverScore
from heyoka_bike.showing.wording import column_text, finding_text, number_text, verdict_text

# Metrics for which larger values are better. For all other metrics smaller values are better.
_AT_LEAST = frozenset({"scd", "mescd", "time_to_tolerance", "columns", "coverage"})
# Maximum number of findings of the diagnosis that are shown for a failed test. If a cause was
# found, the first finding explains the failure. Otherwise the first two findings report that no
# cause was found, and the shape of the error.
_FINDINGS_SHOWN = 2
# Width of the message about a failed test [characters]. Terminals have at least 80 columns, and
# usually more; pytest does not indent the message.
_WIDTH_OF_FAILURE = 96
_LABEL = 17


@dataclass(frozen=True, slots=True)
class RequirementSpec:
    """Requirements that were given as keywords, such as ``maneuver=2, scd=8``.

    Attributes
    ----------
    maneuver, column
        Maneuver and column of the requirements; None for the worst of all.
    metrics : mapping of str to number
        Limits by name of `requirements`: minima of scd, mescd, time_to_tolerance, columns and
        coverage, maxima of the others.
    """

    maneuver: int | None = None
    column: str | None = None
    metrics: Mapping[str, float] = field(default_factory=dict)

    def texts(self) -> tuple[str, ...]:
        """Return the limits as texts that `requirements.parse` reads, such as ``2.scd >= 8``.

        Limits on the coverage of a maneuver apply to all of its columns.
        """
        where = "" if self.maneuver is None else f"{self.maneuver}."
        column = "" if self.column is None else f"{self.column}."
        return tuple(
            f"{where}{'' if name in ENOUGH else column}{name} "
            f"{'>=' if name in _AT_LEAST else '<='} {limit!r}"
            for name, limit in self.metrics.items()
        )

    @property
    def is_about_amount(self) -> bool:
        """True if the requirements limit only column count and coverage, not the errors."""
        return all(name in ENOUGH for name in self.metrics)


def asked(maneuver: object = None, column: object = None, **metrics: object) -> RequirementSpec:
    """Return requirements given as keywords, after checking names and types.

    Raises
    ------
    InputError
        A name is unknown, or a value has another type.
    """
    known = OF_COLUMN + OF_MANEUVER
    for name in metrics:
        if name not in known:
            raise InputError(
                f"found {name!r:.60}, expected maneuver, column, or one of {', '.join(known)}"
            )
    if maneuver is not None and (isinstance(maneuver, bool) or not isinstance(maneuver, int)):
        raise InputError(f"found maneuver={maneuver!r:.60}, expected a maneuver number from 1")
    if column is not None and not isinstance(column, str):
        raise InputError(f"found column={column!r:.60}, expected a name such as 'roll_angle'")
    limits = {}
    for name, value in metrics.items():
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            raise InputError(f"found {name}={value!r:.60}, expected a number")
        limits[name] = value if isinstance(value, int) else float(value)
    found = RequirementSpec(maneuver, column, limits)
    # If no limit is given, parse an arbitrary limit, to check whether maneuver and column are
    # valid.
    for text in found.texts() or RequirementSpec(maneuver, column, {"scd": 0.0}).texts():
        try:
            parse(text)
        except InputError as e:
            raise InputError(_plain(e)) from None
    return found


def _plain(error: BicycleError) -> str:
    """Return the message of an error, without the words ``require:`` at its beginning."""
    return str(error).removeprefix("require: ")


@dataclass(eq=False, repr=False, slots=True)
class Score:
    """A score in a test: results compared with the reference, and requirements on them.

    Attributes
    ----------
    is_checked
        True if anything was required.
    is_read
        True if the test has read the report.
    """

    _report: Report
    _reference: Reference
    # Requirements of the test's markers, which apply if `require` is called without requirements;
    # and the number of digits required by default, None if not set.
    _marked: tuple[RequirementSpec, ...]
    _scd: float | None
    # Function that returns the reason not to diagnose a failure, or an empty string if it is to be
    # diagnosed.
    _may_diagnose: Callable[[], str]
    # Function that fails the test with a message.
    _fail: Callable[[str], NoReturn]
    # Minimum number of columns and minimum coverage of the run, if the settings specify them.
    _enough: Mapping[str, float] = field(default_factory=dict)
    is_checked: bool = False
    is_read: bool = False

    @property
    def report(self) -> Report:
        """The report of the comparison with all measures, definitions and findings."""
        self.is_read = True
        return self._report

    def require(
        self, *requirements: str, maneuver: int | None = None, column: str | None = None,
        **metrics: float,
    ) -> Score:  # fmt: skip
        """Fail the test unless the results are this good; return the score itself.

        Parameters
        ----------
        requirements
            Requirements such as ``"2.roll_angle.scd >= 8"``, see `requirements`.
        maneuver, column
            Maneuver and column of the metrics; by default the worst of all.
        metrics
            ``scd=8``, ``max_abs_error=1e-6`` and so on: minima of scd, mescd, time_to_tolerance,
            columns and coverage, maxima of the others. If only columns and coverage are given, the
            requirements of the marker ``bicycle`` apply too, or the digits of ``--bicycle-scd`` or
            ``bicycle_scd``.

        All eight columns must cover the whole run, in each maneuver of the results, unless
        ``columns=5`` or ``coverage=0.3`` sets a lower limit: here, in the marker, or for all tests
        by ``bicycle_columns`` and ``bicycle_coverage``.
        """
        __tracebackhide__ = True
        self.is_checked = True
        try:
            texts = self._texts(requirements, asked(maneuver, column, **metrics))
            checked = check((*texts, *self._enough_for(texts)), self._report)
        except BicycleError as e:
            self._fail(f"require: {_plain(e)}")
        if not all(r.met for r in checked):
            self._fail(_failure(checked, self._report, self._diagnosis()))
        return self

    def _texts(self, requirements: Sequence[str], own: RequirementSpec) -> tuple[str, ...]:
        """Return the requirements of `require`, or else of the markers, or else of the settings."""
        if requirements and (own.maneuver, own.column) != (None, None) and not own.metrics:
            raise InputError(
                "found maneuver= or column= with a requirement as text; put them into the text, "
                "such as '2.roll_angle.scd >= 8'"
            )
        if requirements or not own.is_about_amount:
            return (*requirements, *own.texts())
        texts: list[str] = []
        for marked in self._marked or (RequirementSpec(),):
            metrics = {**marked.metrics, **own.metrics}
            if marked.is_about_amount and self._scd is not None:
                metrics = {"scd": self._scd, **metrics}
            maneuver = marked.maneuver if own.maneuver is None else own.maneuver
            column = marked.column if own.column is None else own.column
            texts += RequirementSpec(maneuver, column, metrics).texts()
        if not texts:
            raise InputError(
                "nothing is required; give a number such as scd=8 here, in the marker "
                "'bicycle', as --bicycle-scd or as bicycle_scd in the configuration file"
            )
        return tuple(texts)

    def _enough_for(self, texts: Sequence[str]) -> tuple[str, ...]:
        """Return the limits of the settings on columns and coverage, unless a test sets its own."""
        set_by_test = {parse(text).metric for text in texts}
        return RequirementSpec(
            metrics={k: x for k, x in self._enough.items() if k not in set_by_test}
        ).texts()

    def _diagnosis(self) -> tuple[str, ...]:
        """Return sentences on why the results differ, or on why there is no diagnosis."""
        if reason := self._may_diagnose():
            return (f"none: {reason}",)
        try:
            with warnings.catch_warnings():
                # The outcome of the test depends on the results alone, so ignore warnings of the
                # diagnosis.
                warnings.simplefilter("ignore")
                found = diagnosed(self._report, self._reference)
        except BicycleError as e:
            return (f"none: {e}",)
        except Exception as e:
            return (f"none: it failed with {type(e).__name__}: {e}",)
        said, more = found.diagnosis[:_FINDINGS_SHOWN], found.diagnosis[_FINDINGS_SHOWN:]
        # If the search was stopped early, the last sentence states this, so it is always shown.
        return tuple(
            finding_text.sentences((*said, *(more[-1:] if found.is_stopped_early else ())))
        )

    def __repr__(self) -> str:
        return f"<score of {verdict_text.verdict(self._report)}>"


def properties(scored: Report, reference: Reference) -> list[tuple[str, str]]:
    """Return properties of a score for test reports: dataset, digits per maneuver and column."""
    found = [
        ("bicycle.dataset_version", reference.dataset_version),
        ("bicycle.content_sha256", reference.content_sha256),
    ]
    for m in scored.maneuvers:
        if m.worst:
            found.append((f"bicycle.{m.maneuver}.scd", f"{m.worst.scd:.3f}"))
        for c in m.columns:
            where = f"bicycle.{m.maneuver}.{c.key}"
            if c.scd is not None:
                found.append((f"{where}.scd", f"{c.scd:.3f}"))
            found.append((f"{where}.definition", _interpretation(c)))
    return found


def _interpretation(c: ColumnScore) -> str:
    """Return how a column is interpreted: its definition, and an unusual sign, unit or offset."""
    return ", ".join((c.definition, *column_text.notes(c)))


def _failure(checked: Sequence[Requirement], scored: Report, diagnosis: Sequence[str]) -> str:
    """Return the message of a failed test: which requirements are not met, and details.

    Parameters
    ----------
    checked
        Requirements, of which at least one is not met; the first such one is explained.
    scored : Report
    diagnosis
        Sentences on why the results differ.
    """
    failed = [r for r in checked if not r.met]
    lines = [
        f"required {printable(r.text)}, found {number_text.sentence(r.message)}" for r in failed
    ]
    lines.append("")
    entries = list(_explained(parse(failed[0].text), scored))
    for m in scored.maneuvers:
        digits = (f"{c.key} {number_text.correct_digits(c.scd)}" for c in m.columns)
        entries.append((f"scd, maneuver {m.maneuver}", ", ".join(digits)))
    entries += [("warning", said) for said in finding_text.warnings(scored.findings)]
    in_part = next((r.outcome for r in failed if isinstance(r.outcome, InPart)), None)
    if in_part is not None:
        keywords = ", ".join(text.replace(" >= ", "=") for text in in_part.enough)
        entries.append(
            ("compared in part", "missing columns and rows are not judged; if that is intended, "
             f"add {keywords} to the requirements of the test")
        )  # fmt: skip
    entries += [("diagnosis", says) for says in diagnosis]
    labels = [label for label, _ in entries]
    for i, (label, text) in enumerate(entries):
        # A label that is the same as that of the previous entry is not repeated.
        lines.append(_entry("" if i and label == labels[i - 1] else label, text))
    return "\n".join(lines)


def _entry(label: str, text: str) -> str:
    """Return a label and, to the right of it, a wrapped text."""
    return textwrap.fill(
        number_text.sentence(text), _WIDTH_OF_FAILURE,
        initial_indent=f"{label:<{_LABEL}} ", subsequent_indent=" " * (_LABEL + 1),
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _explained(p: Parsed, scored: Report) -> Iterator[tuple[str, str]]:
    """Yield labels and texts about the worst of the columns to which a requirement applies."""
    about = [
        (m, c)
        for m, c in scored.places
        if p.maneuver in (None, m.maneuver) and p.column in (None, c.key)
    ]
    if not about:
        return
    m, c = max(about, key=lambda x: _badness(p, x[1]))
    trace = c.trace
    at = int(np.argmax(np.abs(trace.error)))
    yield (
        "worst column",
        f"{c.key} of maneuver {m.maneuver}, read as {_interpretation_with_remarks(c)}: wrong by "
        f"{number_text.in_unit(number_text.number(c.max_abs_error), c.unit)}, "
        f"{number_text.number(c.max_rel_error)} of its largest value "
        f"(scd {number_text.correct_digits(c.scd)})",
    )
    yield (
        "worst row",
        f"t = {trace.time[at]:.10g} s: found {float(trace.value[at])!r}, expected "
        f"{float(trace.reference[at])!r}, error "
        f"{number_text.in_unit(f'{trace.error[at]:+.2e}', c.unit)}",
    )
    yield "first departure", _departure(p, m, c)


def _badness(p: Parsed, c: ColumnScore) -> float:
    """Return a number that is larger for a worse column, from the requirement's metric or scd."""
    metric = p.metric if p.metric in OF_COLUMN else "scd"
    value = getattr(c.as_understood.measures, metric)
    if value is None:
        return -inf
    return -float(value) if metric in ("scd", "mescd", "time_to_tolerance") else float(value)


def _interpretation_with_remarks(c: ColumnScore) -> str:
    """Return `_interpretation`, with a remark if it is the default, or if others fit as well."""
    taken = _interpretation(c)
    remarks = ["the default"] if column_text.is_default(c) else []
    if c.indistinguishable:
        remarks.append(f"{' and '.join(c.indistinguishable)} fit as well")
    return f"{taken} ({'; '.join(remarks)})" if remarks else taken


def _departure(p: Parsed, m: ManeuverScore, c: ColumnScore) -> str:
    """Return when the error first exceeds the required limit, and 1e-3 of the largest value."""
    said = []
    scale = c.scale or None
    allowed = {
        "scd": None if scale is None else scale * 10.0**-p.number,
        "max_rel_error": None if scale is None else scale * p.number,
        "max_abs_error": p.number,
    }.get(p.metric)
    if allowed is not None:
        above = np.flatnonzero(np.abs(c.trace.error) > allowed)
        if len(above):
            first = above[0]
            said.append(
                f"t = {c.trace.time[first]:.10g} s (row {first + 1} of {len(c.trace.time)}) is the "
                f"first above {number_text.in_unit(number_text.number(allowed), c.unit)}, "
                "the allowed error"
            )
    seen = column_text.first_above(c)
    since = seen if seen == "never" else f"from t = {seen} s"
    said.append(f"above {TOLERANCE:g} of the largest value {since}")
    return "; ".join(said)
