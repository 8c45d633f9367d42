"""Read a file of another program to the 26 parameters, and write them as TOML."""

from __future__ import annotations

import json
import stat
from dataclasses import dataclass
from pathlib import Path

from heyoka_bike.bicycle.foreign import model_file, parameter_file
from heyoka_bike.bicycle.foreign.foreign_bicycle import ForeignBicycle
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, benchmark
from heyoka_bike.errors import InputError, printable
from heyoka_bike.numbers.exact import Exact, shortest_decimal

_MAX_BYTES = 1_000_000
_DIGITS = 17


@dataclass(frozen=True)
class Imported:
    """A bicycle read from a file of another program.

    Attributes
    ----------
    bicycle : Bicycle
        The bicycle, with uncertainties and warnings.
    notes : tuple of str
        Content of the file that the parameters cannot represent, and assumptions.
    source
        The file.
    """

    bicycle: Bicycle
    notes: tuple[str, ...]
    source: str

    def toml(self) -> str:
        """Return the bicycle as the text of a TOML file that `read_bicycle` can read."""
        lines = [f"name = {_quoted(self.bicycle.name)}", f"source = {_quoted(self.source)}", ""]
        lines += ["# Axes: x forward, y to the right, z down, from the rear contact point.", ""]
        lines += ["[parameters]"]
        for symbol, p in PARAMETERS.items():
            entry = [f'value = "{_decimal(self.bicycle[symbol])}"']
            if symbol in self.bicycle.uncertainties:
                entry.append(f'uncertainty = "{_decimal(self.bicycle.uncertainties[symbol])}"')
            entry += [f'unit = "{p.unit}"', f'name = "{p.description}"']
            lines.append(f"{symbol:<4} = {{ {', '.join(entry)} }}")
        return "\n".join(lines) + "\n"


def import_bicycle(path: str | Path) -> Imported:
    """Read a bicycle from a file of BicycleParameters, URDF, SDFormat or MJCF.

    Raises
    ------
    InputError
        The file cannot be read, has another format, or does not describe a bicycle; the message has
        file, line and column.
    """
    file = Path(path)
    text = _text(file)
    is_xml = text.lstrip().startswith("<")
    found: ForeignBicycle = (model_file if is_xml else parameter_file).read(
        text, printable(str(path))
    )
    try:
        bicycle = benchmark()[0].replace(**found.values)
    except InputError as e:
        raise InputError(e.message, file=printable(str(path))) from None
    name = printable(found.name or file.stem)[:100].strip() or "bicycle"
    renamed = Bicycle(name, bicycle.values, bicycle.warnings, found.uncertainties)
    return Imported(renamed, tuple(found.notes), f"read from {printable(file.name)}")


def _text(path: Path) -> str:
    shown = printable(str(path))
    expected = "expected a parameter file, URDF, SDFormat or MJCF"
    try:
        is_file = stat.S_ISREG(path.stat().st_mode)
        raw = b""
        if is_file:
            with path.open("rb") as file:
                raw = file.read(_MAX_BYTES + 1)
    except (OSError, ValueError) as e:
        reason = e.strerror if isinstance(e, OSError) and e.strerror else str(e)
        raise InputError(f"cannot be read ({reason}), {expected}", file=shown) from None
    if not is_file:
        raise InputError(f"found a folder, pipe or device, {expected}", file=shown)
    if len(raw) > _MAX_BYTES:
        raise InputError(f"found more than {_MAX_BYTES} bytes, {expected}", file=shown)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as e:
        line = raw.count(b"\n", 0, e.start) + 1
        raise InputError(
            f"found a byte that is not UTF-8, {expected}", file=shown, line=line
        ) from None


def _decimal(x: Exact) -> str:
    return shortest_decimal(x.rational, _DIGITS) if x.is_rational else str(x)


def _quoted(text: str) -> str:
    """Return a text as a TOML basic string: a JSON string with DEL escaped, no lone surrogates."""
    whole = text.encode("utf-8", "replace").decode("utf-8")
    return json.dumps(whole, ensure_ascii=False).replace("\x7f", "\\u007f")
