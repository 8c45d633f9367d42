"""Mutation testing: make random slips in the code, and see whether a test fails.

python tests/mutations.py trace MAP                  # which tests run which line: some 15 minutes
python tests/mutations.py trace MAP --mark proof     # adds the tests of another tier: an hour
python tests/mutations.py try MAP --count 200 --seed 1 --out TABLE.json
python tests/mutations.py try MAP --left TABLE.json --out OTHER.json  # slips that no test noticed

A slip is one change that still compiles: another comparison, sum or product, a number that is one
larger or twice as large, a negated condition, or a missing statement or value (DeMillo, Lipton and
Sayward 1978, doi:10.1109/C-M.1978.218136). The slip is made in a copy of the repository. There, the
tests that run its line are run until one fails, the fastest first. A slip that no test notices
shows a gap in the tests, or does not change the behaviour: a person has to decide.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "heyoka_bike"
# Modules that contain the decisions and the proofs
SUBJECTS = (
    "scoring/verdict.py", "scoring/measures.py", "scoring/judge", "scoring/requirements.py",
    "reference/proof/rows.py", "motion/integrate.py",
)  # fmt: skip
# [s] time limit for the tests of one slip. Beyond this time, the outcome is `open`.
SECONDS = 120
PYTEST = (sys.executable, "-m", "pytest", "-q")

_COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_OPERATIONS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.Mod: ast.Mult, ast.FloorDiv: ast.Mult, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
_CALLS = {"min": "max", "max": "min", "any": "all", "all": "any", "floor": "ceil", "ceil": "floor"}


@dataclass(frozen=True)
class Slip:
    """A change in the text of one module, from byte `start` to byte `end`."""

    module: str
    line: int
    start: int
    end: int
    before: str
    after: str


@dataclass(frozen=True)
class Outcome:
    """The outcome of a slip: `noticed` by the named test, `unnoticed`, `not run` or `open`."""

    slip: Slip
    became: str
    by: str = ""


def slips_of(path: Path) -> Iterator[Slip]:
    """All slips of a module, in the order of its text."""
    source = path.read_bytes()
    starts = [0]
    for line in source.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    module = path.relative_to(ROOT).as_posix()

    def slip(node: ast.expr | ast.stmt, after: str) -> Slip:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        start = starts[node.lineno - 1] + node.col_offset
        end = starts[node.end_lineno - 1] + node.end_col_offset
        return Slip(module, node.lineno, start, end, source[start:end].decode(), after)

    for node in _executed(ast.parse(source)):
        yield from (
            slip(node, f"({x})" if isinstance(node, ast.expr) else x) for x in _others(node)
        )


def _executed(tree: ast.AST) -> Iterator[ast.expr | ast.stmt]:
    """Nodes that are executed: no annotations, decorators, docstrings, exports or
    error messages."""
    for child in ast.iter_child_nodes(tree):
        if isinstance(child, ast.arguments):
            for default in (*child.defaults, *(d for d in child.kw_defaults if d is not None)):
                yield default
                yield from _executed(default)
            continue
        if isinstance(child, ast.Import | ast.ImportFrom | ast.Raise | ast.JoinedStr):
            continue
        if isinstance(tree, ast.AnnAssign) and child is tree.annotation:
            continue
        if isinstance(tree, ast.FunctionDef) and (
            child in tree.decorator_list or child is tree.returns
        ):
            continue
        if isinstance(tree, ast.ClassDef) and child in (*tree.bases, *tree.decorator_list):
            continue
        if isinstance(child, ast.expr | ast.stmt):
            yield child
        yield from _executed(child)


def _others(node: ast.expr | ast.stmt) -> Iterator[str]:
    """Texts that a programmer could write instead of a node by mistake."""
    match node:
        case ast.Compare(ops=[op, *rest]) if type(op) in _COMPARISONS:
            other = ast.Compare(node.left, [_COMPARISONS[type(op)](), *rest], node.comparators)
            yield ast.unparse(other)
        case ast.BinOp(op=op) if type(op) in _OPERATIONS:
            yield ast.unparse(ast.BinOp(node.left, _OPERATIONS[type(op)](), node.right))
        case ast.BoolOp(op=op):
            yield ast.unparse(
                ast.BoolOp(ast.Or() if isinstance(op, ast.And) else ast.And(), node.values)
            )
        case ast.UnaryOp(op=ast.Not() | ast.USub()):
            yield ast.unparse(node.operand)
        case ast.Constant(value=bool(x)):
            yield repr(not x)
        case ast.Constant(value=int(x)):
            yield repr(x + 1)
        case ast.Constant(value=float(x)):
            yield repr(2 * x or 1.0)
        case ast.Call(func=ast.Name(id=name)) if name in _CALLS:
            yield ast.unparse(ast.Call(ast.Name(_CALLS[name]), node.args, node.keywords))
        case ast.IfExp():
            yield ast.unparse(ast.IfExp(node.test, node.orelse, node.body))
        case ast.Return(value=value) if value is not None and not _is_none(value):
            yield "return None"
        case ast.AugAssign() | ast.Continue() | ast.Break():
            yield "pass"
        case ast.Expr(value=ast.Call()):
            yield "pass"


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def trace(into: Path, mark: str | None) -> None:
    """Run a tier under coverage.py, and add to `into` which test ran which line of the subjects."""
    with tempfile.TemporaryDirectory() as folder:
        settings, times, data = (Path(folder, n) for n in ("settings", "times.xml", "data"))
        settings.write_text(
            f"[run]\nsource_pkgs={PACKAGE}\nparallel=true\ndynamic_context=test_function\n"
            f"data_file={data}\ndisable_warnings=no-data-collected,module-not-imported\n"
        )
        chosen = ["-m", mark] if mark else []
        subprocess.run(
            [*PYTEST, f"--junitxml={times}", *chosen],
            cwd=ROOT,
            env=os.environ | {"COVERAGE_PROCESS_START": str(settings)},
            check=False,
        )
        add_trace(into, folder, times)


def add_trace(into: Path, folder: str, times: Path) -> None:
    """Read coverage.py's data from `folder`, and the duration of each test [s]."""
    from coverage import CoverageData

    known = json.loads(into.read_text()) if into.exists() else {"lines": {}, "seconds": {}}
    seconds = defaultdict(float, known["seconds"])
    files: dict[str, str] = {}
    for case in ElementTree.parse(times).iter("testcase"):
        module, name = case.attrib["classname"], case.attrib["name"].partition("[")[0]
        path = (ROOT / module.replace(".", "/")).with_suffix(".py")
        files[f"{path.stem}.{name}"] = f"{path.relative_to(ROOT).as_posix()}::{name}"
        seconds[files[f"{path.stem}.{name}"]] += float(case.attrib["time"])
    lines: dict[str, dict[str, set[str]]] = defaultdict(lambda: defaultdict(set))
    for module, of_module in known["lines"].items():
        for line, tests in of_module.items():
            lines[module][line] |= set(tests)
    for part in Path(folder).glob("data.*"):
        data = CoverageData(str(part))
        data.read()
        for file in data.measured_files():
            module = PACKAGE + file.rpartition(PACKAGE)[2]
            if not module.startswith(tuple(f"{PACKAGE}/{s}" for s in SUBJECTS)):
                continue
            for line, contexts in data.contexts_by_lineno(file).items():
                lines[module][str(line)] |= {files[c] for c in contexts if c in files}
    into.write_text(
        json.dumps(
            {
                "lines": {m: {k: sorted(v) for k, v in of.items()} for m, of in lines.items()},
                "seconds": dict(seconds),
            }
        )
    )


def drawn(count: int, seed: int) -> list[Slip]:
    """Draw `count` slips of the subjects, all with the same probability."""
    paths: list[Path] = []
    for subject in SUBJECTS:
        path = ROOT / PACKAGE / subject
        paths += sorted(path.rglob("*.py")) if path.is_dir() else [path]
    return random.Random(seed).sample([s for p in paths for s in slips_of(p)], count)


def left(table: Path) -> list[Slip]:
    """The slips of a table that no test noticed."""
    found = json.loads(table.read_text())
    return [Slip(**x["slip"]) for x in found if x["became"] != "noticed"]


def tried(slip: Slip, lines: dict[str, dict[str, list[str]]], seconds: dict[str, float]) -> Outcome:
    """Make a slip in a copy, and run the tests of its line there until one fails."""
    of_module = lines.get(slip.module, {})
    # Python evaluates a constant at import, so every test that uses the module may depend on it.
    tests = of_module.get(str(slip.line)) or sorted(set().union(*of_module.values()))
    if not tests:
        return Outcome(slip, "not run")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder, "copy")
        for name in (PACKAGE, "tests", "docs", "data", ".ci", ".github"):
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("_build"))
        for path in ROOT.iterdir():
            if path.is_file():
                shutil.copy(path, copy)
        (copy / "reference").symlink_to(ROOT / "reference")
        text = (copy / slip.module).read_bytes()
        changed = text[: slip.start] + slip.after.encode() + text[slip.end :]
        (copy / slip.module).write_bytes(changed)
        ordered = sorted(tests, key=lambda t: seconds.get(t, 0.0))
        try:
            run = subprocess.run(
                [*PYTEST, "-x", "-n0", "-m", "", "-p", "no:cacheprovider", *ordered],
                cwd=copy,
                env=os.environ | {"PYTHONPATH": str(copy)},
                capture_output=True,
                text=True,
                timeout=SECONDS,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return Outcome(slip, "open")
    if run.returncode == 0:
        return Outcome(slip, "unnoticed")
    failed = [x for x in run.stdout.splitlines() if x.startswith(("FAILED", "ERROR"))]
    return Outcome(slip, "noticed", failed[0].split(" ")[1] if failed else run.stdout[-200:])


def main() -> None:
    """Trace tests, or try slips."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    commands = parser.add_subparsers(dest="command", required=True)
    traced = commands.add_parser("trace")
    traced.add_argument("map", type=Path)
    traced.add_argument("--mark")
    trying = commands.add_parser("try")
    trying.add_argument("map", type=Path)
    trying.add_argument("--count", type=int, default=200)
    trying.add_argument("--seed", type=int, default=1)
    trying.add_argument("--left", type=Path)
    trying.add_argument("--processes", type=int, default=os.cpu_count())
    trying.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    if chosen.command == "trace":
        trace(chosen.map, chosen.mark)
        return
    known = json.loads(chosen.map.read_text())
    slips = left(chosen.left) if chosen.left else drawn(chosen.count, chosen.seed)
    outcomes: list[Outcome] = []
    with ProcessPoolExecutor(chosen.processes) as pool:
        for outcome in pool.map(partial(tried, **known), slips):
            outcomes.append(outcome)
            slip = outcome.slip
            change = f"{slip.module}:{slip.line}: {slip.before!r} -> {slip.after!r}"
            print(f"{outcome.became:10} {change} {outcome.by}", flush=True)
            if chosen.out:
                chosen.out.write_text(json.dumps([asdict(o) for o in outcomes], indent=1) + "\n")
    print(dict(Counter(o.became for o in outcomes)))


if __name__ == "__main__":
    main()
