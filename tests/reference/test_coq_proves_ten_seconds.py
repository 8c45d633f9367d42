"""Coq proves Theorem 1 for ten seconds of each maneuver, and rejects wrong certificates.

The development is in `tests/checker/formal`. Each damage is made in the certificate of maneuver 3,
cut to three pieces in two blocks, in the equations, in their readable form, or in the checks.
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
README = (SOURCES / "README.md").read_text()
COMMANDS = re.findall(r"for f in (.*?); do coqc", README)
INSTALL = "apt-get install coq libcoq-interval"
PROOFS = COMMANDS[0].split()  # these proofs are compiled once for all tests
CHECKED = """From Coq Require Import List Bool.
Require Import Checks Equations Certificate3.
Lemma checked : check_start start certified block_0
  && check_block equations integers certified block_0 (Some block_1) = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
"""
# The axioms that CoqInterval, Flocq and the real numbers of Coq's library use.
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
    """A folder with the files of the command, and the proofs before the certificate compiled."""
    folder = tmp_path_factory.mktemp("theory")
    probe = "From Interval Require Import Eval.Eval.\nFrom Coquelicot Require Import Coquelicot.\n"
    (folder / "Probe.v").write_text(probe)
    if shutil.which("coqc") is None or compiled(folder, "Probe")[0]:
        pytest.skip(f"needs Coq with CoqInterval: {INSTALL}")
    command = [sys.executable, str(SOURCES / "export.py"), str(folder), "1", "2", "3"]
    subprocess.run(command, check=True, capture_output=True)
    for file in SOURCES.glob("*.v"):
        shutil.copy(file, folder)
    for name in PROOFS:
        code, said = compiled(folder, name)
        assert code == 0, said
    return folder


@pytest.fixture
def short(theory, tmp_path):
    """A copy of the folder, with a certificate of two pieces and a third one in the next block."""
    folder = tmp_path / "short"
    shutil.copytree(theory, folder)
    text = (folder / "Certificate3.v").read_text()
    begin, *pieces = text.split("  Piece ")
    first, second, third = ("  Piece " + piece.rstrip().rstrip(";") for piece in pieces[:3])
    entry = re.search(r"Definition block_1 : block := Block \(.*?\) \[\n", text).group()
    cut = f"{begin}{first};\n{second}].\n{entry}{third}].\n"
    (folder / "Certificate3.v").write_text(cut)
    (folder / "Checked.v").write_text(CHECKED)
    return folder


def is_accepted(folder):
    for name in ("Checks", "Equations", "Certificate3"):
        code, said = compiled(folder, name)
        assert code == 0, said
    code, said = compiled(folder, "Checked")
    assert code == 0 or "block_1) = true" in said, said
    return code == 0


def swapped(name, pattern, change):
    """Return a function that applies `change` to the first group of a pattern's only match."""

    def damage(folder):
        file = folder / f"{name}.v"
        text = file.read_text()
        found = re.search(pattern, text, re.DOTALL)
        new = change(found.group(1))
        assert new != found.group(1)
        file.write_text(text[: found.start(1)] + new + text[found.end(1) :])

    return damage


def entry_of_the_first_block(folder):
    """Let block 1 begin with the bound of block 0, below the one after two segments."""
    file = folder / "Certificate3.v"
    text = file.read_text()
    first, second = re.findall(r"block_\d : block := Block (\(.*?\)) \[", text)
    assert first != second
    file.write_text(text.replace(second, first))


def moved(by):
    return lambda digits: str(int(digits) + by)


SECOND = r"Piece \[.*?Piece \["  # matches two segments, up to the coefficients of the second one
DAMAGES = {
    "the candidate begins elsewhere": swapped("Certificate3", r"Piece \[\[(-?\d+);", moved(2**30)),
    "its polynomial is another": swapped("Certificate3", r"Piece \[\[-?\d+; (-?\d+)", moved(2**30)),
    "the second piece jumps": swapped("Certificate3", SECOND + r"\[(-?\d+)", moved(2**30)),
    "errors grow less": swapped("Certificate3", r"\]\] (\d+)", moved(-300)),
    "the frame is another": swapped("Certificate3", r"Certificate\s+\[\s+\[\((\d+) #", moved(1)),
    "the tube is wider": swapped(
        "Certificate3", r"\]\]?\s+\((\d+) # \d+\)\.", lambda n: str(4 * int(n))
    ),
    "the bound is less": entry_of_the_first_block,
    "another start": swapped("Certificate3", r"\((1, 20)\)", lambda _: "1, 21"),
    "another bicycle": swapped("Equations", r"\((20090)\)", moved(1)),
    "slopes exceed their limit": swapped("Checks", r"steepest : Z := 2 \^ (10)", moved(-4)),
    "another equation": swapped("Equations", r"Binary (Sub) \d+ \d+ ", lambda _: "Add"),
}
READABLE_CHANGES = {
    "a sign": swapped("Readable", r"Definition Y := c \* sb (-) ", lambda _: "+"),
    "the sign of a force": swapped("Readable", r"Definition f_w3 := w1 \* h2 (-) ", lambda _: "+"),
    "a sign of one entry": swapped("Readable", r"Hub, k => ()height", lambda _: "- "),
    "a parameter": swapped("Readable", r"Definition xB := (3) ", lambda _: "4"),
    "the program": swapped("Equations", r"Binary (Sub) \d+ \d+ ", lambda _: "Add"),
}


@pytest.mark.formal
@pytest.mark.parametrize("maneuver", "123")
def test_coq_proves_the_theorem(theory, maneuver):
    said = ""
    for name in COMMANDS[1].replace("${n}", maneuver).split():
        code, said = compiled(theory, name)
        assert code == 0, said
    assumed = re.findall(r"^([\w.]+)\s*:", said.partition("Axioms:")[2], re.MULTILINE)
    assert assumed
    assert [x for x in assumed if not ASSUMED.fullmatch(x)] == []


@pytest.mark.formal
def test_three_pieces_are_accepted(short):
    assert is_accepted(short)


@pytest.mark.formal
@pytest.mark.parametrize("what", DAMAGES)
def test_a_wrong_certificate_is_refused(short, what):
    DAMAGES[what](short)
    assert not is_accepted(short)


@pytest.fixture
def readable(theory, tmp_path):
    folder = tmp_path / "readable"
    shutil.copytree(theory, folder)
    return folder


@pytest.mark.formal
def test_the_readable_equations_are_the_program(readable):
    code, said = compiled(readable, "Reading")
    assert code == 0, said
    assumed = re.findall(r"^([\w.]+)\s*:", said.partition("Axioms:")[2], re.MULTILINE)
    assert assumed
    assert [x for x in assumed if not ASSUMED.fullmatch(x)] == []


@pytest.mark.formal
@pytest.mark.parametrize("what", READABLE_CHANGES)
def test_other_readable_equations_are_refused(readable, what):
    READABLE_CHANGES[what](readable)
    for name in ("Equations", "Readable"):
        code, said = compiled(readable, name)
        assert code == 0, said
    code, said = compiled(readable, "Reading")
    assert code != 0
    assert re.search("The program does not contain|not a valid field equation", said), said


def test_the_stated_theorems_are_proved():
    text = (SOURCES / "Maneuver1.v").read_text()
    stated = re.search(r"```coq\n(.*?)```", README, re.DOTALL).group(1).split("\n\n")
    assert len(stated) == 2
    for theorem in stated:
        assert theorem.strip() in text


def test_nothing_is_left_unproved():
    for file in SOURCES.glob("*.v"):
        name, text = file.stem, file.read_text()
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
def test_the_equations_are_those_of_the_command(tmp_path):
    command = [sys.executable, str(SOURCES / "export.py"), str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    assert (tmp_path / "Equations.v").read_text() == (SOURCES / "Equations.v").read_text()
