"""A separate program accepts the published dataset and rejects damaged ones.

The program is `tests/checker`, in C++ with MPFI. Each test changes the candidate, the
certificate, or both consistently, so that the proof must find the error and not a comparison.
"""

import json
import os
import re
import shutil
import subprocess
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import flint
import h5py
import mpmath
import numpy as np
import pytest

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations import initial
from heyoka_bike.bicycle.equations.constants import constants
from heyoka_bike.bicycle.parameters import STATE_INPUTS, describe_inputs
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator
from heyoka_bike.numbers.arithmetic import Multiprecision
from heyoka_bike.numbers.exact import Exact, shortest_decimal
from heyoka_bike.numbers.rounding import Enclosure, decimal_digits, hi_lo
from heyoka_bike.reference.layout import CANDIDATE, CERTIFICATE, HDF5, TEXT, TEXT_50
from heyoka_bike.reference.proof import candidate as candidate_file
from heyoka_bike.reference.proof import rows
from heyoka_bike.system.resources import reference_folder

SOURCES = Path(__file__).parents[1] / "checker"
# Two segments of each maneuver take seconds to check. All segments take minutes.
UNTIL = ["--until", "0.075"]
ANY_INPUTS = ["--any-inputs", *UNTIL]


@pytest.fixture(scope="session")
def check(tmp_path_factory):
    """The checker, built by the command in its README."""
    line = re.search(r"^g\+\+ .*$", (SOURCES / "README.md").read_text(), re.MULTILINE).group()
    program = tmp_path_factory.mktemp("checker") / "check"
    line = line.replace("tests/checker/prove.cpp", str(SOURCES / "prove.cpp"))
    line = line.replace("tests/checker/check", str(program))
    headers = "#include <hdf5.h>\n#include <mpfi.h>\n#include <mpfi_io.h>\n"
    probe = "g++ -E -x c++ - $(pkg-config --cflags hdf5) > /dev/null"
    if subprocess.run(probe, shell=True, input=headers, text=True, capture_output=True).returncode:
        pytest.skip("needs g++, pkg-config and the headers of MPFI and HDF5")
    built = subprocess.run(line, shell=True, capture_output=True, text=True)
    assert built.returncode == 0, built.stderr

    def run(folder, *options):
        found = subprocess.run([program, folder, *options], capture_output=True, text=True)
        return found.returncode, found.stdout, found.stderr

    return run


@pytest.fixture
def published(tmp_path):
    """A copy of the files that the checker reads."""
    for name in (CANDIDATE, CERTIFICATE, HDF5, TEXT, TEXT_50):
        shutil.copy(reference_folder() / name, tmp_path / name)
    return tmp_path


def candidate(change):
    """Return a function that damages candidate.h5; it calls `change` with the open file."""

    def damage(folder):
        with h5py.File(folder / CANDIDATE, "r+") as f:
            change(f)

    return damage


def certificate(change):
    """Return a function that damages certificate.json; it calls `change` with the document."""

    def damage(folder):
        document = json.loads((folder / CERTIFICATE).read_text())
        change(document)
        (folder / CERTIFICATE).write_text(json.dumps(document))

    return damage


def parameter(name, value):
    """Return a function that changes a parameter in the candidate and in the certificate."""

    def damage(folder):
        def in_candidate(f):
            f.attrs["parameters"] = json.dumps(json.loads(f.attrs["parameters"]) | {name: value})

        candidate(in_candidate)(folder)
        certificate(lambda d: d["inputs"]["bicycle"]["parameters"].update({name: value}))(folder)

    return damage


def start(name, value):
    """Return a function that changes the start of maneuver 1 in candidate and certificate."""

    def damage(folder):
        candidate(lambda f: f["maneuver_1"].attrs.update({name: value}))(folder)
        certificate(lambda d: d["inputs"]["maneuvers"][0].update({name: value}))(folder)

    return damage


def coefficient(piece, state, power, by):
    """Return a function that adds `by` to a coefficient of the candidate of maneuver 1."""

    def change(f):
        group = f["maneuver_1"]
        place = group["coefficients"][piece, state, power]
        n = int.from_bytes(place.tobytes(), "little", signed=True)
        n += round(Fraction(by) * 2 ** int(group.attrs["grid"]))
        raw = n.to_bytes(len(place), "little", signed=True)
        group["coefficients"][piece, state, power] = np.frombuffer(raw, np.uint8)

    return candidate(change)


def shortened(keep):
    """Return a function that removes segments of maneuver 1, except those that `keep` selects."""

    def damage(folder):
        def change(f):
            group = f["maneuver_1"]
            breaks, coefficients = group["breaks"][:], group["coefficients"][:]
            pieces = [i for i in range(len(coefficients)) if keep(i)]
            ends = [*breaks[pieces], breaks[pieces[-1] + 1]]
            del group["breaks"], group["coefficients"]
            group["breaks"], group["coefficients"] = ends, coefficients[pieces]

        candidate(change)(folder)
        with h5py.File(folder / CANDIDATE) as f:
            steps = len(f["maneuver_1/coefficients"])
        certificate(lambda d: d["maneuvers"][0].update(steps=steps))(folder)

    return damage


def cut(f):
    coefficients = f["maneuver_1/coefficients"]
    coefficients[0, :, 20:] = 0


def bounds(document, factor):
    for key in ("interval", "end"):
        for bound in document["maneuvers"][0]["state_bounds"].values():
            bound[key] = f"{float(bound[key]) * factor:.2e}"


def a_fourth_maneuver(document):
    document["inputs"]["maneuvers"].append(document["inputs"]["maneuvers"][2] | {"name": "fourth"})
    document["maneuvers"].append(document["maneuvers"][2] | {"maneuver": "fourth"})


def a_word(file, line, column, change):
    """Return a function that applies `change` to one word of a text file."""

    def damage(folder):
        lines = (folder / file).read_text().splitlines()
        words = lines[line - 1].split(" ")
        words[column - 1] = change(words[column - 1])
        lines[line - 1] = " ".join(words)
        (folder / file).write_text("\n".join(lines) + "\n")

    return damage


def a_digit(file, line, column, decimal):
    """Return a function that changes a digit of a word d.ddd...e-x of a text file."""
    i = decimal + 1
    change = lambda word: f"{word[:i]}{(int(word[i]) + 3) % 10}{word[i + 1 :]}"  # noqa: E731
    return a_word(file, line, column, change)


def published_value(name, row, change):
    """Return a function that applies `change` to a published binary64 value of maneuver 1."""

    def damage(folder):
        with h5py.File(folder / HDF5, "r+") as f:
            values = f["maneuver_1"][name]
            values[row] = change(values[row])

    return damage


def next_up(x):
    return np.nextafter(x, np.inf)


def words_of_certificate(old, new):
    """Return a function that replaces `old` with `new` once in the text of certificate.json."""

    def damage(folder):
        text = (folder / CERTIFICATE).read_text()
        assert text.count(old) >= 1
        (folder / CERTIFICATE).write_text(text.replace(old, new, 1))

    return damage


def another_type(name, kind):
    """Return a function that stores a dataset of the candidate of maneuver 1 as type `kind`."""

    def change(f):
        group = f["maneuver_1"]
        values = group[name][:]
        del group[name]
        group.create_dataset(name, data=values.astype(kind))

    return candidate(change)


def last_break(x):
    def change(f):
        f["maneuver_1/breaks"][-1] = x

    return change


DAMAGES = {
    "the first piece dropped": (shortened(lambda i: i > 0), "the pieces do not cover its time"),
    "a piece dropped inside": (
        shortened(lambda i: i != 1),
        r"piece 0, t = 0 s: \w+: the error may be",
    ),
    "the end missing": (shortened(lambda i: i < 100), "the pieces do not cover its time"),
    "a piece cut to degree 19": (candidate(cut), r"piece 0, t = 0 s: \w+: the error may be"),
    "a state jump of 1e-15": (
        coefficient(1, 0, 0, "1e-15"), r"piece 1, .* roll: the error may be 1\.0",
    ),
    "a start off by 1e-40": (coefficient(0, 2, 0, "1e-40"), "steer at the start: the error may be"),
    "a coefficient off by 1e-22": (coefficient(0, 2, 3, "1e-22"), r"piece 0, .*: the error may be"),
    "the yaw off by 1e-60": (coefficient(0, 6, 5, "1e-60"), r"piece 0, .* yaw: the error may be"),
    "gravity off by 1e-24": (
        parameter("g", str(Fraction(981, 100) + Fraction(1, 10**24))),
        r"piece 0, .*: the error may be",
    ),
    "a mass off by 1e-20": (
        parameter("mB", str(85 + Fraction(1, 10**20))), r"piece 0, .*: the error may be",
    ),
    "an inertia sign flipped": (parameter("IBxz", "-12/5"), r"piece 0, .*: the error may be"),
    "a tilt that is no multiple of pi": (
        parameter("lam", "31415926535897932384626433832795/100000000000000000000000000000000"),
        "the error may be",
    ),
    "a roll rate wrong in the 25th digit": (
        start("roll_rate", str(Fraction(1, 20) + Fraction(1, 10**25))), "w1 at the start: the err",
    ),
    "a mass in one file only": (
        certificate(lambda d: d["inputs"]["bicycle"]["parameters"].update(mF="2")),
        "candidate.h5 has another mF",
    ),
    "a speed in one file only": (
        certificate(lambda d: d["inputs"]["maneuvers"][0].update(speed="5")),
        "candidate.h5 has speed 4, expected 5",
    ),
    "bounds that are too small": (
        certificate(lambda d: bounds(d, 1e-10)), r"piece \d+, .*: the error may",
    ),
    "a bound of nothing": (
        certificate(lambda d: d["maneuvers"][0].update(bound="0")), "at the start: the error may",
    ),
    "a bound that is no number": (
        certificate(lambda d: d["maneuvers"][0].update(bound="nan")), 'found "nan", expected a',
    ),
    "a state variable without a bound": (
        certificate(lambda d: d["maneuvers"][0]["state_bounds"].pop("w3")), "expected bounds of 7",
    ),
    "a parameter more": (
        certificate(lambda d: d["inputs"]["bicycle"]["parameters"].update(wind="1")),
        '"wind" is not known',
    ),
    "the 50th digit of a value": (a_digit(TEXT_50, 2, 6, 49), "line 2, column 6: .* rounds to"),
    "the 15th digit of a value": (a_digit(TEXT, 2, 3, 15), "line 2, column 3: .* rounds to"),
    "the last bit of a value": (
        published_value("steer_rate", 3, next_up), "steer_rate, row 3: not what",
    ),
    "the last bit of a rest": (
        published_value("kinetic_energy_lo", 5, next_up), "energy, row 5: not what",
    ),
    "a bound of a row that is too small": (
        published_value("roll_angle_bound", 2, lambda x: x * 0.99), "roll_angle, row 2: the bound",
    ),
    "a bound of a row that is infinite": (
        published_value("roll_angle_bound", 2, lambda _: np.inf), "row 2: the bound is inf",
    ),
    "a number that is not normalised": (
        a_word(TEXT_50, 3, 2, lambda _: f"0.{'0' * 49}e+50"), "line 3, column 2: .* rounds to",
    ),
    "41 digits in a text of 17": (
        a_word(TEXT, 2, 2, lambda word: word + "0" * 24), "line 2, column 2: .* rounds to",
    ),
    "an exponent in a text of 17 digits": (
        a_word(TEXT, 2, 2, lambda word: f"{float(word):.16e}"), "line 2, column 2: .* rounds to",
    ),
    "a time with more digits": (
        a_word(TEXT_50, 2, 1, lambda word: f"{word}{'0' * 95}1"), "line 2, column 1: .* rounds to",
    ),
    "a key with an escape": (
        words_of_certificate('"bound": "', r'"\u0062ound": "1", "bound": "'), "an escape in JSON",
    ),
    "a key twice": (
        words_of_certificate('"bound": "', '"bound": "1", "bound": "'), "bound is there twice",
    ),
    "a group twice": (
        words_of_certificate('"trusted": [', '"maneuvers": [], "trusted": ['),
        "/maneuvers is there twice",
    ),
    "a key that is a place": (
        words_of_certificate('"trusted": [', '"maneuvers/0/bound": "1", "trusted": ['),
        "a key with a slash",
    ),
    "coefficients as int16": (
        another_type("coefficients", "<i2"), "coefficients is of another type",
    ),
    "breaks as binary32": (another_type("breaks", "<f4"), "breaks is of another type"),
    "a grid as binary64": (
        candidate(lambda f: f["maneuver_1"].attrs.update(grid=253.0)), "grid is of another type",
    ),
    "a speed that is several": (
        candidate(lambda f: f["maneuver_1"].attrs.update(speed=["4", "4"])),
        "speed is of another type or shape",
    ),
    "a last break of infinity": (candidate(last_break(np.inf)), "the last break is not a time"),
    "one more data set": (
        candidate(lambda f: f.create_dataset("maneuver_2/certified", data=1.0)),
        "found certified, and nothing",
    ),
    "one more attribute": (
        candidate(lambda f: f.attrs.update(certified_by="somebody")), "found certified_by, and",
    ),
}  # fmt: skip


def test_it_is_small_enough_to_be_read():
    sources = [path.read_text() for path in SOURCES.iterdir() if path.suffix in (".hpp", ".cpp")]
    lines = [line.strip() for text in sources for line in text.splitlines()]
    assert 0 < sum(1 for line in lines if line and not line.startswith("//")) <= 1100


@pytest.mark.proof
def test_the_published_set_is_accepted_as_far_as_it_is_looked_at(check, published):
    code, out, err = check(published, *UNTIL)
    assert (code, err) == (0, "")
    # The values are those of 5 rows, 3 maneuvers and 2 texts.
    assert "768 values of the rows are correctly rounded" in out
    assert re.search(
        r"^accepted: .*, pieces and rows that begin before that time only$", out, re.MULTILINE
    )


@pytest.mark.slow
def test_the_published_set_is_accepted(check, published):
    code, out, err = check(published)
    assert (code, err) == (0, "")
    assert "96096 values of the rows are correctly rounded\naccepted: " in out


@pytest.mark.slow
def test_a_bound_at_the_end_that_is_too_small_is_refused(check, published):
    def smaller(document):
        document["maneuvers"] = document["maneuvers"][2:]
        document["inputs"]["maneuvers"] = document["inputs"]["maneuvers"][2:]
        document["maneuvers"][0]["state_bounds"]["w3"]["end"] = "1e-76"

    certificate(smaller)(published)

    def only_the_third(f):
        f.move("maneuver_3", "third")
        del f["maneuver_1"], f["maneuver_2"]
        f.move("third", "maneuver_1")

    candidate(only_the_third)(published)
    code, _, err = check(published, "--any-inputs")
    assert code == 3
    assert "refused: maneuver 3: w3 at the end: the error may be" in err


@pytest.mark.proof
@pytest.mark.parametrize("name", DAMAGES)
def test_a_damage_is_refused_in_one_line(check, published, name):
    damage, expected = DAMAGES[name]
    damage(published)
    # ANY_INPUTS allows inputs that differ from the benchmark's. So the checker cannot reject the
    # file because of its inputs, but must find the damage.
    code, _, err = check(published, *ANY_INPUTS)
    assert code == 3
    assert re.fullmatch(rf"refused: .*{expected}.*\n", err), err


OTHERS = {
    "gravity": (parameter("g", "9811/1000"), "g is 9811/1000, that of the benchmark 9.81"),
    "gravity by 1e-24": (
        parameter("g", str(Fraction(981, 100) + Fraction(1, 10**24))), "that of the benchmark 9.81",
    ),
    "the tilt": (parameter("lam", "31415926535/100000000000"), "lam is .* benchmark 1/10.pi"),
    "a roll rate": (start("roll_rate", "-1/20"), "roll_rate is -1/20, that of the benchmark 0.05"),
    "a steer angle": (start("steer", "1/100"), "steer is 1/100, that of the benchmark 0"),
    "a fourth maneuver": (certificate(a_fourth_maneuver), "more maneuvers than the benchmark's"),
    "a third that is missing": (
        certificate(lambda d: (d["maneuvers"].pop(), d["inputs"]["maneuvers"].pop())),
        "fewer or more maneuvers",
    ),
}  # fmt: skip


@pytest.mark.proof
@pytest.mark.parametrize("name", OTHERS)
def test_inputs_that_are_not_the_benchmarks_are_refused_in_one_line(check, published, name):
    damage, expected = OTHERS[name]
    damage(published)
    code, _, err = check(published, *UNTIL)
    assert code == 3
    assert re.fullmatch(rf"refused: .*{expected}.*\n", err), err


def test_the_checker_has_the_benchmarks_own_inputs(bicycle, maneuvers):
    source = (SOURCES / "claims.hpp").read_text()
    own = source.partition("const std::string BICYCLE")[2].partition("// Names of the attributes")[
        0
    ]
    words = " ".join(re.findall(r'"([^"]*)"', own))
    said = iter(words.split())
    pairs = [(name, Exact.parse(value)) for name, value in zip(said, said, strict=True)]
    assert dict(pairs[:26]) == bicycle.values
    rest = dict(pairs[26:31])
    for i, maneuver in enumerate(maneuvers):
        own = dict(pairs[31 + 2 * i : 33 + 2 * i]) | rest
        assert {key: str(own[key]) for key in STATE_INPUTS} == {
            key: str(getattr(maneuver, key)) for key in STATE_INPUTS
        }


def forged_set(folder, bicycle, maneuver):
    """Write a dataset as if the motion from `initial_state` were the benchmark's.

    The claims are 1e-62, which a run of 70 digits meets.
    """
    run = integrate(bicycle, maneuver, 70)
    inputs = describe_inputs(bicycle, [maneuver])
    (folder / CANDIDATE).write_bytes(candidate_file.render([run], inputs, "custom"))
    bounds = {state: {"interval": "1e-62", "end": "1e-62"} for state in run.states}
    entry = {"maneuver": maneuver.name, "steps": run.steps, "ambiguous": 0,
             "bound": "1e-62", "bound_end": "1e-62", "state_bounds": bounds}  # fmt: skip
    document = {"inputs": inputs, "maneuvers": [entry]}
    (folder / CERTIFICATE).write_text(json.dumps(document, indent=2))
    at = evaluator(run, run.bits + 64)
    texts = {TEXT: "", TEXT_50: ""}
    stored = {name + tag: [] for name in BENCHMARK_COLUMNS for tag in ("", "_lo", "_bound")}
    times = [Enclosure.of(maneuver.time(i)) for i in range(maneuver.rows)]
    stored["time"], stored["time_lo"] = zip(*(hi_lo(t, "time") for t in times), strict=True)
    with at.balls.precision():
        for i in range(maneuver.rows):
            found = {name: exact(at.columns(maneuver.time(i))[name]) for name in BENCHMARK_COLUMNS}
            if i == 0:
                given = {"roll_angle": maneuver.roll, "roll_rate": maneuver.roll_rate,
                         "forward_speed": maneuver.speed, "steer_angle": maneuver.steer,
                         "steer_rate": maneuver.steer_rate}  # fmt: skip
                found |= {name: x.rational for name, x in given.items() if not x.pi_multiple}
            words = {name: [shortest_decimal(maneuver.time(i), 50)] for name in texts}
            for name, x in ((name, Enclosure.of(x)) for name, x in found.items()):
                hi, lo = hi_lo(x, name)
                bound = rows.distance(x, hi, lo) * 2
                for tag, number in (("", hi), ("_lo", lo), ("_bound", bound)):
                    stored[name + tag].append(number)
                words[TEXT].append(f"{hi:.17g}")
                words[TEXT_50].append(decimal_digits(x, 50, name))
            for name, line in words.items():
                texts[name] += " ".join(line) + "\n"
    for name, text in texts.items():
        (folder / name).write_text(text)
    with h5py.File(folder / HDF5, "w") as f:
        for name, numbers in stored.items():
            f[f"maneuver_1/{name}"] = np.array(numbers)


def exact(x):
    """Return the middle of a ball."""
    mantissa, exponent = x.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


SHORT = {"duration": Fraction(1, 10), "spacing": Fraction(1, 50)}
ONE_SECOND = {"duration": Fraction(1), "spacing": Fraction(1, 10)}
# The motion from a roll angle of 0.1 rad and a steer angle of -1.5 rad ends after 0.075 s.
HALF_AS_LONG = {"duration": Fraction(1, 20), "spacing": Fraction(1, 100)}


@pytest.fixture
def pitch_is_another_root(monkeypatch, bicycle):
    """Use the pitch root near 3 rad, where the bicycle is turned over its rear hub."""
    with mpmath.workdps(120):
        a = Multiprecision(120)
        k = constants(bicycle, a)
        zero = a.number(0)
        height = lambda pitch: initial.front_contact_height(k, a, zero, pitch, zero)  # noqa: E731
        turned = a.context.findroot(height, a.context.mpf("3.04"))
        assert abs(height(turned)) < 1e-110
    assert 3 < turned < 3.1
    monkeypatch.setattr(initial, "pitch_at_start", lambda *_: flint.arb(str(turned)))


@pytest.mark.proof
@pytest.mark.parametrize(("number", "rows"), [(1, SHORT), (3, ONE_SECOND)])
def test_a_set_that_is_what_it_says_is_accepted(check, tmp_path, bicycle, maneuvers, number, rows):
    """The first dataset is that of the next test, but without a forgery.

    The last row of the second one is at a whole second, where the remainder of the time is zero.
    """
    forged_set(tmp_path, bicycle, replace(maneuvers[number - 1], **rows))
    code, out, err = check(tmp_path, "--any-inputs")
    assert (code, err) == (0, "")
    assert f"accepted: {tmp_path}, for inputs that may be others than the benchmark's" in out


@pytest.mark.proof
@pytest.mark.usefixtures("pitch_is_another_root")
def test_a_bicycle_turned_over_its_rear_hub_is_refused(check, tmp_path, bicycle, maneuvers):
    """The turned bicycle satisfies the same equations, from the same inputs."""
    forged_set(tmp_path, bicycle, replace(maneuvers[0], **SHORT))
    code, _, err = check(tmp_path, "--any-inputs")
    assert code == 3
    said = "pitch at the start: the error may be 3.0., claimed 1e-62"
    assert re.fullmatch(f"refused: {maneuvers[0].name}: {said}\n", err), err


@pytest.mark.proof
@pytest.mark.parametrize(
    ("angles", "rows"),
    [(("1/5", "1/2"), SHORT), (("-1/3", "1"), SHORT), (("1/10", "-3/2"), HALF_AS_LONG),
     (("0", "pi/3"), SHORT)],
)  # fmt: skip
def test_the_pitch_that_grows_from_zero_steer_is_followed(
    check, tmp_path, bicycle, maneuvers, angles, rows
):
    roll, steer = map(Exact.parse, angles)
    forged_set(tmp_path, bicycle, replace(maneuvers[2], roll=roll, steer=steer, **rows))
    code, out, err = check(tmp_path, "--any-inputs")
    assert (code, err) == (0, ""), out


@pytest.mark.proof
def test_a_damage_within_the_claims_is_bounded_by_its_effect(check, published, bicycle, maneuvers):
    """The candidate solves the problem with another gravity, and the claims allow for that."""
    heavier = Fraction(981, 100) + Fraction(1, 10**24)
    parameter("g", str(heavier))(published)
    certificate(lambda d: d["maneuvers"][0].update(bound="1e-18", bound_end="1e-18"))(published)
    certificate(lambda d: bounds(d, 1e48))(published)
    _, out, _ = check(published, *ANY_INPUTS)
    proved = dict(re.findall(r"(\w+) (\S+) \(", out.partition("\n")[0]))
    with h5py.File(published / CANDIDATE) as f:
        end = Fraction(float(f["maneuver_1/breaks"][2]))
    short = replace(maneuvers[0], duration=end)
    runs = [integrate(b, short, 60) for b in (bicycle, bicycle.replace(g=Exact(heavier)))]
    with flint.ctx.workprec(300):
        for j, state in enumerate(runs[0].states):
            true = max(
                abs(float((x.state(end * i / 64)[j] - y.state(end * i / 64)[j]).mid()))
                for i in range(65)
                for x, y in [runs]
            )
            assert true <= float(proved[state]) < 2 * true


@pytest.mark.proof
def test_what_cannot_be_read_is_named_in_one_line(check, published):
    for damage, expected in (
        (lambda: (published / CANDIDATE).write_bytes(b"not HDF5"), "cannot read .*candidate.h5"),
        (lambda: (published / CERTIFICATE).write_text('{"inputs": '), "not JSON"),
        (lambda: (published / CERTIFICATE).unlink(), "certificate.json cannot be read"),
    ):
        damage()
        code, _, err = check(published)
        assert code == 1
        assert re.fullmatch(rf".*{expected}.*\n", err), err
    assert check(published, "--until", "soon")[0] == 1


def shorter(word):
    """Return a number with 20 digits."""
    return word[:21] + word[word.index("e") :]


def off(word):
    """Return a number with 20 digits, with a changed second-to-last digit."""
    digit = (int(word[19]) + 5) % 10
    return f"{word[:19]}{digit}{shorter(word)[20:]}"


@pytest.mark.parametrize(
    ("change", "counted", "reason"),
    [
        (a_word(TEXT_50, 3, 3, shorter), 1, None),
        (a_word(TEXT_50, 3, 3, shorter), 0, "more is not decided than the certificate counts"),
        (a_word(TEXT_50, 3, 3, off), 1, "line 3, column 3: .* rounds to"),
        (a_word(TEXT_50, 3, 3, lambda _: "0e-3"), 1, "line 3, column 3: .* rounds to"),
        (
            published_value("roll_rate", 2, lambda x: x * (1 + 1e-10)),
            1,
            "roll_rate, row 2: .*bound",
        ),
    ],
)
def test_what_is_said_not_to_be_decided_has_to_be_near(check, published, change, counted, reason):
    with h5py.File(published / HDF5, "r+") as f:
        if counted and reason and "row 2" in reason:
            f["maneuver_1"].create_dataset("roll_rate_undecided", data=np.array([2]))
    change(published)
    certificate(lambda document: document["maneuvers"][0].update(ambiguous=counted))(published)
    code, _, err = check(published, *UNTIL)
    assert code == (0 if reason is None else 3)
    assert re.search(reason or "^$", err)


def of_rows(change, maneuver="maneuver_1"):
    """Return a function that damages the rows.

    It calls `change` with the group of the maneuver and the folder.
    """

    def damage(folder):
        with h5py.File(folder / HDF5, "r+") as f:
            change(f[maneuver], folder)

    return damage


def other_time(name):
    def change(group, _):
        group[name][1] = np.nextafter(group[name][1], 1.0)

    return of_rows(change)


def kept_elsewhere(group, folder):
    values = group["roll_angle"][:]
    del group["roll_angle"]
    (folder / "raw").write_bytes(values.tobytes())
    external = [(str(folder / "raw"), 0, values.nbytes)]
    group.create_dataset("roll_angle", values.shape, "f8", external=external)


def virtual(group, folder):
    values = group["roll_angle"][:]
    del group["roll_angle"]
    with h5py.File(folder / "other.h5", "w") as f:
        f["x"] = values
    layout = h5py.VirtualLayout(values.shape, "f8")
    layout[:] = h5py.VirtualSource(str(folder / "other.h5"), "x", shape=values.shape)
    group.create_virtual_dataset("roll_angle", layout)


def linked(group, folder):
    group["own"] = group["roll_angle"][:]
    del group["roll_angle"]
    group["roll_angle"] = h5py.SoftLink(group.name + "/own")


@pytest.mark.proof
@pytest.mark.parametrize("name", ["time", "time_lo"])
def test_other_times_are_refused(check, published, name):
    other_time(name)(published)
    code, _, error = check(published, "--until", "0.02")
    assert (code, "time, row 1: is not that of the row" in error) == (3, True), error


@pytest.mark.proof
@pytest.mark.parametrize(
    ("change", "said"),
    [(kept_elsewhere, "is kept in another file"), (virtual, "is kept in another file"),
     (linked, "is a link, expected numbers stored in the file")],
)  # fmt: skip
def test_numbers_kept_elsewhere_are_refused_before_anything_is_proved(
    check, published, change, said
):
    """Maneuver 3, the last one, is damaged. Reading takes far less than 5 s, a proof minutes."""
    of_rows(change, "maneuver_3")(published)
    limit = os.times().children_user + 5.0
    code, out, error = check(published)
    assert (code, out, error) == (3, "", f"refused: roll_angle {said}\n")
    assert os.times().children_user < limit


@pytest.mark.proof
@pytest.mark.timeout(300, func_only=True)
def test_options_are_taken_in_any_order_and_pipes_are_not_waited_for(check, published):
    for options in (["--until", "1e-9", "--any-inputs"], ["--any-inputs", "--until", "1e-9"]):
        code, out, error = check(published, *options)
        assert (code, error) == (0, "")
        assert "that may be others than the benchmark's, pieces and rows that begin before" in out
    for wrong in (["--until"], ["--until", "0"], ["--any"], ["more"]):
        assert check(published, *wrong)[0] == 1
    (published / CANDIDATE).unlink()
    os.mkfifo(published / CANDIDATE)
    code, _, error = check(published)
    assert code == 1
    assert "is not a regular file" in error
