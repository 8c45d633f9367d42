"""Placeholders of paper.md: how one is declared, and how its number is read and written.

``{{ name argument ... }}`` in the text is a call of the function of that name, whose words are put
in its place. The decorator `fact` says what the function reads and which command wrote that.
"""

import json
import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from heyoka_bike.system.resources import data_folder

ROOT = data_folder().parent
PLACE = re.compile(r"\{\{ *(.*?) *\}\}")


@dataclass(frozen=True)
class Fact:
    """What a placeholder stands for.

    Attributes
    ----------
    words
        The function that gives the words.
    source
        What it reads.
    command
        What wrote that, or what anybody may give to see the same.
    """

    words: Callable[..., str]
    source: str
    command: str


FACTS: dict[str, Fact] = {}
"""By the name of the placeholder."""


def fact(source, command):
    """A function whose name is that of a placeholder."""

    def declared(words):
        FACTS[words.__name__] = Fact(words, source, command)
        return words

    return declared


def filled(text):
    """The text with words in place of its placeholders."""
    return PLACE.sub(lambda place: words_of(place[1]), text)


def words_of(call):
    """Words in place of a placeholder: a name, and arguments as in a shell."""
    name, *arguments = shlex.split(call)
    if name not in FACTS:
        raise KeyError(f"{{{{ {call} }}}}: found {name!r}, expected one of {', '.join(FACTS)}")
    words = FACTS[name].words(*arguments)
    if not words:
        raise ValueError(f"{{{{ {call} }}}}: found no words")
    return words


@cache
def document(path):
    """A JSON file of the repository."""
    return json.loads((ROOT / path).read_text(encoding="utf-8"))


@cache
def text_of(path):
    """A text of the repository."""
    return (ROOT / path).read_text(encoding="utf-8")


def part(page, name):
    """What a script wrote between two markers of a page of docs."""
    return among(text_of(f"docs/{page}"), rf"(?s)<!-- {name}: begin -->(.*?)<!-- {name}: end -->")


def among(text, pattern):
    """Return the first group of a pattern's match in a text; a space also matches a line break."""
    found = re.search(pattern.replace(" ", r"\s+"), text)
    if found is None:
        raise ValueError(f"found no {pattern!r} in {text[:80]!r}")
    return found[1]


def power(number, digits=2):
    """A formula with a power of ten: a text keeps its own digits, a float gets a few."""
    text = number if isinstance(number, str) else f"{number:.{digits - 1}e}"
    mantissa, _, exponent = text.partition("e")
    ten = rf"10^{{{int(exponent)}}}"
    return f"${ten}$" if mantissa == "1" else rf"${mantissa} \times {ten}$"
