"""Check a model at single instants, before it moves.

Compare the values that a program computes in single states with the exact values, level by level:
geometry, posture, positions, velocities, energy, accelerations, forces, the linear bicycle. The
report names the first wrong level, the size of its error, and the parameters that enter there.

The file is a table in any format that 'score' reads. Its columns have names with units, such as
'pitch [rad]'. The states are given either by number (column state; --states writes all of them with
their numbers) or by the columns roll_angle, steer_angle, roll_rate, steer_rate and forward_speed.
The other columns are the quantities to check.

exit codes: 0 every value in the table is right; 1 the table cannot be used;
2 nothing to compare; 3 a level is wrong.

examples:
  heyoka-bike check --states states.csv
  heyoka-bike check my-states.csv
"""

import argparse
from pathlib import Path
from typing import Any

from heyoka_bike.commands import options
from heyoka_bike.commands.printing import print_blocks, print_json
from heyoka_bike.errors import Exit, InputError
from heyoka_bike.numbers.exact import positive_numbers
from heyoka_bike.system.log import complain


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    said = {
        "[FILE]": "table to check; - is standard input",
        "--states CSV": "write all numbered states with every quantity, correctly rounded, and "
        "check nothing",
        **options.BICYCLE,
        "--si": "read columns without a unit in SI units",
        "--tolerance X 1e-9": "largest allowed difference over 1 + abs(value), in SI units "
        "(default 1e-9)",
    }
    p = options.add_command(subparsers, run, __doc__, said)
    options.add_format(p, ("text", "json"))


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    if (args.file is None) == (args.states is None):
        raise InputError("expected either a FILE to check or --states CSV to write, but not both")
    (tolerance,) = positive_numbers("--tolerance", args.tolerance)[:1]
    from heyoka_bike.bicycle.parameters import read_bicycle
    from heyoka_bike.system.resources import find_input

    bicycle = read_bicycle(find_input("bicycles", args.bicycle))
    if args.states is not None:
        return _write(Path(args.states), bicycle)
    from heyoka_bike.scoring.instants.check import check
    from heyoka_bike.showing.formats.check import blocks, document, line

    found = check(args.file, bicycle=bicycle, tolerance=tolerance, si=args.si)
    if args.format == "json":
        print_json(document(found))
    else:
        print_blocks(*blocks(found))
    if found.passed:
        return Exit.OK
    complain(line(found))
    return Exit.CHECK_FAILED


def _write(path: Path, bicycle: Any) -> int:
    from heyoka_bike.reference.proof.instants import as_csv, known_states
    from heyoka_bike.system.files import write_output

    write_output(path, as_csv(bicycle, known_states()))
    print(path)
    return Exit.OK
