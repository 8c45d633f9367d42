"""The origin of a report: when and how it was made, and with which reference."""

import os
import shlex
from collections.abc import Sequence
from datetime import UTC, datetime

from heyoka_bike.errors import printable
from heyoka_bike.version import __version__


def origin(words: Sequence[str] | None = None) -> list[tuple[str, str]]:
    """Return when and with which command a report is made, as pairs of a name and a text.

    The variable ``SOURCE_DATE_EPOCH`` sets another time [s since 1970], so that a report can be
    reproduced byte for byte (https://reproducible-builds.org/specs/source-date-epoch/).

    Parameters
    ----------
    words
        Words of the command line after the name of the program; None without a command.
    """
    given = os.environ.get("SOURCE_DATE_EPOCH", "")
    is_date = given.isascii() and given.isdigit() and len(given) <= 10
    now = datetime.fromtimestamp(int(given), UTC) if is_date else datetime.now(UTC)
    made = [("made", f"{now:%Y-%m-%d %H:%M} UTC")]
    if words is not None:
        made.append(("command", printable(shlex.join(("heyoka-bike", *words)))))
    return made


def reference_words(bicycle: str, dataset_version: str, sha256: str = "") -> list[tuple[str, str]]:
    """Return the program version and the reference of a report, as pairs of a name and a text."""
    said = f"{printable(bicycle)}, data {printable(dataset_version)}"
    content = f", content sha256 {sha256}" if sha256 else ""
    return [("by", f"heyoka_bike {__version__}"), ("reference", said + content)]
