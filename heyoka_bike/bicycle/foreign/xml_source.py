"""XML elements that store their position in the file, for error messages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

import mpmath

from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.exact import Exact

_MAX_DEPTH = 200
MP = mpmath.mp.clone()
"""Context for numbers of the elements, with more digits than any file has."""
MP.dps = 40


@dataclass
class Element:
    """An XML element.

    Attributes
    ----------
    tag, attributes
    file, line, column
        Position where the element begins.
    children : list of Element
    content
        Text between its tags, without that of its children.
    """

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    column: int
    children: list[Element] = field(default_factory=list)
    content: str = ""

    def all(self, tag: str) -> Iterator[Element]:
        """Return the direct children that have this tag."""
        return (x for x in self.children if x.tag == tag)

    def first(self, *path: str) -> Element | None:
        """Return the first element on a path of tags; None if there is none."""
        if not path:
            return self
        inner = (x.first(*path[1:]) for x in self.all(path[0]))
        return next((x for x in inner if x is not None), None)

    def needed(self, *path: str) -> Element:
        """Return the first element on a path of tags; raise `InputError` if there is none."""
        found = self.first(*path)
        if found is None:
            raise self.error(f"found no <{'> <'.join(path)}> in <{self.tag}>, expected one")
        return found

    def text(self, name: str) -> str:
        """Return the text of a required attribute."""
        if name not in self.attributes:
            raise self.error(f"found no {name} in <{self.tag}>, expected one")
        return self.attributes[name]

    def numbers(self, name: str, count: int, default: str | None = None) -> list[mpmath.mpf]:
        """Return the numbers in the text of an attribute, which must be this many."""
        text = self.text(name) if default is None else self.attributes.get(name, default)
        return self._parsed(text, count, f"{name} of <{self.tag}>")

    def values(self, count: int) -> list[mpmath.mpf]:
        """Return the numbers between the tags of the element, which must be this many."""
        return self._parsed(self.content, count, f"<{self.tag}>")

    def _parsed(self, text: str, count: int, what: str) -> list[mpmath.mpf]:
        try:
            exact = [Exact.parse(word).fraction() for word in text.split()]
            found = [MP.mpf(x.numerator) / x.denominator for x in exact]
        except ValueError:
            found = []
        if len(found) != count:
            expected = "a number" if count == 1 else f"{count} numbers"
            raise self.error(f"{what}: found {quoted(text)}, expected {expected}")
        return found

    def error(self, message: str) -> InputError:
        """Return an `InputError` located at this element."""
        return InputError(message, file=self.file, line=self.line, column=self.column)


def parse(text: str, file: str) -> Element:
    """Parse a document and return its root.

    Raises
    ------
    InputError
        The text is not well-formed, defines entities, or is nested too deeply.
    """
    parser = expat.ParserCreate()
    open_elements: list[Element] = []
    roots: list[Element] = []

    def refuse(message: str) -> InputError:
        place = {"line": parser.CurrentLineNumber, "column": parser.CurrentColumnNumber + 1}
        return InputError(message, file=file, **place)

    def begin(tag: str, attributes: dict[str, str]) -> None:
        if len(open_elements) > _MAX_DEPTH:
            raise refuse(f"found elements nested more than {_MAX_DEPTH} deep, expected flatter XML")
        line, column = parser.CurrentLineNumber, parser.CurrentColumnNumber + 1
        element = Element(tag, attributes, file, line, column)
        (open_elements[-1].children if open_elements else roots).append(element)
        open_elements.append(element)

    def doctype(*_: object) -> None:
        raise refuse("found a document type declaration (<!DOCTYPE>), expected XML without one")

    def characters(text: str) -> None:
        open_elements[-1].content += text

    parser.StartElementHandler = begin
    parser.CharacterDataHandler = characters
    parser.EndElementHandler = lambda _: open_elements.pop()
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(text, True)
    except expat.ExpatError as e:
        said = expat.errors.messages[e.code]
        raise InputError(
            f"found XML that is not well-formed ({said})", file=file, line=e.lineno,
            column=e.offset + 1,
        ) from None  # fmt: skip
    return roots[0]
