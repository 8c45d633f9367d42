"""Log of the package: messages about its work, shown on request.

The loggers of `logging` are called like the modules, below ``heyoka_bike``. INFO is what is done,
DEBUG why so; a warning is none of them, it stands in the result.
"""

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from heyoka_bike.errors import InputError, unknown_word

VARIABLE = "HEYOKA_BIKE_LOG"
_LEVELS = {"info": logging.INFO, "debug": logging.DEBUG}
_LOGGER_NAME = "heyoka_bike"


@contextmanager
def shown(level: str) -> Iterator[None]:
    """Print it on standard error inside the ``with``, that of the processes of workers too.

    Parameters
    ----------
    level
        ``info`` or ``debug``.

    Raises
    ------
    InputError
        Another level.
    """
    if level not in _LEVELS:
        raise InputError(f"{VARIABLE}: {unknown_word(level, list(_LEVELS))}")
    logger = logging.getLogger(_LOGGER_NAME)
    before, given = logger.level, os.environ.get(VARIABLE)
    # Processes that begin inside inherit it.
    os.environ[VARIABLE] = level
    handler = _Printed()
    logger.addHandler(handler)
    logger.setLevel(_LEVELS[level])
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(before)
        if given is None:
            del os.environ[VARIABLE]
        else:
            os.environ[VARIABLE] = given


def fault(error: BaseException) -> str:
    """Return kind and place of an error, and nothing of the contents or names of files."""
    place = error.__traceback__
    if place is None:
        return type(error).__name__
    while place.tb_next is not None:
        place = place.tb_next
    file = Path(place.tb_frame.f_code.co_filename).name
    return f"{type(error).__name__} at {file}:{place.tb_lineno}"


class _Printed(logging.Handler):
    """A line on standard error, whatever that is by then: bars put another in its place."""

    def emit(self, record: logging.LogRecord) -> None:
        where = record.name.removeprefix(f"{_LOGGER_NAME}.")
        said = f"{record.relativeCreated / 1000:8.2f} s  {where}: {record.getMessage()}"
        print(said, file=sys.stderr, flush=True)


def complain(line: str) -> None:
    """Print one line on standard error."""
    print(f"heyoka-bike: {' '.join(line.split())}", file=sys.stderr)
