"""The report as JUnit XML, for continuous integration: requirements as test cases.

The form is Jenkins' junit-10.xsd. Nothing in it depends on when or where it was written.
"""

import math
import re
from dataclasses import fields
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from heyoka_bike.errors import printable
from heyoka_bike.scoring.column_score import ColumnScore, Measures
from heyoka_bike.scoring.report import Report, Series
from heyoka_bike.showing.grades import WORDS
from heyoka_bike.showing.wording import by_severity, reports, sentence, verdict


def render(scored: Report | Series) -> str:
    """A test suite for the file, or one for each run, as JUnit XML.

    The test cases are the requirements. Without any there is one for each maneuver and column,
    which passes if that is right, and is skipped if not. The measures are properties of the suite.
    """
    root = Element("testsuites")
    for report in reports(scored):
        root.append(_suite(report))
    for name in ("tests", "failures", "errors"):
        root.set(name, str(sum(int(suite.get(name, "0")) for suite in root)))
    if isinstance(scored, Series):
        # Last: what is about the series belongs to no run, and the schema has no place for it.
        _say(root[-1], [f"{f.severity}: {sentence(f.message)}" for f in scored.findings])
    indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="unicode") + "\n"


def _suite(report: Report) -> Element:
    failures = sum(not r.met for r in report.requirements)
    suite = Element("testsuite", name=printable(report.file.path))
    _add_properties(SubElement(suite, "properties"), report)
    # Readers sort cases by class, and take what is before a dot for the name of a package.
    where = "score." + re.sub(r"[^\w-]", "_", report.file.path)
    if report.requirements:
        for r in report.requirements:
            case = SubElement(suite, "testcase", classname=where, name=printable(r.text), time="0")
            if not r.met:
                message = sentence(r.message)
                failure = SubElement(case, "failure", message=message, type="requirement")
                failure.text = f"{printable(r.text)}: {message}"
    else:
        for m in report.maneuvers:
            for c in m.columns:
                name = f"{m.maneuver}.{printable(c.key)}"
                case = SubElement(suite, "testcase", classname=where, name=name, time="0")
                if not c.is_right:
                    said = WORDS.get(c.grade, "nothing compared")
                    SubElement(case, "skipped", message=f"nothing is required: {said}")
    skipped = len(suite.findall("testcase/skipped"))
    counts = {
        "tests": len(suite) - 1,
        "failures": failures,
        "errors": 0,
        "skipped": skipped,
        "time": 0,
    }
    for key, value in counts.items():
        suite.set(key, str(value))
    findings = by_severity(report.said)
    _say(suite, [verdict(report)] + [f"{f.severity}: {sentence(f.message)}" for f in findings])
    return suite


def _add_properties(properties: Element, report: Report) -> None:
    def add(name: str, value: object) -> None:
        if value is not None:
            SubElement(properties, "property", name=name, value=printable(str(value)))

    add("dataset_version", report.dataset_version)
    add("bicycle", report.bicycle)
    for m in report.maneuvers:
        add(f"{m.maneuver}.performance", _number(m.performance))
        add(f"{m.maneuver}.coverage", _number(m.coverage))
        add(f"{m.maneuver}.gap", _number(m.gap))
        for c in m.columns:
            for name, value in _measures(c).items():
                add(f"{m.maneuver}.{printable(c.key)}.{name}", value)


def _measures(c: ColumnScore) -> dict[str, object]:
    r = c.as_understood
    numbers: dict[str, object] = {
        f.name: _number(getattr(r.measures, f.name)) for f in fields(Measures)
    }
    reading = {"definition": r.definition, "sign": r.sign, "unit": r.unit}
    return numbers | {"floor": _number(c.floor)} | reading | {"offset": _number(r.offset)}


def _number(x: float | None) -> float | None:
    return None if x is None or not math.isfinite(x) else float(x)


def _say(suite: Element, lines: list[str]) -> None:
    if lines:
        out = suite.find("system-out")
        if out is None:
            out = SubElement(suite, "system-out")
        out.text = "\n".join(filter(None, [out.text, *lines]))
