"""Objects that show themselves: in some lines of text, and in notebooks.

How they look is made in `showing`, above the wings that they belong to. So an object imports its
view only when somebody looks at it. These imports are listed in ``pyproject.toml``, as exceptions
of the layers.
"""

from collections.abc import Mapping
from typing import ClassVar, TypeVar

K = TypeVar("K")
V = TypeVar("V", covariant=True)


class Displayed:
    """Base of objects of which a function of `showing.views`, named by `_view`, makes blocks.

    A class whose text is one line has it as its own ``__repr__``.
    """

    __slots__ = ()
    _view: ClassVar[str]

    def __repr__(self) -> str:
        from heyoka_bike.showing import views

        return views.text(self, self._view)

    def _repr_html_(self) -> str:
        """For notebooks: HTML without a script."""
        from heyoka_bike.showing import views
        from heyoka_bike.showing.document import html

        return html.piece(tuple(getattr(views, self._view)(self)))


class IdentityMapping(Mapping[K, V]):
    """A mapping of what an object holds; two are equal only if they are the same object."""

    __slots__ = ()
    __eq__ = object.__eq__
    __hash__ = object.__hash__
