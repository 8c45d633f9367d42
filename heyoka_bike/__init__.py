"""Reference solutions and scoring for the IFToMM benchmark "Uncontrolled bicycle".

``load_reference()`` gives the published reference; ``reference[2].evaluate(t)`` its values at any
time; ``score(read_results(path))`` compares a result file with it. `integrate` runs the model with
heyoka. Names are loaded when first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from heyoka_bike.integration import integrate as integrate
    from heyoka_bike.linear import linearise as linearise
    from heyoka_bike.motion.file import load_motion as load_motion
    from heyoka_bike.parameters import read_bicycle as read_bicycle
    from heyoka_bike.parameters import read_maneuvers as read_maneuvers
    from heyoka_bike.reading import read_results as read_results
    from heyoka_bike.reference import load_reference as load_reference
    from heyoka_bike.scoring import score as score
    from heyoka_bike.sensitivities import load_sensitivities as load_sensitivities
    from heyoka_bike.series import score_series as score_series
    from heyoka_bike.simulation import simulate as simulate

__version__ = "0.1.0"

_HOME = {
    "integrate": "integration",
    "linearise": "linear",
    "load_motion": "motion.file",
    "load_reference": "reference",
    "load_sensitivities": "sensitivities",
    "read_bicycle": "parameters",
    "read_maneuvers": "parameters",
    "read_results": "reading",
    "score": "scoring",
    "score_series": "series",
    "simulate": "simulation",
}

__all__ = [
    "__version__",
    "integrate",
    "linearise",
    "load_motion",
    "load_reference",
    "load_sensitivities",
    "read_bicycle",
    "read_maneuvers",
    "read_results",
    "score",
    "score_series",
    "simulate",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        from importlib import import_module

        return getattr(import_module(f"heyoka_bike.{_HOME[name]}"), name)
    raise AttributeError(f"module 'heyoka_bike' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
