"""The usual mistakes: what a program that makes one of them computes instead.

Each mistake changes a `Program`: the bicycle's parameters, the start, or what is written. Mistakes
can be made together, in any order that makes sense; `apply` makes several. Those that are read off
a file, such as columns in another order, are in `proposals`.
"""

from heyoka_bike.scoring.diagnosis.mistakes.in_axes import AXES_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.in_model import MODEL_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.in_output import OUTPUT_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.in_start import START_MISTAKES
from heyoka_bike.scoring.diagnosis.mistakes.linearised import LINEARISED, WRONGLY_LINEARISED
from heyoka_bike.scoring.diagnosis.programs.program import Mistake, Program, apply

__all__ = ["MISTAKES", "Mistake", "Program", "apply"]

MISTAKES: tuple[Mistake, ...] = (
    *MODEL_MISTAKES, *AXES_MISTAKES, *START_MISTAKES, *OUTPUT_MISTAKES, LINEARISED,
    *WRONGLY_LINEARISED,
)  # fmt: skip
"""The library, in no particular order."""
