"""Scenes of a replay: the motion of each maneuver, next to that of a result file.

A result file has no pitch, no yaw and no position. The model derives them from the state in the
file: the pitch from roll and steer, with both wheels on the floor; the yaw rate from rolling
without slip; the position from the forward speed along the heading; the wheel angles from the
lengths of their tracks. All of them start at the values of the reference. The file's state between
its rows is the reference plus their difference, interpolated linearly, so that a file of few digits
or rows adds no error of its own.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.kinematics import front_contact_height
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import NothingScoredError
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.scoring.reading.results import Results
from heyoka_bike.scoring.report import Report
from heyoka_bike.scoring.score import score
from heyoka_bike.scoring.scores import ManeuverScore
from heyoka_bike.showing.wording.column_text import label
from heyoka_bike.workbench.replay.motion_3d import (
    STATE,
    Motion3D,
    Place,
    State,
    motion_3d,
    reference_state,
)

RATE = 50
"""Frames per second, reduced for runs so long that there would be too many frames."""

WRITTEN_STATES = tuple(name for name in STATE if name in BENCHMARK_COLUMNS)
"""Columns of a result file that determine its motion."""

DERIVED = (
    "Derived: the pitch from roll and steer with both wheels on the floor; the yaw from the yaw "
    "rate of rolling without slip; the position from the forward speed along the heading; the "
    "wheel angles from rolling."
)
CONVERTED_NOTE = (
    "(another definition is converted to the default one by its difference from the reference)"
)
"""Text of notes, here and on the page of the checker."""

# Maximum number of frames of all maneuvers together. A page with this many frames has 3 MB.
_MOST_FRAMES = 6000
LEAST_FRAMES = 50
# A bicycle is shown only until its roll or steer angle reaches this magnitude [rad]. Beyond it the
# bicycle lies on the floor, and tan(roll) has no meaning.
FALLEN = 1.4
# Largest gap between the front wheel and the floor that counts as contact, after Newton's iteration
# for the pitch. A larger gap shows that no pitch puts the wheel on the floor.
SMALLEST_GAP = 1e-9  # [m]
# Distance from the reference beyond which a result cannot be seen [m].
OUT_OF_SIGHT = 1000.0


@dataclass(frozen=True, eq=False, slots=True)
class Shown:
    """A motion and the benchmark's columns at the times of the frames.

    Attributes
    ----------
    motion : Motion3D
    columns : mapping of str to ndarray, shape (n,)
        Columns by name of `columns.BENCHMARK_COLUMNS`, in default definitions; for a result only
        those in its file.
    """

    motion: Motion3D
    columns: Mapping[str, Array]


@dataclass(frozen=True, eq=False, slots=True)
class ShownResult(Shown):
    """The motion of a result file, at the frames from `first` on.

    Attributes
    ----------
    first
        Index of the first frame among those of the reference.
    resolution : mapping of str to float
        Largest rounding error of each column at the digits written [SI], see `ColumnScore`.
    notes : tuple of str
        Sentences on the sources of the quantities, and on where the result ends.
    """

    first: int
    resolution: Mapping[str, float]
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """A maneuver of the replay, with the result next to the reference.

    Attributes
    ----------
    number, name
    reference : Shown
    result : ShownResult, optional
    notes : tuple of str
        Reasons why there is no result, if a file was given.
    """

    number: int
    name: str
    reference: Shown
    result: ShownResult | None = None
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Replay:
    """All scenes of a replay.

    Attributes
    ----------
    bicycle : Bicycle
    dataset_version
        Version of the reference.
    scenes : tuple of Scene
    report : Report, optional
        Scores of the result file, if one was given.
    """

    bicycle: Bicycle
    dataset_version: str
    scenes: tuple[Scene, ...]
    report: Report | None = None


def replay(
    reference: Reference,
    results: Results | Sequence[Results] | None = None,
    maneuver: int | None = None,
    rate: float = RATE,
) -> Replay:
    """Return the replay of the maneuvers of a reference, and of a result file if given.

    Parameters
    ----------
    reference : Reference
    results : Results or sequence of Results, optional
    maneuver
        Number of the only maneuver to show; by default all.
    rate
        Frames per second.

    Raises
    ------
    NothingScoredError
        The file has no column of the motion, or does not contain this maneuver.
    """
    bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
    equations = Equations.binary64(bicycle)
    numbers = list(reference) if maneuver is None else [maneuver]
    total = sum(float(reference[n].duration) for n in numbers)
    rate = min(rate, _MOST_FRAMES / total)
    scenes = [_scene(n, reference[n], equations, rate) for n in numbers]
    if results is None:
        return Replay(bicycle, reference.dataset_version, tuple(scenes))
    scored = score(results, reference)
    scenes = [_beside(scene, scored, equations) for scene in scenes]
    if all(scene.result is None for scene in scenes):
        said = dict.fromkeys(note for scene in scenes for note in scene.notes)
        raise NothingScoredError(f"{scored.file.path}: nothing can be shown: {' '.join(said)}")
    return Replay(bicycle, reference.dataset_version, tuple(scenes), scored)


def _scene(number: int, maneuver: ReferenceManeuver, equations: Equations, rate: float) -> Scene:
    end = float(maneuver.duration)
    steps = max(round(end * rate), LEAST_FRAMES)
    time = np.linspace(0.0, end, steps + 1)
    motion = motion_3d(equations, reference_state(maneuver), time)
    shown = Shown(motion, maneuver.approximate(time, BENCHMARK_COLUMNS))
    return Scene(number, maneuver.name, shown)


def _beside(scene: Scene, scored: Report, equations: Equations) -> Scene:
    """Add the motion of the result to a scene, or a note why it cannot be shown."""
    held = [m for m in scored.maneuvers if m.maneuver == scene.number]
    if not held:
        return replace(scene, notes=(f"The file does not contain maneuver {scene.number}.",))
    said = _result(scene, held[0], equations)
    return replace(scene, notes=(said,)) if isinstance(said, str) else replace(scene, result=said)


def _result(scene: Scene, found: ManeuverScore, equations: Equations) -> ShownResult | str:
    """Return the motion of the result, or the reason why it cannot be shown."""
    part = found.part
    columns = {c.key: c for c in found.compared}
    moving = [name for name in WRITTEN_STATES if name in columns]
    if not moving:
        return (
            f"The file has no usable column of the motion in maneuver {scene.number} "
            f"(found none of {', '.join(map(label, WRITTEN_STATES))})."
        )
    finite = np.all([np.isfinite(part.values[name]) for name in moving], axis=0)
    bad = np.flatnonzero(~finite)
    rows = slice(0, bad[0] if len(bad) else None)
    rows_time = part.time[rows]
    time = scene.reference.motion.time
    if not len(rows_time):
        return f"The first row of maneuver {scene.number} in the file has no usable number."
    # The last frame may be later than the last row by a rounding error.
    inside = np.flatnonzero((time >= rows_time[0]) & (time <= rows_time[-1] * (1 + 1e-12)))
    if len(inside) < 2:
        return f"The rows of maneuver {scene.number} in the file span less than two frames."
    differences = {
        name: (c.trace.time, c.trace.error) for name, c in columns.items() if len(c.trace.time)
    }
    state = _result_state(part.reference, equations, {name: differences[name] for name in moving})
    first, last = int(inside[0]), int(inside[-1])
    upright = _upright(equations, state(time[first : last + 1]))
    shown = time[first : last + 1][:upright]
    if len(shown) < 2:
        return f"The bicycle of maneuver {scene.number} in the file does not stand on its wheels."
    reference = scene.reference.motion
    x, y, _ = reference.rear_contact[first]
    start = Place(float(x), float(y), float(reference.yaw[first]))
    motion, near = _in_sight(motion_3d(equations, state, shown, start), reference, first)
    shown = shown[:near]
    exact = part.reference.approximate(shown, list(differences))
    values = {name: exact[name] + np.interp(shown, *differences[name]) for name in differences}
    if near < upright:
        end = f"The result is not shown after {shown[-1]:.2f} s: its bicycle has left the scene."
    elif upright < last + 1 - first:
        end = f"The result is not shown after {shown[-1]:.2f} s: its bicycle has fallen."
    elif last == len(time) - 1:
        end = ""
    elif len(bad):
        end = f"The result is not shown after {shown[-1]:.2f} s: the next row has no usable number."
    else:
        end = f"The rows of the file end at {rows_time[-1]:.4g} s."
    notes = _notes(found, moving, columns, float(shown[0]), end)
    resolution = {name: columns[name].resolution for name in moving}
    return ShownResult(motion, values, first, resolution, notes)


def _result_state(
    maneuver: ReferenceManeuver,
    equations: Equations,
    differences: Mapping[str, tuple[Array, Array]],
) -> State:
    """Return the state of a result over time: that of the reference plus the differences.

    The pitch is that for which both wheels are on the floor.
    """

    def state(t: Array) -> Mapping[str, Array]:
        found = dict(maneuver.approximate(t, STATE))
        for name, (rows_time, error) in differences.items():
            found[name] = found[name] + np.interp(t, rows_time, error)
        # The pitch of a fallen bicycle has no meaning, so suppress warnings about its computation.
        # `_upright` detects the fall.
        with np.errstate(all="ignore"):
            found["pitch"] = pitch_on_the_floor(
                equations.k, found["roll_angle"], found["pitch"], found["steer_angle"]
            )
        return found

    return state


def _upright(equations: Equations, state: Mapping[str, Array]) -> int:
    """Return the number of frames before the bicycle falls: both wheels can touch the floor."""
    roll = state["roll_angle"]
    with np.errstate(all="ignore"):
        gap = front_contact_height(
            equations.k, Arrays(), roll, state["pitch"], state["steer_angle"]
        )
        stands = (np.abs(gap) < SMALLEST_GAP) & (np.abs(roll) < FALLEN)
        stands &= np.abs(state["steer_angle"]) < FALLEN
    return _leading(stands)


def _in_sight(found: Motion3D, reference: Motion3D, first: int) -> tuple[Motion3D, int]:
    """Cut a motion where it moves too far from the reference; return it and its frame count."""
    beside = reference.rear_contact[first : first + len(found.time)]
    with np.errstate(all="ignore"):
        away = np.linalg.norm(found.rear_contact - beside, axis=1)
        count = _leading(away < OUT_OF_SIGHT)
    cut = {name: getattr(found, name)[:count] for name in Motion3D.__slots__}
    return Motion3D(**cut), count


def _leading(good: NDArray[np.bool_]) -> int:
    """Return the number of entries before the first one that is false."""
    bad = np.flatnonzero(~good)
    return int(bad[0]) if len(bad) else len(good)


def _notes(
    found: ManeuverScore, moving: Sequence[str], columns: Mapping[str, object], start: float,
    end: str,
) -> tuple[str, ...]:  # fmt: skip
    said = [f"From the file: {_listed([label(name) for name in moving])}{_understood(found)}."]
    missing = [name for name in WRITTEN_STATES if name not in moving]
    if missing:
        said.append(
            f"The file has no usable {_listed([label(name) for name in missing])}: "
            "the values of the reference are used instead."
        )
    if start > 0:
        said.append(
            f"The rows of the file begin at {start:.4g} s; the motion starts there at the position "
            "of the reference."
        )
    said.append(DERIVED)
    return (*said, end) if end else tuple(said)


def _understood(found: ManeuverScore) -> str:
    """Return a note on columns that are converted before they are shown."""
    taken = []
    for c in found.columns:
        u, w = c.as_understood, c.as_written
        how = [u.definition] if u.definition != w.definition else []
        how += ["with the opposite sign"] if u.sign < 0 else []
        how += [f"in {u.unit}"] if u.unit != w.unit else []
        if c.key in WRITTEN_STATES and u != w:
            taken.append(f"{label(c.key)} taken as {', '.join(how)}")
    if not taken:
        return ""
    return f"; {'; '.join(taken)} {CONVERTED_NOTE}"


def _listed(items: Sequence[str]) -> str:
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)
