"""How the columns of a file were understood: signs, conventions, and definitions not known here.

A program chooses its axes and senses freely: ground axes and those of each frame, which way lean
and steer are positive, whether a force is that on one body or on the other. Each choice turns round
all columns that it is about, and the sign of a column is the product of its choices. Whether some
choices give the signs of a file is a linear system over the integers modulo 2.

Conventions (axes, units, the zero of the energy, definitions) are no errors: they are said in one
sentence, and column by column with the errors that each choice leaves.

A column that means something that is not known here is far worse than all others of a right motion.
A wrong model or a rough integrator moves all columns. Where the columns with one meaning only have
many digits, and one with several meanings has few, the motion is right and the meaning is not among
those known. That is said instead of looking for a cause. Roll and steer move together, and the
speed and the energies with their squares only: these may be right beside a motion that is not, so
that one of the former must be right.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from math import floor

import numpy as np

from heyoka_bike.bicycle.columns import COMPARED, LATERAL, MOTION_COLUMNS
from heyoka_bike.numbers.double import median
from heyoka_bike.scoring.alignment import MOST_SAMPLED, spread
from heyoka_bike.scoring.findings import Finding, grouped, info, named, warning
from heyoka_bike.scoring.measures import rms
from heyoka_bike.scoring.report import (
    Alternative,
    ColumnScore,
    ManeuverScore,
    Place,
    Report,
    odds,
    odds_words,
    open_words,
)

SIGNS_DISAGREE = "signs_disagree"
ODD_SIGNS = (SIGNS_DISAGREE, "senses_opposed")
"""Findings about signs that may be errors: those columns' signs are not called conventions."""

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


def odd_signs(report: Report) -> Iterator[Finding]:
    """Signs that contradict each other, and senses that are likely to be an error."""
    signs = {
        key: places[0][1].as_understood.sign
        for key, places in report.by_column().items()
        if _has_sign(places)
    }
    for keys in contradictions(signs):
        if len(keys) == 2:
            what = f"{keys[0]} and {keys[1]} have opposite signs: one of them is turned round"
        else:
            what = f"{named(keys)} have signs that no axes give together: some are turned round"
            what += ", or they are of an inverse attitude" if "frame_" in keys[0] else ""
        yield warning(SIGNS_DISAGREE, what, columns=list(keys))
    if keys := opposed(signs):
        yield warning(
            "senses_opposed",
            "roll and steer have opposite senses: roll is positive to the left, steer to the "
            "right. Right-handed axes give this only if one points backward and another down (with "
            "x forward and z up it is steer that turns round): if yours are not so, one of the two "
            "has a sign error",
            columns=list(keys),
        )


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


DEFAULT = (
    "The file follows the conventions that are taken by default: SI units, roll and steer positive "
    "to the right, potential energy from the floor, and the first definition of each column"
)

UNITS_BESIDE = "units_beside"
"""Finding of a diagnosis that the file has other units than those that were scored."""

_SIDES: Mapping[str, tuple[str, ...]] = {
    "roll": ("roll_angle", "roll_rate"),
    "steer": ("steer_angle", "steer_rate"),
    "yaw": ("yaw", "yaw_rate"),
}
_TURNED = {"forward_speed": "the speed counts backward", "pitch": "nose down is positive"}
# Named in one sentence.
_MOST = 6
# Units differ by more than that, so that a column nearer than this tells its own.
_UNIT_TOLD = 0.05


def conventions(report: Report) -> Iterator[Finding]:
    """Say the conventions of a file in one sentence; nothing if they are those by default."""
    columns = {key: places[0][1] for key, places in report.by_column().items()}
    # Signs that may be errors are no convention.
    contradicted = {key for f in odd_signs(report) for key in f.evidence["columns"]}
    turned = [k for k, c in columns.items() if c.as_understood.sign < 0 and k not in contradicted]
    taken = {key: c.as_understood for key, c in columns.items()}
    units = {k: x.unit for k, x in taken.items() if x.unit != columns[k].as_written.unit}
    zeros = {k: x.offset for k, x in taken.items() if x.offset}
    meant = {k: c for k, c in columns.items() if _is_another(c)}
    said = [*_senses(turned), *in_units(units), *_zeros(zeros), *_definitions(meant)]
    if not said:
        return
    others = "else but the signs that are warned of" if contradicted else "else"
    yield info(
        "conventions",
        f"The file follows conventions of its own, which are no errors: {'; '.join(said)}. All "
        f"{others} is as by default. Errors are stated with these conventions applied",
        signs=turned,
        units=units,
        offsets=zeros,
        definitions={key: c.definition for key, c in meant.items()},
    )


def errors_words(found: Iterable[ColumnScore | Alternative]) -> str:
    """Largest errors, one for each maneuver."""
    errors = (x.max_abs_error for x in found)
    return " / ".join("-" if x is None else f"{x:.2g}" for x in errors)


def _senses(turned: Sequence[str]) -> Iterator[str]:
    """Say which way is positive, of the columns with the other sign."""
    left = [name for name, keys in _SIDES.items() if set(keys) & set(turned)]
    if left:
        yield f"{' and '.join(left)} {'is' if len(left) == 1 else 'are'} positive to the left"
    yield from (text for key, text in _TURNED.items() if key in turned)
    known = {*_TURNED, *(key for keys in _SIDES.values() for key in keys)}
    if others := [key for key in turned if key not in known]:
        yield f"{named(others, _MOST)} with the other sign, as in other axes"


def in_units(units: Mapping[str, str]) -> Iterator[str]:
    """Units of columns, as "roll_angle, steer_angle in degree"."""
    for unit in dict.fromkeys(units.values()):
        keys = [key for key, u in units.items() if u == unit]
        yield f"{named(keys, _MOST)} in {unit}"


def _definitions(meant: Mapping[str, ColumnScore]) -> Iterator[str]:
    for key, c in meant.items():
        sure = ", ".join(x for x in (odds(c), open_words([c])) if x)
        yield f"{key} is {c.definition}" + (f" ({sure})" if sure else "")


def _is_another(c: ColumnScore) -> bool:
    """True if a column is known to have another definition than the default."""
    return c.definition != c.as_written.definition and c.is_known


def _zeros(zeros: Mapping[str, float]) -> Iterator[str]:
    for offset in dict.fromkeys(zeros.values()):
        keys = [key for key, x in zeros.items() if x == offset]
        where = "above" if offset < 0 else "below"
        yield f"the zero of {named(keys, _MOST)} is {abs(offset):.9g} J {where} that at the floor"


def understood(report: Report) -> Iterator[Finding]:
    """Column by column, with the errors that each choice leaves."""
    for key, places in report.by_column().items():
        columns = [c for _, c in places]
        taken, written = columns[0].as_understood, columns[0].as_written
        evidence = {
            "column": key,
            "max_abs_error": [c.max_abs_error for c in columns],
            "max_abs_error_as_written": [c.as_written.measures.max_abs_error for c in columns],
        }
        errors = errors_words(columns)
        if _is_another(columns[0]):
            default = written.definition
            far = [a for c in columns for a in c.alternatives if a.definition == default]
            sure = f", {said}" if (said := odds(columns[0])) else ""
            open_ones = f" ({also})" if (also := open_words(columns)) else ""
            said = (
                f"{key} is {taken.definition}{sure}: errors {errors}, against {errors_words(far)} "
                f"for the default {default}{open_ones}"
            )
            yield info("definition", said, **evidence, definition=taken.definition)
        if taken.sign < 0:
            said = f"{key} has the other sign: errors {errors} with it turned round"
            yield info("sign", said, **evidence)
        if taken.unit != written.unit:
            said = f"{key} is in {taken.unit}, not {written.unit}: errors {errors} in the latter"
            yield info("unit", said, **evidence, unit=taken.unit)
        yield from _unit_contradicted(key, places)
        if taken.offset:
            said = f"{key} has another zero, {taken.offset:+.9g} J: errors {errors} without that "
            yield info("offset", said + "constant", **evidence, offset=taken.offset)


def _unit_contradicted(key: str, places: Sequence[Place]) -> Iterator[Finding]:
    (m, first), *_ = places
    unit = first.as_understood.unit
    heading = m.part.units.get(key, unit)
    far = [c.max_rel_error for _, c in places]
    if heading != unit and all(x is not None and x < _UNIT_TOLD for x in far):
        said = (
            f"{key}: its heading says {heading}, but its values are in {unit}. One of them is "
            "wrong; here they are taken as what they fit"
        )
        yield warning("unit_contradicted", said, column=key, named=heading, unit=unit)


# Columns of one motion are wrong by parts of their scales that differ by up to 100: the steer rate
# follows the fastest mode, the energies hardly move.
_FAR_WORSE = 1000.0
# ... and the others must be good enough to say that the motion is right.
RIGHT = 1e-3
_OTHERS = 2
_AT_FLOOR = 4.0


def unknown(report: Report) -> Iterator[Finding]:
    """Columns whose definition is not known, of a motion that is right."""
    known = [c for m in report.maneuvers for c in m.columns if c.is_known]
    for key, places in report.by_column().items():
        columns = [c for _, c in places]
        if columns[0].is_known:
            continue
        others = min(c.scd for c in known if c.scd is not None)
        nearest = columns[0].definition
        against = columns[0].none_odds or 0.0
        sure = f", {odds_words(-against)}" if against < 0.0 else ""
        yield warning(
            "definition_unknown",
            f"{key}: a definition of its own? None that is known here gives this column{sure}; "
            f"the other columns have {floor(others)} digits or more. The nearest definition is "
            f"{nearest}, with errors {errors_words(columns)}. This column is of another point or "
            "axis, or written wrongly: say what it is",
            column=key,
            nearest=nearest,
            max_abs_error=[c.max_abs_error for c in columns],
            digits_of_others=others,
        )


def far_worse(m: ManeuverScore, keys: Collection[str]) -> tuple[frozenset[str], float]:
    """Columns among `keys` that are far worse than all others of a maneuver, whose motion is right.

    Returns
    -------
    keys : frozenset of str
        The most of them that are; empty if none is.
    limit : float
        Largest error of the other columns, in scales.
    """
    columns = [c for c in m.columns if c.values]
    ranked = sorted((c for c in columns if c.key in keys), key=_typical, reverse=True)
    for count in range(len(ranked), 0, -1):
        worse = ranked[:count]
        others = [c for c in columns if c not in worse]
        limit = _largest(others)
        is_shown = len(others) >= _OTHERS and any(c.key in LATERAL for c in others)
        if is_shown and limit < RIGHT and all(is_far(c, limit) for c in worse):
            return frozenset(c.key for c in worse), limit
    return frozenset(), _largest(columns)


def is_far(c: ColumnScore, limit: float, times: float = _FAR_WORSE) -> bool:
    """True if a column is so many times worse than a limit, and than its digits allow."""
    return _typical(c) > times * limit and not c.is_at_floor(_AT_FLOOR)


def _largest(columns: Sequence[ColumnScore]) -> float:
    return max((c.as_understood.measures.max_rel_error or 0.0 for c in columns), default=0.0)


def _typical(c: ColumnScore) -> float:
    """Median error over the size of the column: a few bad rows are no other meaning."""
    size = rms(c.trace.reference) or 1.0
    return float(median(np.abs(c.trace.error))) / size
