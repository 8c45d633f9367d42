"""Mistakes in the parameters of the bicycle."""

from collections.abc import Callable
from math import cos, degrees, pi, radians, tan

from heyoka_bike.scoring.diagnosis.programs.program import Mistake, Parameters
from heyoka_bike.scoring.diagnosis.programs.program import model_mistake as _model

# Point P2 of the steer axis, truncated as in the text of the benchmark: x, z [m].
_PRINTED_P2 = (0.82188470506, -0.85595086466)


def _tilt(code: str, says: str, tilt: Callable[[float], float]) -> Mistake:
    """Make a mistake in the tilt of the steer axis."""
    check = "the steer axis: tilted by lambda from the vertical, its upper end behind its lower one"
    return _model(code, says, check, lambda p: p.update(lam=tilt(p["lam"])))


def _zero(*symbols: str) -> Callable[[Parameters], None]:
    return lambda p: p.update(dict.fromkeys(symbols, 0.0))


def _gravity(g: str) -> Callable[[Parameters], None]:
    return lambda p: p.update(g=float(g))


def _same_radius(wheel: str) -> Callable[[Parameters], None]:
    return lambda p: p.update(rR=p[f"r{wheel}"], rF=p[f"r{wheel}"])


def _negate(*symbols: str) -> Callable[[Parameters], None]:
    return lambda p: p.update({s: -p[s] for s in symbols})


def _times(factor: float, *symbols: str) -> Callable[[Parameters], None]:
    return lambda p: p.update({s: factor * p[s] for s in symbols})


def _exchange(*pairs: tuple[str, str]) -> Callable[[Parameters], None]:
    return lambda p: p.update({s: p[t] for a, b in pairs for s, t in ((a, b), (b, a))})


def _moved(body: str, place: str, sign: int) -> Callable[[Parameters], None]:
    """Return a change that adds or subtracts a body's parallel-axis terms to another point."""

    def change(p: Parameters) -> None:
        x, z = p[f"x{body}"], p[f"z{body}"]
        if place == "hub":
            x, z = (x, z + p["rR"]) if body == "B" else (x - p["w"], z + p["rF"])
        m = sign * p[f"m{body}"]
        p[f"I{body}xx"] += m * z * z
        p[f"I{body}zz"] += m * x * x
        p[f"I{body}yy"] += m * (x * x + z * z)
        p[f"I{body}xz"] -= m * x * z

    return change


def _through_p2(p: Parameters) -> None:
    """Put the steer axis, with the given tilt, through the printed point P2."""
    x, z = _PRINTED_P2
    p["c"] = x - z * tan(p["lam"]) - p["w"]


def _trail_by_cosine(power: int) -> Callable[[Parameters], None]:
    return lambda p: p.update(c=p["c"] * cos(p["lam"]) ** power)


def _as_bodies_of_revolution(spin: float) -> Callable[[Parameters], None]:
    """Return a change to axisymmetric thin wheels.

    Their axial inertia is `spin` m r^2, their diametral inertia half of it.
    """

    def change(p: Parameters) -> None:
        for b in "RF":
            p[f"I{b}yy"] = spin * p[f"m{b}"] * p[f"r{b}"] ** 2
            p[f"I{b}xx"] = p[f"I{b}yy"] / 2

    return change


def _rounded(decimals: int, prefix: str) -> Callable[[Parameters], None]:
    """Return a change that rounds values whose symbols begin with `prefix`, except gravity."""
    return lambda p: p.update(
        {s: round(x, decimals) for s, x in p.items() if s.startswith(prefix) and s != "g"}
    )


_SAME_AXES = "the benchmark lists matrix elements, not products of inertia"
_ABOUT = "the point about which your program takes inertias"
_ORDER = "the order of the axes in your program: x forward, y lateral, z vertical"
_WHEEL = "the inertia tensor of the wheel: Iyy is about its axle, Ixx = Izz about a diameter"
_WHICH = "which wheel is the rear one"
_RADIUS_OF = "the radii of the wheels: rear 0.3 m, front 0.35 m"
_GRAVITY = "gravity: the benchmark has 9.81 m/s^2, down"
_AT_GROUND = "where the steer axis meets the ground: ahead of the front contact point"

_DIGITS = "the digits of the values that are typed: Table 1 has up to six after the point"
_OFF_DIAGONAL = "the products of inertia"
_FRAMES_AND_HUBS = (("B", "rear frame", "rear hub"), ("H", "fork", "front hub"))
_WHEEL_NAMES = (("R", "rear"), ("F", "front"))


def _of_frame(body: str, name: str, hub: str) -> tuple[Mistake, ...]:
    """Return the mistakes in the inertia of one frame."""
    inertia = f"the inertia of the {name}"
    return (
        _model(f"sign_I{body}xz", f"I_{body}xz of the {name} has the opposite sign",
               f"the sign convention of products of inertia: {_SAME_AXES}", _negate(f"I{body}xz")),
        _model(f"no_I{body}xz", f"I_{body}xz of the {name} is missing", _OFF_DIAGONAL,
               _zero(f"I{body}xz")),
        *(_model(f"inertia_{body}_about_{place}", f"{inertia} is taken about the {point}", _ABOUT,
                 _moved(body, place, 1))
          for place, point in (("origin", "origin of the frame"), ("hub", hub))),
        *(_model(f"inertia_{body}_from_{place}", f"{inertia} is moved from the {point} to its "
                 "centre of mass, about which it is given", _ABOUT, _moved(body, place, -1))
          for place, point in (("origin", "origin of the frame"), ("hub", hub))),
        *(_model(f"inertia_{body}_{ij}_zz", f"I{ij} and Izz of the {name} are exchanged", _ORDER,
                 _exchange((f"I{body}{ij}", f"I{body}zz")))
          for ij in ("xx", "yy")),
    )  # fmt: skip


MODEL_MISTAKES: tuple[Mistake, ...] = (
    *(mistake for frame in _FRAMES_AND_HUBS for mistake in _of_frame(*frame)),
    *(_model(f"{code}_{n}_decimals", f"{what} have {n} place{'s' * (n > 1)} after the point",
             _DIGITS, _rounded(n, prefix))
      for code, what, prefix, places in (("inertia", "all moments and products of inertia", "I",
                                          (1, 2, 3)),
                                         ("all", "all values of the table", "", (2, 3)))
      for n in places),
    _model("products_of_inertia", "both products of inertia have the opposite sign",
           "whether your program wants -integral(x z dm) or the matrix element",
           _negate("IBxz", "IHxz")),
    _model("no_products", "both products of inertia are missing", _OFF_DIAGONAL,
           _zero("IBxz", "IHxz")),
    _model("inertia_B_missing", "the rear frame with rider is a point mass", "the inertia of the "
           "body B", _zero("IBxx", "IByy", "IBzz", "IBxz")),
    _model("inertia_H_missing", "the fork is a point mass", "the inertia of the body H",
           _zero("IHxx", "IHyy", "IHzz", "IHxz")),
    *(_model(f"spin_{wheel}_missing", f"the {name} wheel has no inertia about its axle", _WHEEL,
             _zero(f"I{wheel}yy"))
      for wheel, name in _WHEEL_NAMES),
    _model("spin_missing", "the wheels have no inertia about their axles", _WHEEL,
           _zero("IRyy", "IFyy")),
    _model("diametral_missing", "the wheels have no inertia about their diameters", _WHEEL,
           _zero("IRxx", "IFxx")),
    *(_model(f"exchanged_{wheel}", f"Ixx and Iyy of the {name} wheel are exchanged", _WHEEL,
             _exchange((f"I{wheel}xx", f"I{wheel}yy")))
      for wheel, name in _WHEEL_NAMES),
    _model("exchanged_RF", "Ixx and Iyy of both wheels are exchanged", _WHEEL,
           _exchange(("IRxx", "IRyy"), ("IFxx", "IFyy"))),
    _tilt("tilt_sign", "the steer axis is tilted forward instead of backward",
          lambda x: -x),
    _tilt("tilt_zero", "the steer axis is vertical", lambda _: 0.0),
    _tilt("tilt_from_horizontal", "the tilt of the steer axis is measured from the horizontal",
          lambda x: pi / 2 - x),
    _tilt("tilt_degrees_as_radians", "the tilt of the steer axis in degrees is read as "
          "radians", degrees),
    _tilt("tilt_radians_as_degrees", "the tilt of the steer axis in radians is read as "
          "degrees", radians),
    _model("trail_sign", "the trail is negative", _AT_GROUND, _negate("c")),
    _model("trail_zero", "the trail is zero", _AT_GROUND, _zero("c")),
    _model("trail_normal", "the trail is used as the distance of the front contact point from the "
           "steer axis", "the trail: it is measured along the ground", _trail_by_cosine(-1)),
    _model("trail_shortened", "the trail is multiplied by the cosine of the steer axis tilt",
           "the trail: it is measured along the ground", _trail_by_cosine(1)),
    _model("printed_p2", "the steer axis goes through the printed point P2",
           "how the steer axis is built: from wheel base, trail and tilt", _through_p2),
    _model("radii_exchanged", "the wheel radii are exchanged", _RADIUS_OF, _exchange(("rR", "rF"))),
    _model("radii_doubled", "the wheel radii are twice too large", _RADIUS_OF,
           _times(2.0, "rR", "rF")),
    _model("radii_halved", "the wheel radii are taken as diameters", _RADIUS_OF,
           _times(0.5, "rR", "rF")),
    *(_model(f"radius_{wheel}_everywhere", f"both wheels have the radius of the {name} one",
             _RADIUS_OF, _same_radius(wheel))
      for wheel, name in _WHEEL_NAMES),
    _model("wheels_exchanged", "the wheels are exchanged", _WHICH,
           _exchange(("rR", "rF"), ("mR", "mF"), ("IRxx", "IFxx"), ("IRyy", "IFyy"))),
    _model("wheel_masses_exchanged", "the masses of the wheels are exchanged", _WHICH,
           _exchange(("mR", "mF"))),
    _model("front_masses_exchanged", "the masses of the fork and of the front wheel are exchanged",
           "the masses of the table: fork 4 kg, front wheel 3 kg", _exchange(("mH", "mF"))),
    _model("wheel_inertias_exchanged", "the inertias of the wheels are exchanged", _WHICH,
           _exchange(("IRxx", "IFxx"), ("IRyy", "IFyy"))),
    _model("wheel_bodies_exchanged", "masses and inertias of the wheels are exchanged",
           _WHICH, _exchange(("mR", "mF"), ("IRxx", "IFxx"), ("IRyy", "IFyy"))),
    _model("wheels_as_rings", "the wheels have the inertia of rings of their mass and "
           "radius", _WHEEL, _as_bodies_of_revolution(1.0)),
    _model("wheels_as_discs", "the wheels have the inertia of discs of their mass and "
           "radius", _WHEEL, _as_bodies_of_revolution(0.5)),
    _model("mass_H_missing", "the fork has no mass and no inertia", "the body H of the fork",
           _zero("mH", "IHxx", "IHyy", "IHzz", "IHxz")),
    _model("mass_B_missing", "the rear frame with rider has no mass and no inertia",
           "the body B of the frame with rider", _zero("mB", "IBxx", "IByy", "IBzz", "IBxz")),
    _model("wheels_missing", "the wheels have no mass and no inertia", "the bodies of the wheels",
           _zero("mR", "IRxx", "IRyy", "mF", "IFxx", "IFyy")),
    *(_model(f"gravity_{g}", f"gravity is {g} m/s^2", _GRAVITY, _gravity(g))
      for g in ("9.8", "9.80665", "9.82", "10")),
    _model("gravity_missing", "there is no gravity", _GRAVITY, _zero("g")),
    _model("gravity_reversed", "gravity acts upward", _GRAVITY, _negate("g")),
)  # fmt: skip
"""Mistakes in the parameters, in no particular order."""
