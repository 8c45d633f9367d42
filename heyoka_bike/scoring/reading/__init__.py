"""Reading of another program's results: text, NumPy, MATLAB and HDF5 files, and arrays."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from heyoka_bike.scoring.reading.source import read_results as read_results


def __getattr__(name: str) -> Any:
    """`read_results`, when it is wanted: help has the names of formats without NumPy."""
    if name != "read_results":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from heyoka_bike.scoring.reading.source import read_results

    return read_results
