"""The numbers, the tables and the figure of docs/atlas.md, from a store of the default atlas.

Run as a script, this makes the store if it is not there, writes them into the page, and, if that is
asked for, measures a smaller atlas with 1, 2 and 4 workers, on an idle machine::

    python docs/_site/atlas_page.py --store FOLDER [--workers]
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

from heyoka_bike.bicycle.parameters import read_bicycle
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.cli import main as command
from heyoka_bike.system.machine import machine
from heyoka_bike.system.parallel import processors
from heyoka_bike.system.resources import benchmark_bicycle
from heyoka_bike.workbench.atlas.data import CYCLE, FALLS, LIFTS, UPRIGHT, WEAVES
from heyoka_bike.workbench.atlas.design import axis, design
from heyoka_bike.workbench.atlas.make import bisect_boundary
from heyoka_bike.workbench.atlas.store import load_atlas
from speed_page import filled
from timed import content, timed

PAGE = Path(__file__).parent.parent / "atlas.md"
FIGURE = PAGE.parent / "atlas.svg"
SPEEDS = (4.4, 4.6, 5.0, 5.3, 5.4, 5.6, 5.8, 5.9, 6.0)
HEAD = (
    "| initial speed [m/s] | largest roll rate of the grid that recovers [rad/s] | with both "
    "wheels pressed to the floor | basin boundary above it |",
    "| ---: | ---: | ---: | ---: |",
)
ANCHOR = 4.6  # [m/s], of which the edge is known in binary128
SMALL = ["--speed", "4:8.5:120", "--roll-rate", "0.02:4:120"]


def found_in(atlas):
    """By name, the texts of the page that follow from a store."""
    speeds, rates = (a.values for a in atlas.axes)
    fate, lean = atlas.variables["fate"], atlas.variables["largest_lean"]
    stays = np.isin(fate, (UPRIGHT, LIFTS))
    rows = []
    for v in SPEEDS:
        i = int(np.argmin(np.abs(speeds - v)))
        above = atlas.edge.falls[atlas.edge.at == speeds[i]]
        most = rates[stays[i]].max()
        near = above[above > most]
        rows.append(
            f"| {speeds[i]:.4f} | {most:.2f} | {rates[fate[i] == UPRIGHT].max():.2f} | "
            f"{f'{near.min():.4f}' if len(near) and near.min() < most + 0.05 else ''} |"
        )
    weave, capsize = critical()
    inside = (speeds > weave) & (speeds < capsize)
    part = fate[inside]
    at_two = int(np.argmin(np.abs(rates - 2.0)))
    turns = np.isin(fate, (CYCLE, WEAVES))
    recovers = inside[:, None] & stays
    both = inside[:, None] & (fate == UPRIGHT)
    return {
        "recovers": "\n".join([*HEAD, *rows]),
        "energy": f"At {rates[at_two]:.2g} rad/s the bicycle converges to steady straight running "
        f"from {speeds[stays[:, at_two]].min():.2f} m/s, although "
        "straight running at this speed is unstable according to the linear equations.",
        "inside": f"Inside the linearly stable range {100 * np.mean(part == FALLS):.0f} % of the "
        f"initial conditions in the map lead to a fall. No motion recovers from more than "
        f"{rates[recovers.any(axis=0)].max():.2f} rad/s, or from a lean of more than "
        f"{lean[recovers].max():.3f} rad ({np.degrees(lean[recovers].max()):.0f}°). If "
        f"both wheels have to press on the floor, the limit is {lean[both].max():.3f} rad.",
        "weaves": f"Weaves begin at {speeds[turns.any(axis=1)].min():.2f} m/s. Irregular weaves "
        f"are {100 * np.mean(fate == WEAVES):.1f} % of the map.",
    }


def critical():
    """Weave and capsize speed [m/s]."""
    linear = linearise(read_bicycle(benchmark_bicycle()), 10)
    ((weave, _),), (capsize,) = linear.weave_speeds, linear.capsize_speeds
    return float(weave), float(capsize)


def edge_at_anchor():
    """The basin boundary at 4.6 m/s, in neighbouring binary64 numbers."""
    wanted = design(
        read_bicycle(benchmark_bicycle()),
        [axis(f"{ANCHOR}:{ANCHOR + 1}:2", "speed"), axis("2:3:2", "roll_rate")], {}, 200.0,
    )  # fmt: skip
    _, stays, falls = bisect_boundary(wanted, np.array([ANCHOR]), np.array([2.4]), np.array([2.5]))
    return f"At {ANCHOR} m/s they are {stays[0]!s} and {falls[0]!s} rad/s."


def workers():
    """Times of a smaller atlas with more and more processes; the stores have the same bytes."""
    found, contents = [], []
    with tempfile.TemporaryDirectory() as place:
        for n in (1, 2, 4):
            folder = Path(place, f"{n}.zarr")
            words = [sys.executable, "-m", "heyoka_bike", "atlas", *SMALL, "-o", str(folder)]
            found.append(timed([*words, "--workers", str(n)]))
            contents.append(content(folder))
    assert contents[0] == contents[1] == contents[2]
    here = machine()
    cores = f"{here['cpu']}, {here['cores']} processors"
    return "\n".join([
        f"| 120 × 120 points (`{' '.join(SMALL)}`), {cores} | 1 worker | 2 | 4 |",
        "| --- | ---: | ---: | ---: |",
        "| elapsed [s] | " + " | ".join(f"{wall:.0f}" for wall, _ in found) + " |",
        "| processor time [s] | " + " | ".join(f"{cpu:.0f}" for _, cpu in found) + " |",
    ])  # fmt: skip


def main():
    p = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    p.add_argument("--store", required=True, help="folder of the default atlas")
    p.add_argument("--workers", action="store_true", help="measure too")
    asked = p.parse_args()
    is_there = Path(asked.store).exists()
    wall, cpu = timed([sys.executable, "-m", "heyoka_bike", "atlas", "-o", asked.store])
    assert command(["plot", "--figure", "atlas", asked.store, "-o", str(FIGURE)]) == 0
    texts = found_in(load_atlas(asked.store)) | {"anchor": edge_at_anchor()}
    if not is_there:
        texts["default"] = (
            f"The default atlas took {wall:.0f} s, {cpu:.0f} s of processor time, with "
            f"{processors()} processors."
        )
    if asked.workers:
        texts["workers"] = workers()
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8"), texts), encoding="utf-8")
    print("\n\n".join(texts.values()))


if __name__ == "__main__":
    main()
