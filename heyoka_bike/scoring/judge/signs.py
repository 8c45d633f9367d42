"""Signs: whether a choice of axes and senses explains the signs of a file's columns.

Each column has the sign 1 or -1 relative to the reference. A program chooses its axes and senses
freely: the ground axes and the axes of each frame, the direction in which lean and steer are
positive, and the body on which a force acts. Each choice flips certain columns, and the sign of a
column is the product of its choices. Whether there are choices that give the signs of a file is a
linear system over the integers modulo 2.

A set of columns whose signs no choice explains is a `SignContradiction`: one of them is flipped by
mistake. Signs that only unusual axes explain are `SensesOpposed`. In a wrong motion, the slope of
an angle still shows whether its rate has the same sign.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import ANGLE_OF, COMPARED
from heyoka_bike.bicycle.motion_columns import MOTION_COLUMNS
from heyoka_bike.numbers.double import median
from heyoka_bike.scoring.alignment import MOST_SAMPLED, spread
from heyoka_bike.scoring.evidence.column_meaning import SensesOpposed, SignContradiction
from heyoka_bike.scoring.grades import TOLERANCE
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.scores import ManeuverScore, Place
from heyoka_bike.scoring.slopes import opposite_pairs

_ENDS = ("rear", "front")
_GROUND = {axis: f"ground {axis}" for axis in "xyz"}


def _choices() -> dict[str, frozenset[str]]:
    found = {
        "roll_angle": {"lean"}, "roll_rate": {"lean"}, "forward_speed": {"ahead"},
        "steer_angle": {"steer"}, "steer_rate": {"steer"}, "pitch": {"pitch"},
        "yaw": {"heading"}, "yaw_rate": {"heading"},
    }  # fmt: skip
    for end in _ENDS:
        # The columns of the rotation matrix are the frame's axes, and its determinant is one. So
        # the sign of the third axis follows from the signs of all other axes.
        axes = {"x": {f"{end} x"}, "y": {f"{end} y"}}
        axes["z"] = {*axes["x"], *axes["y"], *_GROUND.values()}
        for i, row in enumerate("xyz", 1):
            for j, axis in enumerate("xyz", 1):
                found[f"{end}_frame_r{i}{j}"] = axes[axis] ^ {_GROUND[row]}
            # q and -q are the same rotation. If the axes are flipped by a diagonal matrix d, the
            # vector part of q becomes det(d) d q.
            others = set(_GROUND.values()) - {_GROUND[row]}
            found[f"{end}_frame_q{i}"] = {f"{end} -q", *others}
            found[f"{end}_frame_omega_{row}"] = axes[row] ^ {"sense"}
            found[f"{end}_axle_force_{row}"] = axes[row] ^ {f"{end} action"}
            found[f"{end}_axle_moment_{row}"] = axes[row] ^ {f"{end} action", "sense"}
        found[f"{end}_frame_q0"] = {f"{end} -q"}
        # The rate of the wheel is the derivative of its angle, apart from the rate of the pitch.
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
"""The choices that flip each column, by key; a column without an entry has only one sign."""


def odd_signs(report: Report) -> Iterator[SignContradiction | SensesOpposed]:
    """Yield evidence of signs that contradict each other, or that are probably an error."""
    signs = {
        key: places[0][1].as_understood.sign
        for key, places in report.by_column().items()
        if _has_sign(places)
    }
    further = (pair for pair in _opposite_pairs(report) if not signs.keys() >= {*pair})
    for keys in (*contradictions(signs), *further):
        yield SignContradiction(keys)
    if keys := opposed(signs):
        yield SensesOpposed(keys)


def _has_sign(places: Sequence[Place]) -> bool:
    """True if most values resemble the reference enough to show a sign.

    Errors must be below half the distance between the reference and its negative.
    """
    for _, c in places:
        some = spread(len(c.trace.time), MOST_SAMPLED)
        if median(np.abs(c.trace.error[some])) >= median(np.abs(c.trace.reference[some])):
            return False
    return True


def _opposite_pairs(report: Report) -> Iterator[tuple[str, str]]:
    """Yield angles and rates of which one is flipped, as the slope of the angle shows."""
    signs = {key: places[0][1].as_understood.sign for key, places in report.by_column().items()}
    # Compare the signs as written, because they do not depend on the interpretation.
    written = [
        {c.key: (c.trace.time, signs[c.key] * c.trace.value) for c in m.columns if c.values}
        for m in report.maneuvers
    ]
    for angle, rate in opposite_pairs(written, is_begun=any(map(_begins, report.maneuvers))):
        if signs[angle] != signs[rate]:
            yield angle, rate


def _begins(m: ManeuverScore) -> bool:
    """True if a first row contains the given initial rate, with either sign."""
    rates = (c for c in m.columns if c.key in ANGLE_OF and c.values and c.trace.time[0] == 0.0)
    starts = ((abs(c.trace.value[0]), abs(m.part.reference[c.key][0])) for c in rates)
    return any(given and abs(x - given) <= TOLERANCE * given for x, given in starts)


def contradictions(signs: Mapping[str, int]) -> list[tuple[str, ...]]:
    """Return sets of columns whose signs cannot be explained by any choice of axes and senses.

    Parameters
    ----------
    signs
        Sign of each column relative to the reference, 1 or -1, by key.

    Returns
    -------
    list of tuple of str
        Disjoint sets; empty if the signs are consistent. The entries of a quaternion or a matrix
        are compared with each other first, then with other columns.
    """
    families = grouped((key.rstrip("0123"), key) for key in signs)
    attitudes = (keys for family, keys in families.items() if family not in keys)
    found = [tuple(keys) for keys in attitudes if _impossible(keys, signs)]
    contradicted = {key for keys in found for key in keys}
    return found + _impossible([key for key in signs if key not in contradicted], signs)


def opposed(signs: Mapping[str, int]) -> tuple[str, ...]:
    """Return columns of roll and steer, if roll is positive to the left and steer to the right.

    A right-handed rotation about an axis that points forward is a roll to the right. About an axis
    that points down it steers to the right, about an axis that points up to the left. So in the
    usual axes with z up, only steer is positive to the left. Only roll is positive to the left if
    one axis points backward and one down, or in left-handed axes. That is rare enough to ask the
    user.

    Parameters
    ----------
    signs
        Sign of each column relative to the reference, 1 or -1, by key.

    Returns
    -------
    tuple of str
        Keys, first those of roll; empty if the signs are otherwise or unknown.
    """
    roll = [key for key in ("roll_angle", "roll_rate") if key in signs]
    steer = [key for key in ("steer_angle", "steer_rate") if key in signs]
    are_opposed = all(signs[key] < 0 for key in roll) and all(signs[key] > 0 for key in steer)
    return (*roll, *steer) if roll and steer and are_opposed else ()


def _impossible(keys: Iterable[str], signs: Mapping[str, int]) -> list[tuple[str, ...]]:
    """Return sets of columns with inconsistent equations: elimination reduces them to 0 = 1."""
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
