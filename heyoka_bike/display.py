"""Objects that show themselves: in some lines of text, and in notebooks.

How they look is made in `showing`, above the wings that they belong to. So an object asks for its
view by name, and only when somebody looks at it: it neither imports nor knows what shows it.
"""

from collections.abc import Mapping
from importlib import import_module
from typing import Any, ClassVar, TypeVar

K = TypeVar("K")
V = TypeVar("V", covariant=True)


def shown_by(module: str) -> Any:
    """A module of `heyoka_bike.showing`, by its name there."""
    return import_module(f"heyoka_bike.showing.{module}")


class Displayed:
    """Base of objects of which a function of `showing.views`, named by `_view`, makes blocks.

    A class whose text is one line has it as its own ``__repr__``.
    """

    __slots__ = ()
    _view: ClassVar[str]

    def __repr__(self) -> str:
        return str(shown_by("views").text(self, self._view))

    def _repr_html_(self) -> str:
        """For notebooks: HTML without a script."""
        blocks = getattr(shown_by("views"), self._view)(self)
        return str(shown_by("document.html").piece(tuple(blocks)))


class Held(Mapping[K, V]):
    """A mapping of what an object holds; two are equal only if they are the same object."""

    __slots__ = ()
    __eq__ = object.__eq__
    __hash__ = object.__hash__
