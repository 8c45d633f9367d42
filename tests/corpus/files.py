"""Files as users write them: a run, and the changes to its columns before they are written.

``python -m corpus.files FOLDER`` in tests writes all of them from `runs.h5` (NumPy and h5py only).
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from corpus.writing import (
    Change,
    File,
    Runs,
    as_single,
    coarse,
    constant,
    differences,
    lagrangian,
    late,
    normalised,
    scaled,
    shifted,
    shown,
    summed,
    text,
    timed,
    with_noise,
    with_zero,
    without_wheel_spin,
)

_LEFT = scaled(roll=-1, roll_rate=-1, steer=-1, steer_rate=-1)
_DEGREE = 180 / np.pi
_DEGREES = scaled(roll=_DEGREE, roll_rate=_DEGREE, steer=_DEGREE, steer_rate=_DEGREE)
_FROM_START = with_zero(lambda block: float(block["potential"][0]))
_SB, _EXU, _LIN, _NEW = (
    "symbrim-dop853-1e-12", "exudyn-trapezoidal-0.001", "linear-expm", "newton-dop853-1e-12",
)  # fmt: skip
_ROLL_AND_STEER = ("roll", "steer")
_NO_ENERGIES = ("roll", "roll_rate", "speed", "steer", "steer_rate")
_CSV = {"separator": ",", "heading": True}


def _conventions() -> Iterator[File]:
    """Honest files with other conventions or definitions."""
    runs = (("symbrim", _SB), ("exudyn", _EXU), ("newton", _NEW), ("linear", _LIN))
    common: tuple[tuple[str, str, tuple[Change, ...]], ...] = (
        ("left", "roll and steer positive to the left", (_LEFT,)),
        ("degrees", "angles and rates in degrees", (_DEGREES,)),
        ("zero-at-start", "potential energy zero at the start", (_FROM_START,)),
        ("left-degrees-km-h", "to the left, in degrees, speed in km/h",
         (_LEFT, _DEGREES, scaled(speed=3.6))),
    )  # fmt: skip
    for program, run in runs:
        for name, did, changes in common:
            yield File(f"{program}-{name}", run, did, "convention", changes)
    for name, did, changes in (
        ("steer-left", "steer positive to the left, roll to the right",
         (scaled(steer=-1, steer_rate=-1),)),
        ("angles-in-degrees", "angles in degrees, rates in rad/s",
         (scaled(roll=_DEGREE, steer=_DEGREE),)),
        ("kilojoules", "energies in kJ",
         (scaled(potential=1e-3, kinetic=1e-3, mechanical=1e-3),)),
        ("km-h", "speed in km/h", (scaled(speed=3.6),)),
        ("zero-at-hub", "potential energy zero at the height of the rear hub",
         (with_zero(lambda _: 94 * 9.81 * 0.3),)),
        ("energies-to-6-digits", "", ()),
    ):  # fmt: skip
        yield File(f"symbrim-{name}", _SB, did, "convention" if did else "", changes,
                   number="%.17g" if did else "%.6g")  # fmt: skip
    for name, did, source in (
        ("contact-global-x", "speed: SymBRiM's u1, the contact point along global x",
         "speed_contact_global_x"),
        ("hub-global-x", "speed: rear hub along global x", "speed_hub_global_x"),
        ("hub-norm", "speed: magnitude of the rear hub's velocity", "speed_hub_norm"),
        ("rear-spin", "speed: rear wheel's rate relative to the frame times its radius",
         "speed_rear_spin"),
        ("front-spin", "speed: front wheel's rate relative to the fork times its radius",
         "speed_front_spin"),
    ):  # fmt: skip
        yield File(f"symbrim-{name}", _SB, did, "convention", (shown(speed=source),))
    yield File(
        "symbrim-moore",
        _SB,
        "speed: SymBRiM's u1; roll rate along the tilted frame's x",
        "convention",
        (shown(speed="speed_contact_global_x", roll_rate="rate_own_x"),),
    )
    yield File(
        "symbrim-own-x",
        _SB,
        "roll rate along the tilted frame's x",
        "convention",
        (shown(roll_rate="rate_own_x"),),
    )
    yield File(
        "symbrim-xyz",
        _SB,
        "roll: first of the angles by Rotation.as_euler('XYZ')",
        "convention",
        (shown(roll="roll_intrinsic_xyz"),),
    )
    for name, did, source in (
        ("hub-global", "speed: Velocity of the rear hub, x", "speed_hub_global_x"),
        ("hub-norm", "speed: magnitude of the rear hub's velocity", "speed_hub_norm"),
        ("foot", "speed: VelocityLocal of the frame's point at the contact, x", "speed_foot"),
        ("rider", "speed: VelocityLocal of the rear frame's centre of mass, x", "speed_rider"),
        ("rear-spin", "speed: AngularVelocityLocal of the rear wheel about its axle times radius",
         "speed_rear_spin"),
    ):  # fmt: skip
        yield File(f"exudyn-{name}", _EXU, did, "convention", (shown(speed=source),))
    yield File(
        "exudyn-global-rate",
        _EXU,
        "roll rate: AngularVelocity, global x",
        "convention",
        (shown(roll_rate="rate_global_x"),),
    )
    yield File("exudyn-steer-left", _EXU, "steer positive to the left, as with z up", "convention",
               (scaled(steer=-1, steer_rate=-1),))  # fmt: skip


def _ways_of_writing() -> Iterator[File]:
    """Honest files with few digits, few columns, few rows or other separators."""
    for digits in (4, 6, 8, 10, 15):
        yield File(f"symbrim-{digits}-digits", _SB, f"{digits} significant digits",
                   number=f"%.{digits}g")  # fmt: skip
    yield File("symbrim-6-decimals", _SB, "6 decimals", number="%.6f")
    yield File("symbrim-4-decimals", _SB, "4 decimals", number="%.4f")
    yield File("symbrim-binary32", _SB, "values of binary32", changes=(as_single,))
    yield File("symbrim-binary32-9-digits", _SB, "values of binary32, 9 digits",
               changes=(as_single,), number="%.9g")  # fmt: skip
    yield File("exudyn-6-digits", _EXU, "6 significant digits", number="%.6g")
    yield File("exudyn-binary32", _EXU, "values of binary32", changes=(as_single,))
    yield File("linear-6-digits", _LIN, "6 significant digits", number="%.6g")
    yield File("linear-4-decimals", _LIN, "4 decimals", number="%.4f")
    yield File("symbrim-csv", _SB, "commas, a heading line", **_CSV)
    yield File("exudyn-csv", _EXU, "commas, a heading line", **_CSV)
    yield File("symbrim-0.1-s", _SB, "rows each 0.1 s", every=10)
    yield File("symbrim-0.05-s", _SB, "rows each 0.05 s", every=5)
    for m in (1, 2, 3):
        yield File(f"symbrim-only-{m}", _SB, f"maneuver {m} alone", maneuvers=(m,))
        yield File(f"linear-only-{m}", _LIN, f"maneuver {m} alone", maneuvers=(m,))
        yield File(f"symbrim-roll-and-steer-{m}", _SB, f"roll and steer angle of maneuver {m}",
                   maneuvers=(m,), columns=_ROLL_AND_STEER, **_CSV)  # fmt: skip
    yield File("exudyn-only-3", _EXU, "maneuver 3 alone", maneuvers=(3,))
    yield File("symbrim-no-energies", _SB, "without energies", columns=_NO_ENERGIES, **_CSV)
    yield File("linear-roll-and-steer", _LIN, "roll and steer angle of maneuver 2",
               maneuvers=(2,), columns=_ROLL_AND_STEER, **_CSV)  # fmt: skip
    yield File("symbrim-energies-zero", _SB, "energies never filled in: zeros",
               changes=(constant(potential=0, kinetic=0, mechanical=0),))  # fmt: skip
    yield File(
        "exudyn-energies-constant",
        _EXU,
        "energies never filled in: constants",
        changes=(constant(potential=794.1195, kinetic=0, mechanical=794.1195),),
    )


_ROLL, _STEER = ("roll", "roll_rate"), ("steer", "steer_rate")


def _mistakes_of_output() -> Iterator[File]:
    """Files of a correct run with a mistake in the output."""
    several: tuple[tuple[str, str, str, tuple[Change, ...]], ...] = (
        ("one-row-late", "rows one step late", "values of the next row beside each time",
         (late(1),)),
        ("one-row-early", "rows one step early", "values of the row before beside each time",
         (late(-1),)),
        ("time-stretched", "time stretched",
         "times by linspace(0, 10, 1000), rows of 0.01 s", (timed(1000 / 999),)),
        ("rate-for-steer", "roll rate and steer angle exchanged",
         "columns of roll rate and steer angle exchanged",
         (shown(roll_rate="steer", steer="roll_rate"),)),
        ("roll-for-steer", "roll and steer exchanged", "columns of roll and steer exchanged",
         (shown(roll="steer", steer="roll", roll_rate="steer_rate", steer_rate="roll_rate"),)),
        ("energies-exchanged", "potential and kinetic energy exchanged",
         "columns of potential and kinetic energy exchanged",
         (shown(potential="kinetic", kinetic="potential"),)),
        ("angle-for-rate", "roll angle and roll rate exchanged",
         "columns of roll angle and rate exchanged", (shown(roll="roll_rate", roll_rate="roll"),)),
        ("lagrangian", "mechanical energy is kinetic minus potential",
         "mechanical energy T - V instead of T + V", (lagrangian,)),
        ("potential-downwards", "potential energy with the other sign",
         "V = sum of m g z with z down, and E with it", (scaled(potential=-1), summed)),
        ("energy-normalised", "mechanical energy over its first value", "E / E0", (normalised,)),
        ("no-spin-energy", "kinetic energy without the wheels' spin",
         "kinetic energy without the wheels' rotation about the axles", (without_wheel_spin,)),
        ("forward-differences", "rates by forward differences",
         "rates by np.diff of the angles", (differences(_ROLL, _STEER, central=False),)),
        ("central-differences", "rates by central differences",
         "rates by np.gradient of the angles", (differences(_ROLL, _STEER, central=True),)),
        ("speed-by-front-radius", "speed times 7/6: spin times the front radius",
         "speed from the rear wheel's spin times the front radius", (scaled(speed=0.35 / 0.3),)),
        ("speed-constant", "speed is the constant of the start",
         "speed column filled with the start's", (lambda block: block | {
             "speed": np.full_like(block["speed"], block["speed"][0])},)),
        ("pitch-for-roll", "pitch in place of the roll", "roll column holds q5, the pitch",
         (shown(roll="pitch"),)),
        ("yaw-for-steer", "yaw in place of the steer", "steer columns hold q3 and u3, the yaw",
         (shown(steer="yaw", steer_rate="yaw_rate"),)),
        ("straight-lines", "interpolated between few rows",
         "rows each 0.1 s, straight lines between", (coarse(10),)),
        ("noise-1e-6", "noise", "noise of 1e-6 of each column's size", (with_noise(1e-6),)),
        ("milliseconds", "time in milliseconds", "time in ms", (timed(1000),)),
        ("from-1-s", "time a second late", "the clock starts at 1 s", (shifted(1.0),)),
        ("rate-sign", "roll rate with the other sign than the roll angle",
         "roll rate to the left, roll angle to the right", (scaled(roll_rate=-1),)),
        ("steer-sign", "steer angle with the other sign than its rate",
         "steer angle to the left, its rate to the right", (scaled(steer=-1),)),
        ("steer-rate-in-degrees", "steer rate in degrees per second alone",
         "steer rate in degrees, all else in radians", (scaled(steer_rate=_DEGREE),)),
    )  # fmt: skip
    for name, expected, did, changes in several:
        yield File(f"output-{name}", _SB, did, expected, changes)
    yield File(
        "output-one-maneuver-thrice",
        _SB,
        "maneuver 1 in all three places",
        "one maneuver in several places",
        maneuvers=(1, 1, 1),
    )
    yield File("output-maneuvers-exchanged", _SB, "maneuvers 2 and 3 exchanged",
               "maneuvers exchanged", maneuvers=(1, 3, 2))  # fmt: skip


def files(index: Mapping[str, Any]) -> Iterator[File]:
    """All files: each run as it is until the bicycle falls, then the files made from some of the
    runs."""
    for name in index:
        yield File(name, name)
    yield from _conventions()
    yield from _ways_of_writing()
    yield from _mistakes_of_output()
    for run in ("fork-not-rotated", "rear-product-sign", "gravity-9.8", "start-by-front-radius"):
        for m in (1, 3):
            yield File(f"symbrim-{run}-only-{m}", f"symbrim-{run}", f"maneuver {m} alone",
                       maneuvers=(m,))  # fmt: skip
    yield File(
        "symbrim-fork-not-rotated-6-digits",
        "symbrim-fork-not-rotated",
        "6 significant digits",
        number="%.6g",
    )
    yield File(
        "symbrim-both-not-rotated-left",
        "symbrim-both-not-rotated",
        "roll and steer positive to the left",
        changes=(_LEFT,),
    )
    yield File(
        "symbrim-rear-not-rotated-moore",
        "symbrim-rear-not-rotated",
        "speed: SymBRiM's u1",
        changes=(shown(speed="speed_contact_global_x"),),
    )


def main(arguments: Sequence[str]) -> None:
    folder, runs = Path(arguments[0]), Runs(*map(Path, arguments[1:2]))
    folder.mkdir(parents=True, exist_ok=True)
    for file in files(runs.index):
        (folder / f"{file.name}.txt").write_text(text(file, runs), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
