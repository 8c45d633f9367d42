"""Draws a figure to a file."""

import sys
from argparse import ArgumentParser
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parent.parent))
    from figures import FIGURES, draw
    from heyoka_bike.workbench.style import save

    parser = ArgumentParser(description="Draw a figure about the published set.")
    parser.add_argument("name", choices=FIGURES)
    parser.add_argument("file", type=Path, help=".png, .svg or .pdf")
    parser.add_argument("--maneuver", type=int, help="show this one")
    given = parser.parse_args()
    save(draw(given.name, given.maneuver), given.file)
