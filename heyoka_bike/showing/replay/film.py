"""The replay of one maneuver as a film for slides: GIF through Pillow, MP4 through ffmpeg.

A view from the side and one from behind, both in perspective and moving along, above roll and steer
over time. Drawn with matplotlib: nearer solids over farther ones.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from heyoka_bike.errors import MissingPackageError
from heyoka_bike.numbers.double import Array
from heyoka_bike.showing.figures.shapes import Shape, hull, shape
from heyoka_bike.showing.figures.style import style
from heyoka_bike.showing.replay.motion_3d import Motion3D
from heyoka_bike.showing.replay.scenes import Replay, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RATES = {"gif": 20, "mp4": 25}
"""Frames in a second; a GIF counts hundredths of a second."""

_SIZE, _DPI = (8.0, 5.2), 100  # [inch]
_GIF_COLOURS = 96
_COLOURS = {
    "frame": "#d55e00", "metal": "#8d969f", "dark": "#3a4048", "skin": "#d9a982",
    "shirt": "#e69f00", "shorts": "#4a5663", "helmet": "#e9ebee", "tyre": "#24282d",
}  # fmt: skip
_RESULT, _RESULT_FILL = "#0072b2", "#7fb8d8"
_GROUND, _SHADOW = "#f7f7f4", "#d9d9d6"
_RIM_PARTS, _SPOKES = 32, 12
_TYRE = 0.016  # [m]
_CIRCLE = np.array([(np.cos(a), np.sin(a)) for a in np.linspace(0, 2 * np.pi, 13)[:-1]])
# Direction of the light, down.
_SUN = np.array([0.25, 0.45, 1.0])
_GRID = 9  # [m] to either side
# Points nearer to the eye than this are not drawn [m].
_NEAR = 0.2


@dataclass(frozen=True, slots=True)
class _Camera:
    """Where a view is from: turned from the heading and lifted [rad], so far away [m]."""

    turn: float
    lift: float
    far: float
    opening: float


_VIEWS = (_Camera(2.05, 0.16, 4.2, 0.50), _Camera(np.pi, 0.10, 4.2, 0.50))


def render(
    replay: Replay, file_format: str, name: str = "",
    progress: Callable[[float], None] | None = None,
) -> bytes:  # fmt: skip
    """The first maneuver of a replay as a film.

    Parameters
    ----------
    replay : Replay
        Its frames are those of the film: made at one of `RATES`.
    file_format
        ``gif`` or ``mp4``.
    name
        Of the result file.
    progress
        Is told how much is done, 0 to 1.

    Raises
    ------
    MissingPackageError
        matplotlib is not installed, or ffmpeg for MP4.
    """
    with style():
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        scene = next(s for s in replay.scenes if s.result is not None or not name)
        time = scene.reference.motion.time
        figure = Figure(figsize=_SIZE, dpi=_DPI, facecolor="white")
        canvas = FigureCanvasAgg(figure)
        film = _Film(figure, scene, shape(replay.bicycle), name)

        def drawn() -> Iterator[Any]:
            for i in range(len(time)):
                film.draw(i)
                yield canvas
                if progress is not None:
                    progress((i + 1) / len(time))

        rate = float((len(time) - 1) / time[-1])
        return _gif(drawn(), rate) if file_format == "gif" else _mp4(figure, drawn(), rate)


def _gif(frames: Iterable[Any], rate: float) -> bytes:
    from PIL import Image

    images: list[Any] = []
    for canvas in frames:
        canvas.draw()
        image = Image.fromarray(np.array(canvas.buffer_rgba())[..., :3])
        # One palette without dithering: what stands still is not written again.
        image = image.quantize(palette=images[0] if images else image.quantize(_GIF_COLOURS),
                               dither=Image.Dither.NONE)  # fmt: skip
        images.append(image)
    file = io.BytesIO()
    images[0].save(
        file, "GIF", save_all=True, append_images=images[1:], duration=1000 / rate, loop=0
    )
    return file.getvalue()


def _mp4(figure: Figure, frames: Iterable[Any], rate: float) -> bytes:
    from matplotlib.animation import FFMpegWriter

    if not FFMpegWriter.isAvailable():
        raise MissingPackageError(
            "ffmpeg is not installed; MP4 needs it (a name ending in .gif does not)"
        )
    # Its type says that rates are whole; ffmpeg takes others.
    made: Any = FFMpegWriter
    writer = made(fps=rate)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        with writer.saving(figure, str(path), _DPI):
            for _ in frames:
                writer.grab_frame()
        return path.read_bytes()


class _Film:
    """A figure that is drawn anew for each frame."""

    def __init__(self, figure: Figure, scene: Scene, drawn: Shape, name: str) -> None:
        self._scene, self._shape = scene, drawn
        self._motions = [(scene.reference.motion, 0, False)]
        if scene.result is not None:
            self._motions.append((scene.result.motion, scene.result.first, True))
        grid = figure.add_gridspec(
            2, 2, height_ratios=(3.3, 1), width_ratios=(1.9, 1), left=0.08, right=0.985, top=0.93,
            bottom=0.09, wspace=0.04, hspace=0.10,
        )  # fmt: skip
        self._views = [figure.add_subplot(grid[0, i]) for i in range(2)]
        chart = figure.add_subplot(grid[1, :])
        self._cursor = _draw_chart(chart, scene)
        title = f"Uncontrolled bicycle, {scene.name}"
        figure.text(0.08, 0.955, title, fontsize=11, fontweight="bold", parse_math=False)
        self._clock = figure.text(0.985, 0.955, "", fontsize=11, ha="right")
        if scene.result is not None:
            shown = Path(name).name
            figure.text(
                0.5, 0.955, f"reference, {shown} (blue)", fontsize=9, color=_RESULT,
                parse_math=False,
            )  # fmt: skip

    def draw(self, frame: int) -> None:
        """Draw one frame."""
        time = float(self._scene.reference.motion.time[frame])
        self._clock.set_text(f"{time:.2f} s")
        self._cursor.set_xdata([time, time])
        for ax, camera in zip(self._views, _VIEWS, strict=True):
            self._draw_view(ax, camera, frame)

    def _draw_view(self, ax: Axes, camera: _Camera, frame: int) -> None:
        from matplotlib.collections import LineCollection, PolyCollection

        box = ax.get_window_extent()
        ax.clear()
        ax.set(xticks=[], yticks=[], facecolor="#e9eef3")
        ax.grid(visible=False)
        ax.spines[:].set_visible(True)
        high = np.tan(camera.opening / 2)
        wide = high * box.width / box.height
        ax.set(xlim=(-wide, wide), ylim=(-high, high))
        motion = self._scene.reference.motion
        see = _Eye(motion, frame, camera)
        ax.axhspan(-1, see.horizon, color=_GROUND, zorder=0)
        lines, alphas = _grid_lines(see)
        ax.add_collection(LineCollection(lines, colors="#9aa3ab", alpha=alphas, linewidths=0.7))
        for shown, first, is_result in self._motions:
            for track in (shown.rear_contact, shown.front_contact):
                path = see.line(track[: max(frame - first + 1, 0)])
                colour, dashes = (_RESULT, "--") if is_result else (_COLOURS["frame"], "-")
                ax.plot(*path.T, color=colour, linestyle=dashes, linewidth=1.0, zorder=2)
        for shown, first, is_result in self._motions:
            i = frame - first
            if not 0 <= i < len(shown.time):
                continue
            solids = _solids(self._shape, shown, i)
            if not is_result:
                shadow = PolyCollection(_shadow(see, solids), facecolors=_SHADOW, zorder=1.5)
                ax.add_collection(shadow)
            spokes = see.segments(_spokes(self._shape, shown, i))
            colour = _RESULT if is_result else _COLOURS["metal"]
            ax.add_collection(LineCollection(spokes, colors=colour, linewidths=0.5, zorder=3))
            corners, colours = _painted(see, solids)
            # The result lies below, in one colour, the reference over it.
            look: Any = (
                {"facecolors": _RESULT_FILL, "edgecolors": _RESULT, "zorder": 3.5}
                if is_result
                else {"facecolors": colours, "edgecolors": "#00000040", "zorder": 4}
            )
            ax.add_collection(PolyCollection(corners, linewidths=0.3, **look))


def _draw_chart(ax: Axes, scene: Scene) -> Any:
    """Roll and steer over time; the cursor is returned."""
    pairs = (("roll_angle", "roll", "#000000"), ("steer_angle", "steer", _COLOURS["frame"]))
    for name, said, colour in pairs:
        shown = scene.reference
        ax.plot(shown.motion.time, shown.columns[name], color=colour, label=said)
        result = scene.result
        if result is not None and name in result.columns:
            ax.plot(result.motion.time, result.columns[name], color=_RESULT, linestyle="--")
    time = scene.reference.motion.time
    ax.set(xlim=(time[0], time[-1]), ylabel="[rad]")
    ax.set_xlabel("time [s]", labelpad=0)
    # Above the axes: inside, it would lie on the curves of one maneuver or another.
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 0.95), ncols=2, frameon=False, borderpad=0.1)
    return ax.axvline(0.0, color="#16191d", linewidth=1.0)


class _Eye:
    """Perspective of a view at one frame: places on the screen in tangents of angles."""

    def __init__(self, motion: Motion3D, frame: int, camera: _Camera) -> None:
        self.middle = (motion.rear_contact[frame] + motion.front_contact[frame]) / 2
        self.middle = self.middle - np.array([0.0, 0.0, 0.82])
        angle = float(motion.yaw[frame]) + camera.turn
        s, c = np.sin(angle), np.cos(angle)
        flat = np.cos(camera.lift)
        away = np.array([flat * c, flat * s, -np.sin(camera.lift)])
        self._eye = self.middle + camera.far * away
        right = np.array([s, -c, 0.0])
        self._axes = np.stack([right, np.cross(right, -away), -away])
        self.horizon = float(np.tan(camera.lift))

    def viewed(self, points: Array) -> Array:
        """Right, up and depth of points of shape (..., 3)."""
        found: Array = (points - self._eye) @ self._axes.T
        return found

    def line(self, points: Array) -> Array:
        """A line on the screen, of what is ahead of the eye."""
        v = self.viewed(points)
        v = v[v[:, 2] > _NEAR]
        return v[:, :2] / v[:, 2:]

    def segments(self, ends: Array) -> list[Array]:
        """Segments of shape (n, 2, 3) on the screen."""
        v = self.viewed(ends)
        v = v[(v[:, :, 2] > _NEAR).all(axis=1)]
        return list(v[:, :, :2] / v[:, :, 2:])


_Spheres = tuple[Array, Array, str]
"""Centres, radii and colour of a solid, in the ground frame."""


def _solids(drawn: Shape, motion: Motion3D, i: int) -> list[_Spheres]:
    hubs = {"rear": np.array(drawn.points["P1"]), "front": np.array(drawn.points["P3"])}
    found = []
    for solid in drawn.solids:
        spheres = np.array(solid.spheres)
        centres = _placed(motion, i, solid.body, spheres[:, :3] - hubs[solid.body])
        found.append((centres, spheres[:, 3], solid.colour))
    for body, radius in zip(hubs, drawn.radii, strict=True):
        angles = np.linspace(0, 2 * np.pi, _RIM_PARTS + 1)
        rim = _placed(motion, i, body, (radius - _TYRE) * _around(angles))
        found += [(rim[j : j + 2], np.full(2, _TYRE), "tyre") for j in range(_RIM_PARTS)]
    return found


def _spokes(drawn: Shape, motion: Motion3D, i: int) -> Array:
    """Segments from the hubs to the rims, shape (n, 2, 3)."""
    found = []
    turned = {"rear": motion.rear_wheel[i], "front": motion.front_wheel[i]}
    for (body, angle), radius in zip(turned.items(), drawn.radii, strict=True):
        ends = radius * _around(angle + 2 * np.pi / _SPOKES * np.arange(_SPOKES))
        found.append(_placed(motion, i, body, np.stack([0 * ends, ends], axis=1)))
    return np.concatenate(found)


def _around(angles: Array) -> Array:
    """Points of the unit circle in the plane of a wheel, turned about y."""
    return np.stack([np.cos(angles), 0 * angles, -np.sin(angles)], axis=-1)


def _placed(motion: Motion3D, i: int, body: str, from_hub: Array) -> Array:
    """Points of a body, given from its hub, in the ground frame."""
    attitude = motion.rear_frame[i] if body == "rear" else motion.front_frame[i]
    hub = motion.rear_hub[i] if body == "rear" else motion.front_hub[i]
    found: Array = hub + from_hub @ attitude.T
    return found


def _painted(see: _Eye, solids: Sequence[_Spheres]) -> tuple[list[Array], list[str]]:
    """Outlines of the solids and their colours, the farthest first."""
    items = []
    for centres, radii, colour in solids:
        v = see.viewed(centres)
        if (v[:, 2] - radii).min() < _NEAR:
            continue
        sizes = radii / v[:, 2]
        corners = v[:, None, :2] / v[:, None, 2:] + sizes[:, None, None] * _CIRCLE
        items.append((float(v[:, 2].mean()), hull(corners.reshape(-1, 2)), _COLOURS[colour]))
    items.sort(key=lambda item: -item[0])
    return [corners for _, corners, _ in items], [colour for *_, colour in items]


def _shadow(see: _Eye, solids: Sequence[_Spheres]) -> list[Array]:
    found = []
    rims = np.column_stack((_CIRCLE, np.zeros(len(_CIRCLE))))
    for centres, radii, _ in solids:
        dropped = centres - centres[:, 2:] / _SUN[2] * _SUN
        v = see.viewed(dropped[:, None] + radii[:, None, None] * rims).reshape(-1, 3)
        if v[:, 2].min() > _NEAR:
            found.append(hull(v[:, :2] / v[:, 2:]))
    return found


def _grid_lines(see: _Eye) -> tuple[list[Array], Array]:
    """Lines of the ground, 1 m apart, and how much of them is to be seen."""
    x0, y0, _ = np.rint(see.middle)
    lanes = np.arange(-_GRID, _GRID + 1.0)
    a, b = (part.ravel() for part in np.meshgrid(lanes, lanes[:-1]))
    along = np.stack([np.stack([x0 + a, y0 + b], 1), np.stack([x0 + a, y0 + b + 1], 1)], 1)
    across = np.stack([np.stack([x0 + b, y0 + a], 1), np.stack([x0 + b + 1, y0 + a], 1)], 1)
    ends = np.concatenate([along, across])
    ends = np.concatenate([ends, np.zeros((*ends.shape[:2], 1))], axis=2)
    ahead = (see.viewed(ends)[:, :, 2] > _NEAR).all(axis=1)
    away = np.linalg.norm(ends.mean(axis=1)[:, :2] - see.middle[:2], axis=1)
    return see.segments(ends), np.clip(1 - away / _GRID, 0, 1)[ahead]
