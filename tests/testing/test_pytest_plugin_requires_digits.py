"""`bicycle_score(...)` and the marker fail exactly the tests whose results are too bad."""

import pytest

from generators.plugin_projects import QUICK, outcomes, project
from heyoka_bike.errors import InputError
from heyoka_bike.testing.regression import asked

pytest_plugins = ["pytester"]


def run(pytester, *options):
    return pytester.runpytest_inprocess("-rA", *QUICK, *options)


def check_names(result):
    """Check outcomes against the names of the tests, which contain the expected outcome."""
    found = outcomes(result)
    assert found, result.stdout.str()
    for name, word in found.items():
        expected = {"good": "PASSED", "bad": "FAILED"}[name.split("_")[1]]
        assert word == expected, f"{name}: {word}\n{result.stdout}"
    return found


def test_requirements(pytester):
    project(
        pytester,
        """
        def test_good_digits(table, bicycle_score):
            bicycle_score(table(9)).require(scd=8.9)

        def test_bad_digits(table, bicycle_score):
            bicycle_score(table(9)).require(scd=9.1)

        def test_good_chain(table, bicycle_score):
            score = bicycle_score(table(9))
            same = score.require(scd=8).require("2.roll_angle.scd >= 8.5", coverage=1)
            assert same is score
            assert len(score.report.maneuvers) == 3

        def test_bad_chain(table, bicycle_score):
            bicycle_score(table(9)).require(scd=8).require("2.roll_angle.scd >= 9.5")

        def test_good_other_metrics(by_name, bicycle_score):
            bicycle_score(by_name(6)).require(max_rel_error=1.1e-6, time_to_tolerance=11, mescd=3)

        def test_bad_largest_error(by_name, bicycle_score):
            bicycle_score(by_name(6)).require(max_rel_error=0.9e-6)

        def test_bad_tolerance_is_left(by_name, bicycle_score):
            bicycle_score(by_name(2.5)).require(time_to_tolerance=9)

        def test_good_only_one_column_matters(by_name, bicycle_score):
            results = by_name(9)
            results[3]["steer_angle"] = results[3]["steer_angle"] + 1e-3
            bicycle_score(results).require(maneuver=2, scd=8).require(column="roll_angle", scd=8)

        def test_bad_one_column(by_name, bicycle_score):
            results = by_name(9)
            results[3]["steer_angle"] = results[3]["steer_angle"] + 1e-3
            bicycle_score(results).require(maneuver=3, column="steer_angle", scd=8)

        def test_bad_not_a_number(by_name, bicycle_score):
            results = by_name(9)
            results[1]["roll_rate"][500] = float("nan")
            bicycle_score(results).require(scd=8, coverage=0)

        def test_good_numpy_number(table, bicycle_score):
            import numpy as np
            bicycle_score(table(9)).require(scd=np.float64(8.5))
        """,
    )
    assert len(check_names(run(pytester))) == 11


def test_results_of_every_kind(pytester):
    project(
        pytester,
        """
        import numpy as np
        import pytest
        from heyoka_bike import read_results, load_reference

        def test_good_path(table, bicycle_score, tmp_path):
            np.savetxt(tmp_path / "mine.txt", table(9), fmt="%.17g")
            for path in (tmp_path / "mine.txt", str(tmp_path / "mine.txt")):
                bicycle_score(path).require(scd=8.9)
            bicycle_score(read_results(tmp_path / "mine.txt")).require(scd=8.9)

        def test_bad_path(table, bicycle_score, tmp_path):
            np.savetxt(tmp_path / "mine.txt", table(9), fmt="%.6g")
            bicycle_score(tmp_path / "mine.txt").require(scd=8.9)

        def test_good_nine_columns(table, bicycle_score):
            bicycle_score(table(9)[:, [0, *range(9, 17)]], maneuver=2).require(scd=8.9)

        def test_bad_nine_columns_of_another_maneuver(table, bicycle_score):
            bicycle_score(table(9)[:, [0, *range(9, 17)]], maneuver=1).require(scd=1)

        def test_good_names(by_name, bicycle_score):
            bicycle_score(by_name(9)[2], maneuver=2).require("2.scd >= 8.9")

        def test_good_some_columns(by_name, bicycle_score):
            found = by_name(9)[2]
            some = {key: found[key] for key in ("time", "roll_angle", "steer_angle")}
            bicycle_score({2: some}).require(scd=8.9, columns=2)

        def test_bad_column_is_missing(by_name, bicycle_score):
            found = by_name(9)[2]
            some = {key: found[key] for key in ("time", "roll_angle", "steer_angle")}
            bicycle_score({2: some}).require(column="roll_rate", scd=8.9, columns=2)

        def test_good_groups(by_name, bicycle_score):
            bicycle_score({f"maneuver_{n}": x for n, x in by_name(9).items()}).require(scd=8.9)

        def test_good_mixed(by_name, table, bicycle_score, tmp_path):
            np.save(tmp_path / "3.npy", table(9)[:, [0, *range(17, 25)]])
            bicycle_score({1: by_name(9)[1], 3: tmp_path / "3.npy"}).require(scd=8.9)

        @pytest.mark.parametrize("results", [
            np.zeros((5, 7)), {}, {1: {}}, "no-such-file.txt", [["a"]], None, {4: np.zeros((5, 9))},
        ])
        def test_bad_input(bicycle_score, results):
            bicycle_score(results).require(scd=8)

        def test_bad_maneuver_beside_all(table, bicycle_score):
            bicycle_score(table(9), maneuver=2).require(scd=8)

        def test_good_times(bicycle_reference):
            shared = bicycle_reference.times
            assert shared.shape == (1001,)
            np.testing.assert_array_equal(shared, np.arange(1001) / 100)
            assert bicycle_reference[2].columns == load_reference()[2].columns
        """,
    )
    result = run(pytester)
    assert len(check_names(result)) == 18
    # An unreadable file is reported in one line, without a traceback.
    result.stdout.fnmatch_lines(
        [
            "bicycle_score: array: found 7 columns, expected 9 or 25 columns, or columns named *",
            "bicycle_score: no-such-file.txt: cannot be read (No such file or directory)*",
            "bicycle_score: found maneuver 4, expected 1 to 3",
        ]
    )
    result.stdout.no_fnmatch_line("*Traceback*")
    result.stdout.no_fnmatch_line("*site-packages*")
    result.stdout.no_fnmatch_line("*regression.py*")


def test_runs_that_are_cut_short_do_not_pass_in_silence(pytester):
    project(
        pytester,
        """
        def test_bad_run_ends_early(table, bicycle_score):
            bicycle_score(table(9)[:500]).require(scd=8)

        def test_good_run_is_meant_to_be_short(table, bicycle_score):
            bicycle_score(table(9)[:500]).require(scd=8, coverage=0.49)

        def test_good_first_row_is_left_out(table, bicycle_score):
            bicycle_score(table(9)[1:]).require(scd=8)

        def test_good_other_maneuver_is_short(by_name, bicycle_score):
            results = by_name(9)
            results[1] = {key: x[:500] for key, x in results[1].items()}
            bicycle_score(results).require(maneuver=2, scd=8)
        """,
    )
    result = run(pytester)
    assert len(check_names(result)) == 4
    result.stdout.fnmatch_lines(
        ["required scd >= 8, found only 49.9 % of the run compared (maneuvers 1, 2 and 3)*",
         "compared in part*", "*coverage=0.499 to*"]
    )  # fmt: skip


FEW = """
        def few(by_name):
            keys = ("time", "roll_angle", "steer_angle")
            return {n: {key: x[key] for key in keys} for n, x in by_name(9).items()}
"""


def test_missing_columns_do_not_pass_in_silence(pytester):
    project(
        pytester,
        FEW
        + """
        import pytest

        def test_bad_columns_are_missing(by_name, bicycle_score):
            bicycle_score(few(by_name)).require(scd=8)

        def test_bad_columns_are_missing_beside_one(by_name, bicycle_score):
            bicycle_score(few(by_name)).require(column="roll_angle", scd=8)

        def test_good_columns_are_not_asked_for(by_name, bicycle_score):
            bicycle_score(few(by_name)).require(column="roll_angle", scd=8, columns=2)

        def test_bad_more_are_asked_for(by_name, bicycle_score):
            bicycle_score(few(by_name)).require("scd >= 8", columns=3)

        @pytest.mark.bicycle(scd=8, columns=2)
        def test_good_marker(by_name, bicycle_score):
            bicycle_score(few(by_name))

        @pytest.mark.bicycle(scd=8)
        def test_good_call_completes_the_marker(by_name, bicycle_score):
            bicycle_score(few(by_name)).require(columns=2)

        @pytest.mark.bicycle(scd=10)
        def test_bad_marker_counts_beside_the_call(by_name, bicycle_score):
            bicycle_score(few(by_name)).require(columns=2)
        """,
    )
    result = run(pytester)
    assert len(check_names(result)) == 7
    result.stdout.fnmatch_lines(
        ["required scd >= 8, found only 2 of 8 columns compared (maneuvers 1, 2 and 3)*",
         "*columns=2 to*"]
    )  # fmt: skip


SETTINGS = {"bicycle_scd": "8", "bicycle_columns": "2", "bicycle_coverage": "0.49"}


@pytest.mark.parametrize("where", ["option", "ini"])
def test_settings_say_how_much_is_enough_for_all_tests(pytester, where):
    ini = "\n".join(f"{name} = {x}" for name, x in SETTINGS.items())
    options = [f"--{name.replace('_', '-')}={x}" for name, x in SETTINGS.items()]
    project(
        pytester,
        FEW
        + """
        def test_good_digits_of_the_settings(by_name, bicycle_score):
            bicycle_score(few(by_name)).require()

        def test_good_own_digits(by_name, bicycle_score):
            bicycle_score(few(by_name)).require(scd=8)

        def test_bad_own_columns(by_name, bicycle_score):
            bicycle_score(few(by_name)).require(columns=8)

        def test_good_short_run(table, bicycle_score):
            bicycle_score(table(9)[:500]).require()
        """,
        ini if where == "ini" else "",
    )
    assert len(check_names(run(pytester, *(options if where == "option" else ())))) == 4


@pytest.mark.parametrize("name", ["columns", "coverage"])
def test_settings_that_are_no_numbers_are_refused(pytester, name):
    project(pytester, "def test_nothing(): pass")
    result = run(pytester, f"--bicycle-{name}=most")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"*--bicycle-{name}: found 'most', expected a*"])


def test_markers(pytester):
    project(
        pytester,
        """
        import pytest

        bicycle = pytest.mark.bicycle
        pytestmark = bicycle(scd=9.5)

        def test_bad_module_is_marked(table, bicycle_score):
            bicycle_score(table(9))

        def test_good_is_not_about_bicycles():
            pass

        @bicycle(maneuver=2, column="roll_angle", scd=8)
        def test_good_nearer_marker_decides(table, bicycle_score):
            bicycle_score(table(9))

        @bicycle(maneuver=2, column="roll_angle", scd=9.5)
        def test_bad_checked_at_the_end(table, bicycle_score):
            assert bicycle_score(table(9)).report.maneuvers

        @bicycle(scd=9.5)
        def test_bad_require_without_arguments(table, bicycle_score):
            bicycle_score(table(9)).require()
            raise SystemExit("not reached")

        @bicycle(scd=9.5)
        def test_good_call_says_otherwise(table, bicycle_score):
            bicycle_score(table(9)).require(scd=8)

        @bicycle(scd=9.5)
        def test_bad_call_says_where(by_name, bicycle_score):
            bicycle_score(by_name(9)).require(maneuver=1)

        @bicycle(maneuver=1, scd=8)
        @bicycle(maneuver=2, scd=10)
        def test_bad_both_markers_hold(table, bicycle_score):
            bicycle_score(table(9))

        @bicycle(scd=8)
        def test_bad_second_of_two(table, bicycle_score):
            bicycle_score(table(9))
            bicycle_score(table(7))

        @bicycle(scd=8)
        def test_bad_nothing_scored(bicycle_score):
            pass

        @bicycle(scd=8)
        def test_bad_fixture_not_used():
            pass

        @bicycle(scd=9.5)
        class TestClass:
            def test_bad_method(self, table, bicycle_score):
                bicycle_score(table(9))

            @bicycle(scd=8)
            def test_good_method(self, table, bicycle_score):
                bicycle_score(table(9))

        @pytest.mark.parametrize("digits", [
            pytest.param(9, marks=bicycle(scd=8)), pytest.param(7, marks=bicycle(scd=6)),
        ])
        def test_good_marked_parameters(table, bicycle_score, digits):
            bicycle_score(table(digits))
        """,
    )
    result = run(pytester)
    found = {name.replace("TestClass::", ""): word for name, word in outcomes(result).items()}
    assert len(found) == 15
    for name, word in found.items():
        assert word == ("PASSED" if "_good_" in name else "FAILED"), name
    result.stdout.fnmatch_lines(["*but nothing was scored*"])
    result.stdout.no_fnmatch_line("*SystemExit*")


@pytest.mark.parametrize(
    ("marker", "expected"),
    [
        ("maneuver=2, digits=8", "found 'digits', expected maneuver, column, or one of scd, *"),
        ("2, scd=8", "found 2, expected keywords such as maneuver=2, scd=8"),
        ("column='lean', scd=8", "found column 'lean', expected one of roll_angle,*"),
        ("column='lean'", "found column 'lean', expected one of roll_angle,*"),
        ("maneuver='two', scd=8", "found maneuver='two', expected a maneuver number from 1"),
        ("scd='eight'", "found scd='eight', expected a number"),
        ("scd=float('nan')", "*found*nan*"),
        ("scd=True", "found scd=True, expected a number"),
        ("column='roll_angle', gap=1", "found column 'roll_angle' with 'gap'*"),
    ],
)  # fmt: skip
def test_markers_that_cannot_be_understood_are_refused_before_any_test(pytester, marker, expected):
    pytester.makepyfile(
        f"""
        import pytest

        def test_fine():
            raise SystemExit("not to be run")

        @pytest.mark.parametrize("x", [pytest.param(1, marks=pytest.mark.bicycle({marker}))])
        def test_marked(x):
            pass
        """
    )
    result = pytester.runpytest_inprocess(*QUICK)
    assert result.ret == pytest.ExitCode.INTERRUPTED
    result.stdout.fnmatch_lines([f"*::test_marked?1?: @pytest.mark.bicycle: {expected}"])
    assert "not to be run" not in result.stdout.str()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({"scdd": 8}, "found 'scdd', expected maneuver, column, or one of"),
        ({"scd": None}, "found scd=None, expected a number"),
        ({"maneuver": 1.0, "scd": 8}, "found maneuver=1.0"),
        ({"column": 3}, "found column=3"),
    ],
)
def test_bad_keywords_are_named(arguments, expected):
    with pytest.raises(InputError, match=expected):
        asked(**arguments)


def test_bad_calls_are_told_in_one_line(pytester):
    project(
        pytester,
        """
        def test_bad_keyword(table, bicycle_score):
            bicycle_score(table(9)).require(digits=8)

        def test_bad_text(table, bicycle_score):
            bicycle_score(table(9)).require("scd is 8")

        def test_bad_nothing(table, bicycle_score):
            bicycle_score(table(9)).require()

        def test_bad_about(table, bicycle_score):
            bicycle_score(table(9)).require("scd >= 8", maneuver=2)

        def test_bad_when(table, bicycle_score):
            bicycle_score(table(9), diagnose="always")

        def test_bad_folder(table, bicycle_score):
            bicycle_score(table(9), reference="no-such-folder")
        """,
    )
    result = run(pytester)
    assert len(check_names(result)) == 6
    result.stdout.fnmatch_lines(
        [
            "require: found 'digits', expected maneuver, column, or one of *",
            "require: found 'scd is 8', expected *",
            "require: nothing is required; give a number such as scd=8 here, in the marker *",
            "require: found maneuver= or column= with a requirement as text*",
            "diagnose: found 'always', expected auto or never",
            "no-such-folder: no manifest.json found*",
        ]
    )
    result.stdout.no_fnmatch_line("*regression.py*")


def test_a_score_of_which_nothing_is_required_is_warned_of(pytester):
    project(
        pytester,
        """
        def test_good_nothing(table, bicycle_score):
            bicycle_score(table(1))

        def test_good_looked_at(table, bicycle_score):
            assert bicycle_score(table(1)).report.maneuvers

        def test_good_required(table, bicycle_score):
            bicycle_score(table(9)).require(scd=8)
        """,
    )
    result = run(pytester, "-W", "default")
    assert len(check_names(result)) == 3
    assert result.parseoutcomes()["warnings"] == 1
    result.stdout.fnmatch_lines(["*bicycle_score: the test requires nothing of the results*"])
    # If pytest treats warnings as errors, the finding is a failure of one line.
    result = run(pytester)
    assert result.parseoutcomes() == {"failed": 1, "passed": 2}
    result.stdout.no_fnmatch_line("*plugin.py*")
