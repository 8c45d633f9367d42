"""Features that work without heyoka, and commands that start fast."""

import subprocess
import sys

import pytest

from heyoka_bike.system.resources import data_folder
from support.without_packages import HEAVY, python

RESULTS = str(data_folder() / "peers" / "exudyn-h0.001.txt")


def test_reading_a_reference_and_scoring_need_numpy_and_h5py_only():
    code = f"""
from heyoka_bike import load_reference, load_sensitivities
from heyoka_bike.cli import main
for name in ("table", "json", "csv", "junit", "html"):
    assert main(["score", {RESULTS!r}, "--format", name]) == 0
r = load_reference()
load_sensitivities()[2].evaluate([0.07])
print()
print(r[2].evaluate("0.07")["roll_angle"])
"""
    run = python(code, HEAVY)
    assert (run.returncode, run.stderr) == (0, "")
    assert float(run.stdout.splitlines()[-1]) == pytest.approx(0.03396573763788303, abs=0)


def test_without_heyoka_commands_work_or_say_that_they_need_it():
    works = [["linear", "--speeds", "5"], ["score", RESULTS]]
    needs = [["generate"], ["bench"], ["verify", "--rerun"]]
    code = f"""
from heyoka_bike.cli import main
for arguments in {works!r}:
    assert main(arguments) == 0, arguments
for arguments in {needs!r}:
    assert main(arguments) == 1, arguments
"""
    run = python(code, {"heyoka", "llvmlite"})
    assert run.returncode == 0, run.stderr
    lines = run.stderr.splitlines()
    assert len(lines) == len(needs)
    for line in lines:
        assert "heyoka is not installed" in line
        assert "pip install 'heyoka_bike[generate]' on Linux, or conda install heyoka.py" in line


@pytest.mark.proof
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


@pytest.mark.proof
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
    code = f"""
import sys
from heyoka_bike.cli import parser
parser()
print(sorted({{m.partition(".")[0] for m in sys.modules}} & {HEAVY | {"numpy", "h5py"}!r}))
"""
    run = python(code)
    assert run.stdout.strip() == "[]", run.stderr


def test_a_score_imports_what_it_uses():
    """Each of these modules takes at least a tenth of the time of importing NumPy and h5py.

    ``bicycle.parameters`` is not in the list: it reads the limit of eq. (1) of a published dataset.
    """
    code = f"""
import sys
from heyoka_bike.cli import main
main(["score", {RESULTS!r}, "--require", "scd >= 3"])
avoided = {{"rich", "numpy.ma", "heyoka_bike.workbench.figures"}}
print(sorted(avoided & set(sys.modules)))
"""
    run = python(code)
    assert run.stdout.splitlines()[-1] == "[]", run.stderr
