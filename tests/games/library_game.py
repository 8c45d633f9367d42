"""The game of real libraries: a file is judged like its plain text, or rejected by name.

python tests/games/library_game.py --count 300             # with what is installed
python tests/games/library_game.py --seed 2 --case 123     # one of them, and what became of it
python tests/games/library_game.py --writer pandas_csv     # one writer
python tests/games/library_game.py --collect tests/scoring/drawn
"""

import argparse
import re
import sys
import tempfile
import traceback
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

from games.library_files import KEYS, draw, twin
from games.library_writers import WRITERS, packed
from heyoka_bike import load_reference, score
from heyoka_bike.errors import BicycleError

# Fraction of a column's size by which two correct computations, or a text with 15 digits, may
# differ.
_ARITHMETIC = 1e-12
# Suffixes of source files that are run by other programs, Octave and R.
_SOURCES = (".m", ".R")
REQUIRED = "scd >= 6"


@dataclass(frozen=True)
class Outcome:
    """The outcome of a file: judged like its plain text, rejected, judged in part, or a wrong
    judgement."""

    kind: str
    drawing: str
    said: str = ""


def _drawn(seed, number, writer=None, every=None):
    random = np.random.default_rng([seed, number, 1])
    name = sorted(WRITERS)[int(random.integers(len(WRITERS)))] if writer is None else writer
    drawn = draw(seed, number, WRITERS[name].layouts, WRITERS[name].units, 17, every)
    drawn.writer = name
    return random, drawn


def play(seed, number, folder=None, writer=None, every=None):
    """Return the outcome of one file; None if its writer is not installed."""
    random, drawn = _drawn(seed, number, writer, every)
    of = WRITERS[drawn.writer]
    if of.missing:
        return None
    with tempfile.TemporaryDirectory() as own:
        path = Path(folder or own) / f"{drawn.writer}-{seed}-{number}"
        try:
            file = packed(random, of.write(random, drawn, path))
        except Exception:
            return Outcome("not written", str(drawn), traceback.format_exc()[-300:])
        plain = path.with_name(f"{path.name}.plain")
        plain.write_text(twin(drawn), "utf-8")
        return outcome(drawn, file, plain)


def keep(folder, count, most=30_000):
    """Write files of 11 rows and their plain texts. The files should differ from each other as
    much as possible."""
    seen = set()
    for number in range(10_000):
        _, drawn = _drawn(0, number, every=91)
        kinds = {drawn.writer, drawn.time_kind, drawn.style.split()[0], drawn.units_apart}
        kinds |= {f"{drawn.layout} {drawn.style.split()[0]}", f"{drawn.time_kind} {drawn.layout}"}
        if WRITERS[drawn.writer].missing or len(kinds - seen) < 2 or drawn.writer in seen:
            continue
        with tempfile.TemporaryDirectory() as own:
            found = play(0, number, own, every=91)
            files = [p for p in Path(own).iterdir() if p.is_file() and p.suffix not in _SOURCES]
            if found.kind != "twin" or sum(p.stat().st_size for p in files) > most:
                continue
            stem = f"{drawn.writer}-0-{number}"
            for p in files:
                if p.name.startswith(f"{stem}.") and not p.name.endswith("-source.csv"):
                    (folder / p.name).write_bytes(p.read_bytes())
        print(found.drawing)
        seen |= kinds
        count -= 1
        if not count:
            return


def outcome(drawn, file, plain):
    """Return the outcome of a file compared with its plain text, for a drawing with names."""
    expected = score(plain, load_reference(), REQUIRED)
    try:
        found = score(file, load_reference(), REQUIRED)
    except BicycleError as e:
        said = str(e).partition(f"{file.name}")[2]
        return Outcome("refused", str(drawn), said)
    except Exception:
        return Outcome("internal error", str(drawn), traceback.format_exc()[-600:])
    kind, said = _compared(drawn, found, expected)
    return Outcome(kind, str(drawn), said)


def _columns(report):
    return {(m.maneuver, c.key): c for m in report.maneuvers for c in m.columns}


def _letters(name):
    """Return the letters of a name that all formats preserve."""
    return "".join(x for x in name if x.isascii() and x.isalnum())


def _said(report):
    """Return the verdict without the file's name."""
    return report.verdict.partition(": ")[2]


def _grade(report):
    """Return the first words of the verdict, without the digits of the worst column."""
    return re.split("[,;]", _said(report))[0]


def _compared(drawn, found, expected):
    mine, plain = _columns(found), _columns(expected)
    said = f"{_said(found)} / twin {_said(expected)}"
    if found.is_right and not expected.is_right:
        return "favoured", said
    if found.passed and not expected.passed:
        return "requirement met", said
    if added := [f"{m}.{k}" for m, k in mine.keys() - plain.keys() if k in KEYS]:
        return "read under another meaning", f"added {added}; {said}"
    wrong = []
    for at in mine.keys() & plain.keys():
        a, b = mine[at].as_understood.measures, plain[at].as_understood.measures
        size = max(np.abs(drawn.parts[at[0]][at[1]]).max(), 1e-3) if at[0] in drawn.parts else 1.0
        ea, eb = a.max_abs_error or 0.0, b.max_abs_error or 0.0
        if not abs(ea - eb) <= _ARITHMETIC * size + 1e-6 * abs(eb):
            wrong.append(f"{at[0]}.{at[1]} {a.scd:.2f} / {b.scd:.2f}")
    if wrong:
        return "read as something else", f"{wrong}; {said}"
    if lost := sorted(plain.keys() - mine.keys()):
        names = ", ".join(x for f in found.findings for x in f.evidence.get("names", ()))
        names += ", ".join(x.name for x in found.not_compared)
        told = _letters(names)
        silent = [f"{m}.{k}" for m, k in lost if not any(
            _letters(x) in told for x in drawn.written_as(k))]  # fmt: skip
        if found.is_right:
            return "right in part", f"lost {lost}; {said}"
        if silent:
            return "lost in silence", f"{silent}; {names} {said}"
        return "in part", f"lost {lost}; {names}"
    if expected.is_right and not found.is_right:
        return "accused", f"{said}: {' '.join(f.message for f in found.findings)}"
    if expected.passed and not found.passed:
        return "requirement failed", f"{said}: {' '.join(f.message for f in found.findings)}"
    if _grade(found) != _grade(expected):
        return "verdict differs", said
    return "twin", ""


FINE = ("twin", "refused", "in part", "not written")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--case", type=int)
    parser.add_argument("--writer", choices=sorted(WRITERS))
    parser.add_argument("--keep", type=Path, help="folder in which the files stay")
    parser.add_argument("--collect", type=Path, help="folder for a file of each writer")
    given = parser.parse_args()
    if given.collect:
        given.collect.mkdir(exist_ok=True)
        keep(given.collect, given.count)
        return
    numbers = [given.case] if given.case is not None else range(
        given.first, given.first + given.count)  # fmt: skip
    kinds, of = Counter(), Counter()
    for number in numbers:
        found = play(given.seed, number, folder=given.keep, writer=given.writer)
        if found is None:
            kinds["not installed"] += 1
            continue
        kinds[found.kind] += 1
        of[found.drawing.split()[1].strip(":"), found.kind] += 1
        if found.kind != "twin":
            print(f"{found.kind.upper()}  {found.drawing}\n      {found.said}", flush=True)
    for (writer, kind), n in sorted(of.items()):
        print(f"{writer}: {kind} {n}")
    print(dict(kinds))
    sys.exit(3 if {*kinds} - {*FINE, "not installed"} else 0)


if __name__ == "__main__":
    main()
