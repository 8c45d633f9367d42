"""Seeded random pairs of mistakes, each visible in the presence of the other."""

import numpy as np

from generators.mistaken_programs import SEEN, columns_of, distance
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.scoring.diagnosis.mistakes.library import MISTAKES

LEVEL = 1e-6
SEED = 20


def random_pairs(reference, count):
    """Yield codes of two mistakes, and the columns of a program that makes both."""
    scales = {(n, k): reference[n].scale(k) for n in reference for k in BENCHMARK_COLUMNS}
    correct = columns_of(reference, [])
    random = np.random.default_rng(SEED)
    while count:
        i, j = sorted(random.choice(len(MISTAKES), 2, replace=False))
        pair = MISTAKES[i], MISTAKES[j]
        try:
            made = columns_of(reference, pair)
        except ZeroDivisionError:
            # With these two mistakes together, one half of the bicycle has no mass.
            continue
        others = [correct, *(columns_of(reference, [m]) for m in pair)]
        if min(distance(made, other, scales) for other in others) < SEEN * LEVEL:
            continue
        count -= 1
        yield tuple(m.code for m in pair), made
