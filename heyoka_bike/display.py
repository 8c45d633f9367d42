"""Base classes of objects that are displayed: as some lines of text, and as HTML in notebooks.

How they look is made in `showing`, above the wings that they belong to. So an object imports its
view only when somebody looks at it. These imports are listed in ``pyproject.toml``, as exceptions
of the layers.
"""

from collections.abc import Mapping
from typing import ClassVar, TypeVar

K = TypeVar("K")
V = TypeVar("V", covariant=True)


class Displayed:
    """Base of displayed objects; `_view` names the function of `showing.views` that makes blocks.

    A class whose text is one line has it as its own ``__repr__``.
    """

    __slots__ = ()
    _view: ClassVar[str]

    def __repr__(self) -> str:
        from heyoka_bike.showing import views

        return views.text(self, self._view)

    def _repr_html_(self) -> str:
        """Return HTML without a script, for notebooks."""
        from heyoka_bike.showing import views
        from heyoka_bike.showing.document import html

        return html.piece(tuple(getattr(views, self._view)(self)))


class IdentityMapping(Mapping[K, V]):
    """A mapping that is equal only to itself, whatever items it has."""

    __slots__ = ()
    __eq__ = object.__eq__
    __hash__ = object.__hash__
