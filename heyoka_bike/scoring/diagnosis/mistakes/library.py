"""The usual mistakes: what a program that makes one of them computes instead.

Each mistake changes a `Program`: the bicycle's parameters, the start, or what is written. Mistakes
can be made together, in any order that makes sense; `apply` makes several. Those that are read off
a file, such as columns in another order, are in `proposals`.
"""

from collections.abc import Sequence

from heyoka_bike.scoring.diagnosis.mistakes.in_axes import AXES_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.in_model import MODEL_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.in_output import OUTPUT_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.in_start import START_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEAR_PROGRAMS
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, Program, apply

__all__ = ["MISTAKES", "Mistake", "Program", "apply", "in_order"]

KINDS = ("model", "start", "output")

MISTAKES: tuple[Mistake, ...] = (
    *MODEL_MISTAKES, *AXES_MISTAKES, *START_MISTAKES, *OUTPUT_MISTAKES,
    *LINEAR_PROGRAMS,
)  # fmt: skip
"""The library, in no particular order."""

_PLACE = {m.code: i for i, m in enumerate(MISTAKES)}


def in_order(mistakes: Sequence[Mistake]) -> tuple[Mistake, ...]:
    """Mistakes that are made together: of the model, of the start, of what is written."""
    return tuple(sorted(mistakes, key=lambda m: (KINDS.index(m.kind), _PLACE.get(m.code, 0))))
