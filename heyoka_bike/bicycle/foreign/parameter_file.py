"""Parameter files of BicycleParameters: lines such as ``IBxx = 9.2+/-0.1`` or ``IBxx: 9.2``.

Their symbols, units and axes are those of the benchmark.
"""

import re

from heyoka_bike.bicycle.foreign.foreign_bicycle import ForeignBicycle
from heyoka_bike.bicycle.parameters import PARAMETERS
from heyoka_bike.errors import InputError, did_you_mean, quoted
from heyoka_bike.numbers.exact import Exact

_LINE = re.compile(r"\s*(?P<symbol>[A-Za-z]\w*)\s*[=:,]\s*(?P<value>.*?)\s*")
_POSITIVE = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_VALUE = re.compile(rf"(?P<value>[-+]?{_POSITIVE})(?:\s*\+/-\s*(?P<uncertainty>{_POSITIVE}))?")
# The package uncertainties writes small values in this form: (3.0+/-0.1)e-05.
_SCALED = re.compile(r"\((?P<both>[^()]*)\)(?P<power>[eE][-+]?\d+)")
_NOT_OF_THE_BICYCLE = ("v",)


def read(text: str, file: str) -> ForeignBicycle:
    """Read the parameters of a bicycle from the text of a file.

    Raises
    ------
    InputError
        A line has another form, or a parameter is missing or occurs twice.
    """
    found = ForeignBicycle()
    lines: dict[str, int] = {}
    for number, whole in enumerate(text.splitlines(), start=1):
        line, _, _ = whole.partition("#")
        if not line.strip():
            continue

        def refuse(message: str, at: int = 0, number: int = number) -> InputError:
            return InputError(message, file=file, line=number, column=at + 1)

        parts = _LINE.fullmatch(line)
        if parts is None:
            raise refuse(
                f"found {quoted(line.strip())}, expected a line such as 'IBxx = 9.2+/-0.1'"
            )
        symbol, value = parts["symbol"], parts["value"]
        if symbol in _NOT_OF_THE_BICYCLE:
            found.notes.append(f"{symbol} is left out: it is not a parameter of the bicycle")
            continue
        if symbol not in PARAMETERS:
            guess = did_you_mean(symbol, PARAMETERS)
            raise refuse(f"found unknown parameter {quoted(symbol)}{guess}", parts.start("symbol"))
        if symbol in lines:
            raise refuse(f"found {symbol} again, after line {lines[symbol]}, expected it once")
        lines[symbol] = number
        scaled = _SCALED.fullmatch(value)
        both = _VALUE.fullmatch(scaled["both"] if scaled else value)
        if both is None:
            raise refuse(
                f"{symbol}: found {quoted(value)}, expected a number, or one +/- its standard "
                "deviation",
                parts.start("value"),
            )
        power = f" * 1{scaled['power']}" if scaled else ""
        try:
            found.values[symbol] = Exact.parse(both["value"] + power)
            if both["uncertainty"]:
                found.uncertainties[symbol] = Exact.parse(both["uncertainty"] + power)
        except ValueError as e:
            raise refuse(f"{symbol}: {e}", parts.start("value")) from None
    missing = [symbol for symbol in PARAMETERS if symbol not in found.values]
    if missing:
        raise InputError(
            f"found no {', '.join(missing)}, expected all {len(PARAMETERS)} parameters", file=file
        )
    return found
