"""Compare the checker in C with `score`, column by column.

python tests/games/checker.py results          # data/results
python tests/games/checker.py corpus           # tests/corpus
python tests/games/checker.py honest --count 1000 --first 0
python tests/games/checker.py wrong --count 1000
"""

import argparse
import math
import struct
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from functools import cache
from itertools import islice
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

from games.files import in_memory, references
from heyoka_bike import load_reference, read_results
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.errors import BicycleError
from heyoka_bike.scoring.alignment import align, merge
from heyoka_bike.scoring.judge.unfilled import without_unfilled
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.score import scored
from heyoka_bike.scoring.units import UNITS
from heyoka_bike.showing.wording.verdict_text import PHRASES, graded
from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.checker.header import checker_header

MOST_DIGITS = 14.0
"""The checker counts at most this many digits."""

APART = 0.1
"""Digits by which the two may differ."""

_AT_ONCE = 20

_DRIVER = """
#include "uncontrolled_bicycle.h"
#include <stdio.h>
#include <stdlib.h>

int main(void)
{
    static bicycle_check c;
    int count, head[5], m, k, i;
    char text[200];
    while (fread(&count, sizeof count, 1, stdin) == 1) {
        double *kept[48];
        bicycle_begin(&c);
        for (i = 0; i < count; i++) {
            bicycle_data *d;
            if (fread(head, sizeof head, 1, stdin) != 1)
                return 1;
            kept[i] = (double *)malloc(2 * sizeof(double) * (size_t)head[4] + 1);
            if (fread(kept[i], 2 * sizeof(double), (size_t)head[4], stdin) != (size_t)head[4])
                return 1;
            bicycle_give(&c, head[0], head[1], (size_t)head[4], kept[i], 2, kept[i] + 1, 2);
            d = &c.data[head[0] - 1][head[1]];
            d->digits = head[2];
            d->places = head[3];
        }
        bicycle_judge(&c);
        for (m = 0; m < BICYCLE_MANEUVERS; m++)
            for (k = 0; k < BICYCLE_KEYS; k++) {
                bicycle_result *r = &c.result[m][k];
                if (r->rows)
                    printf("%d %s %.17g %.17g %.17g %s %d '%s' %.17g %d %llu\\n", m + 1,
                           bicycle_key(k), r->digits, r->mescd, r->max_error,
                           bicycle_definition(r->column), r->sign, r->unit, r->offset, r->grade,
                           r->also);
            }
        printf("%s\\n", bicycle_line(&c, text, sizeof text));
        for (i = 0; i < count; i++)
            free(kept[i]);
    }
    return 0;
}
"""


@dataclass(frozen=True)
class Found:
    """The result of the checker for a column."""

    digits: float
    mescd: float
    max_error: float
    definition: str
    sign: int
    unit: str
    offset: float
    grade: int
    also: frozenset


@cache
def _header():
    return checker_header(load_reference()).decode()


class Checker:
    """The compiled header, called with a batch of files."""

    def __init__(self, folder, change=("", "")):
        text = _header()
        assert change[0] in text
        (folder / "uncontrolled_bicycle.h").write_text(text.replace(*change) if change[0] else text)
        (folder / "driver.c").write_text(_DRIVER)
        self.program = folder / "driver"
        subprocess.run(
            ["cc", "-std=c99", "-O2", "driver.c", "-o", str(self.program), "-lm"],
            cwd=folder, check=True, timeout=120,
        )  # fmt: skip
        keys = load_reference()[1].definitions
        self.names = [keys[key][0].definition for key in BENCHMARK_COLUMNS]
        self.names += [c.definition for key in BENCHMARK_COLUMNS for c in keys[key][1:]]

    def judge(self, files):
        """Return for each file and each of its parts the found columns and the line."""
        given = b"".join(map(_packed, files))
        done = subprocess.run([str(self.program)], input=given, capture_output=True, check=True)
        found, outcomes = {}, []
        for line in done.stdout.decode().splitlines():
            if not line[:1].isdigit():
                outcomes.append((found, line))
                found = {}
                continue
            head, unit, rest = line.split("'")
            m, key, digits, mescd, error, definition, sign = head.split()
            offset, grade, also = rest.split()
            others = {n for i, n in enumerate(self.names) if int(also) >> i & 1}
            found[int(m), key] = Found(float(digits), float(mescd), float(error), definition,
                                       int(sign), unit, float(offset), int(grade),
                                       frozenset(others))  # fmt: skip
        return outcomes


def _packed(parts):
    columns = [(p, key) for p in parts for key in BENCHMARK_COLUMNS if key in p.values]
    found = [struct.pack("i", len(columns))]
    for p, key in columns:
        q = p.quantum.get(key)
        digits = q.digits if q and q.base == 10 and q.digits and q.digits <= 17 else 0
        places = q.places if q and q.base == 10 and q.places is not None else -1
        place = BENCHMARK_COLUMNS.index(key)
        found.append(struct.pack("5i", p.number, place, digits, places, len(p.time)))
        # Take the binary64 number nearest to hi + lo.
        values = p.values[key] + p.lo.get(key, 0.0)
        found.append(np.column_stack([p.time, values]).tobytes())
    return b"".join(found)


@dataclass(frozen=True)
class Judged:
    """A file that both judge: its parts as read, and the report of `score`."""

    name: str
    parts: tuple
    report: object


def judged_by_score(name, results):
    """Return the judgement of `score`, with the benchmark's columns as the checker gets them."""
    reference, _ = references()
    several = [results] if isinstance(results, Results) else results
    try:
        read = merge([align(r, reference) for r in several])
        return Judged(name, read.parts, scored(without_unfilled(read), reference))
    except BicycleError:
        return None


def disagreements(judged, found, line):
    """Return the differences of the checker from `score` for each column, in words."""
    report = judged.report
    units = {(p.number, k): u for p in judged.parts for k, u in p.units.items()}
    theirs = {(m.maneuver, c.key): c for m in report.maneuvers for c in m.columns
              if c.key in BENCHMARK_COLUMNS and c.values}  # fmt: skip
    for at, c in theirs.items():
        si = DEFINITIONS[at[1]][0].unit
        if units.get(at, si) not in UNITS[si]:
            # The heading states a unit other than the SI unit. The checker does not read headings,
            # so it cannot convert the values.
            continue
        mine = found.get(at)
        if mine is None:
            yield f"{at}: left out"
            continue
        taken = c.as_understood
        known = {c.definition, *c.indistinguishable}
        if mine.definition not in known and c.definition not in mine.also:
            yield f"{at}: {mine.definition}, score {sorted(known)}"
        if taken.unit in UNITS[si] and (mine.unit, mine.sign) != (taken.unit, taken.sign):
            yield f"{at}: {mine.unit} {mine.sign}, score {taken.unit} {taken.sign}"
        digits = min(c.scd if c.scd is not None else math.nan, MOST_DIGITS)
        if mine.definition != c.definition and mine.digits >= digits - APART:
            # If the definition is open, `score` keeps the default definition, but the checker takes
            # the nearest one.
            continue
        if not abs(mine.digits - digits) <= APART and not math.isnan(digits):
            yield f"{at}: {mine.digits:.2f} digits, score {digits:.2f} ({c.definition})"
        if mine.grade != c.grade:
            yield f"{at}: grade {mine.grade}, score {c.grade:d}"
    for at in found.keys() - theirs.keys():
        yield f"{at}: too many"
    # Compare two lists in the verdicts: the columns whose definition the verdict asks for, and the
    # columns with contradictory signs.
    are_all_read = all(
        units.get(at, "") in ("", *UNITS[DEFINITIONS[at[1]][0].unit]) for at in units
    )
    are_all_read &= all(c.key in BENCHMARK_COLUMNS for m in report.maneuvers for c in m.columns)
    if are_all_read and (mine := _reasons(line)) != (others := _reasons(graded(report))):
        yield f"{mine}, score {others}"


def _reasons(line):
    """Return the columns whose definition the verdict asks for, and those of wrong signs."""
    asked = line.partition("? If not, ")[0].partition(": ")[0] if "? If not, " in line else ""
    signs = line.partition(PHRASES["signs_of"])[2].partition(PHRASES["contradict"])[0]
    return asked, signs


def result_files():
    for path in sorted((data_folder() / "results").glob("*.txt.gz")):
        yield path.name, lambda path=path: read_results(path)


def corpus_files(every=1):
    from corpus.files import files
    from corpus.writing import Runs, text
    from heyoka_bike.commands.result_files import read

    runs = Runs()
    with tempfile.TemporaryDirectory() as folder:
        for file in list(files(runs.index))[::every]:
            path = Path(folder) / f"{file.name}.txt"
            path.write_text(text(file, runs))
            yield file.name, lambda path=path: read(str(path), None, load_reference(), None)


def game_files(game, numbers):
    from games.honest_files import honest_file
    from games.play import SEED
    from games.wrong_files import wrong_file

    for number in numbers:
        if game == "honest":
            _, honest = honest_file(SEED, number)
            yield f"honest {number}", lambda honest=honest: in_memory(honest.parts)
        else:
            wrong = wrong_file(SEED, number)
            if not wrong.text:
                name = f"wrong {number} ({wrong.kind})"
                yield name, lambda wrong=wrong: in_memory(wrong.parts, wrong.quantum)


def judged_files(files):
    """Yield the judgements of `score` for the files that it can read."""
    for name, make in files:
        try:
            results = make()
        except BicycleError:
            continue
        if judged := judged_by_score(name, results):
            yield judged


def compare(checker, files, show=print):
    """Count files and columns, compared and different; `files` is the result of `judged_files`."""
    counts, files = Counter(), iter(files)
    while batch := list(islice(files, _AT_ONCE)):
        outcomes = checker.judge([j.parts for j in batch])
        for j, (found, line) in zip(batch, outcomes, strict=True):
            said = list(disagreements(j, found, line))
            counts.update(files=1, columns=len(found), apart=len(said), files_apart=bool(said))
            if said:
                show(f"{j.name}, {line}: {'; '.join(said[:3])}")
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("results", "corpus", "honest", "wrong"))
    parser.add_argument("--first", type=int, default=0, help="number of the first file (0)")
    parser.add_argument("--count", type=int, default=1000, help="files of a game (1000)")
    given = parser.parse_args()
    if given.what == "results":
        files = result_files()
    elif given.what == "corpus":
        files = corpus_files()
    else:
        files = game_files(given.what, range(given.first, given.first + given.count))
    with tempfile.TemporaryDirectory() as folder:
        counts = compare(Checker(Path(folder)), judged_files(files))
    print(dict(counts))


if __name__ == "__main__":
    main()
