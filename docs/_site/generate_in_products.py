"""What making the reference takes, in units that do not depend much on the machine.

The unit is the processor time of ten million products of balls of 256 bits (`flint.arb`), measured
in the same process before and after each set is made. The set is made in this process alone, in a
folder that goes again. Run as a script, this prints a table: a set for each of its columns.
"""

import argparse
import statistics
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import flint

import heyoka_bike
from speed_page import STAGE_NAMES, table

PRODUCTS = 10_000_000
BITS = 256


def seconds_of_products(count=PRODUCTS):
    """Processor time of so many products [s]."""
    with flint.ctx.workprec(BITS):
        x, y = flint.arb(2).sqrt(), flint.arb(3).sqrt()
        start = time.process_time()
        for _ in range(count):
            x * y
        return time.process_time() - start


def measured(count=PRODUCTS):
    """The unit before and after a set is made [s], and the processor time of its stages [s]."""
    before = seconds_of_products(count)
    start = time.process_time()
    with TemporaryDirectory() as folder, heyoka_bike.using(workers=1):
        made = heyoka_bike.generate(Path(folder) / "set")
    whole = time.process_time() - start
    stages = {name: sum(t.seconds[name] for t in made.tables) for name in STAGE_NAMES}
    return (before, seconds_of_products(count)), stages | {"whole": whole}


def rows(runs):
    """Lines of the table: the unit, then each stage in units."""
    units = [statistics.mean(unit) for unit, _ in runs]
    apart = [abs(after - before) for (before, after), _ in runs]
    yield "ten million products [s]", *(f"{x:.2f}" for x in units)
    yield "the same afterwards, off by [s]", *(f"{x:.2f}" for x in apart)
    for name, says in (*STAGE_NAMES.items(), ("whole", "all, with states and files")):
        parts = [stages[name] / unit for (_, stages), unit in zip(runs, units, strict=True)]
        yield says, *(f"{x:.1f}" for x in parts)


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument(
        "--runs", type=int, default=3, help="sets that are made, of minutes each (3)"
    )
    runs = [measured() for _ in range(words.parse_args().runs)]
    print(
        table(("in units of ten million products", *map(str, range(1, len(runs) + 1))), rows(runs))
    )


if __name__ == "__main__":
    main()
