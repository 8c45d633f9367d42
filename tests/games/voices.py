"""Compare other programs that judge files with `score`: the page, the leaderboard, the plugin.

python tests/games/voices.py honest --count 300 --first 0
python tests/games/voices.py wrong --count 300

The module `checker` compares the header, which gets columns and does not read files.
"""

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

from games.honest_files import honest_file
from games.play import SEED
from games.writing import write
from games.wrong_files import wrong_file
from heyoka_bike import load_reference, score
from heyoka_bike.errors import BicycleError
from heyoka_bike.showing.wording.grade_text import file_grade
from heyoka_bike.workbench.checker import page

NODE = shutil.which("node")
FORMS = ("text", "csv", "semicolons")
_AT_ONCE = 50

# This program runs the page's unchanged scripts in Node, without a document.
_JUDGE = """
const fs = require("fs");
const [, , folder] = process.argv;
const scripts = JSON.parse(fs.readFileSync(`${folder}/scripts.json`, "utf8"));
const source = scripts.map((x) => fs.readFileSync(`${folder}/${x}`, "utf8"));
const data = fs.readFileSync(`${folder}/data.json`, "utf8");
const made = new Function(
  `"use strict"; const data = ${data};\\n${source.join("\\n")}\\nreturn [judgedText, Unreadable];`
);
const [judgedText, Unreadable] = made();
for (const path of fs.readFileSync(0, "utf8").split("\\n").filter(Boolean)) {
  let said;
  try {
    const { line, style, cells, maneuver, guess } = judgedText(fs.readFileSync(path, "utf8"), "it");
    said = { line, style, grade: Math.max(...cells.map((c) => c.grade)), maneuver, guess };
  } catch (e) {
    if (!(e instanceof Unreadable)) throw e;
    said = { refused: e.message };
  }
  console.log(JSON.stringify(said));
}
"""


class PageJudge:
    """The page's reader and judge in Node, called with the paths of texts."""

    def __init__(self, folder):
        self.folder = folder
        for name in page.SCRIPTS:
            shutil.copy(page.KEPT.parent / name, folder)
        (folder / "scripts.json").write_text(json.dumps(page.SCRIPTS))
        (folder / "data.json").write_text(json.dumps(page.page_data()))
        (folder / "judge.js").write_text(_JUDGE)

    def judge(self, paths):
        """Return for each file the shown result, or the reason for rejecting it."""
        done = subprocess.run(
            [NODE, str(self.folder / "judge.js"), str(self.folder)],
            input="\n".join(map(str, paths)), capture_output=True, text=True, timeout=600,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return [json.loads(line) for line in done.stdout.splitlines()]


@dataclass(frozen=True)
class Text:
    """A file of text, and its name."""

    name: str
    path: Path


def texts(game, numbers, folder):
    """Yield the files of a game as texts, in the forms that the page claims to read."""
    for number in numbers:
        random = np.random.default_rng([SEED, number, 77])
        path = folder / f"{game}{number}"
        file = honest_file(SEED, number)[1] if game == "honest" else wrong_file(SEED, number)
        if text := getattr(file, "text", ""):
            path = path.with_suffix(".txt")
            path.write_text(text, newline="")
        elif any(not np.array_equal(p.time, file.parts[0].time) for p in file.parts):
            # Maneuvers with different times do not fit into one table, so this form is not used.
            continue
        else:
            digits = min(getattr(file, "digits", 17) or 17, 17)
            form = str(random.choice(FORMS))
            path, _ = write(random, file.parts, path, form, digits)
        kind = getattr(file, "kind", "")
        yield Text(f"{game} {number}{f' ({kind})' if kind else ''}", path)


def by_score(path):
    """Return the judgement of `score` for a file; None if `score` rejects it."""
    try:
        return score(path)
    except BicycleError:
        return None


def disagreements(report, said):
    """Return the differences of the page from `score`; none if the page rejects the file."""
    if "refused" in said:
        return
    if report is None:
        yield f"score refuses what the page calls {said['line']}"
        return
    # If `score` leaves a definition open, it keeps the default definition, but the page takes the
    # nearest one.
    worse = [c for m in report.maneuvers for c in m.columns if int(c.grade) > said["grade"]]
    if worse and all(c.indistinguishable for c in worse):
        return
    is_right = said["style"] == "right"
    if is_right != report.is_right or said["grade"] != int(file_grade(report)):
        yield f"{said['line']}; score: {report.verdict}"


def compare(judge, files, show=print):
    """Count files: compared, rejected by the page, and different."""
    counts, files = Counter(), list(files)
    for i in range(0, len(files), _AT_ONCE):
        some = files[i : i + _AT_ONCE]
        for file, said in zip(some, judge.judge([x.path for x in some]), strict=True):
            counts["files"] += 1
            counts["refused" if "refused" in said else "compared"] += 1
            if found := list(disagreements(by_score(file.path), said)):
                counts["apart"] += 1
                show(f"{file.name}: {'; '.join(found)}")
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("honest", "wrong"))
    parser.add_argument("--first", type=int, default=0, help="number of the first file (0)")
    parser.add_argument("--count", type=int, default=300, help="files of a game (300)")
    given = parser.parse_args()
    load_reference()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "page").mkdir()
        files = texts(given.what, range(given.first, given.first + given.count), folder)
        print(dict(compare(PageJudge(folder / "page"), files)))


if __name__ == "__main__":
    main()
