"""`score` and `diagnose` end with a documented exit code for every degenerate file.

A call may take 25 s of processor time and 1 GB. Continuous integration scores 1,800 drawn tables,
and diagnoses 200 others and all files of the corpus with a small budget. The budget does not limit
the steps that look at rows and times before a simulation. The slow tests have a larger budget.
"""

import random
from concurrent.futures import as_completed

import numpy as np
import pytest

from corpus.files import files
from corpus.writing import Runs
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.scoring.rows.grids import step_of
from heyoka_bike.system.jobs import ProcessExecutor, ProcessLimits
from support.degenerate_runs import DOCUMENTED, PRELOAD, on_corpus, on_tables

MOST_MEMORY = 1_000_000_000
# Limits of a process that makes many calls. They are so large that only a call that hangs reaches
# them.
LIMITS = ProcessLimits(600.0, 4 * MOST_MEMORY)
SMALL = ("diagnose", "--budget", "0.05")


def check(jobs, calls, workers=1):
    """Run each job in its own process; check that all calls end with a documented exit code."""
    codes, faults = {}, []
    with ProcessExecutor(workers, LIMITS, PRELOAD) as pool:
        for future in as_completed([pool.submit(*job) for job in jobs]):
            of_job, at_fault, memory = future.result()
            faults += at_fault
            for code, count in of_job:
                codes[code] = codes.get(code, 0) + count
            assert memory < MOST_MEMORY
    assert not faults, "\n".join(faults)
    assert codes.keys() <= DOCUMENTED
    assert sum(codes.values()) >= calls
    return codes


def tables(seed, count, words, folder, each=100):
    return [(on_tables, seed, k, min(each, count - k), words, str(folder))
            for k in range(0, count, each)]  # fmt: skip


@pytest.mark.proof
@pytest.mark.timeout(3600)
def test_2000_degenerate_tables(tmp_path):
    scored = check(tables("scored", 1800, ("score",), tmp_path), 1800)
    diagnosed = check(tables("diagnosed", 200, SMALL, tmp_path), 200)
    # The drawn tables include both good and bad files.
    assert min(scored[k] for k in (0, 1, 2)) > 10
    assert min(diagnosed[k] for k in (0, 1, 2, 4)) > 1


@pytest.mark.proof
@pytest.mark.timeout(3600)
def test_every_file_of_the_corpus_is_diagnosed_in_short(tmp_path):
    count = len(list(files(Runs().index)))
    check([(on_corpus, k, 4, 10, SMALL, str(tmp_path)) for k in range(4)], count)


@pytest.mark.slow
@pytest.mark.timeout(4 * 3600)
def test_2000_degenerate_tables_are_diagnosed(tmp_path):
    """This test takes about an hour on one core."""
    check(tables("slow", 2000, ("diagnose", "--budget", "1"), tmp_path, 25), 2000)


@pytest.mark.slow
@pytest.mark.timeout(4 * 3600)
def test_the_corpus_at_one_row_a_second(tmp_path):
    count = len(list(files(Runs().index)))
    words = ("diagnose", "--budget", "1")
    check([(on_corpus, k, 20, 100, words, str(tmp_path)) for k in range(20)], count)


def written(path, columns, form="%.17g"):
    np.savetxt(path, np.column_stack(columns), form)
    return str(path)


def motion(reference, number, rows, factor=1.0):
    """Columns of a maneuver in the given rows; the motion is multiplied by `factor`."""
    m = reference[number]
    return [m.time[rows], *(factor * m.rows[key][rows] for key in BENCHMARK_COLUMNS)]


@pytest.fixture(scope="module")
def called(reference, tmp_path_factory):
    """Return a function that scores and diagnoses a table of one maneuver: the exit codes and the
    text."""
    folder = tmp_path_factory.mktemp("called")

    def call(capsys, columns, number=1, form="%.17g"):
        path = written(folder / "x.txt", columns, form)
        told, codes = "", []
        for words in (["score", path], [SMALL[0], path, *SMALL[1:]]):
            codes.append(main([*words, "--maneuver", str(number)]))
            told += capsys.readouterr().out
        return codes, " ".join(told.split())

    return call


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
def test_few_rows(reference, called, capsys, count):
    """A correct motion and a wrong one, and the bicycle standing still."""
    rows = np.linspace(0, 1000, count).astype(int)
    for factor in (1.0, 1.3):
        codes, _ = called(capsys, motion(reference, 1, rows, factor))
        assert {*codes} <= {0, 4}
    still = motion(reference, 1, np.zeros(count, int))
    still[0] = np.arange(count) * 0.1
    assert {*called(capsys, still)[0]} <= {0, 2, 4}


MICROSECONDS = """
0 0 0.05 4 8e+02 8e+02 2e+03 0 0
1e-06 0.003 0.04 4 8e+02 8e+02 2e+03 0.004 0.05
2e-06 0.006 0.03 4 8e+02 8e+02 2e+03 0.01 0.05
3e-06 0.007 0.005 4 8e+02 8e+02 2e+03 0.02 0.03
4e-06 0.006 0.02 4 8e+02 8e+02 2e+03 0.02 0.004
5e-06 0.004 0.04 4 8e+02 8e+02 2e+03 0.02 0.03
6e-06 0.0006 0.06 4 8e+02 8e+02 2e+03 0.01 0.05
7e-06 0.004 0.06 4 8e+02 8e+02 2e+03 0.003 0.08
"""


def test_rows_a_microsecond_apart(tmp_path):
    """The distance of the rows is far shorter than a step of the propagation of errors."""
    (tmp_path / "x.txt").write_text(MICROSECONDS)
    path = str(tmp_path / "x.txt")
    assert main(["diagnose", path, "--maneuver", "1", "--budget", "3"]) in (0, 4)


def test_rows_that_repeat_a_time(reference, called, capsys):
    rows = np.arange(0, 1001, 5)
    columns = motion(reference, 2, rows)
    columns[0] = np.floor(columns[0] * 10) / 10
    codes, said = called(capsys, columns, 2)
    assert {*codes} <= {0, 4}
    assert said.count("200 rows repeat the time of another row: the time column has too few") == 2


def test_one_time_in_every_row(reference, called, capsys):
    columns = motion(reference, 1, np.arange(0, 1001, 50))
    columns[0] = np.zeros(21)
    codes, said = called(capsys, columns)
    assert {*codes} <= {0, 4}
    assert "21 rows repeat the time of another row" in said
    # Only one row remains, because all rows have the same time. A single row cannot show which
    # column is wrong.
    assert "Only " not in said


def test_the_numbers_before_the_last_row_without_any(reference, called, capsys):
    columns = motion(reference, 1, np.arange(0, 1001, 10))
    for x in columns[1:]:
        x[80:] = np.nan
    assert {*called(capsys, columns, form="%.9g")[0]} <= {0, 4}


@pytest.mark.parametrize("large", [1e149, 1e300])
def test_large_numbers_beside_small_ones(reference, called, capsys, large):
    columns = motion(reference, 3, np.array([430, 440, 450, 480]))
    for x in columns[1:5]:
        x *= 1e-308
    for x in columns[6:]:
        x[:] = large
    assert {*called(capsys, columns, 3)[0]} <= {0, 2, 4}


def test_levels_that_share_no_step_end():
    """Euclid's algorithm used to loop forever on the last digits of decaying levels."""
    pick = random.Random(1)
    least = float(np.finfo(np.float64).eps)
    for _ in range(300):
        levels = np.unique([pick.gauss(0.0, 1.0) * 0.1**k for k in range(11)])
        assert step_of(levels, least) is None
    levels = 0.0123 * np.unique([pick.randrange(-50, 50) for _ in range(11)])
    assert step_of(levels, least) == pytest.approx(0.0123, rel=1e-12)
