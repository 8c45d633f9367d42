"""Mistakes in the output of a correct motion."""

from collections.abc import Callable, Sequence

import numpy as np

from heyoka_bike.bicycle.columns import DEFINITIONS
from heyoka_bike.numbers.double import Array
from heyoka_bike.scoring.diagnosis.programs.program import (
    Mistake,
    Program,
    clock_mistake,
    output_mistake,
)
from heyoka_bike.scoring.grades import RIGHT
from heyoka_bike.scoring.rows.edits import Change, Columns, Rewritten
from heyoka_bike.scoring.rows.local_polynomials import local_polynomials

# For each rate, the angle whose derivative it is. Some definitions of the roll angle have their own
# definition of the roll rate.
_RATES = {
    "roll_rate": "roll_angle",
    "steer_rate": "steer_angle",
    "roll_rate_tait_bryan_xyz_rate": "roll_angle_tait_bryan_xyz",
    "roll_rate_zyx_rate": "roll_angle_zyx",
}


def _differences(which: str) -> Change:
    """Return a change that replaces rates with differences of the angles of neighbouring rows."""

    def rate(angle: Array, time: Array) -> Array:
        if len(angle) < 3:
            return np.full_like(angle, np.nan)
        slopes = np.diff(angle) / np.diff(time)
        if which == "forward":
            return np.append(slopes, slopes[-1])
        found: Array = np.gradient(angle, time)
        return np.insert(slopes, 0, slopes[0]) if which == "backward" else found

    def change(columns: Columns, time: Array) -> Columns:
        return {**columns, **{key: rate(columns[angle], time) for key, angle in _RATES.items()}}

    return change


def _changed(
    columns: Columns, keys: Sequence[str], change: Callable[[Array], Array]
) -> dict[str, Array]:
    """Apply a function to the columns of some quantities, in every definition."""
    names = {c.name for key in keys for c in DEFINITIONS[key]} & columns.keys()
    return {**columns, **{name: change(columns[name]) for name in names}}


def _rates_shifted(rows: float) -> Change:
    """Return a change that replaces each rate with the rate this many rows later."""

    def change(columns: Columns, time: Array) -> Columns:
        if len(time) <= DEGREE:
            return columns
        step = rows * float(np.median(np.diff(time)))
        meant = np.clip(time + step, time[0], time[-1]) - time
        powers = meant[:, None] ** np.arange(DEGREE + 1)
        return _changed(
            columns,
            ("roll_rate", "steer_rate"),
            lambda x: np.sum(local_polynomials(time, x, DEGREE) * powers, axis=1),
        )

    return change


def _energies(
    kinetic: float = 1.0, potential: float = 1.0, without: str = "", below: str = ""
) -> Change:
    """Return a change that multiplies the energies by factors and leaves out parts of them.

    `without` and `below` name the parts of the kinetic and of the potential energy.
    """

    def change(columns: Columns, _: Array) -> Columns:
        t = kinetic * (columns["kinetic_energy"] - (columns[without] if without else 0.0))
        v = potential * (columns["potential_energy"] - (columns[below] if below else 0.0))
        return {**columns, "kinetic_energy": t, "potential_energy": v, "mechanical_energy": t + v}

    return change


def _difference(columns: Columns, sign: int) -> Columns:
    """Replace the mechanical energy with the kinetic minus the potential energy, times a sign."""
    difference = columns["kinetic_energy"] - columns["potential_energy"]
    return {**columns, "mechanical_energy": sign * difference}


def _first_speed(columns: Columns, _: Array) -> Columns:
    return _changed(columns, ("forward_speed",), lambda v: np.where(np.isfinite(v), v[0], np.nan))


def _speed_times(code: str, says: str, radius: str, other: str) -> Mistake:
    """Make a mistake that computes the forward speed with the other wheel's radius."""

    def make(program: Program) -> Program:
        ratio = float(program.motion.bicycle[radius]) / float(program.motion.bicycle[other])

        def change(columns: Columns, _: Array) -> Columns:
            return _changed(columns, ("forward_speed",), lambda v: ratio * v)

        return program.edited(Rewritten(change))

    return Mistake(code, says, "the radius in the forward speed", "output", make)


def _absolute_steer_rate(columns: Columns, _: Array) -> Columns:
    """Add the angular velocity of the rear frame along the steer axis to the steer rate."""
    absolute = columns["steer_rate"] + columns["yaw_rate_steer_axes_z"]
    return {**columns, "steer_rate": absolute}


_BODIES = {"R": "rear wheel", "B": "rear frame with rider", "H": "fork", "F": "front wheel"}

# Degree of the polynomials that interpolate a rate between the rows.
DEGREE = 5

_MOMENT = "when a row is written: before or after the step"
_SUMMED = (
    "that the energy sum contains the potential, translational and rotational energy of every body"
)


_FEWEST_ROWS = 3


def misspaced(times: Array, duration: float) -> tuple[Mistake, ...]:
    """Return the mistakes in counting rows that these times allow.

    If the written times include the end of the run, the rows may be spread over the run without its
    end. If they stop one step before the end [s], the rows may be spread over the whole run. With
    other times there is no such mistake.
    """
    rows = len(times)
    if rows < _FEWEST_ROWS:
        return ()
    found = []
    for code, steps, scale in (
        ("end_left_out", rows - 1, (rows - 1) / rows),
        ("one_row_less", rows, rows / (rows - 1)),
    ):
        step = duration / steps
        if np.max(np.abs(times - step * np.arange(rows))) > RIGHT * step:
            continue
        found.append(
            clock_mistake(
                code,
                f"the motion advances by {scale * step:g} s from row to row, but the times by "
                f"{step:g} s",
                "whether the rows include the end of the run",
                scale=scale,
            )
        )
    return tuple(found)


ROWS_LATE = {
    1.0: ("one_row_late", "one row before"),
    -1.0: ("one_row_early", "one row after"),
    0.5: ("half_row_late", "half a row before"),
    -0.5: ("half_row_early", "half a row after"),
}
"""By the delay of a rate in rows: the name of the mistake, and words for the row of the rate."""

OUTPUT_MISTAKES: tuple[Mistake, ...] = (
    clock_mistake("one_step_late", "each row is written one step late", _MOMENT, shift=-1.0),
    clock_mistake("one_step_early", "each row is written one step early: the first row has "
                  "the state at t = h", _MOMENT, shift=1.0),
    clock_mistake("half_step_late", "each row is written half a step late", _MOMENT, shift=-0.5),
    clock_mistake("half_step_early", "each row is written half a step early", _MOMENT, shift=0.5),
    *(output_mistake(f"{which}_differences", f"the rates are {which} differences of the angles",
                     "where the rates come from", _differences(which))
      for which in ("forward", "backward", "central")),
    *(output_mistake(f"rates_{code}", f"the rates are taken {says} the angles", _MOMENT,
                     _rates_shifted(-rows))
      for rows, (code, says) in ROWS_LATE.items()),
    output_mistake("energy_without_spin", "the kinetic energy leaves out the wheels' spin about "
                   "their axles", _SUMMED, _energies(without="spin_energy")),
    *(output_mistake(f"energy_without_spin_{wheel}", f"the kinetic energy leaves out the {name} "
                     "wheel's spin about its axle", _SUMMED,
                     _energies(without=f"spin_energy_{wheel}"))
      for wheel, name in (("R", "rear"), ("F", "front"))),
    output_mistake("energy_without_rotation", "the kinetic energy leaves out all rotation",
                   _SUMMED, _energies(without="rotation_energy")),
    output_mistake("energy_without_rotation_of_wheels", "the kinetic energy leaves out the "
                   "wheels' rotation", _SUMMED, _energies(without="rotation_energy_of_wheels")),
    *(output_mistake(f"energy_without_rotation_of_{body}", "the kinetic energy leaves out the "
                     f"rotation of the {name}", _SUMMED,
                     _energies(without=f"rotation_energy_of_{body}"))
      for body, name in _BODIES.items()),
    *(output_mistake(f"{kind}_energy_without_{body}", f"the {kind} energy leaves out the "
                     f"{name}", _SUMMED,
                     _energies(without=f"kinetic_energy_of_{body}" if kind == "kinetic" else "",
                               below=f"potential_energy_of_{body}" if kind == "potential" else ""))
      for kind in ("kinetic", "potential") for body, name in _BODIES.items()),
    *(output_mistake(f"energies_without_{body}", f"the energies leave out the {name}",
                     _SUMMED, _energies(without=f"kinetic_energy_of_{body}",
                                        below=f"potential_energy_of_{body}"))
      for body, name in _BODIES.items()),
    output_mistake("kinetic_doubled", "the kinetic energy is twice too large", _SUMMED,
                   _energies(kinetic=2.0)),
    output_mistake("potential_sign", "the potential energy falls with the height", _SUMMED,
                   _energies(potential=-1.0)),
    output_mistake("energy_difference", "the mechanical energy is the kinetic minus the potential "
                   "energy", _SUMMED, lambda c, _: _difference(c, 1)),
    output_mistake("energy_difference_reversed", "the mechanical energy is the potential minus the "
                   "kinetic energy", _SUMMED, lambda c, _: _difference(c, -1)),
    output_mistake("speed_of_start", "the forward speed written is that of the start in every row",
                   "where the forward speed comes from: it varies", _first_speed),
    _speed_times("speed_written_by_front_radius", "the forward speed written is the spin of the "
                 "rear wheel times the radius of the front wheel", "rF", "rR"),
    _speed_times("speed_written_by_rear_radius", "the forward speed written is the spin of the "
                 "front wheel times the radius of the rear wheel", "rR", "rF"),
    output_mistake("steer_rate_absolute", "the steer rate written is the absolute angular velocity "
                   "of the front frame about the steer axis, without subtracting that of the rear "
                   "frame", "the steer rate in the output: it is relative to the rear frame",
                   _absolute_steer_rate),
)  # fmt: skip
"""Mistakes in the output, in no particular order."""
