"""Coq proves Theorem 1 for the first second of maneuver 3, and rejects wrong certificates.

The development is in `tests/checker/formal`. Each damage is made in its certificate, cut to two
segments, or in its equations.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import mpmath
import pytest

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.numbers.arithmetic import Multiprecision

SOURCES = Path(__file__).parents[1] / "checker" / "formal"
ORDER = re.search(r"for f in (.*); do coqc", (SOURCES / "README.md").read_text()).group(1).split()
INSTALL = "apt-get install coq libcoq-interval"
CHECKED = """From Coq Require Import List.
Require Import Enclosure Equations Certificate.
Lemma checked : check equations integers start pieces = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
"""
# Axioms of CoqInterval, Flocq and the real numbers of Coq's library.
ASSUMED = re.compile(
    r"(Uint63|PrimInt63|PrimFloat|FloatAxioms|ClassicalDedekindReals)\.\w+"
    r"|FunctionalExtensionality\.functional_extensionality_dep|Classical_Prop\.classic"
)


def compiled(folder, name):
    """Run Coq on a file; return its exit code and its output."""
    found = subprocess.run(["coqc", f"{name}.v"], cwd=folder, capture_output=True, text=True)
    return found.returncode, found.stdout + found.stderr


@pytest.fixture(scope="module")
def theory(tmp_path_factory):
    """A folder with everything compiled, except the certificate and the files that need it."""
    folder = tmp_path_factory.mktemp("theory")
    probe = "From Interval Require Import Eval.Eval.\nFrom Coquelicot Require Import Coquelicot.\n"
    (folder / "Probe.v").write_text(probe)
    if shutil.which("coqc") is None or compiled(folder, "Probe")[0]:
        pytest.skip(f"needs Coq with CoqInterval: {INSTALL}")
    for name in ORDER:
        shutil.copy(SOURCES / f"{name}.v", folder)
        if name not in ("Certificate", "Maneuver3"):
            code, said = compiled(folder, name)
            assert code == 0, said
    return folder


@pytest.fixture
def short(theory, tmp_path):
    """A copy of the folder, with a certificate of two segments."""
    folder = tmp_path / "short"
    shutil.copytree(theory, folder)
    text = (folder / "Certificate.v").read_text()
    begin, *pieces = text.split("  Piece ")
    cut = begin + "  Piece " + "  Piece ".join(pieces[:2]).rstrip().rstrip(";") + "].\n"
    (folder / "Certificate.v").write_text(cut)
    (folder / "Checked.v").write_text(CHECKED)
    return folder


def is_accepted(folder):
    for name in ("Equations", "Certificate"):
        code, said = compiled(folder, name)
        assert code == 0, said
    code, said = compiled(folder, "Checked")
    assert code == 0 or "check equations integers start pieces = true" in said, said
    return code == 0


def swapped(name, pattern, change):
    """Return a damage that changes the first group of a pattern's only match."""

    def damage(folder):
        file = folder / f"{name}.v"
        text = file.read_text()
        found = re.search(pattern, text, re.DOTALL)
        new = change(found.group(1))
        assert new != found.group(1)
        file.write_text(text[: found.start(1)] + new + text[found.end(1) :])

    return damage


def moved(by):
    return lambda digits: str(int(digits) + by)


SECOND = r"Piece \[.*?Piece \["  # matches two segments, up to the coefficients of the second
NUMBERS = r"\]\]\s+"  # matches up to the four numbers of the first
DAMAGES = {
    "the candidate begins elsewhere": swapped("Certificate", r"Piece \[\[(0);", moved(2**30)),
    "its polynomial is another": swapped("Certificate", r"Piece \[\[0; (-?\d+)", moved(2**30)),
    "the second piece jumps": swapped("Certificate", SECOND + r"\[(-?\d+)", moved(2**30)),
    "errors grow less": swapped("Certificate", NUMBERS + r"\((\d+)\)", moved(-24)),
    "the defect is less": swapped(
        "Certificate", NUMBERS + r"\(\d+\) \((\d+)\)", lambda n: str(int(n) // 10**4)
    ),
    "the bound is less": swapped(
        "Certificate", NUMBERS + r"\(\d+\) \(\d+\) \(\d+\) \((\d+)\)", lambda n: str(int(n) // 10)
    ),
    "another start": swapped("Certificate", r"\((1, 20)\)", lambda _: "1, 21"),
    "another bicycle": swapped("Equations", r"\((20090)\)", moved(1)),
    "another equation": swapped("Equations", r"Binary (Sub) \d+ \d+ ", lambda _: "Add"),
}


@pytest.mark.formal
def test_coq_proves_the_theorem(theory):
    for name in ("Certificate", "Maneuver3"):
        code, said = compiled(theory, name)
        assert code == 0, said
    assumed = re.findall(r"^([\w.]+)\s*:", said.partition("Axioms:")[2], re.MULTILINE)
    assert assumed
    assert [x for x in assumed if not ASSUMED.fullmatch(x)] == []


@pytest.mark.formal
def test_two_pieces_are_accepted(short):
    assert is_accepted(short)


@pytest.mark.formal
@pytest.mark.parametrize("what", DAMAGES)
def test_a_wrong_certificate_is_refused(short, what):
    DAMAGES[what](short)
    assert not is_accepted(short)


def test_nothing_is_left_unproved():
    for name in ORDER:
        text = (SOURCES / f"{name}.v").read_text()
        assert not re.search(r"\b(Axiom|Parameter|Conjecture|Admitted|admit|Abort)\b", text), name


def test_the_program_is_the_equations():
    """The program's operations, as defined in Coq, give the rates of the state."""
    text = (SOURCES / "Equations.v").read_text()
    integers, program = (part.partition("\n")[2] for part in text.split("Definition ")[1:])
    a = Multiprecision(40)
    mp = a.context
    bicycle, _ = benchmark()
    state = [mp.mpf(x) / 64 for x in (3, -1, 5, 7, -9, 1700, 2)]
    stack = [*state, *(mp.mpf(n) for n in re.findall(r"\((-?\d+)\)", integers)), mp.pi]
    unary = {"Neg": lambda x: -x, "Sin": mp.sin, "Cos": mp.cos}
    binary = {
        "Add": lambda x, y: x + y, "Sub": lambda x, y: x - y,
        "Mul": lambda x, y: x * y, "Div": lambda x, y: x / y,
    }  # fmt: skip
    for line in program.splitlines():
        words = line.partition("(*")[0].split()
        if not words or words[0] not in ("Forward", "Unary", "Binary"):
            continue
        numbers = [stack[int(n)] for n in words if n.isdigit()]
        if words[0] != "Forward":
            numbers = [(unary | binary)[words[1]](*numbers)]
        stack[:0] = numbers
    wanted = Equations.of(bicycle, a).rates_with_yaw(state)
    for found, rate in zip(stack, wanted, strict=False):
        assert mpmath.almosteq(found, rate, rel_eps=1e-33)


@pytest.mark.proof
def test_files_are_those_of_the_command(tmp_path):
    command = [sys.executable, str(SOURCES / "export.py"), str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    for name in ("Equations.v", "Certificate.v"):
        assert (tmp_path / name).read_text() == (SOURCES / name).read_text()
