"""The command ``linear`` prints the results of the linearisation with the requested digits."""

import argparse
import json
import re
import subprocess
import sys
from fractions import Fraction

import mpmath
import pytest

from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.commands import linear as command
from heyoka_bike.errors import InputError
from heyoka_bike.system.resources import benchmark_bicycle

NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d+(?:e[+-]?\d+)?(?![\w.])")
# A bicycle of two point masses on skates. The heavy mass is ahead of the front contact point.
STABLE = dict.fromkeys(("mR", "IRxx", "IRyy", "mF", "IFxx", "IFyy"), "0")
STABLE |= dict.fromkeys((f"I{body}{ij}" for body in "BH" for ij in ("xx", "yy", "zz", "xz")), "0")
STABLE |= {"w": "1", "c": "-0.02", "lam": "-pi/36", "rR": "0.1", "rF": "0.1"}
STABLE |= {"mB": "10", "xB": "1.2", "zB": "-0.4", "mH": "1", "xH": "1.02", "zH": "-0.2"}
BAD_SPEEDS = [
    "",
    "a",
    "1,,2",
    "pi",
    "0:1",
    "0:1:2:3",
    "0:1:0",
    "0:1:-1",
    "2:1:1",
    "0:1:1e-9",
    "nan",
]


@pytest.fixture
def run(capsys):
    """Return a function that runs the command and returns its output."""

    def run(*arguments):
        parser = argparse.ArgumentParser()
        command.add_parser(parser.add_subparsers())
        args = parser.parse_args(["linear", *arguments])
        assert args.run(args) == 0
        return capsys.readouterr().out

    return run


@pytest.fixture
def bicycle_file(tmp_path):
    """Return a function that writes the benchmark's file with some values changed, and returns
    its path."""

    def write(**changes):
        text = benchmark_bicycle().read_text("utf-8")
        for symbol, value in changes.items():
            text, n = re.subn(
                rf'^({symbol}\s*= {{ value = )"[^"]*"', rf'\g<1>"{value}"', text, flags=re.M
            )
            assert n == 1
        path = tmp_path / "bicycle.toml"
        path.write_text(text, "utf-8")
        return str(path)

    return write


def _significant(text):
    """Number of significant digits in a text."""
    return len(text.partition("e")[0].lstrip("-0.").replace(".", ""))


@pytest.mark.parametrize("digits", [5, 15, 30])
def test_every_number_has_all_digits(run, digits):
    out = run("--digits", str(digits), "--speeds", "0,3,5")
    numbers = NUMBER.findall(out)
    # The terms are g, 13 nonzero matrix entries, and 4 + 6 + 6 nonzero parts of eigenvalues. The
    # last 7 are the weave speed, its frequency, the capsize speed, the double root, its eigenvalue,
    # and both ends of the stable range.
    assert len(numbers) == 1 + 13 + 16 + 7
    assert {_significant(x) for x in numbers} == {digits}


@pytest.mark.parametrize("digits", [15, pytest.param(1000, marks=pytest.mark.proof)])
def test_no_number_is_cut_or_folded(run, bicycle, digits):
    out = run("--digits", str(digits), "--speeds", "5")
    linear = linearise(bicycle, digits)
    root = min(linear.eigenvalues(5), key=lambda z: z.real)
    for x in (linear.M[1][1], linear.K2[0][1], root.real, linear.capsize_speeds[0]):
        text = mpmath.nstr(x, digits, strip_zeros=False)
        assert any(text in line.replace("│", " ").split() for line in out.splitlines())
    assert "…" not in out
    assert "..." not in out


def test_table_shows_eigenvalues_and_critical_speeds(run):
    out = run("--digits", "10", "--speeds", "4.6")
    for text in (
        "4.6", "-13.29863952", "-0.3779662263", "-3.872841916", "3.872841916",
        "weave speed [m/s]", "4.292382536", "weave frequency [rad/s]", "3.435033849",
        "capsize speed [m/s]", "6.024262015", "double root", "0.6842830789", "3.782904051",
        "stable from [m/s]", "stable to [m/s]", "-80.95000000", "M [kg m^2]", "K2 [kg]",
    ):  # fmt: skip
        assert text in out


def test_json_holds_the_same_numbers_as_strings(run, bicycle):
    found = json.loads(run("--digits", "20", "--speeds", "0:6:1.5", "--format", "json"))
    linear = linearise(bicycle, 20)

    def texts(x):
        return mpmath.nstr(x, 20, strip_zeros=False) if x else "0"

    assert found["bicycle"] == "benchmark bicycle"
    assert found["digits"] == 20
    for name in ("M", "C1", "K0", "K2"):
        assert found[name] == [[texts(x) for x in row] for row in getattr(linear, name)]
    speeds = ["0", "1.5", "3", "4.5", "6"]
    assert [entry["speed"] for entry in found["eigenvalues"]] == speeds
    for entry in found["eigenvalues"]:
        roots = linear.eigenvalues(Fraction(entry["speed"]))
        assert entry["eigenvalues"] == [{"re": texts(z.real), "im": texts(z.imag)} for z in roots]
    ((weave, frequency),) = linear.weave_speeds
    ((double, value),) = linear.double_roots
    (capsize,) = linear.capsize_speeds
    assert found["weave"] == [{"speed": texts(weave), "frequency": texts(frequency)}]
    assert found["capsize"] == [{"speed": texts(capsize)}]
    assert found["double_roots"] == [{"speed": texts(double), "eigenvalue": texts(value)}]
    assert found["stable_ranges"] == [{"from": texts(weave), "to": texts(capsize)}]


def test_default_speeds_are_0_to_10(run):
    found = json.loads(run("--format", "json"))
    assert [entry["speed"] for entry in found["eigenvalues"]] == [str(v) for v in range(11)]
    assert found["digits"] == 15


@pytest.mark.parametrize(
    ("text", "speeds"),
    [
        ("3", ["3"]),
        ("0, 4.6,-8", ["0", "4.6", "-8"]),
        ("0:1:0.25", ["0", "0.25", "0.5", "0.75", "1"]),
        ("0:1:0.4", ["0", "0.4", "0.8"]),
        ("2:2:1", ["2"]),
        ("1/3", ["1/3"]),
    ],
)
def test_speeds_are_exact(text, speeds):
    assert command.parse_speeds(text) == [Fraction(v) for v in speeds]


def test_speeds_without_end_are_printed_with_more_digits_than_asked_for(run):
    assert "0.333333333333333" in run("--digits", "5", "--speeds", "1/3")


def test_a_bicycle_without_critical_speeds_says_none(run, bicycle_file):
    path = bicycle_file(c="0", lam="0", IFyy="0", IRyy="0")
    out = run("--bicycle", path, "--speeds", "1")
    for quantity in ("weave speed", "capsize speed", "stable from"):
        assert re.search(rf"{quantity} \[m/s\]\W*none", out)
    found = json.loads(run("--bicycle", path, "--speeds", "1", "--format", "json"))
    assert found["weave"] == found["capsize"] == found["stable_ranges"] == []


def test_a_stable_range_without_end_says_so(run, bicycle_file):
    path = bicycle_file(**STABLE)
    out = run("--bicycle", path, "--speeds", "1")
    assert re.search(r"stable to \[m/s\]\W*no end", out)
    found = json.loads(run("--bicycle", path, "--speeds", "1", "--format", "json"))
    assert found["stable_ranges"][-1]["to"] is None


@pytest.mark.parametrize("speeds", BAD_SPEEDS)
def test_bad_speeds_are_refused_in_one_line(run, speeds):
    with pytest.raises(InputError, match=r"^--speeds: found .*, expected ") as e:
        run(f"--speeds={speeds}")
    assert "\n" not in str(e.value)


@pytest.mark.parametrize("digits", ["4", "1001", "-1"])
def test_digits_out_of_range_are_refused(run, digits):
    with pytest.raises(InputError, match=f"^--digits: found {digits}, expected 5 to 1000$"):
        run(f"--digits={digits}")


def test_a_missing_file_is_named(run, tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.toml: "):
        run("--bicycle", str(tmp_path / "nowhere.toml"))


def test_help_has_an_example(capsys):
    parser = argparse.ArgumentParser()
    command.add_parser(parser.add_subparsers())
    with pytest.raises(SystemExit, match="0"):
        parser.parse_args(["linear", "--help"])
    out = capsys.readouterr().out
    assert "example: heyoka-bike linear --digits 30" in out


def test_the_parser_needs_no_heavy_import():
    code = (
        "import argparse, sys; from heyoka_bike.commands import linear; "
        "linear.add_parser(argparse.ArgumentParser().add_subparsers()); "
        "print(sorted({'mpmath', 'flint', 'rich', 'numpy', 'heyoka'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_nothing_needs_heyoka(bicycle):
    code = (
        "import sys; sys.modules['heyoka'] = None; import argparse; "
        "from heyoka_bike.commands import linear as c; p = argparse.ArgumentParser(); "
        "c.add_parser(p.add_subparsers()); a = p.parse_args(['linear', '--speeds', '1']); a.run(a)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert bicycle.name in done.stdout
