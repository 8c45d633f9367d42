"""Log of the package: messages about its steps, shown on request.

The loggers of `logging` have the names of the modules, below ``heyoka_bike``. INFO messages state
the steps, DEBUG messages the reasons. Warnings are not logged; they are part of results.
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
    """Print the log, also that of worker processes, on standard error inside the ``with``.

    Parameters
    ----------
    level
        ``info`` or ``debug``.

    Raises
    ------
    InputError
        The level is unknown.
    """
    if level not in _LEVELS:
        raise InputError(f"{VARIABLE}: {unknown_word(level, list(_LEVELS))}")
    logger = logging.getLogger(_LOGGER_NAME)
    before, given = logger.level, os.environ.get(VARIABLE)
    # Processes that are started inside the block inherit this environment variable.
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
    """Return the type of an error and its line of code, but nothing from the user's files."""
    place = error.__traceback__
    if place is None:
        return type(error).__name__
    while place.tb_next is not None:
        place = place.tb_next
    file = Path(place.tb_frame.f_code.co_filename).name
    return f"{type(error).__name__} at {file}:{place.tb_lineno}"


class _Printed(logging.Handler):
    """Prints lines on the current standard error, which a progress bar may have replaced."""

    def emit(self, record: logging.LogRecord) -> None:
        where = record.name.removeprefix(f"{_LOGGER_NAME}.")
        said = f"{record.relativeCreated / 1000:8.2f} s  {where}: {record.getMessage()}"
        print(said, file=sys.stderr, flush=True)


def complain(line: str) -> None:
    """Print one line on standard error."""
    print(f"heyoka-bike: {' '.join(line.split())}", file=sys.stderr)
