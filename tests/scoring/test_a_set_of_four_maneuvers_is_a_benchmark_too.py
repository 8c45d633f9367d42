"""The number of maneuvers, their rows and the limits of eq. (1) come from the dataset.

A dataset of four short maneuvers, two of which have performance limits of their own, is scored,
diagnosed, required, exported, plotted, replayed and ranked like the benchmark.
"""

import hashlib
import json
import re
import shutil
import subprocess
from itertools import pairwise

import numpy as np
import pytest

from generators.made_sets import manifest
from heyoka_bike import diagnose, load_reference, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.bicycle.parameters import benchmark, read_maneuvers
from heyoka_bike.cli import main
from heyoka_bike.errors import InputError
from heyoka_bike.reference.description import COPYRIGHT
from heyoka_bike.reference.manifest import read_manifest
from heyoka_bike.showing.wording.verdict_text import performance_remark
from heyoka_bike.system.resources import benchmark_maneuvers
from heyoka_bike.workbench.leaderboard import ranking

pytestmark = pytest.mark.proof

MANEUVERS = "".join(
    f'[[maneuver]]\nname = "{name}"\nspeed = "{speed}"\nroll_rate = "{rate}"\n'
    f'duration = "0.4"\nspacing = "0.01"\n{limit}'
    for name, speed, rate, limit in (
        ("slow", "4", "0.05", ""),
        ("middle", "4.6", "0.5", 'performance_limit = { value = "1e-2", unit = "%" }\n'),
        ("fast", "8", "0.05", ""),
        ("left", "5.5", "-0.3", 'performance_limit = { value = "2e-4", unit = "%" }\n'),
    )
)


@pytest.fixture(scope="module")
def folder(made_once):
    def fill(place):
        (place / "m.toml").write_text(MANEUVERS)
        made = ["generate", "--maneuvers", str(place / "m.toml"), "--out", str(place / "set")]
        assert main(made) == 0

    return made_once("four-maneuvers", fill)


@pytest.fixture(scope="module")
def four(folder):
    return load_reference(folder / "set")


def table(four, change=lambda number, key, x: x):
    """The time and 32 columns, in the order of the published file."""
    columns = [four.times]
    columns += [change(n, key, four[n][key]) for n in four for key in KEYS]
    return np.column_stack(columns)


def written(path, four, change=lambda number, key, x: x):
    np.savetxt(path, table(four, change), fmt="%.17g")
    return path


def drifting(number, key, x):
    """Let the energies of maneuver 4 grow by 3e-4 %; change nothing else."""
    if number != 4 or not key.endswith("energy") or key == "potential_energy":
        return x
    return x + 3e-6 * 2500.0 * np.linspace(0.0, 1.0, len(x))


def test_the_set_has_the_limit_and_is_verified(folder, four, capsys):
    assert (len(four), four.judged) == (4, (2, 4))
    assert (four[2].performance_limit, four[4].performance_limit) == (1e-2, 2e-4)
    assert main(["verify", str(folder / "set")]) == 0
    assert main(["certify", str(folder / "set")]) == 0


def test_a_file_of_it_is_right(four, tmp_path, capsys):
    path = written(tmp_path / "a.txt", four)
    asked = ["--reference", str(four.folder), "--require", "4.performance < 2e-4"]
    assert main(["score", str(path), *asked, "--require", "4.scd >= 12"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "right; the worst column" in said
    assert said.count("limits how much the energy varies in maneuvers 2 and 4. ") == 1
    assert re.search(r"Maneuver 2 passes with \S+ % \(limit 1e-2 %\)\. Maneuver 4 passes", said)
    assert re.search(r"Maneuver 4 passes with \S+ % \(limit 2e-4 %\)", said)


def test_its_own_limit_judges(four, tmp_path, capsys):
    path = written(tmp_path / "a.txt", four, drifting)
    report = score(path, four, ["performance < 2e-4", "4.scd >= 12", "3.scd >= 12"])
    assert report[4].meets_limit is False
    assert [r.met for r in report.requirements] == [False, False, True]
    assert [m.meets_limit for m in report.maneuvers[:3]] == [None, True, None]


def test_the_first_and_the_last_are_judged_by_limits_of_two_digits(four, tmp_path):
    # The motion does not depend on the limits, so a copy of the same dataset with different limits
    # is enough.
    other = shutil.copytree(four.folder, tmp_path / "set")
    manifest(other, performance_limits={"1": "1/400", "4": "1/10000"})
    judged = load_reference(other)
    assert judged.judged == (1, 4)
    said = performance_remark(score(written(tmp_path / "a.txt", four, drifting), judged))
    assert re.search(r"Maneuver 1 passes with \S+ % \(limit 2.5e-3 %\)\. Maneuver 4 FAILS", said)
    assert re.search(r"Maneuver 4 FAILS with \S+ % \(limit 1e-4 %\)", said)
    assert "maneuver 2" not in said.lower()


def test_what_is_said_of_eq_1_leaves_out_what_has_no_energy(four):
    columns = {"time": four.times, "m2_roll_angle": four[2]["roll_angle"]}
    columns |= {f"m4_{key}": four[4][key] for key in KEYS}
    said = performance_remark(score(columns, four))
    assert said.startswith("eq. (1), the benchmark's own test, limits how much the energy varies")
    assert "in maneuver 4. The file passes with " in said
    assert "maneuver 2" not in said


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_each_maneuver_is_found(four, number, tmp_path):
    alone = np.column_stack([four.times, *(four[number][key] for key in KEYS)])
    assert list(score(alone, four)) == [number]
    named = {"time": four.times} | {f"m{number}_{key}": four[number][key] for key in KEYS}
    assert score(named, four).is_right
    with pytest.raises(InputError, match="expected 1 to 4"):
        score(alone, four, maneuver=5)


def test_maneuvers_in_each_others_place_are_named(four, tmp_path):
    order = {3: 4, 4: 3}
    mixed = table(four, lambda n, key, x: four[order.get(n, n)][key])
    found = diagnose(mixed, four).diagnosis
    exchanged = [(f.code, f.evidence["maneuver"], f.evidence["of_maneuver"]) for f in found]
    assert exchanged == [("other_maneuver", 3, 4), ("other_maneuver", 4, 3)]
    for f, (n, of) in zip(found, order.items(), strict=True):
        assert f.message.startswith(f"Maneuver {n} has the values of maneuver {of}. ")


@pytest.mark.parametrize("format_", ["c", "fortran", "matlab", "json", "csv", "netcdf"])
def test_it_is_exported(four, format_, tmp_path):
    out = tmp_path / "out"
    asked = ["--format", format_, "-o", str(out), "--reference", str(four.folder)]
    assert main(["export", *asked]) == 0
    files = [out, *out.rglob("*")] if out.is_dir() else [out]
    said = b"".join(p.read_bytes() for p in files if p.is_file())
    # This dataset is not the benchmark, so the page shows neither the benchmark's title nor its
    # licence.
    assert b"IFToMM multibody benchmark" not in said
    assert COPYRIGHT.encode() not in said
    assert b"left" in said or b"maneuver_4" in said or b"4" in said


def test_the_header_judges_it(four, tmp_path):
    assert main(["export", "--checker", "-o", str(tmp_path), "--reference", str(four.folder)]) == 0
    header = (tmp_path / "uncontrolled_bicycle.h").read_text()
    assert "BICYCLE_MANEUVERS = 4" in header
    assert "ub_pieces_4" in header
    # The page is compiled for the published dataset only, so the export is refused.
    assert main(["export", "--page", "-o", str(tmp_path), "--reference", str(four.folder)]) == 1
    program = tmp_path / "judge.c"
    program.write_text(
        '#include <stdio.h>\n#include "uncontrolled_bicycle.h"\n'
        "int main(void) { char text[8]; ub_put_number(text, sizeof text, 0, 120);\n"
        'printf("%d %s", BICYCLE_MANEUVERS, text); return 0; }\n'
    )
    if shutil.which("gcc"):
        subprocess.run(["gcc", str(program), "-o", str(tmp_path / "judge"), "-lm"], check=True)
        assert subprocess.run([tmp_path / "judge"], capture_output=True).stdout == b"4 120"


def test_it_is_drawn_and_replayed(four, tmp_path):
    path = written(tmp_path / "a.txt", four, drifting)
    reference = ["--reference", str(four.folder)]
    assert main(["plot", str(four.folder), "-o", str(tmp_path / "p"), "--format", "svg"]) == 0
    assert len(list((tmp_path / "p").iterdir())) == len(four)
    assert main(["score", str(path), "-o", str(tmp_path / "r.html"), *reference]) == 0
    assert "Maneuver 4" in (tmp_path / "r.html").read_text()
    page = str(tmp_path / "a.html")
    assert main(["animate", str(path), "--maneuver", "4", "-o", page, *reference]) == 0


def test_it_is_ranked(folder, four, tmp_path, monkeypatch, capsys):
    inputs = ("benchmark", str(folder / "m.toml"))
    monkeypatch.setitem(ranking.PROBLEMS, "H4", ranking.RankedProblem(inputs))
    sizes = {"worse": 1e-4, "better": 1e-8}
    for name, size in sizes.items():
        file = written(tmp_path / f"{name}.txt", four, lambda n, key, x, s=size: x * (1 + s))
        digest = hashlib.sha256(file.read_bytes()).hexdigest()
        (tmp_path / f"{name}.toml").write_text(
            f'name = "{name}"\nproblem = "H4"\nprogram = "mine"\nversion = "1"\n'
            'method = "none"\ncoordinates = "none"\nprecision = "binary64"\ncontact = "here"\n'
            'tolerance = "1e-9"\nprocessor_time = "1"\nmachine = "a desk"\nlicence = "CC0-1.0"\n'
            f'[[file]]\npath = "{file.name}"\nsha256 = "{digest}"\n'
        )
    asked = ["leaderboard", str(tmp_path), "--reference", str(four.folder), "--format", "json"]
    code, out = main(asked), json.loads(capsys.readouterr().out)
    assert (code, out["refused"]) == (0, [])
    (ranked,) = (p for p in out["problems"] if p["entries"])
    assert [e["name"] for e in ranked["entries"]] == ["better", "worse"]
    digits = [e["scd"] for e in ranked["entries"]]
    assert all(a > b for a, b in pairwise(digits))


def test_the_published_set_has_the_limit_of_the_benchmarks_own_maneuvers():
    limits = {n: m.performance_limit for n, m in enumerate(benchmark()[1], 1)}
    published = load_reference()
    assert {n: published[n].performance_limit for n in published} == {
        n: None if x is None else float(x) for n, x in limits.items()
    }
    assert published.judged == (2,)
    # The published manifest has no entry for the limits, so its bytes do not change.
    assert "performance_limits" not in (published.folder / "manifest.json").read_text()


@pytest.mark.parametrize(("entry", "said"), [
    ('performance_limit = { value = "1e-3", unit = "J" }', r"found unit 'J', expected '%'"),
    ('performance_limit = { value = "0", unit = "%" }', r"found 0 %, expected a positive number"),
    ('performance_limit = { value = "abc", unit = "%" }', "expected"),
])  # fmt: skip
def test_a_limit_that_is_none_is_refused(entry, said, tmp_path):
    path = tmp_path / "m.toml"
    path.write_text(benchmark_maneuvers().read_text() + f"{entry}\n")
    with pytest.raises(InputError, match=rf"m\.toml: maneuver 3, performance_limit.*{said}"):
        read_maneuvers(path)


def test_a_limit_is_no_input_of_the_motion(folder):
    one, other = (read_maneuvers(folder / "m.toml")[3] for _ in range(2))
    assert one.performance_limit is not None
    assert one == other
    assert read_manifest(folder / "set").inputs["maneuvers"][3].keys() == {
        "name", "speed", "roll_rate", "roll", "steer", "steer_rate", "duration", "spacing",
    }  # fmt: skip
