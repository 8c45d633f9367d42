"""The report as JUnit XML, for continuous integration: requirements as test cases.

The schema is Jenkins' junit-10.xsd. The content does not depend on the time or place of writing.
"""

import re
from collections.abc import Iterator
from dataclasses import fields
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.errors import printable
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.scoring.outcomes import Requirement
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.runs import Series
from heyoka_bike.scoring.scores import Measures
from heyoka_bike.scoring.verdict import MIN_COVERAGE
from heyoka_bike.showing.formats.json import clean
from heyoka_bike.showing.wording.grade_text import WORDS
from heyoka_bike.showing.wording.number_text import percent, sentence
from heyoka_bike.showing.wording.run_text import reports
from heyoka_bike.showing.wording.verdict_text import PHRASES, by_severity, verdict


def render(scored: Report | Series) -> str:
    """Render a test suite for the file, or one for each run, as JUnit XML.

    There is a test case for each maneuver and column to which a requirement applies. If none of
    these fails although the requirement is not met, there is also one for the requirement itself.
    Without requirements there is a test case for each of the eight columns. It passes if the column
    is right over the whole run, and is skipped otherwise. The measures are properties of the suite.
    """
    root = Element("testsuites")
    for report in reports(scored):
        root.append(_suite(report))
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    if isinstance(scored, Series):
        # JUnit's schema has no place for findings about a whole series, so add them to the last
        # run.
        _say(root[-1], [f"{f.severity}: {sentence(f.message)}" for f in scored.findings])
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _suite(report: Report) -> Element:
    suite = Element("testsuite", name=printable(report.file.path))
    properties = SubElement(suite, "properties")
    for name, value in _properties(report):
        if value is not None:
            SubElement(properties, "property", name=name, value=printable(str(value)))
    # Readers of JUnit files sort test cases by class, and read the text before a dot as a package.
    # So the class contains one dot only.
    where = "score." + re.sub(r"[^\w-]", "_", report.file.path)
    for case_name, problem in _cases(report):
        case = SubElement(suite, "testcase", classname=where, name=case_name, time="0")
        if problem is not None:
            case.append(problem)
    for key, tag in (("tests", ""), ("failures", "/failure"), ("errors", "/error"),
                     ("skipped", "/skipped")):  # fmt: skip
        suite.set(key, str(len(suite.findall(f"testcase{tag}"))))
    suite.set("time", "0")
    findings = by_severity(report.said)
    _say(suite, [verdict(report)] + [f"{f.severity}: {sentence(f.message)}" for f in findings])
    return suite


def _cases(report: Report) -> Iterator[tuple[str, Element | None]]:
    """Yield the name of each test case, and the reason why it failed or was skipped, or None."""
    for r in _told(report):
        name, message = printable(r.text), sentence(r.message)
        failure = Element("failure", message=message, type="requirement")
        failure.text = f"{name}: {message}"
        yield name, None if r.met else failure
    if report.requirements:
        return
    for m in report.maneuvers:
        part = "" if m.coverage >= MIN_COVERAGE else f"{PHRASES['in_part']} ({percent(m.coverage)})"
        graded = {c.key: c.grade for c in m.columns}
        for key in dict.fromkeys([*graded, *BENCHMARK_COLUMNS]):
            grade = graded.get(key, Grade.UNKNOWN)
            said = f"{WORDS[grade]}{part}" if grade in WORDS else "nothing compared"
            skipped = Element("skipped", message=f"nothing is required: {said}")
            is_right = grade == Grade.RIGHT and not part
            yield f"{m.maneuver}.{printable(key)}", None if is_right else skipped


def _told(report: Report) -> Iterator[Requirement]:
    """Yield each requirement's parts, and the requirement itself if they do not show its result."""
    for r in report.requirements:
        yield from r.parts
        if not r.parts or (not r.met and all(part.met for part in r.parts)):
            yield r


def _properties(report: Report) -> Iterator[tuple[str, object]]:
    """Yield names and values for the properties of a test suite; None if a value is unknown."""
    yield "dataset_version", report.dataset_version
    yield "bicycle", report.bicycle
    for m in report.maneuvers:
        for name in ("performance", "coverage", "column_count", "gap"):
            yield f"{m.maneuver}.{name}", clean(getattr(m, name))
        for c in m.columns:
            where, r = f"{m.maneuver}.{printable(c.key)}", c.as_understood
            for f in fields(Measures):
                yield f"{where}.{f.name}", clean(getattr(r.measures, f.name))
            yield f"{where}.floor", clean(c.floor)
            for name in ("definition", "sign", "unit"):
                yield f"{where}.{name}", getattr(r, name)
            yield f"{where}.offset", clean(r.offset)


def _say(suite: Element, lines: list[str]) -> None:
    if lines:
        out = suite.find("system-out")
        if out is None:
            out = SubElement(suite, "system-out")
        out.text = "\n".join(filter(None, [out.text, *lines]))
