"""The Attributes section of a dataclass or named tuple names all of its own fields, in their order.

The section may also describe inherited fields.
"""

import inspect
import pkgutil
import re
from dataclasses import fields, is_dataclass
from importlib import import_module

import heyoka_bike

_SECTION = re.compile(r"^Attributes\n-+\n(.*?)(?=^\w+\n-+$|\Z)", re.MULTILINE | re.DOTALL)
_NAMES = re.compile(r"^\w.*", re.MULTILINE)
FEW = 3  # a class with at most this many fields needs no section


def records():
    """Public dataclasses and named tuples: class, own fields and all fields. An imported class
    is repeated."""
    for info in pkgutil.walk_packages(heyoka_bike.__path__, "heyoka_bike."):
        if info.name != "heyoka_bike.__main__":
            for name, thing in vars(import_module(info.name)).items():
                if isinstance(thing, type) and name[0] != "_":
                    if is_dataclass(thing):
                        # Only the fields of the class itself, without those of its base class
                        own = inspect.get_annotations(thing)
                        yield thing, own, [f.name for f in fields(thing)]
                    elif issubclass(thing, tuple) and hasattr(thing, "_fields"):
                        yield thing, thing._fields, thing._fields


def test_attributes_are_the_fields():
    wrong = {}
    for thing, declared, names in records():
        all_fields = [name for name in names if name[0] != "_"]
        own = [name for name in all_fields if name in declared]
        found = _SECTION.search(inspect.getdoc(thing))
        lines = _NAMES.findall(found[1]) if found else ()
        named = [name for line in lines for name in line.partition(" :")[0].split(", ")]
        is_right = [name for name in named if name in own] == own and set(named) <= set(all_fields)
        if not is_right and (found or len(own) > FEW):
            wrong[f"{thing.__module__}.{thing.__name__}"] = (named, own)
    assert not wrong, "\n".join(f"{k}: {v}" for k, v in wrong.items())
