"""An atlas as one self-contained HTML page: a map, and the motion from any start in it.

The page computes motions itself. It contains the equations of the bicycle as JavaScript, written by
evaluating the model (see `numbers.straight_line`), and ``motion.js`` integrates them.
"""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from html import escape
from itertools import groupby, product
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from heyoka_bike.bicycle.equations.bodies import bodies_of
from heyoka_bike.bicycle.equations.constants import constants_of
from heyoka_bike.bicycle.equations.forces import forces
from heyoka_bike.bicycle.equations.kinematics import front_contact_height, turn_divisor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import (
    INTEGRALS,
    Configuration,
    track_speeds,
    whole_rates,
)
from heyoka_bike.bicycle.parameters import START, Bicycle
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.errors import printable
from heyoka_bike.numbers.arithmetic import Number
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.straight_line import JAVASCRIPT, StraightLine
from heyoka_bike.showing.document.html import PAGE_STYLE, page
from heyoka_bike.workbench.atlas.data import FALLS, FATES, VARIABLES, Atlas, GridAxis
from heyoka_bike.workbench.atlas.figure import limits, maneuvers
from heyoka_bike.workbench.atlas.store import load_atlas
from heyoka_bike.workbench.replay.page import PITCH_SCRIPT, drawing, stage
from heyoka_bike.workbench.replay.page import SCRIPT as REPLAY_SCRIPT
from heyoka_bike.workbench.replay.page import STYLE as REPLAY_STYLE

_LAST_VALUE, _NO_VALUE = 65534, 65535


@dataclass(frozen=True, slots=True)
class Packed:
    """Numbers that are stored as integers k of 16 bits.

    A number is ``low + (high - low) k / 65534``, or ten to that power. For powers k = 0 means zero.
    65535 stands for a missing value.

    Attributes
    ----------
    low, high
        Range of the numbers, or of their decimal logarithms.
    is_log
        Whether the numbers are powers of ten.
    codes : ndarray of uint16
    """

    low: float
    high: float
    is_log: bool
    codes: NDArray[np.uint16]

    @classmethod
    def of(cls, values: Array, *, is_log: bool) -> Packed:
        """Pack numbers: NaN and infinity become missing; among powers, negative values become 0."""
        flat = np.asarray(values, dtype=float).ravel()
        is_there = np.isfinite(flat)
        kept = is_there & (flat > 0) if is_log else is_there
        scaled = np.log10(flat[kept]) if is_log else flat[kept]
        low, high = (float(scaled.min()), float(scaled.max())) if len(scaled) else (0.0, 0.0)
        codes = np.where(is_there, 0, _NO_VALUE).astype(np.uint16)
        places = (scaled - low) / ((high - low) or 1.0) * _LAST_VALUE
        codes[kept] = np.maximum(np.rint(places), 1 if is_log else 0)
        return cls(low, high, is_log, codes)

    @property
    def precision(self) -> float:
        """The largest rounding error of a stored number: absolute, or relative for powers."""
        half = (self.high - self.low) / _LAST_VALUE / 2
        # On a logarithmic scale, code 0 stands for the value zero. So the smallest power has code
        # 1, and its error is a whole step, not half a step.
        return float(10 ** (2 * half) - 1) if self.is_log else half

    def text(self) -> str:
        """Return the codes in base64, little-endian."""
        return b64encode(self.codes.astype("<u2").tobytes()).decode()


MOTION_SCRIPT = "".join(
    file.read_text(encoding="utf-8")
    for file in (PITCH_SCRIPT, Path(__file__).with_name("motion.js"))
)
"""Script that integrates a motion with the equations of `motion_source`."""

ERROR = 1e-8
"""The largest error of angles [rad], rates [rad/s] and speed [m/s] within 10 s."""

STATE = ("roll", "pitch", "steer", "roll_rate", "steer_rate", "spin", "yaw", *INTEGRALS, "track")
"""The integrated variables; `track` is the length of the rear track [m]."""

OBSERVED = (
    "front_x", "front_y", "speed", "potential", "kinetic", "rear_normal", "front_normal",
)  # fmt: skip
"""The derived quantities: front contact [m], speed [m/s], energies [J], normal forces [N]."""

DIVISORS = 3
"""Number of divisors of the equations that may vanish; a motion ends where one does."""

_Formulas = Callable[[Equations, Sequence[Number]], Sequence[Number]]


def motion_source(bicycle: Bicycle, free: Sequence[str] = ()) -> str:
    """Return functions and constants for ``motion.js``, as JavaScript.

    Parameters
    ----------
    bicycle : Bicycle
    free
        Symbols of parameters that ``P`` supplies instead of the bicycle.

    ``rates(y, f)`` writes the time derivatives of the state y into f, followed by the `DIVISORS`.
    ``observe(y, f)`` writes the quantities of `OBSERVED`, ``floorGap([roll, pitch, steer], f)`` the
    height of the front wheel [m], and ``spinOf([speed], f)`` the state's ``spin``.
    """

    def function(name: str, size: int, formulas: _Formulas) -> str:
        return JAVASCRIPT.function(
            name, {"y": size}, "f", lambda code, y: formulas(_equations(bicycle, free, code), y)
        )

    parts = [
        "const { sin, cos, sqrt, atan2 } = Math;",
        f"const STATE = {json.dumps(STATE)}, OBSERVED = {json.dumps(OBSERVED)};",
        f"const DIVISORS = {DIVISORS}, P = {json.dumps({x: float(bicycle[x]) for x in free})};",
        function("rates", len(STATE), _rates),
        function("observe", len(STATE), _observed),
        function("floorGap", 3, _floor_gap),
        function("spinOf", 1, _spin),
    ]
    return "\n".join(parts) + "\n"


def _equations(bicycle: Bicycle, free: Sequence[str], code: StraightLine) -> Equations:
    """Return equations with constants rounded once, or with formulas of the `free` parameters."""
    if not free:
        return Equations.binary64(bicycle).convert(code.literal, code)
    p: dict[str, Number] = {symbol: value.rational for symbol, value in bicycle.values.items()}
    p |= {symbol: code.variable(f"P.{symbol}") for symbol in free}
    tilt = p["lam"] if "lam" in free else code.number(bicycle["lam"])
    k = constants_of(p, tilt, code, is_vertical=False)
    return Equations(bicycle, k, bodies_of(p, tilt, code), code)


def _rates(equations: Equations, y: Sequence[Number]) -> Sequence[Number]:
    o, u = equations.unfold(y)
    rear, _ = track_speeds(equations.k, u)
    return [*whole_rates(equations, y), rear, o.kappa, o.den, turn_divisor(o)]


def _observed(equations: Equations, y: Sequence[Number]) -> Sequence[Number]:
    x_y = Configuration.of(equations, y).places()["front_contact"][:2]
    energies, contacts = equations.energies(y), forces(equations, y)
    _, u = equations.unfold(y)
    return [
        *x_y, equations.k.length * u.v, energies.potential, energies.kinetic,
        contacts.rear.normal, contacts.front.normal,
    ]  # fmt: skip


def _floor_gap(equations: Equations, y: Sequence[Number]) -> Sequence[Number]:
    return [front_contact_height(equations.k, equations.a, *y)]


def _spin(equations: Equations, y: Sequence[Number]) -> Sequence[Number]:
    return [y[0] / equations.k.length]


_HERE = Path(__file__).parent
_BODY = Template((_HERE / "page.html").read_text(encoding="utf-8"))
_SCRIPTS = (_HERE / "charts.js", _HERE / "atlas.js")
# Maximum length of a provenance entry [characters]; longer entries, such as the inputs, are not
# shown.
_LETTERS_OF_SOURCE = 200
_SHAPES = 9  # number of drawings along an axis that changes the bicycle
_CURVE = 25  # number of points of a curve of speeds
_DIGITS_OF_RANGE = 15  # number of digits of the ends of the stable range
_SAID_OF_FATES = {
    "undecided": "not decided",
    "upright": "converges to steady running",
    "cycle": "approaches a limit cycle",
    "lifts": "lifts a wheel, recovers",
    "weaves": "weaves irregularly",
}
# Words between a fate and the time after which it is known, if not ``, settled after``.
_WHEN_OF_FATES = {
    "undecided": ", followed for", "weaves": ", followed for", "upright": " after",
    "falls": " after",
}  # fmt: skip
# Title of each layer in the menu, and whether its scale is logarithmic.
_SHOWN_OF_LAYERS = {
    "fate_time": ("time until decided", True),
    "final_speed": ("final speed", False),
    "largest_lean": ("largest lean", True),
    "largest_steer": ("largest steer", True),
    "condition": ("growth of a small error within 10 s", True),
    "lift_time": ("time until a wheel lifts", True),
}
_UNIT_TEXTS = {"s": "s", "m s-1": "m/s", "rad": "rad", "1": ""}


def atlas_page(folder: str | Path) -> str:
    """Return the page of the atlas in a folder."""
    return render(load_atlas(folder))


def render(atlas: Atlas) -> str:
    """Return the atlas as an HTML page."""
    packed = {
        name: Packed.of(atlas.variables[name], is_log=is_log)
        for name, (_, is_log) in _SHOWN_OF_LAYERS.items()
        if name in atlas.variables
    }
    free = [axis.name for axis in atlas.axes if axis.name not in START]
    across, along = atlas.shape
    body = _BODY.substitute(
        _of_map(atlas, packed), name=escape(printable(atlas.bicycle.name)), across=across,
        along=along, stage=stage([("1", "1")], False), **_of_words(packed),
    )  # fmt: skip
    scripts = [
        motion_source(atlas.bicycle, free), MOTION_SCRIPT,
        *(file.read_text(encoding="utf-8") for file in (REPLAY_SCRIPT, *_SCRIPTS)),
    ]  # fmt: skip
    return page(
        f"{printable(atlas.bicycle.name)} – atlas",
        body,
        [
            (key.replace("_", " "), printable(said))
            for key, said in atlas.provenance.items()
            if len(said) <= _LETTERS_OF_SOURCE
        ],
        styles=(PAGE_STYLE, REPLAY_STYLE, _HERE / "atlas.css"),
        script='"use strict";\n' + "".join(scripts),
        data=_data(atlas, packed),
    )


def _of_map(atlas: Atlas, packed: dict[str, Packed]) -> dict[str, str]:
    """Return the HTML of the controls of the map, by placeholder of page.html."""
    options = "".join(
        f'<option value="{name}">{escape(_SHOWN_OF_LAYERS[name][0])}</option>' for name in packed
    )
    boxes = "".join(
        f'<label>{escape(_title(axis))} <input type="number" step="any" name="{place}" '
        f'min="{axis.values[0]:.12g}" max="{axis.values[-1]:.12g}" required> '
        f"{escape(axis.unit)}</label> "
        for place, axis in zip("xy", atlas.axes, strict=True)
    )
    quick = "".join(
        f'<button type="button" data-mark="{i}" aria-label="maneuver {mark["text"]}">'
        f"{mark['text']}</button>"
        for i, mark in enumerate(_marks(atlas))
    )
    quick = f"<span>maneuver {quick}</span>" if quick else ""
    return {"options": options, "boxes": boxes, "quick": quick}


def _of_words(packed: dict[str, Packed]) -> dict[str, str]:
    """Return HTML with the meanings of the fates and the precision of the stored numbers."""
    fates = "".join(
        f"<dt>{escape(_SAID_OF_FATES.get(name, name))}</dt><dd>{escape(meaning)}</dd>"
        for name, meaning in FATES.items()
    )
    kept = "; ".join(
        f"{_SHOWN_OF_LAYERS[name][0]} to {p.precision:.1g} "
        f"{'of itself' if p.is_log else _UNIT_TEXTS[VARIABLES[name].unit]}"
        for name, p in packed.items()
    )
    return {"fates": fates, "kept": kept}


def _title(axis: GridAxis) -> str:
    return axis.title if axis.name in START else f"{axis.title} {axis.name}"


def _marks(atlas: Atlas) -> list[dict[str, Any]]:
    """Return the benchmark's maneuvers that lie in the map."""
    found = []
    names = [axis.name for axis in atlas.axes]
    for number, maneuver in enumerate(maneuvers(atlas), start=1):
        start = {key: float(getattr(maneuver, key)) for key in START}
        is_on = all(start[key] == x for key, x in atlas.start.items() if key not in names)
        inside = all(a.values[0] <= start.get(a.name, np.nan) <= a.values[-1] for a in atlas.axes)
        if is_on and inside:
            x, y = (start[name] for name in names)
            found.append({"text": str(number), "x": x, "y": y})
    return found


def _stable(atlas: Atlas) -> dict[str, Any]:
    """Return where upright running is stable in the linear theory, if an axis is the speed.

    ``curves`` contains the ends of the stable ranges as points of the map. If the bicycle is the
    same everywhere, ``ranges`` contains them as pairs of speeds, with null for an unbounded range.
    """
    names = [axis.name for axis in atlas.axes]
    if "speed" not in names:
        return {"curves": [], "ranges": []}
    other = atlas.axes[1 - names.index("speed")]
    is_one, ends = other.name in START, (other.values[0], other.values[-1])
    values = ends if is_one else np.linspace(*ends, _CURVE)
    changes = [{} if is_one else {other.name: Exact(Fraction(x))} for x in values]
    ranges = [_ranges(atlas.bicycle.replace(**change)) for change in changes]
    curves = []
    for i, j in product(range(max(map(len, ranges))), (0, 1)):
        speeds = [found[i][j] if i < len(found) else None for found in ranges]
        for is_there, points in groupby(
            zip(speeds, values, strict=True), lambda p: p[0] is not None
        ):
            if is_there:
                places = [[speed, float(x)] for speed, x in points]
                curves.append(places if names[0] == "speed" else [p[::-1] for p in places])
    return {"curves": curves, "ranges": ranges[0] if is_one and names[0] == "speed" else []}


def _energy(atlas: Atlas) -> list[list[list[float]]]:
    """Return a curve for each critical speed: the starts that have the energy at that speed."""
    names = tuple(axis.name for axis in atlas.axes)
    if names != ("speed", "roll_rate") or any(atlas.start[n] for n in START if n not in names):
        return []
    return [np.column_stack((c.speed, c.roll_rate)).round(4).tolist() for c in limits(atlas)]


def _ranges(bicycle: Bicycle) -> list[tuple[float, float | None]]:
    found = linearise(bicycle, _DIGITS_OF_RANGE).stable_ranges
    return [(float(low), None if high is None else float(high)) for low, high in found]


def _shapes(atlas: Atlas) -> list[Any]:
    """Return outlines of the bicycle at some values of each axis that is a parameter."""

    def along(bicycle: Bicycle, axes: Sequence[GridAxis]) -> Any:
        if not axes:
            return drawing(bicycle)
        name, values = axes[0].name, axes[0].values
        if name in START:
            return [along(bicycle, axes[1:])]
        at = np.linspace(values[0], values[-1], _SHAPES if len(values) > 1 else 1)
        return [along(bicycle.replace(**{name: Exact(Fraction(x))}), axes[1:]) for x in at]

    found: list[Any] = along(atlas.bicycle, atlas.axes)
    return found


def _data(atlas: Atlas, packed: dict[str, Packed]) -> str:
    quantities = {
        name: {
            "title": _SHOWN_OF_LAYERS[name][0], "unit": _UNIT_TEXTS[VARIABLES[name].unit],
            "low": p.low, "high": p.high, "isLog": p.is_log, "codes": p.text(),
        }
        for name, p in packed.items()
    }  # fmt: skip
    axes = [
        {"name": a.name, "title": _title(a), "unit": a.unit, "values": a.values.tolist()}
        for a in atlas.axes
    ]
    order = np.argsort(atlas.edge.at, kind="stable")
    edge = (atlas.edge.at, atlas.edge.stays, atlas.edge.falls)
    data = {
        "axes": axes, "start": dict(atlas.start),
        "fates": [_SAID_OF_FATES.get(name, name) for name in FATES],
        "fate": _bytes(atlas.variables["fate"]), "wheel": _bytes(atlas.variables["lift_wheel"]),
        "falls": FALLS, "when": [_WHEN_OF_FATES.get(name, ", settled after") for name in FATES],
        "quantities": quantities, "edge": [x[order].tolist() for x in edge],
        "marks": _marks(atlas), "stable": _stable(atlas), "energy": _energy(atlas),
        "shapes": _shapes(atlas),
    }  # fmt: skip
    # The data contain only numbers and names of this package, so no text in them can end the script
    # element.
    return json.dumps(data, separators=(",", ":"), allow_nan=False)


def _bytes(values: Array) -> str:
    return b64encode(np.asarray(values, dtype=np.uint8).tobytes()).decode()
