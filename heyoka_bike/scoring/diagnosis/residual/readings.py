"""Other interpretations of a file's columns.

If the motion is wrong, a column may fit the exact motion best by a wrong definition or sign.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import log

from heyoka_bike.bicycle.columns import ANGLE_OF, COMPARED, DERIVATIVES
from heyoka_bike.scoring.definitions import Understanding
from heyoka_bike.scoring.diagnosis.odds import THRESHOLDS


def readings(understood: Mapping[str, Understanding]) -> Iterator[Mapping[str, Understanding]]:
    """Yield interpretations of a file, beginning with the one that fits the exact motion best.

    These are: the definitions that fit best; the default definitions; and these with the opposite
    sign of steer.
    """
    yield understood
    plain = {key: replace(u, column=COMPARED[key][0]) for key, u in understood.items()}
    yield plain
    turned = [key for key in ("steer_angle", "steer_rate") if key in plain]
    yield plain | {key: replace(plain[key], sign=-plain[key].sign) for key in turned}


def other_definitions(
    understood: Mapping[str, Understanding], keys: Sequence[str], *, rates_are_slopes: bool
) -> Iterator[Mapping[str, Understanding]]:
    """Yield interpretations of some columns with other definitions, the likeliest first.

    Definitions that are far less likely than the likeliest one are skipped. With
    `rates_are_slopes`, so is each definition of a rate that is not the derivative of its angle.
    """
    having = [key for key in keys if key in understood]
    ways = []
    for key in having:
        u = understood[key]
        odds = {u.column.definition: 0.0, **u.odds}
        likely = sorted(odds, key=lambda name: odds[name])
        each = {c.definition: c for c in COMPARED[key]}
        least = THRESHOLDS.drop_log_odds / log(10.0)
        ways.append([
            replace(u, column=each[name], indistinguishable=())
            for name in likely if name in each and odds[name] - odds[likely[0]] < least
        ])  # fmt: skip
    for several in product(*ways):
        read = dict(zip(having, several, strict=True))
        found = {**understood, **read}
        if rates_are_slopes and not all(_is_slope(key, found) for key in having):
            continue
        if any(read[key].column != understood[key].column for key in having):
            yield found


def _is_slope(key: str, understood: Mapping[str, Understanding]) -> bool:
    """False for a rate whose definition is not that of the derivative of its angle."""
    angle = understood.get(ANGLE_OF.get(key, ""))
    own = DERIVATIVES.get((key, understood[key].column.definition))
    return angle is None or own == (angle.column.key, angle.column.definition)
