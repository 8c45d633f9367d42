"""Signs: whether some choice of axes and senses gives those of a file.

The task: each column has the sign 1 or -1 against the reference. A program chooses its axes and
senses freely: ground axes and those of each frame, which way lean and steer are positive, whether a
force is that on one body or on the other. Each choice turns round all columns that it is about, and
the sign of a column is the product of its choices. Whether some choices give the signs of a file is
a linear system over the integers modulo 2.

A set of columns whose signs no choice gives is a `SignContradiction`: one of them is turned round.
Signs that only unusual axes give are `SensesOpposed`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED, MOTION_COLUMNS
from heyoka_bike.numbers.double import median
from heyoka_bike.scoring.alignment import MOST_SAMPLED, spread
from heyoka_bike.scoring.evidence.column_meaning import SensesOpposed, SignContradiction
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import Place

_ENDS = ("rear", "front")
_GROUND = {axis: f"ground {axis}" for axis in "xyz"}


def _choices() -> dict[str, frozenset[str]]:
    found = {
        "roll_angle": {"lean"}, "roll_rate": {"lean"}, "forward_speed": {"ahead"},
        "steer_angle": {"steer"}, "steer_rate": {"steer"}, "pitch": {"pitch"},
        "yaw": {"heading"}, "yaw_rate": {"heading"},
    }  # fmt: skip
    for end in _ENDS:
        # A matrix whose columns are the frame's axes and whose determinant is one: the sign of the
        # third axis follows from all others.
        axes = {"x": {f"{end} x"}, "y": {f"{end} y"}}
        axes["z"] = {*axes["x"], *axes["y"], *_GROUND.values()}
        for i, row in enumerate("xyz", 1):
            for j, axis in enumerate("xyz", 1):
                found[f"{end}_frame_r{i}{j}"] = axes[axis] ^ {_GROUND[row]}
            # q and -q are the same turn. With all axes turned round by d, its vector is det(d) d q.
            others = set(_GROUND.values()) - {_GROUND[row]}
            found[f"{end}_frame_q{i}"] = {f"{end} -q", *others}
            found[f"{end}_frame_omega_{row}"] = axes[row] ^ {"sense"}
            found[f"{end}_axle_force_{row}"] = axes[row] ^ {f"{end} action"}
            found[f"{end}_axle_moment_{row}"] = axes[row] ^ {f"{end} action", "sense"}
        found[f"{end}_frame_q0"] = {f"{end} -q"}
        # The rate is that of the angle, but for the pitch.
        found[f"{end}_wheel_angle"] = found[f"{end}_wheel_omega_y"] = {"rolling"}
        found[f"{end}_normal_force"] = {"up", "floor action"}
        found[f"{end}_longitudinal_force"] = {"along", "floor action"}
        found[f"{end}_lateral_force"] = {"across", "floor action"}
    for axis in "xyz":
        found[f"steer_joint_force_{axis}"] = {f"steer {axis}", "steer action"}
        found[f"steer_joint_moment_{axis}"] = {f"steer {axis}", "steer action", "sense"}
    for column in MOTION_COLUMNS:
        if column.definition == "ground_axes":
            found[column.key] = {_GROUND[column.key[-1]]}
    return {key: frozenset(choices) for key, choices in found.items() if key in COMPARED}


CHOICES: Mapping[str, frozenset[str]] = _choices()
"""By key of a column, the choices that turn it round; a column that is not here has one sign."""


def odd_signs(report: Report) -> Iterator[SignContradiction | SensesOpposed]:
    """Signs that contradict each other, and senses that are likely to be an error."""
    signs = {
        key: places[0][1].as_understood.sign
        for key, places in report.by_column().items()
        if _has_sign(places)
    }
    for keys in contradictions(signs):
        yield SignContradiction(keys)
    if keys := opposed(signs):
        yield SensesOpposed(keys)


def _has_sign(places: Sequence[Place]) -> bool:
    """True if most values are nearer to the reference than they would be with another sign."""
    for _, c in places:
        some = spread(len(c.trace.time), MOST_SAMPLED)
        if median(np.abs(c.trace.error[some])) >= median(np.abs(c.trace.reference[some])):
            return False
    return True


def contradictions(signs: Mapping[str, int]) -> list[tuple[str, ...]]:
    """Sets of columns whose signs no choice of axes and senses gives.

    Parameters
    ----------
    signs
        1 or -1 of each column against the reference, by key.

    Returns
    -------
    list of tuple of str
        Disjoint; empty if the file agrees with itself. The entries of one quaternion or matrix are
        told before they are held against other columns.
    """
    families = grouped((key.rstrip("0123"), key) for key in signs)
    attitudes = (keys for family, keys in families.items() if family not in keys)
    found = [tuple(keys) for keys in attitudes if _impossible(keys, signs)]
    told = {key for keys in found for key in keys}
    return found + _impossible([key for key in signs if key not in told], signs)


def opposed(signs: Mapping[str, int]) -> tuple[str, ...]:
    """Columns of roll, positive to the left, beside a steer that is positive to the right.

    A right-handed turn about an axis that points forward leans to the right, and about one that
    points down steers to the right, about one that points up to the left. So steer alone is
    positive to the left in the usual axes with z up, and roll alone where one axis points backward
    and one down, or in left-handed axes: rare enough to be worth a question.

    Parameters
    ----------
    signs
        1 or -1 of each column against the reference, by key.

    Returns
    -------
    tuple of str
        Keys, first those of roll; empty if this is not so, or not told.
    """
    roll = [key for key in ("roll_angle", "roll_rate") if key in signs]
    steer = [key for key in ("steer_angle", "steer_rate") if key in signs]
    are_opposed = all(signs[key] < 0 for key in roll) and all(signs[key] > 0 for key in steer)
    return (*roll, *steer) if roll and steer and are_opposed else ()


def _impossible(keys: Iterable[str], signs: Mapping[str, int]) -> list[tuple[str, ...]]:
    """Gauss's elimination: sums of equations whose left side vanishes and whose right side is 1."""
    keys = list(keys)
    solved: list[tuple[str, frozenset[str], frozenset[str], bool]] = []
    found: list[set[str]] = []
    for key in keys:
        choices, of, is_turned = CHOICES.get(key, frozenset()), frozenset({key}), signs[key] < 0
        for pivot, others, summed, turned in solved:
            if pivot in choices:
                choices, of, is_turned = choices ^ others, of ^ summed, is_turned ^ turned
        if choices:
            solved.append((min(choices), choices, of, is_turned))
        elif is_turned:
            shared = [c for c in found if c & of]
            found = [c for c in found if c not in shared] + [set(of).union(*shared)]
    return [tuple(key for key in keys if key in c) for c in found]
