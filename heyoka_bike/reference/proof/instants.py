"""Single states of a bicycle: every quantity, correctly rounded with proof.

A state consists of exact numbers, so ball arithmetic on exact inputs gives every quantity. A value
is the binary64 nearest to every number of its ball; a ball that does not decide the rounding is an
error. A dataset contains the known states of the benchmark's bicycle as states.csv and states.h5.
Their coordinates are exactly the decimals written there, so everything else can be proved again
from them.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cache, lru_cache, partial
from math import nan
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.instant import Instant, linear_quantities, quantities
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS, NonnegativeRoots
from heyoka_bike.bicycle.instant_columns import COORDINATES, UNITS, WHERE
from heyoka_bike.bicycle.parameters import START, Bicycle, Maneuver, read_maneuvers
from heyoka_bike.bicycle.stability.linear import matrices
from heyoka_bike.errors import BicycleError, UndecidedError
from heyoka_bike.numbers.arithmetic import Number, exact_ball
from heyoka_bike.numbers.double import Array
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.numbers.rounding import Enclosure
from heyoka_bike.reference import hdf5, structure
from heyoka_bike.reference.description import about
from heyoka_bike.reference.layout import STATES, STATES_HDF5
from heyoka_bike.system.resources import find_input

BITS = 256
"""Precision of the balls. A value below 2^-_NOTHING whose ball contains zero is rounded to zero."""

_NOTHING = 160
_KEYS_OF_START = {
    "roll": "roll_angle", "steer": "steer_angle", "roll_rate": "roll_rate",
    "steer_rate": "steer_rate", "speed": "forward_speed",
}  # fmt: skip
_DECIMAL = re.compile(r"-?[0-9]{1,17}(\.[0-9]{1,17})?(e-?[0-9]{1,2})?")
_ONE_SECOND = Fraction(1)


def known_states() -> tuple[Maneuver, ...]:
    """Return the states of states.csv as maneuvers, whose values are exact; numbered from 1."""
    return read_maneuvers(find_input("maneuvers", "states"))


def of_known(bicycle: Bicycle, states: Sequence[Maneuver]) -> dict[str, Array]:
    """Return coordinates and quantities of states by name, correctly rounded to binary64.

    An undefined quantity is NaN: a multiple eigenvalue, or the friction demand without a force.

    Raises
    ------
    UndecidedError
        A ball does not decide a rounding.
    InputError
        No pitch puts both wheels on the floor.
    """
    return dict(_of_known(tuple(bicycle.values.items()), tuple(states)))


@lru_cache(8)
def _of_known(
    parameters: tuple[tuple[str, Exact], ...], states: tuple[Maneuver, ...]
) -> Mapping[str, Array]:
    bicycle = Bicycle("", dict(parameters))
    balls = NonnegativeRoots(BITS)
    equations = Equations.of(bicycle, balls)
    rows = []
    with balls.precision():
        linear = linear_by_speed(bicycle)
        for state in states:
            start = initial_state(equations, state)
            instant = Instant.of(equations, [*start, *[balls.number(0)] * len(INTEGRALS)])
            given = {_KEYS_OF_START[key]: balls.number(getattr(state, key)) for key in START}
            found = {**given, **dict.fromkeys(WHERE, balls.number(0)), **quantities(instant)}
            found |= linear(state.speed.fraction())
            rows.append([_nearest(x, f"{state.name}: {name}") for name, x in found.items()])
    return dict(zip(found, np.array(rows).T, strict=True)) if rows else {}


def as_csv(bicycle: Bicycle, states: Sequence[Maneuver]) -> bytes:
    """Return the table of `of_known` as CSV; each value reads back as the same binary64."""
    table = _texts(of_known(bicycle, states))
    heading = (f"{name} [{UNITS[name]}]" if name in UNITS else name for name in table)
    rows = zip(*table.values(), strict=True)
    return "".join(",".join(row) + "\n" for row in (heading, *rows)).encode()


def render_states(bicycle: Bicycle, inputs: Mapping[str, Any], version: str) -> dict[str, bytes]:
    """Return the files of a dataset that contain the known states.

    Parameters
    ----------
    bicycle
    inputs
        Inputs as in the manifest.
    version
        Version of the dataset.
    """
    states = known_states()
    table = of_known(bicycle, states)
    layout = structure.states(about(STATES_HDF5, inputs, version), len(states))
    numbers = np.arange(1, len(states) + 1)
    return {
        STATES: as_csv(bicycle, states),
        STATES_HDF5: hdf5.render(layout, {"state": numbers, **table}),
    }


def states_differ(name: str, raw: bytes, bicycle: Bicycle) -> Iterator[str]:
    """Yield the differences of a file of states from the proved values, as text."""
    found = _read_csv(raw) if name == STATES else _read_hdf5(raw)
    coordinates = zip(*(found.get(key, ()) for key in COORDINATES), strict=True)
    try:
        states = tuple(_state(i, x) for i, x in enumerate(coordinates, start=1))
        expected = _texts(of_known(bicycle, states))
    except (BicycleError, ValueError) as e:
        yield f"the states cannot be used: {e}"
        return
    if list(found) != list(expected):
        yield f"found the columns {', '.join(found):.80}, expected {', '.join(expected):.80}"
        return
    for key, right in expected.items():
        for i, (x, y) in enumerate(zip(found[key], right, strict=True), start=1):
            if x != y:
                yield f"state {i}: {key}: found {x:.40}, proved {y}"


def _state(number: int, coordinates: Iterable[str]) -> Maneuver:
    """Construct a state from decimal texts in the order of `COORDINATES`."""
    given = dict(zip(_KEYS_OF_START, coordinates, strict=True))
    for text in given.values():
        if not _DECIMAL.fullmatch(text):
            raise ValueError(f"state {number}: found {text!r:.40}, expected a decimal")
    exact: dict[str, Any] = {key: Exact(Fraction(text)) for key, text in given.items()}
    return Maneuver(f"state {number}", duration=_ONE_SECOND, spacing=_ONE_SECOND, **exact)


def _texts(table: Mapping[str, Array]) -> dict[str, list[str]]:
    """Return the columns of states.csv as texts, by names without units."""
    texts = {name: [repr(float(x)) for x in values] for name, values in table.items()}
    count = max(map(len, texts.values()), default=0)
    return {"state": [str(i + 1) for i in range(count)], **texts}


def _read_csv(raw: bytes) -> dict[str, list[str]]:
    heading, *lines = raw.decode("ascii").removesuffix("\n").split("\n")
    names = [name.removesuffix(f" [{UNITS.get(name.partition(' ')[0])}]")
             for name in heading.split(",")]  # fmt: skip
    columns = zip(*(line.split(",") for line in lines), strict=True)
    return {name: list(column) for name, column in zip(names, columns, strict=True)}


def _read_hdf5(raw: bytes) -> dict[str, list[str]]:
    with hdf5.opened(raw) as f:
        return {name: [repr(x) for x in f[name][:].tolist()] for name in f if f[name].ndim == 1}


def linear_by_speed(bicycle: Bicycle) -> Callable[[Fraction], dict[str, flint.arb]]:
    """Return a function from speed [m/s] to the quantities of the last level, as balls."""
    g = exact_ball(bicycle["g"].rational)
    return cache(partial(linear_quantities, matrices(bicycle, NonnegativeRoots(BITS)), g))


def _nearest(x: Number, name: str) -> float:
    if isinstance(x, int):
        return float(x)
    if not x.is_finite():
        return nan
    enclosed = Enclosure.of(x)
    if enclosed.holds_zero and enclosed.size() <= Fraction(1, 2**_NOTHING):
        return 0.0
    nearest = enclosed.binary64()
    if nearest is None:
        raise UndecidedError(f"{name}: {BITS} bits do not decide its nearest binary64")
    return nearest
