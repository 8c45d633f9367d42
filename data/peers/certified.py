"""Rows of a problem of the harder tier, certified, without the rest of its reference set.

The whole set, with all forces and sensitivities, takes hours of H3. The rows that results are
compared with are proved in minutes, by the same steps: integrated, enclosed, rounded. Between the
rows is the run itself, which nothing proves; it is looked at where times are off only.
"""

import pickle
from pathlib import Path

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.parameters import describe_inputs, read_bicycle, read_maneuvers
from heyoka_bike.errors import UndecidedError
from heyoka_bike.motion.evaluator import evaluator
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.reference.proof.dense import interpolate
from heyoka_bike.reference.proof.enclose import enclose
from heyoka_bike.reference.proof.rows import (
    EVALUATION_BITS,
    constant_columns,
    round_rows,
    rounded_times,
)
from heyoka_bike.reference.values import Values
from heyoka_bike.system.resources import find_input

# Of the integration: a rounding that is not decided asks for more.
DIGITS = (70, 90, 110)
FILE = "rows.pickle"


class RowsAlone(Reference):
    """A reference of which there are rows and what lies between, and no files."""

    def with_motion(self):
        """None: there is no whole motion."""
        return


def certified(bicycle, maneuvers, numbers, folder):
    """A reference of some maneuvers of a set, by the names of its inputs; kept in a folder.

    Others of the set stand in it without rows.
    """
    bike, asked = (
        read_bicycle(find_input("bicycles", bicycle)),
        read_maneuvers(find_input("maneuvers", maneuvers)),
    )
    said = describe_inputs(bike, asked)
    known = Path(folder, FILE)
    rows = pickle.loads(known.read_bytes()) if known.exists() else {}
    for n in numbers:
        if n not in rows:
            rows[n] = _proved(bike, asked[n - 1])
            known.parent.mkdir(parents=True, exist_ok=True)
            known.write_bytes(pickle.dumps(rows))
    empty = {c.name: np.empty(0) for c in COLUMNS}
    found = [
        ReferenceManeuver(
            maneuver.name,
            {key: x for key, x in given.items() if key != "name"},
            *rounded_times(maneuver),
            *rows.get(n, (Values(empty, empty), None)),
            units={c.name: c.unit for c in COLUMNS},
        )
        for n, (maneuver, given) in enumerate(zip(asked, said["maneuvers"], strict=True), start=1)
    ]
    parameters = said["bicycle"]["parameters"]
    return RowsAlone("rows alone", "", bike.name, parameters, tuple(found), Path(folder))


def _proved(bicycle, maneuver):
    """Rows and dense output of a maneuver."""

    def silent(_):
        """Progress goes nowhere."""

    for digits in DIGITS:
        run = integrate(bicycle, maneuver, Precision.of(digits))
        try:
            rows = round_rows(run, enclose(run, silent), silent)
        except UndecidedError:
            continue
        scales = {name: rows.scale(name) for name in rows.hi}
        between = evaluator(run, run.bits + EVALUATION_BITS)
        dense = interpolate(between, scales, constant_columns(run), silent)
        return Values(rows.hi, rows.lo, rows.bound), dense
    raise UndecidedError(f"{maneuver.name}: a rounding is not decided with {DIGITS[-1]} digits")
