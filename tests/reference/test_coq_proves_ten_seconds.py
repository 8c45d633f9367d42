"""Coq proves Theorem 1 for ten seconds of each maneuver, and compares the published text with it.

The development is in `tests/checker/formal`. Each damage is made in the certificate of maneuver 3,
cut to three pieces in two blocks, in the equations, in their readable form, in the checks, or in
the lines of the text in these pieces.
"""

import re
import shutil
import subprocess
import sys
from decimal import Decimal
from pathlib import Path

import mpmath
import pytest

from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.numbers.arithmetic import Multiprecision
from oracles import vectors
from support.coq_program import Program

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "tests" / "checker" / "formal"
PUBLISHED = ROOT / "reference" / "uncontrolled-bicycle.txt"
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
COMPARED = """From Coq Require Import List.
Require Import Checks Certificate3 Lines Text.
Lemma compared : check_text (members block_0 ++ members block_1) 3 lines = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
"""
PRINTED = """From Coq Require Import List String.
Require Import Lines.
Set Printing Depth 1000000.
Eval compute in lines.
"""
LINES = 19  # lines of the text until 0.1875 s, the end of three pieces
# The axioms that CoqInterval, Flocq and the real numbers of Coq's library use.
ASSUMED = re.compile(
    r"(Uint63|PrimInt63|PrimFloat|FloatAxioms|ClassicalDedekindReals)\.\w+"
    r"|FunctionalExtensionality\.functional_extensionality_dep|Classical_Prop\.classic"
)


def compiled(folder, name):
    """Run Coq on a file; return its exit code and its output."""
    found = subprocess.run(["coqc", f"{name}.v"], cwd=folder, capture_output=True, text=True)
    return found.returncode, found.stdout + found.stderr


def check_axioms(said):
    """Check that Coq lists axioms, and no others than the known ones."""
    assumed = re.findall(r"^([\w.]+)\s*:", said, re.MULTILINE)
    assert assumed
    assert [x for x in assumed if not ASSUMED.fullmatch(x)] == []


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
    begin, *lines = (folder / "Lines.v").read_text().split('"')
    strings = ";\n".join(f'"{line}"' for line in lines[: 2 * LINES : 2])
    (folder / "Lines.v").write_text(f"{begin}{strings}].\n")
    (folder / "Compared.v").write_text(COMPARED)
    return folder


def is_accepted(folder, check="Checked", changed=("Checks", "Equations", "Certificate3")):
    for name in changed:
        code, said = compiled(folder, name)
        assert code == 0, said
    code, said = compiled(folder, check)
    assert code == 0 or "= true" in said, said
    return code == 0


def is_text_accepted(folder):
    return is_accepted(folder, "Compared", ("Certificate3", "Lines"))


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
    "the candidate begins elsewhere": swapped("Certificate3", r"Piece \[\[(-?\d+);", moved(2**40)),
    "its polynomial is another": swapped("Certificate3", r"Piece \[\[-?\d+; (-?\d+)", moved(2**40)),
    "the second piece jumps": swapped("Certificate3", SECOND + r"\[(-?\d+)", moved(2**40)),
    "errors grow less": swapped("Certificate3", r"\]\] (\d+)", moved(-300)),
    "the frame is another": swapped("Certificate3", r"Certificate\s+\[\s+\[\((\d+) #", moved(1)),
    "the tube is wider": swapped(
        "Certificate3", r"\]\]\s+\((\d+) # \d+\) \(", lambda n: str(4 * int(n))
    ),
    "the claim is less": swapped("Certificate3", r"\) \(1 # (\d+)\)\.", lambda n: str(2 * int(n))),
    "the claim is beyond the slopes": swapped(
        "Certificate3", r"\) \(1 # (\d+)\)\.", lambda n: str(int(n) // 10**6)
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


def with_word(line, column, change):
    words = line.split(" ")
    words[column] = change(words[column])
    return " ".join(words)


def larger(by):
    return lambda word: str(Decimal(word) + Decimal(by))


# Changes of the last line of the text up to the end of the three pieces. Its columns 17 to 24 are
# those of maneuver 3. The bound of speeds is 0.3 times the bound of the other columns.
CHANGES = {
    "its time": lambda line: with_word(line, 0, larger("0.01")),
    "the roll angle": lambda line: with_word(line, 17, larger("2e-14")),
    "the roll rate": lambda line: with_word(line, 18, larger("-2e-14")),
    "the speed": lambda line: with_word(line, 19, larger("6e-15")),
    "the steer angle": lambda line: with_word(line, 23, larger("2e-14")),
    "the steer rate": lambda line: with_word(line, 24, larger("-2e-14")),
    "a decimal comma": lambda line: with_word(line, 24, lambda word: word.replace(".", ",")),
    "a sign": lambda line: with_word(line, 17, lambda word: f"-{word}"),
    "an exponent": lambda line: with_word(line, 17, lambda word: f"{word}e-01"),
    "one column less": lambda line: line.rpartition(" ")[0],
}


@pytest.mark.formal
@pytest.mark.parametrize("maneuver", "123")
def test_coq_proves_the_theorems(theory, maneuver):
    printed = []
    for name in COMMANDS[1].replace("${n}", maneuver).split():
        code, said = compiled(theory, name)
        assert code == 0, said
        printed += said.split("Axioms:")[1:]
    assert len(printed) == 2  # one theorem about the polynomials, one about the text
    for axioms in printed:
        check_axioms(axioms)


@pytest.mark.formal
def test_three_pieces_are_accepted(short):
    assert is_accepted(short)


@pytest.mark.formal
@pytest.mark.parametrize("what", DAMAGES)
def test_a_wrong_certificate_is_refused(short, what):
    DAMAGES[what](short)
    assert not is_accepted(short)


@pytest.mark.formal
def test_coq_has_the_published_text(theory):
    """The strings that Coq prints are the lines of the file, byte by byte."""
    (theory / "Printed.v").write_text(PRINTED)
    code, said = compiled(theory, "Printed")
    assert code == 0, said
    lines = re.findall(r'"(.*?)"', said)
    assert "".join(f"{line}\n" for line in lines).encode() == PUBLISHED.read_bytes()


@pytest.mark.formal
def test_lines_of_three_pieces_are_accepted(short):
    assert is_text_accepted(short)


@pytest.mark.formal
@pytest.mark.parametrize("what", CHANGES)
def test_a_changed_text_is_refused(short, what):
    swapped("Lines", r'"([^"]*)"\]', CHANGES[what])(short)
    assert not is_text_accepted(short)


@pytest.fixture
def readable(theory, tmp_path):
    folder = tmp_path / "readable"
    shutil.copytree(theory, folder)
    return folder


@pytest.mark.formal
def test_the_readable_equations_are_the_program(readable):
    code, said = compiled(readable, "Reading")
    assert code == 0, said
    check_axioms(said.partition("Axioms:")[2])


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
    text = "".join((SOURCES / f"{name}1.v").read_text() for name in ("Maneuver", "Published"))
    blocks = re.findall(r"```coq\n(.*?)```", README, re.DOTALL)
    stated = [theorem for block in blocks for theorem in block.split("\n\n")]
    assert len(stated) == 3
    for theorem in stated:
        assert theorem.strip() in text


def test_nothing_is_left_unproved():
    for file in SOURCES.glob("*.v"):
        name, text = file.stem, file.read_text()
        assert not re.search(r"\b(Axiom|Parameter|Conjecture|Admitted|admit|Abort)\b", text), name


def test_the_program_is_the_equations():
    """The program's operations, as defined in Coq, give the rates of the state."""
    a, number = Multiprecision(40), vectors.Multiprecision(40)
    bicycle, _ = benchmark()
    state = [a.context.mpf(x) / 64 for x in (3, -1, 5, 7, -9, 1700, 2)]
    wanted = Equations.of(bicycle, a).rates_with_yaw(state)
    for found, rate in zip(Program.of_coq().rates(state, number), wanted, strict=True):
        assert mpmath.almosteq(found, rate, rel_eps=1e-33)


@pytest.mark.proof
def test_the_equations_are_those_of_the_command(tmp_path):
    command = [sys.executable, str(SOURCES / "export.py"), str(tmp_path)]
    subprocess.run(command, check=True, capture_output=True)
    assert (tmp_path / "Equations.v").read_text() == (SOURCES / "Equations.v").read_text()
