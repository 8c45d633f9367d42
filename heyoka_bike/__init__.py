"""Reference solutions and scoring for the IFToMM benchmark "Uncontrolled bicycle".

``load_reference()`` gives the published reference; ``reference[2].evaluate(t)`` its values at any
time; ``score(read_results(path))`` compares a result file with it. `integrate` runs the model with
heyoka. Names are loaded when first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from heyoka_bike.version import __version__

if TYPE_CHECKING:
    from heyoka_bike.bicycle.parameters import read_bicycle as read_bicycle
    from heyoka_bike.bicycle.parameters import read_maneuvers as read_maneuvers
    from heyoka_bike.bicycle.stability.linear import linearise as linearise
    from heyoka_bike.motion.fast.simulate import simulate as simulate
    from heyoka_bike.motion.integrate import integrate as integrate
    from heyoka_bike.reference.load import load_motion as load_motion
    from heyoka_bike.reference.load import load_reference as load_reference
    from heyoka_bike.reference.sensitivities import load_sensitivities as load_sensitivities
    from heyoka_bike.scoring.reading import read_results as read_results
    from heyoka_bike.scoring.score import score as score
    from heyoka_bike.scoring.series import score_series as score_series


_HOME = {
    "integrate": "motion.integrate",
    "linearise": "bicycle.stability.linear",
    "load_motion": "reference.load",
    "load_reference": "reference.load",
    "load_sensitivities": "reference.sensitivities",
    "read_bicycle": "bicycle.parameters",
    "read_maneuvers": "bicycle.parameters",
    "read_results": "scoring.reading",
    "score": "scoring.score",
    "score_series": "scoring.series",
    "simulate": "motion.fast.simulate",
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
