"""Paths of the files of the project: inside the wheel, or next to the package in a checkout."""

from pathlib import Path
from typing import Literal

from heyoka_bike.errors import InputError, quoted

Inputs = Literal["bicycles", "maneuvers"]

_PACKAGE = Path(__file__).resolve().parent.parent


def _folder(name: str) -> Path:
    inside = _PACKAGE / "bundled" / name
    return inside if inside.is_dir() else _PACKAGE.parent / name


def data_folder() -> Path:
    """Return the folder of the inputs: ``bicycles`` and ``maneuvers``."""
    return _folder("data")


def reference_folder() -> Path:
    """Return the folder of the published reference files."""
    return _folder("reference")


def after_folder() -> Path:
    """Return the folder of the proved facts on the motions after ten seconds."""
    return reference_folder() / "after-ten-seconds"


def benchmark_bicycle() -> Path:
    """Return the TOML file of the benchmark bicycle."""
    return data_folder() / "bicycles" / "benchmark.toml"


def benchmark_maneuvers() -> Path:
    """Return the TOML file of the three maneuvers of the benchmark."""
    return data_folder() / "maneuvers" / "benchmark.toml"


def collection(kind: Inputs) -> dict[str, Path]:
    """Return the TOML files of a kind by name (``browser``, ``adversarial/no-trail``), sorted."""
    folder = data_folder() / kind
    files = {p.relative_to(folder).with_suffix("").as_posix(): p for p in folder.rglob("*.toml")}
    return dict(sorted(files.items()))


def find_input(kind: Inputs, text: str) -> Path:
    """Return the TOML file for a name of the collection, or else for a path.

    A user's file with a name of the collection is written ``./name``.

    Raises
    ------
    InputError
        There is no such name in the collection, and no such file.
    """
    names = collection(kind)
    if text in names:
        return names[text]
    path = Path(text)
    if path.suffix == ".toml" or path.is_absolute() or path.exists():
        return path
    import difflib

    close = difflib.get_close_matches(text[:40], names, n=1)
    guess = f"'{close[0]}' or another of" if close else "a TOML file or one of"
    what = "bicycle" if kind == "bicycles" else kind
    raise InputError(f"{what}: found {quoted(text)}, expected {guess}: {', '.join(names)}")
