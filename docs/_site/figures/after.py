"""Maneuvers after their ten seconds: a limit cycle, steady straight running, and a fall.

The motions are computed in binary64 when the figure is drawn, which takes heyoka and a few seconds.
Rates and final values are those of the runs themselves, except that of maneuver 2, which the linear
equations give.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import exp, log
from typing import TYPE_CHECKING, Any

import flint
import numpy as np

from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.motion.events import GREATEST_LEAN, REAR_LIFT, events, follow
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.double import Array
from heyoka_bike.reference.load import Reference
from heyoka_bike.workbench.style import BLACK, BLUE, SKY, VERMILLION, WIDTH, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WEAVES = Fraction(200)
"""How long maneuver 1 is followed [s]: since 110 s it is on the cycle, but for roundoff."""

STRAIGHTENS = Fraction(90)
"""How long maneuver 2 is followed [s]: its leans are then below `ROUNDOFF`."""

FALLS_FROM = 40.0
"""Since when the fall is shown [s]."""

ROUNDOFF = 2.0**-53
"""Of a number near 1 in binary64; what is smaller is not shown."""

ASYMPTOTIC = (1e-11, 1e-6)
"""Distances [rad] that fall off like the slowest mode alone: of the smallest, roundoff is less than
a part in a thousand, and so are the other modes of the largest."""

# Of the cycle's leans, the last ones: the slowest mode is below roundoff since 50 leans before.
_LAST = 40
_NOISE = 5e-14  # above the roundoff of those, for a note on it [rad]
_PERIODS = 2  # of the cycle that are drawn
_PER_SECOND = 200  # points of a portrait: it turns by less than a degree in between
_PER_PIECE = 24  # points of a Taylor step, as many as `events` interpolates with
_DIGITS = 15
_GUARD_BITS = 64

_LAYOUTS: Mapping[tuple[int, ...], tuple[Any, tuple[float, ...]]] = {
    (1,): ([["portrait", "cycle"]], (2.8,)),
    (2,): ([["straight"]], (2.8,)),
    (3,): ([["roll"], ["forces"]], (1.2, 1.6)),
    (1, 2, 3): (
        [["portrait", "cycle"], ["straight", "roll"], ["straight", "forces"]],
        (2.8, 1.2, 1.6),
    ),
}
"""Panels of the maneuvers shown, and heights of their rows [inch]."""

_NOTE: Mapping[str, Any] = {"fontsize": 7.5, "linespacing": 1.25}
_BESIDE: Mapping[str, Any] = {"textcoords": "offset points", **_NOTE}
_POINT: Mapping[str, Any] = {
    "marker": "o", "markersize": 4.5, "markerfacecolor": "white", "markeredgecolor": BLACK,
    "linestyle": "none", "zorder": 3,
}  # fmt: skip


@dataclass(frozen=True, eq=False, slots=True)
class Decay:
    """Distances from what a motion settles on, at its greatest leans, beside an exponential.

    Attributes
    ----------
    time, distance : ndarray, shape (n,)
        [s], [rad]
    rate : float
        Of the exponential [1/s], negative.
    level : float
        Logarithm of the exponential [rad] at time 0.
    """

    time: Array
    distance: Array
    rate: float
    level: float

    @property
    def end(self) -> float:
        """When the exponential falls below `ROUNDOFF` [s]."""
        return (log(ROUNDOFF) - self.level) / self.rate

    def draw(self, ax: Axes, note: str) -> None:
        """Points on a straight line, over time."""
        ends = np.array([0.0, self.end])
        ax.plot(self.time, self.distance, linestyle="none", marker="o", markersize=2.8, color=SKY)
        ax.plot(ends, np.exp(self.level + self.rate * ends), color=BLACK, linewidth=0.7)
        ax.set_yscale("log", nonpositive="mask")
        ax.set(xlim=(0.0, self.end), ylim=(ROUNDOFF, 1.0), xlabel="time [s]")
        ax.text(0.97, 0.95, note, transform=ax.transAxes, ha="right", va="top", **_NOTE)


@dataclass(frozen=True, eq=False, slots=True)
class Weave:
    """Maneuver 1, which settles on a cycle.

    Attributes
    ----------
    maneuver : Maneuver
    beginning, cycle : ndarray, shape (2, n)
        Roll and steer angle [rad] of its own duration, and of the last periods of the run.
    period : float
        Of the cycle [s].
    decay : Decay
        Of the greatest leans' distance from their final value.
    """

    maneuver: Maneuver
    beginning: Array
    cycle: Array
    period: float
    decay: Decay

    @classmethod
    def of(cls, bicycle: Bicycle, maneuver: Maneuver) -> Weave:
        """The run, and what its last leans say of the cycle; there is one each half period."""
        run = integrate(bicycle, replace(maneuver, duration=WEAVES))
        time, lean = _leans(run)
        period = 2 * float(time[-1] - time[-1 - _LAST]) / _LAST
        distance = np.abs(lean - lean[-_LAST:].mean())
        is_slowest = _is_asymptotic(distance)
        rate, level = np.polyfit(time[is_slowest], np.log(distance[is_slowest]), 1)
        end = float(WEAVES)
        return cls(
            maneuver=maneuver,
            beginning=_portrait(run, 0.0, float(maneuver.duration)),
            cycle=_portrait(run, end - _PERIODS * period, end),
            period=period,
            decay=Decay(time, distance, float(rate), float(level)),
        )

    def draw(self, axes: Mapping[str, Axes]) -> None:
        name, ax = self.maneuver.name, axes["portrait"]
        _title(ax, f"{name} settles on a cycle")
        ax.plot(*self.beginning, color=SKY, linewidth=0.7)
        ax.plot(*self.cycle, color=BLUE, linewidth=1.8)
        ax.set(xlabel="roll angle [rad]", ylabel="steer angle [rad]")
        # Where steer leads roll most, and, of the first loops, least: above and below the others.
        roll, steer = self.cycle
        _point_out(ax, "the cycle", self.cycle[:, (steer - roll).argmax()], (0.06, 0.87))
        inner = self.beginning[:, : self.beginning.shape[1] // 2]
        first = f"the first {float(self.maneuver.duration):g} s"
        _point_out(ax, first, inner[:, (inner[1] - inner[0]).argmin()], (0.7, 0.18))
        ax = axes["cycle"]
        _title(ax, f"{name}: distance from the cycle")
        factor = exp(self.decay.rate * self.period)
        self.decay.draw(ax, f"line: times {factor:.4f}\neach period of {self.period:.4f} s")
        ax.annotate("roundoff", (self.decay.end, _NOISE), xytext=(-2, 2), ha="right", **_BESIDE)
        ax.set_ylabel("distance of greatest lean\nfrom its final value [rad]")


@dataclass(frozen=True, eq=False, slots=True)
class Straightening:
    """Maneuver 2, which converges to steady straight running.

    Attributes
    ----------
    maneuver : Maneuver
    speed : float
        At the end [m/s].
    decay : Decay
        Of the greatest leans; the exponential is that of the weave eigenvalue at the final speed.
    """

    maneuver: Maneuver
    speed: float
    decay: Decay

    @classmethod
    def of(cls, bicycle: Bicycle, maneuver: Maneuver) -> Straightening:
        """The run, and the weave eigenvalue at its last speed."""
        run = integrate(bicycle, replace(maneuver, duration=STRAIGHTENS))
        time, lean = _leans(run)
        spin = _states(run, [float(STRAIGHTENS)])[5, 0]
        speed = float(Equations.binary64(bicycle).k.length * spin)
        values = linearise(bicycle, _DIGITS).eigenvalues(Fraction(speed))
        (rate,) = (float(z.real) for z in values if z.imag > 0)
        is_slowest = _is_asymptotic(lean)
        level = float(np.mean(np.log(lean[is_slowest]) - rate * time[is_slowest]))
        return cls(maneuver, speed, Decay(time, lean, rate, level))

    def draw(self, axes: Mapping[str, Axes]) -> None:
        ax = axes["straight"]
        _title(ax, f"{self.maneuver.name} converges to steady straight running")
        rate = f"{self.decay.rate:.4f} 1/s".replace("-", "\N{MINUS SIGN}")
        note = f"line: weave eigenvalue at {self.speed:.4f} m/s,\nreal part {rate}"
        self.decay.draw(ax, note)
        ax.set_ylabel("greatest lean [rad]")


@dataclass(frozen=True, eq=False, slots=True)
class Fall:
    """Maneuver 3, until the rear wheel leaves the floor.

    Attributes
    ----------
    maneuver : Maneuver
    time, roll, rear, front : ndarray, shape (n,)
        [s]; roll angle [rad]; normal forces on the wheels [N]. The last is the lift-off.
    """

    maneuver: Maneuver
    time: Array
    roll: Array
    rear: Array
    front: Array

    @classmethod
    def of(cls, bicycle: Bicycle, maneuver: Maneuver) -> Fall:
        """The run and its forces at points of each Taylor step, which are short where it turns."""
        followed = follow(bicycle, maneuver, until=REAR_LIFT)
        assert followed.event is not None  # the benchmark's falls
        run, lift = followed.run, float(followed.event.time)
        breaks = np.array([float(t) for t in run.breaks])
        inside = breaks[(breaks > FALLS_FROM) & (breaks < lift)]
        edges = np.array([FALLS_FROM, *inside, lift])
        parts = np.linspace(edges[:-1], edges[1:], _PER_PIECE, endpoint=False, axis=1)
        time = np.append(parts, lift)
        state = _states(run, time)
        equations = Equations.binary64(bicycle, is_regular=run.is_regular)
        found = forces(equations, tuple(state))
        return cls(maneuver, time, state[0], found.rear.normal, found.front.normal)

    def draw(self, axes: Mapping[str, Axes]) -> None:
        upper, lower = axes["roll"], axes["forces"]
        _title(upper, f"{self.maneuver.name} falls")
        upper.plot(self.time, self.roll, color=BLUE)
        upper.set_ylabel("roll angle [rad]")
        lower.axhline(0.0, color=BLACK, linewidth=0.6)
        lower.plot(self.time, self.rear, color=BLUE)
        lower.plot(self.time, self.front, color=VERMILLION, linestyle=(0, (4, 1.5)))
        for ax, values in ((upper, self.roll), (lower, self.rear)):
            ax.plot(self.time[-1:], values[-1:], **_POINT)
        lift = np.array([self.time[-1], self.roll[-1]])
        _point_out(upper, f"rear wheel leaves the floor\nat {lift[0]:.4f} s", lift, (0.4, 0.12))
        lower.annotate("rear wheel", (FALLS_FROM, self.rear[0]), xytext=(2, 3), **_BESIDE)
        top = self.time[-1], self.front[-1]
        lower.annotate("front wheel", top, xytext=(-6, 0), ha="right", va="top", **_BESIDE)
        lower.set(xlim=(FALLS_FROM, None), xlabel="time [s]", ylabel="normal force [N]")
        upper.sharex(lower)
        upper.tick_params(labelbottom=False)


def draw(reference: Reference, numbers: Sequence[int]) -> Figure:
    """Two panels of maneuver 1, one of maneuver 2, and one of maneuver 3, as far as they are shown.

    Parameters
    ----------
    reference : Reference
        Of the benchmark.
    numbers
        All three, or one.

    Raises
    ------
    MissingPackageError
        matplotlib or heyoka is not installed.
    """
    with style():
        from matplotlib.figure import Figure

        panels, heights = _LAYOUTS[tuple(numbers)]
        figure = Figure(figsize=(WIDTH, sum(heights)), layout="constrained")
        axes = figure.subplot_mosaic(panels, height_ratios=heights)
        for motion in motions(reference, numbers):
            motion.draw(axes)
        figure.align_ylabels()
    return figure


def motions(reference: Reference, numbers: Sequence[int]) -> list[Weave | Straightening | Fall]:
    """Long-term behaviour of the maneuvers of the benchmark."""
    bicycle = Bicycle.parse(reference.bicycle, reference.parameters)
    parts = {n: reference[n] for n in numbers}
    return [_KINDS[n](bicycle, Maneuver.parse(m.name, m.inputs)) for n, m in parts.items()]


_KINDS: Mapping[int, Callable[[Bicycle, Maneuver], Weave | Straightening | Fall]] = {
    1: Weave.of, 2: Straightening.of, 3: Fall.of,
}  # fmt: skip


def _leans(run: Trajectory) -> tuple[Array, Array]:
    """Times [s] and sizes [rad] of the greatest leans."""
    time = np.array([float(e.time) for e in events(run, (GREATEST_LEAN,))])
    return time, np.abs(_states(run, time)[0])


def _portrait(run: Trajectory, start: float, end: float) -> Array:
    """Roll and steer angle [rad] between two times, shape (2, n)."""
    points = round((end - start) * _PER_SECOND)
    return _states(run, np.linspace(start, end, points))[[0, 2]]


def _states(run: Trajectory, times: Sequence[float] | Array) -> Array:
    """States at times, shape (7, n)."""
    with flint.ctx.workprec(run.bits + _GUARD_BITS):
        rows = [[float(x.mid()) for x in run.state(Fraction(t))] for t in times]
    return np.array(rows).T


def _is_asymptotic(distance: Array) -> Any:
    return (distance > ASYMPTOTIC[0]) & (distance < ASYMPTOTIC[1])


def _point_out(ax: Axes, text: str, point: Array, place: tuple[float, float]) -> None:
    """Text at a place of the axes (0 to 1), with a line to a point."""
    ax.annotate(
        text, (float(point[0]), float(point[1])), xytext=place, textcoords="axes fraction",
        arrowprops={"arrowstyle": "-", "linewidth": 0.6, "shrinkA": 1, "shrinkB": 1}, **_NOTE,
    )  # fmt: skip


def _title(ax: Axes, text: str) -> None:
    ax.set_title(text, loc="left", fontsize=9, parse_math=False)
