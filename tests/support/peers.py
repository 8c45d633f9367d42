"""The modules beside the programs of the field, from ``data/peers``.

Their folder does not stay on the path: it has folders that are called like the packages that they
use, and would be imported in the place of one that is not here.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from heyoka_bike.system.resources import data_folder

PEERS = data_folder() / "peers"


@contextmanager
def on_path() -> Iterator[None]:
    """The folder is on the path, also of processes that are started meanwhile."""
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
