"""Outside `showing`, no code reads the code, message or numbers of a finding: decisions use data.

A message is made from evidence, see `scoring.evidence`, and only for output. A decision by words
would be wrong as soon as a message is reworded.
"""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2] / "heyoka_bike"
WORDS = {"code", "message", "evidence", "severity"}
HOLDERS = {"findings", "diagnosis", "said"}
LOOPS = (ast.For, ast.comprehension)


def findings_read(text):
    """Lines that read the words of a finding.

    A finding is a parameter or variable with that annotation, an item of a report's findings in a
    loop, or a selection of these. A module that imports the class reads the findings that it made.
    """
    found = []
    makes_them = "scoring.findings import" in text
    for scope in _scopes(ast.parse(text)):
        names = set()
        # The definition of one name may use another name that is defined later, so all nodes are
        # visited twice.
        for node in [*scope, *scope]:
            if isinstance(node, ast.arg | ast.AnnAssign) and node.annotation is not None:
                target = node.arg if isinstance(node, ast.arg) else ast.unparse(node.target)
                names |= {target} if "Finding" in ast.unparse(node.annotation) else set()
            elif isinstance(node, ast.For | ast.comprehension) and _is_of_findings(
                node.iter, names
            ):
                names |= {x.id for x in ast.walk(node.target) if isinstance(x, ast.Name)}
            elif isinstance(node, ast.Assign) and _is_of_findings(node.value, names):
                names |= {
                    x.id for t in node.targets for x in ast.walk(t) if isinstance(x, ast.Name)
                }
        # An attribute that is called is a method of evidence, not a field of a finding.
        called = {id(node.func) for node in scope if isinstance(node, ast.Call)}
        for node in scope:
            if isinstance(node, ast.Attribute) and node.attr in WORDS and id(node) not in called:
                of = node.value
                is_name = isinstance(of, ast.Name) and of.id in names
                is_own = makes_them and node.attr in ("message", "evidence")
                if is_name or is_own or (not isinstance(of, ast.Name) and _is_of_findings(of)):
                    found.append(node.lineno)
    return found


def _scopes(tree):
    """The nodes of each function, and those of the module outside its functions."""
    functions = [x for x in ast.walk(tree) if isinstance(x, ast.FunctionDef | ast.AsyncFunctionDef)]
    inside = {id(x) for f in functions for x in ast.walk(f)}
    return [
        *([*ast.walk(f)] for f in functions),
        [x for x in ast.walk(tree) if id(x) not in inside],
    ]


def _is_of_findings(node, names=()):
    attributes = {x.attr for x in ast.walk(node) if isinstance(x, ast.Attribute)}
    known = {x.id for x in ast.walk(node) if isinstance(x, ast.Name)} & {*names}
    return bool(attributes & HOLDERS or known)


def modules():
    paths = sorted(p.relative_to(ROOT).as_posix() for p in ROOT.rglob("*.py"))
    makers = ("showing/", "scoring/evidence/")
    return [p for p in paths if not p.startswith(makers)]


def test_no_module_reads_the_words_of_a_finding():
    read = {p for p in modules() if findings_read((ROOT / p).read_text(encoding="utf-8"))}
    assert read == set()


@pytest.mark.parametrize("line", [
    "any(f.code == 'never_filled' for f in report.findings)",
    "next(f for f in report.said if f.severity == 1)",
    "report.diagnosis[0].message",
    "[x.evidence['names'] for x in reversed(report.findings)]",
])  # fmt: skip
def test_it_is_seen_in_a_line(line):
    assert findings_read(f"def decide(report):\n    return {line}\n") == [2]


def test_it_is_seen_of_a_parameter_and_a_loop():
    assert findings_read("def f(x: Finding):\n    return x.code\n") == [2]
    assert findings_read("def f(r):\n    for x in r.findings:\n        print(x.message)\n") == [3]
    assert findings_read("def f(r):\n    x = r.findings[0]\n    return x.code\n") == [3]
    assert findings_read("def f(r):\n    x = r.said\n    return [y.code for y in x]\n") == [3]
    assert findings_read("def f(e: InputError):\n    return e.message\n") == []
