"""Compute the long-term behaviour of the bicycle for a grid of initial speed and roll rate.

Simulate the bicycle from every point of a grid of initial conditions. It converges to steady
straight running, approaches a limit cycle, lifts a wheel on its way, or falls. The atlas records
for each point which of these happens and when, the final speed, the largest lean and steer, and the
factor by which the motion magnifies a small initial error. The boundary between the behaviours is
bisected down to neighbouring binary64 numbers. The result is a Zarr store, which xarray opens.
Needs heyoka and zarr, on Linux: pip install "heyoka_bike[atlas]".

The bicycle starts upright and straight unless an option sets other values. To continue after an
interruption, give the same command again.

names: speed [m/s], roll_rate [rad/s], roll, steer [rad], steer_rate [rad/s], or a
parameter of the bicycle by its symbol, such as c (trail), w, lam, mB, xB

examples:
  heyoka-bike atlas -o benchmark.zarr
  heyoka-bike plot --figure atlas benchmark.zarr -o atlas.svg
  heyoka-bike atlas --speed 4:5:100 --axis steer=-0.3:0.3:61 -o steered.zarr
  heyoka-bike atlas --axis c=0.02:0.12:51 --start roll_rate=0.5 -o trail.zarr

exit codes: 3 --prove left a point undecided; 130 interrupted, finished points are
kept. docs/atlas.md explains how each point is classified.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands import options
from heyoka_bike.commands.printing import print_table
from heyoka_bike.errors import Exit, InputError, did_you_mean, quoted, unknown_word
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.console import progress_bar

if TYPE_CHECKING:
    from heyoka_bike.workbench.atlas.data import Atlas, GridAxis
    from heyoka_bike.workbench.atlas.design import Design

_DEFAULTS = {"speed": "2.5:8.5:200", "roll_rate": "0.02:4:200"}


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = options.add_command(subparsers, run, __doc__)
    said = "N points from FROM to TO (default {})"
    where = {
        "--speed FROM:TO:N": f"initial speed [m/s], {said.format(_DEFAULTS['speed'])}",
        "--roll-rate FROM:TO:N": "initial roll rate [rad/s], "
        f"{said.format(_DEFAULTS['roll_rate'])}",
        "--axis NAME=FROM:TO:N...": "another axis of the grid, see names below; give it once (the "
        "other axis is the speed) or twice",
        "--start NAME=VALUE...": "initial value of a variable that is not an axis (default 0); may "
        "be repeated",
        **options.BICYCLE,
        "--longest SECONDS 200": "stop simulating after this time [s] if the behaviour is still "
        "undecided (default 200)",
        "-o --output FOLDER": "folder of the Zarr store to write",
        "--force": "replace a different atlas in that folder",
        "--prove X,Y...": "prove for the point with these values on the two axes when a wheel "
        "leaves the floor, or that none does within 10 s (each takes half a minute or more); may "
        "be repeated",
    }
    options.add_arguments(p, where, output={"required": True})
    options.add_workers(p)


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    from heyoka_bike.bicycle.parameters import read_bicycle
    from heyoka_bike.system.resources import find_input
    from heyoka_bike.workbench.atlas.design import design
    from heyoka_bike.workbench.atlas.make import make_atlas

    wanted = design(
        read_bicycle(find_input("bicycles", args.bicycle)), _axes(args), _start(args),
        _longest(args.longest),
    )  # fmt: skip
    points = [_point(word, wanted) for word in args.prove]
    with progress_bar("atlas") as progress:
        made = make_atlas(wanted, args.output, force=args.force, progress=progress)
    _summary(made)
    print(f"{args.output}: {made.shape[0]} x {made.shape[1]} points")
    return _prove(wanted, points)


def _point(word: str, wanted: Design) -> dict[str, Exact]:
    """Return the exact coordinates of a point of the grid, by the names of the axes."""
    texts = word.split(",")
    if len(texts) != len(wanted.axes):
        names = ",".join(a.name for a in wanted.axes)
        raise InputError(f"--prove: found {quoted(word)}, expected two numbers: {names}")
    return {a.name: Exact.read("--prove", x) for a, x in zip(wanted.axes, texts, strict=True)}


def _prove(wanted: Design, points: Sequence[Mapping[str, Exact]]) -> int:
    """Print for each point what is proved about wheel lift; return 3 if any is undecided."""
    from heyoka_bike.workbench.after_ten_seconds.facts import prove_lift
    from heyoka_bike.workbench.atlas.make import lift_of

    code = Exit.OK
    for point in points:
        bicycle, maneuver, time = lift_of(wanted, point)
        said = ", ".join(f"{name} {float(x):.12g}" for name, x in point.items())
        proved = prove_lift(bicycle, maneuver, time)
        if proved.lift is not None and proved.is_decided:
            print(f"{said}: {proved.lift.what} at {float(proved.lift.time):.9f} s: proved")
        elif proved.is_decided:
            print(f"{said}: both wheels press on the floor for {float(proved.end):g} s: proved")
        else:
            print(f"{said}: not decided within {float(proved.end):g} s")
            code = Exit.CHECK_FAILED
    return code


def _axes(args: argparse.Namespace) -> list[GridAxis]:
    from heyoka_bike.workbench.atlas.design import axis

    given = {name: text for name in _DEFAULTS if (text := getattr(args, name))}
    for word in args.axis:
        name, text = _pair(word, "--axis", "FROM:TO:N")
        if name in given:
            raise InputError(f"--axis: found {name} twice, expected it once")
        given[name] = text
    for name, text in _DEFAULTS.items():
        if len(given) < 2 and name not in given:
            given[name] = text
    # The basin boundary is searched for along the second axis, so put the speed first.
    names = sorted(given, key=lambda name: name != "speed")
    return [axis(given[name], name) for name in names]


def _start(args: argparse.Namespace) -> dict[str, float]:
    from heyoka_bike.bicycle.parameters import START

    found = {}
    for word in args.start:
        name, text = _pair(word, "--start", "VALUE")
        if name not in START:
            raise InputError(f"--start: {unknown_word(name, list(START))}")
        found[name] = float(Exact.read(f"--start {name}", text))
    return found


def _pair(word: str, option: str, what: str) -> tuple[str, str]:
    from heyoka_bike.bicycle.parameters import PARAMETERS, START

    name, sign, text = word.partition("=")
    if not sign:
        raise InputError(f"{option}: found {quoted(word)}, expected NAME={what}")
    if name not in START and name not in PARAMETERS:
        raise InputError(
            f"{option}: found {quoted(name)}, expected one of {', '.join(START)}, or the symbol of "
            f"a parameter{did_you_mean(name, [*START, *PARAMETERS])}"
        )
    return name, text


def _longest(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 20 <= seconds <= 10_000 or seconds % 5:
        raise InputError(
            f"--longest: found {quoted(text)}, expected a multiple of 5 s from 20 to 10000"
        )
    return seconds


def _summary(made: Atlas) -> None:
    import numpy as np

    from heyoka_bike.showing.document import TableColumn
    from heyoka_bike.workbench.atlas.data import FATES

    fates = made.variables["fate"]
    counts = np.bincount(fates.ravel().astype(int), minlength=len(FATES))
    rows = [
        (name, str(count), f"{100 * count / fates.size:.1f} %", about)
        for (name, about), count in zip(FATES.items(), counts, strict=True)
    ]
    print_table(("behaviour", "points", "part", TableColumn("meaning", is_prose=True)), rows)
    print(f"basin boundary: {len(made.edge.at)} places, to neighbouring binary64 numbers")
