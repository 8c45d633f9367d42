"""Choice of a measured accuracy of a code for one that is asked for."""

from collections.abc import Iterable

from heyoka_bike.errors import InputError


def choose(accuracy: str | float, measured: Iterable[str | float]) -> str | float:
    """The accuracy itself, or the loosest number that is no larger.

    Raises
    ------
    InputError
        There is none.
    """
    known = list(measured)
    if accuracy in known:
        return accuracy
    if not isinstance(accuracy, str):
        passing = [x for x in known if not isinstance(x, str) and x <= accuracy]
        if passing:
            return max(passing)
    raise InputError(
        f"found accuracy {accuracy}, expected 'eq1', 'roundoff' or a number of 1e-13 or more; "
        "integrate() goes further"
    )
