"""Columns computed from others: those that a dataset does not store, or stores only at rows.

A friction demand has no dense pieces, because the magnitude of the tangential force has a corner
where the force vanishes. Definitions that are newer than a dataset (see `columns.FOLLOWING`) are
formulas of older columns, so they need no new dataset.
"""

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from heyoka_bike.bicycle.motion_columns import CONTACT_FORCES
from heyoka_bike.numbers.double import PI, Array, Doubles
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.reference.values import Values

Formula = Callable[[Any, Mapping[str, Any], Mapping[str, Any]], Any]
"""A formula of functions, columns and parameters of the bicycle, all in one number type."""


@dataclass(frozen=True, slots=True)
class Follows:
    """The formula of a column that is computed from other columns.

    Attributes
    ----------
    needs : tuple of str
        Names of the columns in the formula.
    formula
    parameters : tuple of str
        Symbols of the bicycle's parameters in the formula.
    """

    needs: tuple[str, ...]
    formula: Formula
    parameters: tuple[str, ...] = ()


def _friction(normal: str, along: str, across: str) -> Formula:
    return lambda a, c, _: a.sqrt(c[along] * c[along] + c[across] * c[across]) / c[normal]


def _rear_com(a: Any, c: Mapping[str, Any], p: Mapping[str, Any]) -> tuple[Any, Any, Any]:
    """Return the velocity of the rear frame's centre of mass along heading, axle and down."""
    x, z = _from_the_hub(p)
    turn = _pitch_turn(c, p)
    sin, cos = a.sin(c["pitch"]), a.cos(c["pitch"])
    aside = p["rR"] * c["roll_rate"] + c["yaw_rate_body_z"] * x - c["roll_rate_body_x"] * z
    return c["forward_speed"] + turn * (z * cos - x * sin), aside, -turn * (z * sin + x * cos)


def _from_the_hub(p: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return the upright rear frame's centre of mass relative to the rear hub [m]: ahead, down."""
    return p["xB"], p["zB"] + p["rR"]


def _pitch_turn(c: Mapping[str, Any], p: Mapping[str, Any]) -> Any:
    """Return the angular velocity of the rear frame about its axle [rad/s]."""
    return (c["forward_speed_wheel_spin"] - c["forward_speed"]) / p["rR"]


def _rear_com_body_x(a: Any, c: Mapping[str, Any], p: Mapping[str, Any]) -> Any:
    return c["forward_speed_hub_body_x"] + _pitch_turn(c, p) * _from_the_hub(p)[1]


def _rear_com_norm(a: Any, c: Mapping[str, Any], p: Mapping[str, Any]) -> Any:
    x, y, z = _rear_com(a, c, p)
    return a.sqrt(x * x + y * y + z * z)


def _rear_com_global_x(a: Any, c: Mapping[str, Any], p: Mapping[str, Any]) -> Any:
    ahead, aside, down = _rear_com(a, c, p)
    level = aside * a.cos(c["roll_angle"]) - down * a.sin(c["roll_angle"])
    return ahead * a.cos(c["yaw"]) - level * a.sin(c["yaw"])


def _zyx(a: Any, c: Mapping[str, Any]) -> tuple[Any, Any]:
    """Project the frame's x axis onto the floor: components across and along the heading."""
    return a.sin(c["roll_angle"]) * a.sin(c["pitch"]), a.cos(c["pitch"])


def _yaw_zyx(a: Any, c: Mapping[str, Any], _: Mapping[str, Any]) -> Any:
    return c["yaw"] + a.arctan2(*_zyx(a, c))


def _yaw_rate_zyx(a: Any, c: Mapping[str, Any], p: Mapping[str, Any]) -> Any:
    across, along = _zyx(a, c)
    sin_roll, sin_pitch = a.sin(c["roll_angle"]), a.sin(c["pitch"])
    pitch_rate = _pitch_turn(c, p) - c["yaw_rate"] * sin_roll
    across_rate = c["roll_rate"] * a.cos(c["roll_angle"]) * sin_pitch
    across_rate = across_rate + pitch_rate * sin_roll * along
    turned = across_rate * along + pitch_rate * across * sin_pitch
    return c["yaw_rate"] + turned / (across * across + along * along)


_SPEED_AND_SPIN = ("forward_speed", "forward_speed_wheel_spin")
_COM = (*_SPEED_AND_SPIN, "pitch", "roll_rate", "roll_rate_body_x", "yaw_rate_body_z")
_PLACE_PARAMETERS = ("rR", "xB", "zB")

FOLLOWS: Mapping[str, Follows] = {
    **{name: Follows(forces, _friction(*forces)) for name, forces in CONTACT_FORCES.items()},
    "forward_speed_rear_com_heading": Follows(_COM, lambda *x: _rear_com(*x)[0], _PLACE_PARAMETERS),
    "forward_speed_rear_com_body_x": Follows(
        (*_SPEED_AND_SPIN, "forward_speed_hub_body_x"), _rear_com_body_x, _PLACE_PARAMETERS
    ),
    "forward_speed_rear_com_global_x": Follows(
        (*_COM, "roll_angle", "yaw"), _rear_com_global_x, _PLACE_PARAMETERS
    ),
    "forward_speed_rear_com_norm": Follows(_COM, _rear_com_norm, _PLACE_PARAMETERS),
    "yaw_zyx": Follows(("yaw", "roll_angle", "pitch"), _yaw_zyx),
    "yaw_rate_zyx_rate": Follows(
        (*_SPEED_AND_SPIN, "yaw_rate", "roll_angle", "roll_rate", "pitch"), _yaw_rate_zyx, ("rR",)
    ),
}
"""Formulas by name of the column."""


def with_following(
    evaluate: Callable[[Sequence[str]], Values], names: Sequence[str],
    parameters: Mapping[str, str], known: Container[str] = (),
) -> Values:  # fmt: skip
    """Evaluate columns by a function, and compute those that follow from its results.

    `evaluate` also provides the columns of `known`, even if they could be computed. If it returns
    no lo, the others are computed in plain binary64.
    """
    follow = {name: FOLLOWS[name] for name in names if name in FOLLOWS and name not in known}
    needed = [n for name in names for n in (follow[name].needs if name in follow else (name,))]
    found = evaluate(list(dict.fromkeys(needed)))
    if not follow:
        return found
    hi, lo = dict(found.hi), dict(found.lo)
    # Make one number object for each column, so that formulas of the same angle share its cached
    # sine and cosine.
    exactly = {n: Doubles(hi[n], lo[n]) for n in lo}
    for name, how in follow.items():
        exact = {p: _value(parameters[p]) for p in how.parameters}
        if lo:
            x = how.formula(Doubles, exactly, {p: Doubles.of(v) for p, v in exact.items()})
            hi[name], lo[name] = x.hi, x.lo
        else:
            hi[name] = how.formula(np, hi, {p: float(v) for p, v in exact.items()})
    return Values({name: hi[name] for name in names}, {n: lo[n] for n in names if n in lo})


def following(columns: Mapping[str, Array], parameters: Mapping[str, float]) -> dict[str, Array]:
    """Compute all columns that follow from the columns of a motion, in plain binary64."""
    return {
        name: how.formula(np, columns, parameters)
        for name, how in FOLLOWS.items()
        if columns.keys() >= set(how.needs)
    }


def in_binary64(parameters: Mapping[str, str]) -> dict[str, float]:
    """Return the exact parameters of a bicycle rounded to binary64, for `following`."""
    return {name: float(_value(text)) for name, text in parameters.items()}


@cache
def _value(text: str) -> Fraction:
    exact = Exact.parse(text)
    return exact.rational + exact.pi_multiple * PI
