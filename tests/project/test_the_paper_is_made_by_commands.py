"""No number in docs/paper/paper.md is typed: each is a placeholder for the output of a command.

The test checks that placeholders resolve, that citations and figures exist, and that README.md
names all sources. The proof tier also typesets the paper if Pandoc and Typst are installed (``pip
install -e '.[paper]'``).
"""

import re
import shlex
import subprocess
import sys

import pytest

from build import FACTS, FIGURES, HERE, source
from heyoka_bike.system.resources import data_folder
from paper_fact import PLACE, filled, power, words_of

TEXT = (HERE / "paper.md").read_text(encoding="utf-8")
CALLS = sorted(set(PLACE.findall(TEXT)))
_FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)

# Names and phrases in which digits are allowed
NAMES = (
    r"eq\. \(1\)",  # an equation number of the benchmark
    r"maneuvers? [123]\b",  # names of the benchmark's maneuvers
    r"binary(64|128)",  # number formats
    r"SHA-256",
    r"SciPy's DOP853",
    r"HDF5",
    r'`--require "scd >= 6"`',  # example of an option
    r"^\d\. ",  # numbered conditions
    r"\| [123] \|",  # maneuvers in the table of bounds
)
# Numbers that are allowed in formulas: the ends of intervals, the coefficients of a theorem, and
# the 100 of eq. (1).
_FORMULA = re.compile(r"\$\$.*?\$\$|\$[^$]+\$", re.DOTALL)
_IN_FORMULAS = {"0", "1", "2", "100"}
_SYMBOLS = re.compile(r"_\{?\d+\}?")  # indices, and the base of a logarithm
# Numbers written as words, which must come from placeholders. Only two kinds may be written:
# numbers up to four that count things listed next to them, and "thousandth", which is defined.
_SPELLED = re.compile(
    r"\b(five|six|seven|eight|nine|ten|eleven|twelve|dozen|\w+teen|twenty|\w+ty-\w+|thirty|forty"
    r"|fifty|sixty|seventy|eighty|ninety|hundred|thousand|million|billion|half)s?\b",
    re.IGNORECASE,
)


def bare_numbers(text):
    """Numbers in a text of the paper that are not the output of a command."""
    text = PLACE.sub("", text)
    # Readers type commands and Python code themselves. The output of both must be a placeholder.
    text = _FENCE.sub(lambda block: "" if block[1] in ("sh", "python") else block[2], text)
    found = [
        n for formula in _FORMULA.findall(text)
        for n in re.findall(r"\d+(?:\.\d+)?", _SYMBOLS.sub("", formula)) if n not in _IN_FORMULAS
    ]  # fmt: skip
    text = _FORMULA.sub("", text)
    text = re.sub(r"\]\([^)]*\)\{[^}]*\}|\{#[^}]*\}|@[\w:]+", "", text)
    for name in NAMES:
        text = re.sub(name, "", text, flags=re.MULTILINE | re.IGNORECASE)
    found += re.findall(r"\S*\d\S*", text)
    return found + _SPELLED.findall(text)


def test_no_number_is_typed():
    assert bare_numbers(TEXT) == []


@pytest.mark.parametrize(
    "typed",
    [
        "wrong by 2.3 %", "of 199 runs", "$1.7 \\times 10^{-65}$", "$$ x = 0.5 $$", "twenty runs",
        "```text\nworst 1.6\n```", "binary32", "maneuver 4", "eq. (2)", "half a minute",
        "$10^{-3}$",
    ],
)  # fmt: skip
def test_a_typed_number_is_seen(typed):
    assert bare_numbers(f"{TEXT}\n\n{typed}\n") != bare_numbers(TEXT)


@pytest.mark.parametrize("call", CALLS)
def test_a_placeholder_resolves(call):
    words = words_of(call)
    assert words
    assert "{{" not in words
    assert "nan" not in words


def test_placeholders_that_do_not_exist_are_refused():
    for call in ("nothing", "proved nothing", "given speed 4", "wrong exudyn-h0.01.txt 1 nothing"):
        with pytest.raises((KeyError, IndexError, StopIteration)):
            filled(f"a {{{{ {call} }}}} b")
    with pytest.raises(ValueError, match="found no"):
        words_of("recognised 1e-5")


def test_every_fact_is_used():
    assert {shlex.split(call)[0] for call in CALLS} == set(FACTS)


def test_powers_of_ten_keep_the_digits_of_a_bound():
    assert power("1.69e-65") == r"$1.69 \times 10^{-65}$"
    assert power("1e-12") == "$10^{-12}$"
    assert power(0.000448791) == r"$4.5 \times 10^{-4}$"


def test_citations_and_figures_exist():
    cited = set(re.findall(r"@([\w:]+)", _FENCE.sub("", TEXT)))
    library = (HERE / "paper.bib").read_text(encoding="utf-8")
    references = set(re.findall(r"^@\w+\{(\w+),$", library, re.MULTILINE))
    places = set(re.findall(r"\{#(\S+?)[ }]", TEXT))
    assert {c for c in cited if ":" not in c} == references
    assert {c for c in cited if ":" in c} == places
    drawn = {f"{name}.svg" for name in FIGURES}
    assert set(re.findall(r"\]\((\w+\.svg)\)", TEXT)) == drawn


def test_the_readme_says_where_each_number_is_from():
    page = (HERE / "README.md").read_text(encoding="utf-8")
    assert source() in page, "put what python docs/paper/build.py --sources prints into README.md"


def test_the_example_of_the_paper_runs():
    (example,) = (code for kind, code in _FENCE.findall(TEXT) if kind == "python")
    subprocess.run([sys.executable, "-c", example], check=True, cwd=data_folder().parent)


@pytest.mark.proof
def test_the_paper_is_set(tmp_path):
    for name in ("pypandoc", "typst"):
        pytest.importorskip(name)
    command = [sys.executable, str(HERE / "build.py"), "-o", str(tmp_path / "page-{p}.svg")]
    subprocess.run(command, check=True, timeout=300)
    pages = len(list(tmp_path.glob("page-*.svg")))
    assert 4 <= pages <= 8
    text = (tmp_path / "paper.md").read_text(encoding="utf-8")
    assert "{{" not in text
    assert "#cite(<fig:" not in (tmp_path / "paper.typ").read_text(encoding="utf-8")
    assert {p.name for p in tmp_path.glob("*.svg")} >= {f"{name}.svg" for name in FIGURES}
