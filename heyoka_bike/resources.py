"""Where the files that come with the project are: in the wheel, or beside it in a checkout."""

from __future__ import annotations

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def _folder(name: str) -> Path:
    inside = _PACKAGE / name
    return inside if inside.is_dir() else _PACKAGE.parent / name


def data_folder() -> Path:
    """Folder of the inputs: ``bicycles`` and ``maneuvers``."""
    return _folder("data")


def reference_folder() -> Path:
    """Folder of the published reference files."""
    return _folder("reference")


def benchmark_bicycle() -> Path:
    """TOML file of the benchmark bicycle."""
    return data_folder() / "bicycles" / "benchmark.toml"


def benchmark_maneuvers() -> Path:
    """TOML file of the three maneuvers of the benchmark."""
    return data_folder() / "maneuvers" / "benchmark.toml"
