"""The motion in 3D: as numbers, and in a page."""

from pathlib import Path

from heyoka_bike.errors import InputError, quoted

SUFFIXES = (".html", ".htm")
"""Endings of a replay's file."""

_FILMS = (".gif", ".mp4")


def check_suffix(path: Path, option: str = "path") -> None:
    """Raise `InputError` if a file is none of a page, of which `option` says the name."""
    suffix = path.suffix.lower()
    if suffix in SUFFIXES:
        return
    more = ": a page, from which a browser's screen recorder makes a film" * (suffix in _FILMS)
    raise InputError(
        f"{option}: found {quoted(path.name)}, expected a name ending in "
        f"{' or '.join(SUFFIXES)}{more}"
    )
