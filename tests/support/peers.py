"""Import of the modules next to the programs of the field, in ``data/peers``.

Their folder is on the path only temporarily. It contains folders with names of packages, which
would be imported if such a package is not installed.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from heyoka_bike.system.resources import data_folder

PEERS = data_folder() / "peers"


@contextmanager
def on_path() -> Iterator[None]:
    """Put the folder on the path, also for processes that are started meanwhile."""
    sys.path.insert(0, str(PEERS))
    try:
        yield
    finally:
        sys.path.remove(str(PEERS))


with on_path():
    import apart
    import field
    import measured
    import problem
    import race

__all__ = ["PEERS", "apart", "field", "measured", "on_path", "problem", "race"]
