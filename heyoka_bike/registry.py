"""Registry by name: the commands, and what the workbench adds to commands of the others.

The workbench uses the rest of the package, and no module of the rest imports it. Its public names
stand in ``__init__.pyi``, like all others.
"""

from collections.abc import Mapping
from importlib import import_module
from types import ModuleType
from typing import Any, NamedTuple

_CORE, _WORKBENCH = "heyoka_bike.commands", "heyoka_bike.workbench.commands"


class Group(NamedTuple):
    """Commands of ``--help`` that belong together."""

    title: str
    example: str
    commands: Mapping[str, str]
    """Package of each, in the order of ``--help``."""


GROUPS = (
    Group(
        "the reference",
        "heyoka-bike verify",
        {
            "generate": _CORE,
            "certify": _CORE,
            "verify": _CORE,
            "linear": _CORE,
            "import": _CORE,
        },
    ),
    Group(
        "judging",
        "heyoka-bike diagnose my-results.txt",
        {"score": _CORE, "diagnose": _CORE, "check": _CORE, "bench": _WORKBENCH},
    ),
    Group(
        "looking",
        "heyoka-bike animate my-results.txt -o replay.html",
        {"animate": _WORKBENCH, "plot": _WORKBENCH, "atlas": _WORKBENCH},
    ),
    Group(
        "sharing",
        "heyoka-bike export --page -o judge/",
        {
            "export": _CORE,
            "submit": _WORKBENCH,
            "leaderboard": _WORKBENCH,
            "serve": _WORKBENCH,
        },
    ),
    Group("this installation", "heyoka-bike selfcheck", {"selfcheck": _CORE}),
)

COMMANDS = {name: package for group in GROUPS for name, package in group.commands.items()}
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
