"""``python -m heyoka_bike``."""

import sys

from heyoka_bike.cli import main

if __name__ == "__main__":
    sys.exit(main())
