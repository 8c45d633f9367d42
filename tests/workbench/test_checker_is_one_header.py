"""The header of ``export --checker``: any C and C++, exact to 1e-15, small, the same every time."""

import ctypes
import itertools
import subprocess
from fractions import Fraction

import numpy as np
import pytest

from generators.published_columns import published_table
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.cli import main
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.grades import Grade
from heyoka_bike.showing.wording.grade_text import WORDS
from heyoka_bike.showing.wording.verdict_text import PHRASES
from support.export_programs import STRICT, need, run

HEADER = "uncontrolled_bicycle.h"
ALL = """
#include "uncontrolled_bicycle.h"

int main(void)
{
    static bicycle_check c;
    char text[100];
    bicycle_begin(&c);
    bicycle_judge(&c);
    return !(bicycle_line(&c, text, sizeof text)[0] == 'n') + bicycle_is_right(&c);
}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("header")
    assert main(["export", "--checker", "-o", f"{found}/"]) == 0
    return found


@pytest.fixture(scope="module")
def library(folder):
    return loaded(folder)


def loaded(folder):
    """Load the header in a folder as a shared library."""
    command = [need("cc"), "-x", "c", "-std=c99", "-O1", "-DBICYCLE_API=", "-shared", "-fPIC"]
    run([*command, HEADER, "-o", "libbicycle.so", "-lm"], folder)
    found = ctypes.CDLL(str(folder / "libbicycle.so"))
    number, array = ctypes.c_double, ctypes.c_void_p
    found.bicycle_evaluate_all.argtypes = [ctypes.c_int, number, array]
    found.bicycle_evaluate.argtypes = [ctypes.c_int, ctypes.c_int, number]
    found.bicycle_evaluate.restype = number
    return found


def columns(reference):
    known = reference[1].definitions
    first = [known[key][0] for key in BENCHMARK_COLUMNS]
    return first + [c for key in BENCHMARK_COLUMNS for c in known[key][1:]]


def test_it_is_small_and_the_same_every_time(folder, tmp_path):
    assert main(["export", "--checker", "-o", str(tmp_path / "again.h")]) == 0
    written = (folder / HEADER).read_bytes()
    assert written == (tmp_path / "again.h").read_bytes()
    assert len(written) <= 500_000
    assert written.decode("ascii").isascii()


def test_its_words_are_those_of_score(folder):
    text = (folder / HEADER).read_text()
    assert f'"", "{WORDS[Grade.RIGHT]}", "{WORDS[Grade.UNTOLD]}"' in text
    for name, words in PHRASES.items():
        assert f'#define UB_{name.upper()} "{words}"\n' in text


def values(library, names, maneuver, times):
    found = np.empty((len(times), len(names)))
    for row, t in zip(found, times, strict=True):
        library.bicycle_evaluate_all(maneuver, t, row.ctypes.data)
    return found


def largest_errors(library, reference, times):
    """Return the largest error of every definition over the maneuvers, in scales."""
    names = [c.name for c in columns(reference)]
    rest = [float(Fraction(repr(t)) - Fraction(t)) if len(repr(t)) < 10 else 0.0 for t in times]
    for n in reference:
        exact = reference[n].evaluate((np.array(times), np.array(rest)), names)
        found = values(library, names, n, times)
        for name, column in zip(names, found.T, strict=True):
            error = np.abs((column - exact.hi[name]) - exact.lo[name]).max()
            yield error / reference[n].scale(name), name


def test_every_definition_is_exact_at_any_time(library, reference):
    random = np.random.default_rng(7)
    times = [*(np.arange(0, 1001, 10) / 100).tolist(), *random.uniform(0, 10, 150).tolist()]
    assert max(largest_errors(library, reference, times)) < (1e-15, "")


@pytest.mark.proof
def test_it_is_exact_at_many_times(library, reference):
    random = np.random.default_rng(8)
    times = [*(np.arange(10001) / 1000).tolist(), *random.uniform(0, 10, 20000).tolist()]
    assert max(largest_errors(library, reference, times)) < (1.5e-15, "")


def test_what_is_not_there_is_not_a_number(library):
    for maneuver, column, t in ((0, 0, 1), (4, 0, 1), (1, -1, 1), (1, 99, 1), (1, 0, -1e-9),
                                (1, 0, 10.1), (1, 0, np.nan)):  # fmt: skip
        assert np.isnan(library.bicycle_evaluate(maneuver, column, t))
    assert library.bicycle_evaluate(2, 2, 0.0) == pytest.approx(4.6, rel=1e-15)


def check_table(library, table, first=1, size=100):
    """Return the grade, the digits and the line of a NumPy table with any strides."""
    count = (table.shape[1] - 1) // 8
    digits = np.full(8 * count, -1.0)
    line = ctypes.create_string_buffer(size)
    grade = library.bicycle_check_table(
        ctypes.c_size_t(len(table)), ctypes.c_void_p(table.ctypes.data),
        ctypes.c_ssize_t(table.strides[0] // 8), ctypes.c_ssize_t(table.strides[1] // 8),
        first, count, ctypes.c_void_p(digits.ctypes.data), line, ctypes.c_size_t(size),
    )  # fmt: skip
    return grade, digits, line.value.decode()


def published(reference, every=10):
    return published_table(reference, reference, every)


def test_arrays_lie_as_they_like(library, reference):
    table = published(reference)
    exact = check_table(library, table)
    assert exact[0] == Grade.RIGHT
    assert exact[1].tolist() == [14.0] * 24
    assert exact[2].startswith("right; the worst column has 14.0 correct digits (")
    for other in (np.asfortranarray(table), np.repeat(table, 2, axis=1)[:, ::2]):
        grade, digits, line = check_table(library, other)
        assert (grade, digits.tolist(), line) == (exact[0], exact[1].tolist(), exact[2])
    alone = np.column_stack([table[:, 0], table[:, 9:17]])
    assert check_table(library, alone, first=2)[:1] == (Grade.RIGHT,)
    assert check_table(library, alone, first=1)[0] == Grade.WRONG
    assert check_table(library, alone, first=4)[2] == PHRASES["nothing"]


def test_a_part_is_not_called_right(library, reference):
    table = published(reference)
    for part in (table[:-20], table[20:], np.delete(table, range(30, 70), axis=0)):
        grade, _, line = check_table(library, part)
        assert grade == Grade.CLOSE
        assert line.startswith("right, compared only in part; the worst")
    table[5, 3] = np.nan
    assert check_table(library, table)[0] == Grade.CLOSE


def test_digits_are_not_rounded_up_to_a_better_grade(library, reference):
    table = published(reference)
    roll = table[:, 1]
    roll[50] += 10.0**-5.97 * reference[1].scale("roll_angle")
    _, digits, line = check_table(library, table)
    assert 5.95 < digits[0] < 6.0
    assert line.startswith(
        "close; the worst column has 5.9 correct digits (roll_angle in maneuver 1"
    )


def test_what_was_never_filled_is_left_out(library, reference):
    table = published(reference)
    table[:, 4] = 0.0
    grade, digits, _ = check_table(library, table)
    assert grade == Grade.CLOSE
    assert np.isnan(digits[3])
    assert digits[0] == 14.0


def test_signs_that_contradict_are_wrong(library, reference):
    for turned, expected in (((1, 2), Grade.RIGHT), ((2,), Grade.WRONG), ((8,), Grade.WRONG)):
        table = published(reference)
        for column in turned:
            table[:, [column, column + 8, column + 16]] *= -1
        assert check_table(library, table)[0] == expected


def test_a_line_is_cut_where_the_room_ends(library, reference):
    table = published(reference)
    whole = check_table(library, table)[2]
    for size in (1, 2, 10, len(whole), len(whole) + 1):
        assert check_table(library, table, size=size)[2] == whole[: size - 1]


def test_hostile_numbers_end(library):
    random = np.random.default_rng(3)
    for bad in (np.nan, np.inf, -np.inf, 1e308, 1e-320, 0.0):
        table = random.standard_normal((50, 25))
        table[random.integers(0, 50, 600), random.integers(0, 25, 600)] = bad
        assert check_table(library, table)[0] in list(Grade)
        assert check_table(library, np.full((20, 25), bad))[0] in list(Grade)
    assert check_table(library, np.empty((0, 25)))[2] == PHRASES["nothing"]


@pytest.mark.proof
def test_any_compiler_takes_it_without_a_word(folder):
    for name in ("all.c", "all.cpp"):
        (folder / name).write_text(ALL)
    kinds = [("gcc", "c99", "c"), ("gcc", "c17", "c"), *(("g++", f"c++{y}", "cpp")
             for y in (11, 17, 20))]  # fmt: skip
    for (compiler, standard, kind), level in itertools.product(kinds, ("-O0", "-O2")):
        strict = [*STRICT, "-Wshadow", "-Wconversion", "-Wno-sign-conversion"]
        run([need(compiler), f"-std={standard}", level, *strict, f"all.{kind}", "-o", "all", "-lm"],
            folder)  # fmt: skip
        run([folder / "all"], folder)
    command = [need("gcc"), "-ffast-math", "all.c", "-o", "all", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode != 0
    assert "without -ffast-math" in done.stderr


@pytest.mark.proof
def test_a_set_of_ones_own_has_a_judge_of_its_own(small_set, tmp_path):
    folder = tmp_path / "header"
    options = ["--reference", str(small_set), "-o", f"{folder}/"]
    assert main(["export", "--checker", *options]) == 0
    found = loaded(folder)
    reference = load_reference(small_set)
    names = [c.name for c in columns(reference)]
    for n in reference:
        exact = reference[n].evaluate("0.085", names)
        (row,) = values(found, names, n, [0.085])
        for name, value in zip(names, row, strict=True):
            assert value == pytest.approx(
                exact[name], rel=1e-14, abs=1e-15 * reference[n].scale(name)
            )
    assert np.isnan(found.bicycle_evaluate(1, 0, 0.4))
    assert np.isnan(found.bicycle_evaluate(2, 0, 0.1))


@pytest.mark.proof
def test_no_byte_is_read_that_is_not_given(folder, reference):
    """Test with the compiler's own checks of memory and arithmetic."""
    table = published(reference, 100)
    rows = ",\n".join(", ".join(map(repr, row)) for row in table.tolist())
    (folder / "table.c").write_text(f"""
#include "uncontrolled_bicycle.h"
static const double table[] = {{{rows}}};
int main(void)
{{
    double digits[24];
    char text[40];
    return bicycle_check_table({len(table)}, table, 25, 1, 1, 3, digits, text, sizeof text);
}}
""")
    checks = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g"]
    run([need("gcc"), "-std=c99", *checks, "table.c", "-o", "table", "-lm"], folder)
    assert subprocess.run([folder / "table"], cwd=folder).returncode == Grade.CLOSE


EDGES = r"""
#include "uncontrolled_bicycle.h"
#include <stdio.h>
#include <stdlib.h>

static bicycle_check c;
static double t[1001], x[1001], rate[1001], others[8][1001], times[1001];

static void say(const char *what)
{
    char line[300];
    bicycle_judge(&c);
    printf("%s: %d %d %s\n", what, c.is_whole, bicycle_is_right(&c),
           bicycle_line(&c, line, sizeof line));
}

static void begin(void)
{
    int i, key;
    for (i = 0; i < 1001; i++) {
        t[i] = times[i] = i / 100.0;
        x[i] = bicycle_evaluate(2, BICYCLE_ROLL_ANGLE, t[i]);
        rate[i] = bicycle_evaluate(2, BICYCLE_ROLL_RATE, t[i]);
        for (key = 1; key < 8; key++)
            others[key][i] = bicycle_evaluate(2, key, t[i]);
    }
    bicycle_begin(&c);
    bicycle_give(&c, 2, BICYCLE_ROLL_ANGLE, 1001, t, 1, x, 1);
    for (key = 1; key < 8; key++)
        bicycle_give(&c, 2, key, 1001, times, 1, others[key], 1);
}

int main(void)
{
    double nan_ = strtod("nan", NULL), inf_ = strtod("inf", NULL);
    int i;
    begin(); say("exact");
    begin(); bicycle_give(&c, 2, BICYCLE_ROLL_RATE, 0, t, 1, x, 1); say("a column less");
    printf("enough: %d %.3f\n", c.columns, c.coverage);
    begin(); bicycle_give(&c, 2, BICYCLE_ROLL_RATE, 501, t, 1, rate, 1); say("half a column");
    printf("half: %d %.3f\n", c.columns, c.coverage);
    begin(); rate[0] = bicycle_evaluate(1, BICYCLE_ROLL_RATE, 0);
    bicycle_give(&c, 1, BICYCLE_ROLL_RATE, 1, t, 1, rate, 1); say("another maneuver");
    begin(); x[500] = nan_; say("a value");
    begin(); for (i = 0; i < 1001; i++) x[i] = nan_; say("all values");
    begin(); x[500] = inf_; say("an infinity");
    begin(); t[500] = nan_; say("a time");
    begin(); t[500] = inf_; say("an infinite time");
    begin(); t[1000] = 10.0000001; x[1000] = 1; say("a late row");
    begin(); bicycle_begin(&c); say("nothing");
    begin();
    for (i = 0; i < 1001; i++) rate[i] = -rate[i];
    bicycle_give(&c, 2, BICYCLE_ROLL_RATE, 1001, t, 1, rate, 1);
    say("signs");
    return 0;
}
"""


def test_what_is_not_finite_or_contradicts_itself_is_not_right(folder):
    (folder / "edges.c").write_text(EDGES)
    run([need("cc"), "-std=c99", "-O2", "edges.c", "-o", "edges", "-lm"], folder)
    lines = run(["./edges"], folder).splitlines()
    said = dict(line.split(": ", 1) for line in lines)
    assert said.pop("exact").startswith("1 1 right; the worst column has 14.0")
    assert (said.pop("enough"), said.pop("half")) == ("7 1.000", "8 0.500")
    assert (
        "right, compared only in part (7 of 8 columns); the worst column" in said["a column less"]
    )
    assert "right, compared only in part; the worst column has 14.0" in said["half a column"]
    assert "compared only in part (1 of 8 columns in maneuver 1)" in said["another maneuver"]
    assert {key: line.split(maxsplit=2)[:2] for key, line in said.items() if key != "signs"} == {
        key: ["0", "0"] for key in said if key not in ("signs", "a late row")
    } | {"a late row": ["1", "0"]}
    assert said["a time"].endswith("cannot be judged: a time is not finite (roll_angle)")
    assert said["an infinite time"].endswith("a time is not finite (roll_angle)")
    assert said["a late row"].split(maxsplit=2)[2].startswith("wrong")
    assert (
        "wrong, because the signs of roll_angle, roll_rate contradict each other; apart from the "
        "signs, the worst column has 14.0" in said["signs"]
    )


@pytest.mark.parametrize("option", ["-ffinite-math-only", "-ffast-math", "-Ofast"])
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_flags_that_take_nan_away_are_refused(compiler, option, folder):
    (folder / "all.c").write_text(ALL)
    found = subprocess.run(
        [need(compiler), "-std=c99", "-O2", option, "-c", "all.c", "-o", "all.o"],
        cwd=folder, capture_output=True, text=True,
    )  # fmt: skip
    assert found.returncode != 0
    assert "error" in found.stderr
    assert "expected" in found.stderr


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_conversions_are_said(compiler, folder):
    (folder / "all.c").write_text(ALL)
    strict = ["-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Werror"]
    run([need(compiler), "-std=c99", "-O2", *strict, "-c", "all.c", "-o", "all.o"], folder)
