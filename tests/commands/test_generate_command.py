"""`heyoka-bike generate` writes a whole dataset, repairs a damaged one, and refuses bad input."""

import contextlib
import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from fractions import Fraction
from pathlib import Path

import pytest

from heyoka_bike.cli import main
from heyoka_bike.errors import DatasetError
from heyoka_bike.motion import events
from heyoka_bike.reference.load import load_reference
from heyoka_bike.reference.manifest import read_file, read_manifest, render, write_set

SHORT = """
name = "short"
[[maneuver]]
name = "a"
speed = "4"
roll_rate = "0.05"
duration = "0.03"
spacing = "0.01"
"""


def write(folder: Path, text: str = SHORT) -> str:
    path = folder / "maneuvers.toml"
    path.write_text(text)
    return str(path)


@pytest.fixture(scope="module")
def short_set(tmp_path_factory):
    """A small custom dataset: 3 rows of one maneuver."""
    where = tmp_path_factory.mktemp("short")
    out = where / "out"
    arguments = ["--maneuvers", write(where), "--out", str(out), "--workers", "1"]
    assert main(["generate", *arguments]) == 0
    return out


@pytest.mark.proof
def test_writes_a_set_that_loads(short_set, reference):
    loaded = load_reference(short_set)
    assert loaded.dataset_version == "custom"
    assert len(loaded) == 1
    assert loaded[1].time.tolist() == [0.0, 0.01, 0.02, 0.03]
    # The generated motion equals the motion of the published maneuver 1.
    for name in ("roll_angle", "steer_rate"):
        assert loaded[1].rows.hi[name].tolist() == reference[1].rows.hi[name][:4].tolist()
        assert loaded[1].rows.lo[name].tolist() == reference[1].rows.lo[name][:4].tolist()


@pytest.mark.proof
def test_same_bytes_again_nothing_touched_and_quiet_when_not_a_terminal(short_set, tmp_path):
    before = {p.name: (p.read_bytes(), p.stat().st_mtime_ns) for p in short_set.iterdir()}
    run = subprocess.run(
        [sys.executable, "-m", "heyoka_bike", "generate", "--maneuvers", write(tmp_path),
         "--out", str(short_set)],
        capture_output=True, text=True, timeout=300, check=True,
    )  # fmt: skip
    assert run.stderr == ""
    assert "max |E - E0| / E0" in run.stdout
    assert "nothing written" in run.stdout
    after = {p.name: (p.read_bytes(), p.stat().st_mtime_ns) for p in short_set.iterdir()}
    assert after == before


@pytest.mark.proof
def test_refuses_another_version_and_other_inputs(short_set, tmp_path, capsys):
    other = write(tmp_path, SHORT.replace('"4"', '"5"'))
    arguments = ["generate", "--maneuvers", other, "--out", str(short_set)]
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert "--force" in error
    assert error.count("\n") == 1
    # Make a copy with the same inputs and a different dataset version.
    document = json.loads((short_set / "manifest.json").read_text())
    copy = tmp_path / "copy"
    copy.mkdir()
    (copy / "manifest.json").write_text(json.dumps(document | {"dataset_version": "9.9.9"}))
    assert main(["generate", "--maneuvers", write(tmp_path), "--out", str(copy)]) == 1
    assert "9.9.9" in capsys.readouterr().err
    arguments = ["generate", "--maneuvers", write(tmp_path), "--out", str(copy), "--workers", "1"]
    assert main([*arguments, "--force", "--digits", "90"]) == 0
    assert load_reference(copy).dataset_version == "custom"
    # A computation with more digits does not change the published numbers: content_sha256 is a hash
    # of the exact values, not of the run that computed them.
    assert read_manifest(copy).content_sha256 == read_manifest(short_set).content_sha256


@pytest.mark.proof
@pytest.mark.parametrize(
    ("extra", "fragment"),
    [
        (["--digits", "10"], "expected 65 to 1000"),
        (["--digits", "x"], "invalid int value"),
        (["--bicycle", "/nowhere/b.toml"], "/nowhere/b.toml"),
        (["--nonsense"], "unrecognized arguments"),
        (["--after-ten-seconds", "--digits", "80"], "--digits cannot be combined"),
        (["--after-ten-seconds", "--until", "fall"], "--until cannot be combined"),
        (["--after-ten-seconds", "--out", " "], "--out: found nothing"),
    ],
)
def test_bad_arguments_end_with_one_line_and_code_1(tmp_path, capsys, extra, fragment):
    try:
        code = main(["generate", "--out", str(tmp_path / "out"), *extra])
    except SystemExit as e:
        code = e.code
    assert code == 1
    error = capsys.readouterr().err
    assert fragment in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.proof
def test_unwritable_output_is_one_line(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    arguments = ["generate", "--maneuvers", write(tmp_path), "--out", str(tmp_path / "file" / "x")]
    assert main(arguments) == 1
    error = capsys.readouterr().err
    assert "cannot be written" in error
    assert error.count("\n") == 1


@pytest.mark.proof
def test_what_ends_early_is_kept_marked_and_said(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(events, "MAX_SEARCH_TIME", Fraction(1))
    out = tmp_path / "out"
    arguments = ["--maneuvers", write(tmp_path), "--out", str(out), "--workers", "1"]
    assert main(["generate", *arguments, "--until", "fall"]) == 4
    error = capsys.readouterr().err
    assert "stopped early: a: " in error
    assert error.count("\n") == 1
    (maneuver,) = load_reference(out).values()
    assert maneuver.name == "a, no fall within 1 s"


@pytest.mark.slow
def test_a_singular_motion_is_reported_with_its_time_and_kept_up_to_it(tmp_path, capsys):
    fall = SHORT.replace('"0.03"', '"10"').replace('"0.05"', '"5"') + 'roll = "1.4"\n'
    out = tmp_path / "out"
    assert main(["generate", "--maneuvers", write(tmp_path, fall), "--out", str(out)]) == 4
    error = capsys.readouterr().err
    assert "stopped early: a: the motion meets a singularity at t = " in error
    assert error.count("\n") == 1
    end = float(error.split("t = ")[1].split()[0])
    (maneuver,) = load_reference(out).values()
    assert 0 < end - maneuver.time[-1] <= 0.01
    assert maneuver.name == f"a, stopped at {maneuver.time[-1]:g} of 10 s"


@pytest.fixture(scope="module")
def two(tmp_path_factory):
    """A dataset of two maneuvers: one starts upright, the other with roll and steer; each has
    its own rows."""
    where = tmp_path_factory.mktemp("two")
    second = SHORT.split("[[")[1].replace('"a"', '"b"').replace('"0.03"', '"0.04"')
    second += 'roll = "0.1"\nsteer = "-0.2"\nsteer_rate = "0.3"\n'
    text = SHORT.replace('"0.05"', '"0"') + "[[" + second
    assert main(["generate", "--maneuvers", write(where, text), "--out", str(where / "o")]) == 0
    return where / "o"


@pytest.mark.proof
def test_maneuvers_on_their_own_grids_get_a_text_each(two):
    rows = {
        p.name: [line.split() for line in p.read_text().splitlines()] for p in two.glob("*.txt")
    }
    assert sorted(rows) == [
        "uncontrolled-bicycle-1.txt", "uncontrolled-bicycle-2.txt",
        "uncontrolled-bicycle-50digits-1.txt", "uncontrolled-bicycle-50digits-2.txt",
    ]  # fmt: skip
    assert {len(line) for lines in rows.values() for line in lines} == {9}
    assert len(rows["uncontrolled-bicycle-2.txt"]) == 5


@pytest.mark.proof
def test_straight_running_is_steady_and_exact(two):
    rows = load_reference(two)[1].rows
    assert set(rows["forward_speed"]) == {4.0}
    assert set(rows["roll_angle"]) == {0.0}
    assert len(set(rows["kinetic_energy"])) == 1


@pytest.mark.proof
def test_any_initial_posture_works(two):
    """Roll, steer and steer rate are given, and the pitch is solved for. Row 0 contains the
    given values."""
    rows = load_reference(two)[2].rows
    assert rows["roll_angle"][0] == 0.1
    assert rows["steer_angle"][0] == -0.2
    assert rows["steer_rate"][0] == 0.3
    assert rows["roll_rate"][0] == 0.05
    assert 0 < abs(rows["pitch"][0]) < 0.02
    assert len(set(rows["mechanical_energy"])) == 1


@pytest.mark.proof
def test_an_unreachable_posture_is_refused(tmp_path, capsys):
    text = SHORT + 'roll = "1.5"\nsteer = "1.57"\n'
    code = main(["generate", "--maneuvers", write(tmp_path, text), "--out", str(tmp_path / "o")])
    error = capsys.readouterr().err
    assert code == 1
    assert error.count("\n") == 1
    assert "floor" in error or "singular" in error


@pytest.mark.proof
def test_a_singular_mass_matrix_is_refused(tmp_path, capsys):
    """The fork is massless and vertical, and the wheel's mass is on the steer axis: nothing
    resists steer."""
    from heyoka_bike.system.resources import benchmark_bicycle

    lines = benchmark_bicycle().read_text().replace('"pi/10"', '"0"').splitlines()
    zero = ("c ", "mH", "IH", "IF")
    text = "\n".join(
        re.sub(r'value = "[^"]*"', 'value = "0"', x) if x.startswith(zero) else x for x in lines
    )
    path = tmp_path / "bicycle.toml"
    path.write_text(text)
    arguments = ["generate", "--maneuvers", write(tmp_path), "--out", str(tmp_path / "o")]
    assert main([*arguments, "--bicycle", str(path)]) == 1
    errors = capsys.readouterr().err.splitlines()
    assert "mass matrix is singular" in errors[-1]
    assert all("warning" in line for line in errors[:-1])


@pytest.mark.proof
def test_zero_trail_uses_the_regular_form(tmp_path):
    from heyoka_bike.reference.proof.candidate import read_candidate
    from heyoka_bike.system.resources import benchmark_bicycle

    path = tmp_path / "bicycle.toml"
    path.write_text(benchmark_bicycle().read_text().replace('"0.08"', '"0"'))
    out = tmp_path / "o"
    arguments = ["generate", "--maneuvers", write(tmp_path), "--out", str(out), "--workers", "1"]
    assert main([*arguments, "--bicycle", str(path)]) == 0
    assert read_candidate(out)[0].is_regular


@pytest.mark.proof
@pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", -15), ("SIGKILL", -9)])
def test_an_ended_run_leaves_no_worker_and_no_file(tmp_path, name, code):
    run = subprocess.Popen(
        [sys.executable, "-m", "heyoka_bike", "generate", "--out", str(tmp_path / "o")],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=hear_interrupts,
    )  # fmt: skip
    deadline = time.monotonic() + 60
    while len(workers := children(run.pid)) < 3 and time.monotonic() < deadline:
        time.sleep(0.05)  # meanwhile a resource tracker and, with two processors, two workers start
        if len(workers) == 2 and os.cpu_count() == 1:
            break
    assert workers
    time.sleep(1.0)
    run.send_signal(getattr(signal, name))
    _, error = run.communicate(timeout=60)
    assert run.returncode == code
    assert "Traceback" not in error  # Python's resource tracker may print a warning after a kill
    if name == "SIGINT":
        assert error == "heyoka-bike: interrupted\n"
    deadline = time.monotonic() + 30
    while any(is_alive(p) for p in workers) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not [p for p in workers if is_alive(p)]
    assert not (tmp_path / "o").exists()


def hear_interrupts() -> None:
    """Restore the default action: a shell makes its background processes ignore interrupts."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def children(pid: int) -> list[int]:
    # Look at all threads, because an executor's threads start its processes.
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        tasks = Path(f"/proc/{pid}/task").glob("*/children")
        return [int(p) for path in tasks for p in path.read_text().split()]
    return []


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


# This program replaces one dataset with another and back. The test kills it many times.
WRITER = """
import sys
from heyoka_bike.reference.manifest import render, write_set
sets = []
for version in ("1", "2"):
    files = {f"f{i}": (version * 300_000).encode() for i in range(6)}
    made = render(dataset_version=version, content_sha256="", inputs={}, made_by={}, files=files)
    sets.append((files, made))
print("ready", flush=True)
while True:
    for files, made in sets:
        write_set(sys.argv[1], files, made)
"""


def whole(folder: Path) -> bool:
    """True if the dataset in the folder is accepted; then it must be one dataset and
    not a mixture."""
    try:
        manifest = read_manifest(folder)
        contents = {read_file(folder, name, manifest) for name in manifest.files}
    except DatasetError as error:
        if "generate" not in str(error):
            raise
        return False
    assert contents == {(manifest.dataset_version * 300_000).encode()}
    return True


@pytest.mark.proof
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="needs SIGKILL")
def test_a_killed_writer_leaves_a_whole_set_or_a_named_problem(tmp_path):
    rng = random.Random(1)
    outcomes = set()
    for _ in range(25):
        writer = subprocess.Popen(
            [sys.executable, "-c", WRITER, str(tmp_path)], stdout=subprocess.PIPE, text=True
        )
        assert writer.stdout is not None
        assert writer.stdout.readline() == "ready\n"
        time.sleep(rng.uniform(0.0, 0.08))
        os.kill(writer.pid, signal.SIGKILL)
        writer.communicate()
        outcomes.add(whole(tmp_path) if (tmp_path / "manifest.json").exists() else False)
    # Some of the kills must have interrupted the writer ...
    assert False in outcomes
    # ... and one more run of the writer repairs the folder.
    files = {f"f{i}": ("1" * 300_000).encode() for i in range(6)}
    made = render(dataset_version="1", content_sha256="", inputs={}, made_by={}, files=files)
    write_set(tmp_path, files, made)
    assert whole(tmp_path)
    assert not list(tmp_path.glob("*.part"))
