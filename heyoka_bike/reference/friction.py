"""The friction demand at any time: it follows from the contact force.

It has no pieces of its own: where the tangential force vanishes, its magnitude has a corner.
"""

from collections.abc import Callable, Sequence

import numpy as np

from heyoka_bike.bicycle.motion_columns import CONTACT_FORCES
from heyoka_bike.numbers.double import add, divide, multiply, root
from heyoka_bike.reference.values import Values


def with_friction(evaluate: Callable[[Sequence[str]], Values], names: Sequence[str]) -> Values:
    """Columns by a function that knows all but the friction demands, and these."""
    needed = [force for name in names for force in CONTACT_FORCES.get(name, (name,))]
    found = evaluate(list(dict.fromkeys(needed)))
    hi, lo = dict(found.hi), dict(found.lo)
    for name in CONTACT_FORCES.keys() & set(names):
        normal, *tangential = (
            (hi[force], lo.get(force, np.zeros_like(hi[force]))) for force in CONTACT_FORCES[name]
        )
        squares = [multiply(force, force) for force in tangential]
        hi[name], lo[name] = divide(root(add(*squares)), *normal)
    return Values({name: hi[name] for name in names}, {n: lo[n] for n in names if n in lo})
