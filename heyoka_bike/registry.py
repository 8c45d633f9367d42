"""Registry by name: the commands, and what the workbench adds to commands of the others.

The workbench uses the rest of the package, and no module of the rest imports it. Its public names
stand in ``__init__.pyi``, like all others.
"""

from importlib import import_module
from types import ModuleType
from typing import Any

_CORE, _WORKBENCH = "heyoka_bike.commands", "heyoka_bike.workbench.commands"

COMMANDS = {
    "generate": _CORE,
    "score": _CORE,
    "diagnose": _CORE,
    "check": _CORE,
    "verify": _CORE,
    "certify": _CORE,
    "linear": _CORE,
    "plot": _WORKBENCH,
    "animate": _WORKBENCH,
    "export": _CORE,
    "import": _CORE,
    "bench": _WORKBENCH,
    "atlas": _WORKBENCH,
    "leaderboard": _WORKBENCH,
    "submit": _WORKBENCH,
    "serve": _WORKBENCH,
    "selfcheck": _CORE,
}
"""Package of each command, in the order of ``--help``."""

_ADDITIONS = {
    "certify_after": "heyoka_bike.workbench.after_ten_seconds.facts",
    "checker_header": "heyoka_bike.workbench.checker.header",
    "checker_page": "heyoka_bike.workbench.checker.page",
    "connected": "heyoka_bike.workbench.cluster",
    "generate_after": "heyoka_bike.workbench.after_ten_seconds.making",
    "uncertain_stability": "heyoka_bike.workbench.boxes.box",
}


def command(name: str) -> ModuleType:
    """The module of a command, with ``add_parser`` and ``run``."""
    return import_module(f"{COMMANDS[name]}.{name}")


def addition(name: str) -> Any:
    """A function of the workbench that a command of the others calls."""
    return getattr(import_module(_ADDITIONS[name]), name)
