"""No test has the marks of two tiers: `-m proof` selects the proofs that are not slow."""

import subprocess
import sys
from itertools import combinations
from pathlib import Path

import pytest

TIERS = ("proof", "slow", "peers", "formal")


@pytest.mark.proof
def test_no_test_has_two_marks():
    both = " or ".join(f"({a} and {b})" for a, b in combinations(TIERS, 2))
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q", "-n", "0", "-m", both]
    root = Path(__file__).resolve().parents[2]
    run = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=600)
    assert run.returncode == pytest.ExitCode.NO_TESTS_COLLECTED, run.stdout + run.stderr
