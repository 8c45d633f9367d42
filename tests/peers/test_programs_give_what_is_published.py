"""Each installed program of the field reproduces its error in data/results."""

import gzip
import json

import numpy as np
import pytest

from support.peers import apart, field, measured, on_path, problem

FIELD, H1 = field.read_field(), problem.Problem.of("H1")
DOCUMENT = field.HERE.parent.parent / "docs" / "field.json"
RUNS = {
    name: said["runs"]
    for name, said in json.loads(DOCUMENT.read_text(encoding="utf-8"))["programs"].items()
}
# On the same kind of processor, the same version of a program reproduced all bytes. This was
# measured with MuJoCo, PyBullet, Pinocchio, Drake, Simbody, ODE and IDA. Other processors,
# compilers and libraries round differently. This moves steps and iterations that depend on a
# tolerance, and changes the error by less than the error itself. A factor of two indicates a
# different method or setting.
FACTOR = 2.0
# [s] time limit for deriving or compiling a program, and for its run. The cheaper programs take
# less than 20 s.
SECONDS = 600


@pytest.fixture(autouse=True)
def _modules_are_found():
    with on_path():
        yield


def cheaper(name):
    """Return the faster one of a program's two published runs, and its kind; None if none."""
    known = [
        (kind, line) for kind, line in field.published(RUNS.get(name, ())).items()
        if field.is_submitted(field.result_file(name, kind), line)
    ]  # fmt: skip
    return min(known, key=lambda x: x[1]["cpu"], default=(None, None))


def judged(name, kind, reference):
    """Return the judgement of a published file."""
    text = gzip.decompress(field.result_file(name, kind).read_bytes()).decode()
    return H1.judge(text, reference)


def further_apart(found, published):
    """Return columns whose errors differ by more than the factor."""
    return [
        key for key, right in published["scd"].items()
        if abs(found["scd"][key] - right) > np.log10(FACTOR)
    ]  # fmt: skip


@pytest.mark.peers
@pytest.mark.timeout(2 * SECONDS)
@pytest.mark.parametrize("name", FIELD)
def test_a_program_gives_what_is_published(name, reference):
    entry = FIELD[name]
    kind, line = cheaper(name)
    if kind is None:
        pytest.skip(f"{entry['program']}: no result of it is published yet")
    with apart.Apart(SECONDS, field.running, name) as program:
        try:
            program.start()
        except apart.AbsentError as e:
            pytest.skip(f"{entry['program']} is not here: {entry['install']} ({e})")
        here = measured.described(
            entry, field.RESULTS.parent / "peers" / entry.get("folder", name)
        )["installed"]
        wanted = measured.pinned(entry["install"])
        others = {x: v for x, v in here.items() if wanted.get(x, v) != v}
        if others:
            pytest.skip(f"{entry['program']} is here with {others}: {entry['install']}")
        text, _ = program("H1", line["setting"])
    found, published = H1.judge(text, reference), judged(name, kind, reference)
    assert not further_apart(found, published), (found, published)


def test_another_setting_is_told_apart(reference):
    best, default = (judged("ode", kind, reference) for kind in ("best", "default"))
    assert not further_apart(best, best)
    assert "roll_angle" in further_apart(best, default)
