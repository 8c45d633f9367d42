"""What works without heyoka, and what starts fast."""

import subprocess
import sys

import pytest
from support.without_packages import HEAVY, python

from heyoka_bike.system.resources import data_folder


def test_the_reader_needs_numpy_and_h5py_only():
    code = """
from heyoka_bike import load_reference, load_sensitivities
r = load_reference()
print(r[2].evaluate("0.07")["roll_angle"])
load_sensitivities()[2].evaluate([0.07])
"""
    run = python(code, HEAVY)
    assert run.returncode == 0, run.stderr
    assert float(run.stdout) == pytest.approx(0.03396573763788303, abs=0)


RESULTS = str(data_folder() / "peers" / "exudyn-h0.001.txt")


@pytest.mark.parametrize(
    "arguments",
    [["linear", "--speeds", "5"], ["--help"], ["score", RESULTS]],
)
def test_commands_work_without_heyoka(arguments):
    code = f"import sys; from heyoka_bike.cli import main; sys.exit(main({arguments!r}))"
    run = python(code, {"heyoka"})
    assert run.returncode == 0, run.stderr


def test_fast_runs_work_without_heyoka():
    pytest.importorskip("llvmlite")
    code = """
from heyoka_bike import Ensemble, simulate
print(simulate(2)["roll_angle"][-1], Ensemble().ends([[0, 0, 0.5, 0, 4.6]], 10.0)[0, 0])
"""
    run = python(code, {"heyoka"})
    assert run.returncode == 0, run.stderr
    one, other = map(float, run.stdout.split())
    assert one == pytest.approx(other, abs=1e-4)
    missing = python(code, {"llvmlite"})
    assert "simulate needs it (pip install 'heyoka_bike[generate]')" in missing.stderr


@pytest.mark.parametrize("arguments", [["generate"], ["bench"], ["verify", "--rerun"]])
def test_commands_that_need_heyoka_say_so(arguments):
    code = f"import sys; from heyoka_bike.cli import main; sys.exit(main({arguments!r}))"
    run = python(code, {"heyoka", "llvmlite", "filelock"})
    assert run.returncode == 1
    assert "heyoka is not installed" in run.stderr
    assert "pip install 'heyoka_bike[generate]' on Linux, or conda install heyoka.py" in run.stderr
    assert run.stderr.count("\n") == 1


def test_output_that_cannot_be_written_is_no_internal_error():
    command = f"{sys.executable} -m heyoka_bike linear"
    for shell, code in (
        (f"{command} > /dev/full", 1), (f"{command} >&-", 1),
        (f"set -o pipefail; {command} | head -n 1", 0),
        (f"set -o pipefail; {sys.executable} -m heyoka_bike --cite | true", 0),
        (f"set -o pipefail; {sys.executable} -u -m heyoka_bike --help | true", 0),
    ):  # fmt: skip
        run = subprocess.run(["bash", "-c", shell], capture_output=True, text=True, timeout=60)
        assert run.returncode == code, shell
        assert run.stderr.count("\n") == (1 if code else 0)


def test_help_imports_nothing_heavy():
    code = """
import sys
from heyoka_bike.cli import parser
parser()
print(sorted({m.partition(".")[0] for m in sys.modules} & %r))
"""
    run = python(code % (HEAVY | {"numpy", "h5py"}))
    assert run.stdout.strip() == "[]", run.stderr


@pytest.mark.parametrize("name", ["table", "json", "csv", "junit", "html"])
def test_scoring_needs_little(name):
    code = f"""
import sys
from heyoka_bike.cli import main
sys.exit(main(["score", {RESULTS!r}, "--format", {name!r}]))
"""
    run = python(code, HEAVY)
    assert run.returncode == 0, run.stderr
    assert run.stderr == ""


def test_a_score_imports_what_it_uses():
    """Each of these takes a tenth of the time of importing NumPy and h5py, or more."""
    code = f"""
import sys
from heyoka_bike.cli import main
main(["score", {RESULTS!r}, "--require", "scd >= 3"])
avoided = {{"rich", "numpy.ma", "heyoka_bike.showing.figures", "heyoka_bike.bicycle.parameters"}}
print(sorted(avoided & set(sys.modules)))
"""
    run = python(code)
    assert run.stdout.splitlines()[-1] == "[]", run.stderr
