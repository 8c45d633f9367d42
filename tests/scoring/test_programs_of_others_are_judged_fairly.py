"""Result files of independent programs are judged fairly: correct files are accused of nothing."""

import pytest

from corpus.answers import ANSWERS, judge, read_index
from corpus.files import files
from corpus.writing import File, Runs, text
from heyoka_bike.commands.result_files import read
from heyoka_bike.scoring.score import score

LEAST = 0.95
"""Smallest share of the visible mistakes that must be named correctly and first."""

SOME = (
    "symbrim-left-degrees-km-h", "symbrim-roll-and-steer-2", "exudyn-only-3", "linear-only-1",
    "symbrim-fork-not-rotated-only-1", "symbrim-start-by-front-radius-only-3",
    "exudyn-gravity-9.8",
)  # fmt: skip
"""One file of each kind, for continuous integration."""


def check(found):
    """Check that no honest file is accused, and that enough visible mistakes are named first."""
    honest = [j for j in found if "visible" not in j.entry]
    mistakes = [j for j in found if j.entry.get("visible")]
    right = [j for j in mistakes if j.outcome == "right"]
    lines = [f"honest: {len(honest)}, accused {sum(j.outcome == 'unfair' for j in honest)}; "
             f"visible mistakes: {len(mistakes)}, named first {len(right)}"]  # fmt: skip
    for j in found:
        if j.outcome not in ("right", "fair"):
            name, answer = j.entry["name"], j.entry["expected"]
            lines.append(f"{j.outcome:6} {name} ({answer}): {j.said[:200]}")
    table = "\n".join(lines)
    print(table)
    assert not any(j.outcome == "unfair" for j in honest), table
    assert len(right) >= LEAST * len(mistakes), table


def fewest_digits(file, runs, folder, reference):
    """Correct digits of the worst interpreted column, apart from columns of unknown definition."""
    path = folder / "file.txt"
    path.write_text(text(file, runs))
    report = score(read(str(path), None, reference), reference)
    unknown = [f.message for f in report.findings if f.code == "definition_unknown"]
    return min(
        c.as_understood.measures.scd
        for m in report.maneuvers
        for c in m.columns
        if not any(c.key in message for message in unknown)
    )


@pytest.mark.proof
def test_definitions_signs_units_and_zeros_cost_no_digits(reference, tmp_path):
    runs = Runs()
    plain = {
        run: fewest_digits(File("", run), runs, tmp_path, reference)
        for run in ("symbrim-dop853-1e-12", "exudyn-trapezoidal-0.001", "newton-dop853-1e-12")
    }
    # The error of a column differs between its definitions, but has about the same size in all of
    # them. So up to half a digit may be lost.
    lost = {
        f.name: (digits, plain[f.run])
        for f in files(runs.index)
        if f.expected == "convention" and f.run in plain
        if (digits := fewest_digits(f, runs, tmp_path, reference)) < plain[f.run] - 0.5
    }
    # Two columns have no known definition: the speed of the rider's own centre of mass, and a rate
    # about a ground axis. The nearest known definition is not rejected for them.
    assert lost.keys() <= {"exudyn-rider", "exudyn-global-rate"}, lost


def test_every_answer_is_known():
    asked = {entry["expected"] for entry in read_index().values()}
    assert asked - {"correct", "convention"} == set(ANSWERS)


@pytest.mark.proof
def test_some_files_of_other_programs(reference, tmp_path):
    check(judge(SOME, tmp_path, reference))


@pytest.mark.slow
def test_all_files_of_other_programs(reference, tmp_path):
    check(judge(None, tmp_path, reference))
