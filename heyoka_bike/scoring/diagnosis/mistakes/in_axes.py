"""Mistakes of programs that use axes along the steer axis (Moore's convention, SymBRiM).

In this convention both frames have their own axes: the global ones, rotated about y by the tilt, so
that z is along the steer axis. Table 1 must be converted to these axes: the inertia, the centres of
mass (l1, l2 from the rear hub, l3, l4 from the front hub), and the path from the rear hub across to
the steer axis (d1), along it (d2), and across to the front hub (d3). If a length is wrong, the
bicycle pitches until both wheels are on the floor.

References
----------
J. K. Moore (2012), Human control of a bicycle, University of California, Davis, chapter 2.
"""

from collections.abc import Callable
from math import acos, atan2, cos, hypot, pi, sin, tan

from heyoka_bike.scoring.diagnosis.programs.program import Mistake, Parameters, model_mistake

_Entries = tuple[float, float, float]
"""xx, zz and xz of a tensor."""


def _turned(entries: _Entries, angle: float) -> _Entries:
    """Return a tensor's entries in axes rotated about y by an angle: z becomes (sin, 0, cos)."""
    xx, zz, xz = entries
    s, c = sin(angle), cos(angle)
    return (
        xx * c * c - 2 * xz * s * c + zz * s * s,
        xx * s * s + 2 * xz * s * c + zz * c * c,
        (xx - zz) * s * c + xz * (c * c - s * s),
    )


def _turn(p: Parameters, bodies: str, change: Callable[[_Entries], _Entries]) -> None:
    """Apply a function to the inertia tensors of frames."""
    for body in bodies:
        names = [f"I{body}{ij}" for ij in ("xx", "zz", "xz")]
        xx, zz, xz = (p[name] for name in names)
        p.update(zip(names, change((xx, zz, xz)), strict=True))


def _negative_product(entries: _Entries, tilt: float) -> _Entries:
    xx, zz, xz = _turned(entries, tilt)
    return xx, zz, -xz


def _lengths(p: Parameters) -> Parameters:
    """Compute Moore's lengths [m] of the geometry (d1 to d3) and the centres of mass (l1 to l4)."""
    s, c = sin(p["lam"]), cos(p["lam"])
    w, r, r_f = p["w"], p["rR"], p["rF"]
    x, z, x_f, z_f = p["xB"], p["zB"] + r, p["xH"] - w, p["zH"] + r_f
    d1 = c * (w + p["c"]) - s * r
    return {
        "d1": d1,
        "d2": s * w + c * (r - r_f),
        "d3": c * w - s * (r - r_f) - d1,
        "l1": c * x - s * z,
        "l2": s * x + c * z,
        "l3": c * x_f - s * z_f,
        "l4": s * x_f + c * z_f,
    }


_Lengths = Callable[[Parameters, Parameters], Parameters]
"""Function from the correct lengths and the parameters to the wrong lengths."""


def _stand(p: Parameters, *changes: _Lengths) -> None:
    """Put the bicycle with changed lengths on the floor."""
    m = _lengths(p)
    for change in changes:
        m |= change(m, p)
    across, r, r_f = m["d1"] + m["d3"], p["rR"], p["rF"]
    reach = (r - r_f) / hypot(across, m["d2"])
    if abs(reach) > 1:
        return
    # Solve d2 cos(tilt) - (d1 + d3) sin(tilt) = rR - rF for the tilt. Both sides are the height of
    # the rear hub above the front hub.
    stands = acos(reach) - atan2(across, m["d2"])
    pitch = stands - p["lam"]
    s, c = sin(stands), cos(stands)
    w = c * across + s * m["d2"]
    _turn(p, "BH", lambda entries: _turned(entries, -pitch))
    p.update(
        lam=stands,
        w=w,
        c=(m["d1"] + s * r) / c - w,
        xB=c * m["l1"] + s * m["l2"],
        zB=c * m["l2"] - s * m["l1"] - r,
        xH=w + c * m["l3"] + s * m["l4"],
        zH=c * m["l4"] - s * m["l3"] - r_f,
    )


def _rear_not_tilted(_: Parameters, p: Parameters) -> Parameters:
    return {"l1": p["xB"], "l2": p["zB"] + p["rR"]}


def _front_not_tilted(_: Parameters, p: Parameters) -> Parameters:
    return {"l3": p["xH"] - p["w"], "l4": p["zH"] + p["rF"]}


_WHICH_AXES = (
    "in which axes your program expects inertia tensors: global axes, or axes along the steer axis"
)
_OFFSETS = "the lengths from hub to steer axis: each with the radius of its own wheel"
_CENTRES = "in which axes your program expects the centres of mass"
_HEIGHTS = "the height from which centres of mass are measured"


def _of_inertia(
    code: str, says: str, given: Callable[[_Entries, float], _Entries]
) -> tuple[Mistake, ...]:
    """Return mistakes in the inertia of the rear frame, of the fork, and of both.

    `given` computes, from the correct entries and the tilt, the entries that the program uses in
    axes along the steer axis.
    """

    def made(bodies: str, name: str) -> Mistake:
        def change(p: Parameters) -> None:
            _turn(p, bodies, lambda entries: _turned(given(entries, p["lam"]), -p["lam"]))

        return model_mistake(code.format(bodies), says.format(name), _WHICH_AXES, change)

    names = {"B": "rear frame", "H": "fork", "BH": "rear frame and of the fork"}
    return tuple(made(bodies, name) for bodies, name in names.items())


AXES_MISTAKES: tuple[Mistake, ...] = (
    *_of_inertia("inertia_{}_rotated", "the inertia of the {} is used as if it were in axes along "
                 "the steer axis", lambda i, _: i),
    *_of_inertia("inertia_{}_rotated_back", "the inertia of the {} is rotated to axes along the "
                 "steer axis, but used as if it were in global axes",
                 lambda i, tilt: _turned(i, 2 * tilt)),
    *_of_inertia("inertia_{}_rotated_wrong_way", "the inertia of the {} is rotated by the tilt in "
                 "the wrong direction, and used in axes along the steer axis",
                 lambda i, tilt: _turned(i, -tilt)),
    *_of_inertia("inertia_{}_rotated_by_head_angle", "the inertia of the {} is rotated by the head "
                 "angle instead of the tilt", lambda i, tilt: _turned(i, pi / 2 - tilt)),
    *_of_inertia("sign_I{}xz_along_steer", "the product of inertia of the {} has the opposite sign "
                 "in axes along the steer axis", _negative_product),
    model_mistake("offset_d1_by_front_radius", "the distance from the rear hub to the steer axis "
                  "is computed with the front wheel's radius", _OFFSETS, lambda p: _stand(
                      p, lambda m, p: {"d1": m["d1"] - sin(p["lam"]) * (p["rF"] - p["rR"])})),
    model_mistake("offset_d3_by_rear_radius", "the distance from the steer axis to the front hub "
                  "is computed with the rear wheel's radius", _OFFSETS, lambda p: _stand(
                      p, lambda _, p: {"d3": sin(p["lam"]) * p["rR"] - cos(p["lam"]) * p["c"]})),
    model_mistake("trail_by_rear_radius", "the trail is computed with the rear wheel's radius from "
                  "the offset of the front hub", _OFFSETS,
                  lambda p: p.update(c=p["c"] - (p["rF"] - p["rR"]) * tan(p["lam"]))),
    model_mistake("offset_for_rear_radius", "the offset of the front hub from the steer axis is "
                  "computed from the trail with the rear wheel's radius", _OFFSETS,
                  lambda p: p.update(c=p["c"] + (p["rF"] - p["rR"]) * tan(p["lam"]))),
    model_mistake("no_offset", "the steer axis goes through the front hub", _OFFSETS,
                  lambda p: _stand(p, lambda m, _: {"d3": 0.0})),
    model_mistake("offset_sign", "the front hub is behind the steer axis", _OFFSETS,
                  lambda p: _stand(p, lambda m, _: {"d3": -m["d3"]})),
    model_mistake("centre_B_not_tilted", "the centre of mass of the rear frame is used as if it "
                  "were in axes along the steer axis", _CENTRES,
                  lambda p: _stand(p, _rear_not_tilted)),
    model_mistake("centre_H_not_tilted", "the centre of mass of the fork is used as if it were in "
                  "axes along the steer axis", _CENTRES, lambda p: _stand(p, _front_not_tilted)),
    model_mistake("centres_not_tilted", "the centres of mass of both frames are used as if they "
                  "were in axes along the steer axis", _CENTRES,
                  lambda p: _stand(p, _rear_not_tilted, _front_not_tilted)),
    model_mistake("centre_B_from_hub", "the height of the centre of mass of the rear frame is "
                  "measured from the rear hub", _HEIGHTS, lambda p: p.update(zB=p["zB"] - p["rR"])),
    model_mistake("centre_H_from_hub", "the height of the centre of mass of the fork is measured "
                  "from the front hub", _HEIGHTS, lambda p: p.update(zH=p["zH"] - p["rF"])),
)  # fmt: skip
"""Mistakes with axes along the steer axis, in no particular order."""
