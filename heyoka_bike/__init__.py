"""Reference solutions and scoring for the IFToMM benchmark "Uncontrolled bicycle".

``load_reference()`` gives the published reference; ``reference[2].evaluate(t)`` its values at any
time; ``score(read_results(path))`` compares a result file with it. `integrate` runs the model with
heyoka; `generate`, `certify` and `verify` make and check sets. Names are loaded when first used.
"""

import re
from importlib import import_module
from pathlib import Path
from typing import Any

_STUB = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_HOME = {name: home for home, name in re.findall(r"^from (\S+) import (\S+) as", _STUB, re.M)}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'heyoka_bike' has no attribute '{name}'")


def __dir__() -> list[str]:
    return __all__
