"""The meaning of the names of columns: aliases, units in them, the numbers of maneuvers.

A name may be the way to a joint in a model, as ``bike.steer.phi`` and ``der(bike.steer.phi)`` of
Modelica, ``Roll_Joint.Rz.w`` of Simscape and ``/jointset/fork/steer_angle/value`` of OpenSim. Only
joints are read so: the speed or the energy of some part is not that of the bicycle.

The names of a file are understood beside each other. A name may end in a digit for other reasons:
`u1` and `u2` are the speeds of Kane's method, and `V2` is the potential energy of some body. So a
number is that of a maneuver only if its word is longer than a letter, or if the numbers are those
of all maneuvers; and where other columns have none, only if that is said in words.
"""

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache

from heyoka_bike.bicycle.columns import COMPARED, KEYS_BY_WORD
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.unit import UNITS as WORDS
from heyoka_bike.numbers.unit import factor, size
from heyoka_bike.scoring.evidence import LostColumn, NotCompared, Reason, UnknownUnit
from heyoka_bike.scoring.grouped import grouped
from heyoka_bike.scoring.reading.request import LEFT_OUT, NAMES, Request
from heyoka_bike.scoring.units import UNITS

_QUANTITIES = {"s": ("s", "ms"), **{si: units for si, units in UNITS.items() if si != "1"}}
"""By SI unit, those that are usual."""
_SPELLINGS: Mapping[str, tuple[str, ...]] = {
    "rad": ("radian",),
    "degree": ("deg", "\u00b0"),
    "revolution": ("rev", "turn"),
    "arcminute": ("arcmin",),
    "arcsecond": ("arcsec",),
    "grade": ("gon", "grad", "gradian"),
    "m": ("meter", "metre"),
    "inch": ("in", "inches"),
    "foot": ("ft", "feet"),
    "mile": ("mi",),
    "s": ("sec", "second"),
    "min": ("minute",),
    "h": ("hr", "hour"),
    "N": ("newton",),
    "lbf": ("lb",),
    "J": ("joule",),
    "W": ("watt",),
    "knot": ("kt",),
    "m/s": ("mps",),
    "km/h": ("kmh", "kph"),
    "foot/s": ("fps",),
    "inch/s": ("ips",),
    "mile/h": ("mph",),
    "rad/s": ("rads",),
    "degree/s": ("dps", "degs"),
    "revolution/s": ("rps",),
    "revolution/min": ("rpm", "r/min"),
}
"""Other spellings, in small letters, without the s of a plural."""
_PRODUCTS = ("W h", "MN m", "N m", "kN m", "mN m", "N mm", "N cm", "kg m")
"""Units that are written without their blank, too."""
_WORDS: Mapping[str, str] = {
    # For who writes everything in capitals or in small letters; MJ is a mega if it is written so.
    **{unit.lower(): unit for unit in reversed([*WORDS])},
    **{unit: unit for unit in WORDS},
    **{spelling: unit for unit, spellings in _SPELLINGS.items() for spelling in spellings},
    **{unit.replace(" ", "").lower(): unit for unit in _PRODUCTS},
    "MNm": "MN m",
    **{
        f"{prefix}{spelling}": f"{short}{unit}"
        for prefix, short in (("kilo", "k"), ("milli", "m"), ("micro", "u"), ("mega", "M"))
        for unit in ("rad", "s", "N", "J")
        for spelling in _SPELLINGS[unit]
    },
}

BRACKETS = re.compile(r"\[[^][]*\]|\([^()]*\)|(?<!\\dot)\{[^{}]*\}")
"""Brackets in a name, and what is in them; the braces of TeX's ``\\dot{\\phi}`` hold no unit."""
_NO_UNITS = ("si", "none", "n/a")
_WORD = re.compile(r"[^\W\d_]")
# That of a maneuver, or an index; not an exponent.
_NUMBER = re.compile(r"^\W*(?:m|man|maneuver|manoeuvre)?[\s_-]*[0-9]+\W*$", re.IGNORECASE)
_ONE_WORD = re.compile(r"r/min|[A-Za-z\u00b0]+")
_MARKS = str.maketrans(dict.fromkeys("[](){}") | {
    "\u00b5": "u", "\u03bc": "u", "\u2212": "-", "\u22c5": "*", "_": " ",
})  # fmt: skip
_DIVIDED = re.compile(r"\s*/\s*(\w+)")
_PER = re.compile(r"\bper\b")
_HYPHEN = re.compile(r"(?<=[A-Za-z])-(?=[A-Za-z])")
# No power of a metre or a second.
_INDEX = re.compile(r"[A-Za-z]+[0-9]+")
_BEFORE_POWER = re.compile(r" +(?=-[0-9])")
# time_s, steer_rate_deg_s, speed_m_per_s
_ENDING = re.compile(r"(.+?)_([a-z\u00b0]+(?:_(?:per_)?(?:s|h))?)")


@lru_cache(1 << 12)
def quantities(unit: str) -> Mapping[str, str]:
    """The unit, as `scoring.units` has it, by the SI unit of each quantity that it may be of."""
    text = _PER.sub("/", unit.translate(_MARKS)).strip(" .*")
    text = _BEFORE_POWER.sub("", _HYPHEN.sub(" ", text))
    if _INDEX.fullmatch(text) or not _ONE_WORD.search(text):
        return {}
    name = _ONE_WORD.sub(_word, text)
    product = _DIVIDED.sub(r" \1-1", name)
    meant = {}
    for si, usual in _QUANTITIES.items():
        if factor(name, si) is not None:
            # Other times are not converted.
            units = usual if si == "s" else (*usual, product)
            if same := [u for u in units if size(u) == size(name)]:
                meant[si] = same[0]
    return meant


def is_si(unit: str | None) -> bool:
    """True if the unit is an SI unit, or not told."""
    return unit is None or any(si == usual for si, usual in quantities(unit).items())


def unknown_unit(name: str) -> str | None:
    """Return the word in brackets in a name that stands where a unit does, if it is not known."""
    for match in BRACKETS.finditer(name):
        unit = match[0][1:-1].strip()
        # In round brackets there may be anything, such as phi(t).
        is_unit = match[0][0] != "(" or "/" in unit
        is_unit &= unit.lower() not in _NO_UNITS
        if is_unit and _WORD.search(unit) and not _NUMBER.search(unit) and not quantities(unit):
            return unit
    return None


def split_unit(name: str) -> tuple[str, str | None]:
    """Name of a column without the unit in brackets or behind a slash, and the unit.

    What is no unit is left where it is.
    """
    for match in BRACKETS.finditer(name):
        if quantities(unit := match[0][1:-1]):
            return name[: match.start()].rstrip(" /") + name[match.end() :], unit
    for mark in ("/", " in "):
        stem, found, unit = name.partition(mark)
        if found and stem.strip() and quantities(unit):
            return stem.strip(), unit.strip()
    return name, None


def _word(match: re.Match[str]) -> str:
    """A word of a unit as `numbers.unit` has it."""
    word = match[0]
    plain = word.lower()
    return next((_WORDS[x] for x in (word, plain, plain.removesuffix("s")) if x in _WORDS), word)


TIME = "time"

_TIMES = ("t", "times", "timestamp", "sec", "seconds", "simulationtime", "tout")
_KEYS: Mapping[str, str] = {**dict.fromkeys((TIME, *_TIMES), TIME), **KEYS_BY_WORD}
# What a name means in another unit than that of its usual meaning.
_BY_UNIT: Mapping[tuple[str, str], str] = {
    ("t", "J"): "kinetic_energy",
    ("v", "J"): "potential_energy",
    ("u", "m s-1"): "forward_speed",
    # A wheel's.
    **{(name, "rad s-1"): "forward_speed" for name in ("v", "u", "vx", "speed", "velocity")},
    **{(name, "rad s-1"): "roll_rate" for name in ("roll", "phi", "lean")},
    **{(name, "rad s-1"): "steer_rate" for name in ("steer", "steering", "delta")},
    **{(name, "rad s-1"): "yaw_rate" for name in ("yaw", "heading", "psi")},
}
# For values to decide, where the other names (see `meanings`) do not.
_ALSO: Mapping[str, tuple[str, ...]] = {
    "V": ("forward_speed", "potential_energy"),
    "u": ("potential_energy", "forward_speed"),
    "v": ("forward_speed", "potential_energy"),
    "p": ("roll_rate", "potential_energy"),
    **dict.fromkeys(("theta", "\u03b8"), ("pitch", "roll_angle", "steer_angle")),
}
_MANEUVERS = frozenset(
    {"man", "maneuver", "manoeuvre", "maneuvernumber", "maneuverno", "maneuverid", "maneuverindex"}
)

_MANEUVER = r"(?:m|man|maneuver|manoeuvre)"
_ONE = re.compile(r"[\[({]\s*1\s*[\])}]")
_NUMBERED = re.compile(rf"[\s_-]*{_MANEUVER}?[\s_-]*([0-9]{{1,3}})\s*")
_BREAKS = re.compile(r"[\s_.:/\\${}-]+")
_PREFIX = re.compile(rf"{_MANEUVER}_?([0-9]{{1,3}})_(.+)")
_SUFFIX = re.compile(rf"(.+?)_?(?:{_MANEUVER}_?)?([0-9]{{1,3}})")
_GROUP = re.compile(rf"{_MANEUVER}_?([0-9]{{1,3}})")
# Joints by their names, and how often the angle is differentiated.
_JOINTS: Mapping[str, tuple[str, int]] = {
    **dict.fromkeys(("roll", "rollangle", "lean", "leanangle"), ("roll", 0)),
    **dict.fromkeys(("steer", "steerangle", "steering", "steeringangle"), ("steer", 0)),
    **dict.fromkeys(("rollrate", "leanrate"), ("roll", 1)),
    **dict.fromkeys(("steerrate", "steeringrate"), ("steer", 1)),
}
_IS_ANGLE = frozenset({"phi", "q", "angle", "value"})
_IS_RATE = frozenset({"w", "qd", "omega", "speed", "rate"})

_STEPS = re.compile(r"[./|]")
_DERIVATIVE = re.compile(r"der\((.+)\)")
# What kind of joint it is, beside which one it is.
_KIND = re.compile(r"revolute|rev|joint|hinge|pin|_")
# An axis of a joint that could have several.
_AXIS = re.compile(r"r[xyz]")
# The names of a message; more would not be read.
_SHOWN = 8
# Shorter names are like too many others.
_SHORTEST = 5
LIKE = 0.63
"""Names so much alike may mean the same: `Rollwinkel` and `roll_angle` are just so."""
ALMOST = 0.85
"""Names that were misspelt are so much alike."""


# The names of a file are asked for many times.
@lru_cache(1 << 17)
def recognise(name: str, *, one_is_a_unit: bool = True) -> tuple[str, int | None] | None:
    """Key of the column that a name means, and number of the maneuver if it has one.

    Case, blanks, hyphens and underscores do not matter. A unit, in brackets or at the end, decides
    where a name alone would mean another column (``V [J]``); there 1 is that of a column without
    dimension, or the first maneuver.
    """
    if one_is_a_unit and _ONE.search(name):
        found = recognise(_ONE.sub("", name))
        if found and found[0] != TIME and COMPARED[found[0]][0].unit == "1":
            return found
    stem, unit, is_ending = unit_in(name)
    word, key, number = _by_words(stem)
    if key is None:
        key, number = _of_joint(stem), group_number(stem.partition(".")[0])
    if key is not None and unit is not None:
        key = _in_unit(word, key, unit, is_ending)
    if key is None or (key == TIME and number is not None):
        return None
    return key, number


def is_time(name: str) -> bool:
    """True if the name is that of the times."""
    return recognise(name) == (TIME, None)


def time_among(names: Sequence[str]) -> int:
    """Place of the times among the columns of these names: the first if none is theirs."""
    return next((i for i, name in enumerate(names) if is_time(name)), 0)


def unit_in(name: str) -> tuple[str, str | None, bool]:
    """The name without its unit, that unit, and whether it is an ending such as ``_rad``."""
    stem, unit = split_unit(name)
    # MATLAB makes underscores of brackets.
    match = _ENDING.fullmatch(name.strip().lower().rstrip("_"))
    if unit is None and match and _by_words(name)[1] is None:
        ending = match[2].replace("_per_", "/").replace("_", "/")
        if quantities(ending):
            return match[1], ending, True
    return stem, unit, False


def named_unit(name: str, key: str) -> str | None:
    """The unit that the name of a column tells, if the column can have it, as `units` has it."""
    unit = unit_in(name)[1]
    return None if unit is None else quantities(unit).get(COMPARED[key][0].unit)


def _by_words(name: str) -> tuple[str, str | None, int | None]:
    """The word for the column, its key if it is known, and the number of the maneuver."""
    plain = _BREAKS.sub("_", BRACKETS.sub(_number_in_brackets, name.lower())).strip("_\"'")
    number = None
    if match := _PREFIX.fullmatch(plain):
        number, plain = int(match[1]), match[2]
    elif plain.replace("_", "") not in _KEYS and (match := _SUFFIX.fullmatch(plain)):
        plain, number = match[1], int(match[2])
    word = plain.replace("_", "")
    return word, _KEYS.get(word), number


def _in_unit(word: str, key: str, unit: str, is_strict: bool) -> str | None:
    """Return the key that a word means with a unit; None if no column of that name has it."""
    possible = quantities(unit)
    if not possible or ("s" if key == TIME else COMPARED[key][0].unit) in possible:
        return key
    other = next((k for (w, q), k in _BY_UNIT.items() if w == word and q in possible), None)
    # Of a full name and its unit, the unit is more likely to be the one that is wrong.
    is_full = word == key.replace("_", "")
    return other or (key if is_full and not is_strict else None)


def _of_joint(name: str) -> str | None:
    """The column that the name of a joint's angle or rate means; None if it is no such name."""
    path = name.lower().strip(" \"'")
    if derived := _DERIVATIVE.fullmatch(path):
        path = derived[1]
    steps = [step for step in _STEPS.split(path) if step and not _AXIS.fullmatch(step)]
    if not steps or (len(steps) == 1 and not derived):
        return None
    *way, last = steps
    is_part = way and last in _IS_ANGLE | _IS_RATE
    joint, order = _JOINTS.get(_KIND.sub("", way[-1] if is_part else last), ("", 2))
    order += (derived is not None) + (last in _IS_RATE)
    # The second derivative is an acceleration.
    return f"{joint}_{('angle', 'rate')[order]}" if order < 2 else None


def may_mean(name: str) -> tuple[str, ...]:
    """Return all keys that a name may mean, for values to decide; none if it means one thing."""
    return _ALSO.get(name.strip(" \"'"), ())


def told(columns: Sequence[str], option: str) -> tuple[str, ...]:
    """The names that columns were said to have.

    Raises
    ------
    InputError
        A name that is not known, or no time.
    """
    names = tuple(name.strip() for name in columns)
    where = option.rstrip("=")
    found = []
    for name in names:
        known = recognise(name)
        if known is None and name not in LEFT_OUT and not is_maneuver(name):
            raise InputError(
                f"{where}: found {quoted(name)}, expected {NAMES}, a column of motion.h5, a short "
                f"name such as t, phi, v or delta, or - for one that is left out"
                f"{did_you_mean(name)}"
            )
        if known is not None:
            found.append(known[0])
    if TIME not in found or len(found) < 2:
        raise InputError(f"{where}: found no time and another column, expected both among them")
    return names


def is_maneuver(name: str) -> bool:
    """True if a column of this name tells the maneuver of each row."""
    return _BREAKS.sub("", name.lower()).strip("\"'[]()#") in _MANEUVERS


@lru_cache(1 << 10)
def nearest(name: str, like: float = LIKE) -> str | None:
    """The known column whose name is most like another one; None if none is."""
    from difflib import get_close_matches

    word = _by_words(split_unit(name)[0])[0]
    if len(word) < _SHORTEST:
        return None
    close = get_close_matches(word, [k for k in _KEYS if len(k) >= _SHORTEST], 1, like)
    return _KEYS[close[0]] if close else None


def did_you_mean(name: str) -> str:
    """Return the end of a message about a name; nothing if no known column has one like it."""
    like = nearest(name)
    return f"; did you mean {like}?" if like else ""


def group_number(name: str) -> int | None:
    """Number in the name of a group of columns (``maneuver_2``), if it is one."""
    match = _GROUP.fullmatch(_BREAKS.sub("_", name.lower()))
    return int(match[1]) if match else None


def are_names(names: Sequence[str], request: Request) -> bool:
    """True if the names have the time and another column that is known, or what is asked for."""
    if request.known is not None:
        return any(map(request.known, names))
    known = {found[0] for name in names if (found := recognise(name))}
    return TIME in known and len(known) > 1


def left_out(names: Sequence[str], request: Request) -> NotCompared:
    """Return the evidence that columns of unknown names are not used."""
    columns = tuple(LostColumn(name, *name_held(name, request)) for name in names)
    return NotCompared(Reason.UNKNOWN_NAME, columns, request.how_to_tell)


def set_aside(
    names: Sequence[str], request: Request, reason: Reason = Reason.SET_ASIDE
) -> NotCompared:
    """Return the evidence that columns are not used although their names are known."""
    columns = []
    for name in names:
        found = recognise(name)
        key = None if found is None else found[0]
        is_letter = bool(_letter(split_unit(name)[0]))
        columns.append(LostColumn(name, key, _maneuver_in_words(name, request), is_letter))
    return NotCompared(reason, tuple(columns), request.how_to_tell)


def _maneuver_in_words(name: str, request: Request) -> int | None:
    """The maneuver that a name says in words; else that of its part of the file."""
    match = _IN_WORDS.search(name.lower())
    return request.group if match is None else int(match[1])


def name_held(name: str, request: Request) -> tuple[str | None, int | None]:
    """Return the key of the quantity whose name an unknown name holds, and its maneuver.

    ``field.forward_speed`` and ``roll_rate [\u00ba/s]`` hold one, as ``roll_angle_setpoint`` does.
    A name of one word is held only if it is the last step of a path (``bike.speed``): a
    ``wheel_speed`` is another quantity.

    Returns
    -------
    key, maneuver
        None where nothing is held, or where the maneuver is not told.
    """
    plain = name.partition("[")[0].partition("(")[0]
    steps = [step for step in _PATH.split(plain) if step.strip()] or [""]
    last = "".join(_TOKENS.findall(steps[-1])).lower()
    key = _KEYS.get(last) if len(last) > 1 else None
    words = [word.lower() for step in steps for word in _TOKENS.findall(step)]
    runs = ("".join(words[i:j]) for i in range(len(words)) for j in range(i + 1, i + 5))
    key = key or next((_KEYS[run] for run in runs if run in _KEYS and _COMPOUND.search(run)), None)
    if key is None or key == TIME:
        return None, None
    return key, _maneuver_in_words(name, request)


def unknown_units(names: Mapping[str, str]) -> list[UnknownUnit]:
    """Return the unknown units in the names of columns, here with their keys; not too many."""
    found = ((name, unknown_unit(name), key) for name, key in names.items())
    return [UnknownUnit(name, unit, key) for name, unit, key in found if unit is not None][:_SHOWN]


def listed(names: Sequence[str], like: float | None = None) -> str:
    """List some of the names in quotes, each with a known name that is so much like it."""
    found = [
        None if like is None or recognise(name) else nearest(name, like) for name in names[:_SHOWN]
    ]
    shown = ", ".join(
        f"{quoted(name)} ({near}?)" if near else quoted(name)
        for name, near in zip(names, found, strict=False)
    )
    more = len(names) - _SHOWN
    return f"{shown} and {more} more" if more > 0 else shown


def names_found(names: Sequence[str], found: Sequence[object] | None = None) -> str:
    """Return words that say that too few of the names are known, or mean what is found."""
    known = [recognise(name) for name in names] if found is None else found
    unknown = [name for name, k in zip(names, known, strict=True) if not k]
    if unknown:
        return f"column names {listed(unknown, LIKE)} not understood"
    if not names:
        return "no column whose name is known"
    has_time = any(k and k[0] == TIME for k in map(recognise, names))
    return f"column names {listed(names)}{'' if has_time else ' without their times'}"


def _number_in_brackets(match: re.Match[str]) -> str:
    number = _NUMBERED.fullmatch(match[0][1:-1])
    return f"_{number[1]}" if number else ""


Found = tuple[str, int | None] | None
"""Key of a column and number of its maneuver; None if it is not known."""

_ENERGY = "J"
# The small letters, what the capital means alone, and what beside one of these.
_CAPITALS: Mapping[str, tuple[str, str, str]] = {
    "V": ("vu", "forward_speed", "potential_energy"),
    "T": ("t", TIME, "kinetic_energy"),
}
_ENERGIES = frozenset({"T", "H", "kinetic_energy", "potential_energy", "mechanical_energy"})
_COORDINATE = "q"
# One letter, and perhaps a number.
_LETTER = re.compile(r"\W*([^\W\d_])[\W_]*[0-9]*\W*")
_IN_WORDS = re.compile(r"(?<![a-z])(?:m|man|maneuver|manoeuvre)[\s_.:-]*([0-9]{1,3})")
# What separates the steps of a path, and the words of a step: roll_angle, rollAngle.
_PATH = re.compile(r"[./|:\\]+")
_TOKENS = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
# The end of a name that says what kind of quantity it is, behind whose it is.
_COMPOUND = re.compile(r".(?:angle|rate|velocity|speed|energy|dot)$")


def meanings(names: Sequence[str], count: int) -> list[Found]:
    """Find the meaning of each column of a file.

    Parameters
    ----------
    names
        Of all its columns.
    count
        Number of maneuvers of the reference.

    Returns
    -------
    list of (str, int or None) or None
        Key, and number of the maneuver if that is told; None if the name is not known, or if what
        it means alone cannot be meant beside the others.
    """
    # With other numbers in brackets, all of them are maneuvers.
    brackets = [x[1:-1] for name in names for x in BRACKETS.findall(name)]
    are_numbers = any(b.strip().isdecimal() and int(b) != 1 for b in brackets)
    found: list[Found] = [recognise(name, one_is_a_unit=not are_numbers) for name in names]
    found = _apart(names, _with_capitals(names, found))
    found = _without_speeds(names, _from_one(found, count))
    found = _without_indices(names, found, count)
    if not any(f and f[1] is not None for f in found):
        return _in_turn(found, count)
    # Beside numbered columns one without a number tells nothing, and no reference has others.
    numbers = range(1, count + 1)
    return [f if f and (f[0] == TIME or f[1] in numbers) else None for f in found]


def is_coordinate(name: str) -> bool:
    """True if a column of this name is a coordinate, so that the u beside it is its speed."""
    return _letter(split_unit(name)[0]) == _COORDINATE


def _letter(stem: str) -> str:
    """The letter that a name is but for a number; empty if it is a word."""
    match = _LETTER.fullmatch(stem)
    return match[1].lower() if match else ""


def _with_capitals(names: Sequence[str], found: list[Found]) -> list[Found]:
    """Meanings with T and V as energies, as mechanics writes them beside a time and a speed.

    They are where t and v stand beside them, or where each is a second column of its meaning and
    other energies are there.
    """
    split = [(stem.strip(), unit) for stem, unit in map(split_unit, names)]
    plain = [stem if unit is None else "" for stem, unit in split]
    others = [f for name, f in zip(plain, found, strict=True) if f and name not in _CAPITALS]
    meant = list(found)
    for name, (small, alone, energy) in _CAPITALS.items():
        is_second = (alone, None) in others and (energy, None) not in others
        words = {*plain, *(f[0] for f in meant if f)} - {name, energy}
        if any(stem in [*small] for stem, _ in split) or (is_second and words & _ENERGIES):
            meant = [(energy, None) if x == name else f for x, f in zip(plain, meant, strict=True)]
    return meant


def _apart(names: Sequence[str], found: list[Found]) -> list[Found]:
    """Meanings in which an ambiguous small letter means what no other column does."""
    apart = list(found)
    for i, (name, f) in enumerate(zip(names, found, strict=True)):
        keys = may_mean(name)
        if f and f[0] in keys and apart.count(f) > 1 and name not in _CAPITALS:
            apart[i] = next(((k, f[1]) for k in keys if (k, f[1]) not in apart), f)
    return apart


def _from_one(found: list[Found], count: int) -> list[Found]:
    """Meanings with maneuvers counted from 1, where every column counts from 0.

    Instead of 0 the first of all may have none: so pandas makes equal names differ.
    """
    numbers = grouped((key, number) for _, key, number in _columns(found)).values()
    are_from_zero = all(0 in n for n in numbers)
    are_of_pandas = count > 1 and all({*n} == {None, *range(1, count)} for n in numbers)
    if not (are_from_zero or are_of_pandas):
        return found
    return [f if f is None or f[0] == TIME else (f[0], (f[1] or 0) + 1) for f in found]


def _without_speeds(names: Sequence[str], found: list[Found]) -> list[Found]:
    """Meanings in which u beside coordinates q is a speed, and no potential energy."""
    if not any(map(is_coordinate, names)):
        return found
    units = [split_unit(name) for name in names]
    are_speeds = [_letter(x) == "u" and not (u and _ENERGY in quantities(u)) for x, u in units]
    return [None if is_speed else f for f, is_speed in zip(found, are_speeds, strict=True)]


def _without_indices(names: Sequence[str], found: list[Found], count: int) -> list[Found]:
    """Meanings without columns whose numbers are not those of maneuvers."""
    every = set(range(1, count + 1)) if count > 1 else None
    stems = [split_unit(name)[0].lower() for name in names]
    columns = [(i, key, number, bool(_letter(stems[i]))) for i, key, number in _columns(found)]
    plain = {key for _, key, number, _ in columns if number is None}
    numbered = grouped(((key, x), (i, n)) for i, key, n, x in columns if n is not None)
    of_words = {n for _, _, n, is_letter in columns if n is not None and not is_letter}
    kept = []
    for (_, is_letter), group in numbered.items():
        own = {n for _, n in group}
        # That of a letter is one if those of words are, or if its own are those of all maneuvers.
        if not is_letter or own <= of_words or (own == every and not plain):
            kept.append(group)
    trusted = {i for group in kept for i, _ in group}
    are_most = every in [{n for _, n in group} for group in kept] or len(kept) > len(plain)
    if plain and not are_most and not any(_IN_WORDS.search(stems[i]) for i in trusted):
        trusted = set()
    out = {i for group in numbered.values() for i, _ in group} - trusted
    return [None if i in out else f for i, f in enumerate(found)]


def _in_turn(found: list[Found], count: int) -> list[Found]:
    """The eight names once for each maneuver mean the maneuvers in order."""
    keys = [f[0] if f else None for f in found]
    times = {keys.count(key) for key in keys if key not in (None, TIME)}
    if count == 1 or times != {count} or keys.count(TIME) != 1:
        return found
    return [
        f if f is None or f[0] == TIME else (f[0], 1 + keys[:i].count(f[0]))
        for i, f in enumerate(found)
    ]


def _columns(found: Sequence[Found]) -> list[tuple[int, str, int | None]]:
    """Index, key and number of the columns that are known, but for the time."""
    return [(i, *f) for i, f in enumerate(found) if f and f[0] != TIME]
