"""Names of the commands, in the groups in which ``--help`` lists them."""

from importlib import import_module
from types import ModuleType
from typing import NamedTuple


class Group(NamedTuple):
    """A group of commands in the list of ``--help``: title, example and commands."""

    title: str
    example: str
    commands: tuple[str, ...]
    """Names in the order of ``--help``; each is a module of `heyoka_bike.commands`."""


GROUPS = (
    Group(
        "the reference",
        "heyoka-bike verify",
        ("generate", "certify", "verify", "linear", "import"),
    ),
    Group(
        "checking results",
        "heyoka-bike diagnose my-results.txt",
        ("score", "diagnose", "check", "bench"),
    ),
    Group(
        "pictures",
        "heyoka-bike animate my-results.txt -o replay.html",
        ("animate", "plot", "atlas"),
    ),
    Group(
        "sharing",
        "heyoka-bike export --page -o judge/",
        ("export", "submit", "leaderboard", "serve"),
    ),
    Group("this installation", "heyoka-bike selfcheck", ("selfcheck",)),
)

COMMANDS = tuple(name for group in GROUPS for name in group.commands)
"""The commands, in the order of ``--help``."""


def command(name: str) -> ModuleType:
    """Import the module of a command, which contains ``add_parser`` and ``run``."""
    return import_module(f"heyoka_bike.commands.{name}")
