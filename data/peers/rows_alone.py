"""Rows of a problem of the extended problem set, without the rest of its reference set.

The whole set, with all forces and sensitivities, takes hours of H3. The rows that results are
compared with are proved in minutes, by the same steps: integrated, enclosed, rounded. Computed,
which takes seconds, they are those of a run in 70 digits, and nothing is proved. Between the rows
is the run itself; it is looked at where times are off only.
"""

import json
import pickle
from hashlib import sha256
from pathlib import Path

import numpy as np

from heyoka_bike.bicycle.columns import COLUMNS
from heyoka_bike.bicycle.parameters import describe_inputs, read_bicycle, read_maneuvers
from heyoka_bike.errors import UndecidedError
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.motion.trajectory import evaluator
from heyoka_bike.numbers.precision import Precision
from heyoka_bike.reference.load import Reference, ReferenceManeuver
from heyoka_bike.reference.proof.dense import interpolate
from heyoka_bike.reference.proof.enclose import enclose
from heyoka_bike.reference.proof.rows import constant_columns, round_rows, rounded_times
from heyoka_bike.reference.values import Dense, Values
from heyoka_bike.system.files import replace_file
from heyoka_bike.system.machine import versions
from heyoka_bike.system.resources import find_input

# Of the integration: a rounding that is not decided asks for more.
DIGITS = (70, 90, 110)


class RowsAlone(Reference):
    """A reference of which there are rows and what lies between, and no files."""

    def with_motion(self):
        """None: there is no whole motion."""
        return


def rows_alone(bicycle, maneuvers, numbers, folder, how):
    """A reference of some maneuvers of a set, by the names of its inputs; kept in a folder.

    Others of the set have no number in it. How is "prove" or "compute".
    """
    bike, asked = (
        read_bicycle(find_input("bicycles", bicycle)),
        read_maneuvers(find_input("maneuvers", maneuvers)),
    )
    said = describe_inputs(bike, asked)
    Path(folder).mkdir(parents=True, exist_ok=True)
    work = {"prove": _proved, "compute": _computed}[how]
    rows = {}
    for n in numbers:
        # Depends on the versions of the packages and on the code of this project, too.
        text = json.dumps([versions(), how, describe_inputs(bike, [asked[n - 1]])], sort_keys=True)
        file = Path(folder) / f"{sha256(text.encode()).hexdigest()}.pickle"
        if not file.exists():
            replace_file(file, pickle.dumps(work(bike, asked[n - 1])))
        rows[n] = pickle.loads(file.read_bytes())
    nothing = {c.name: np.full(asked[0].rows, np.nan) for c in COLUMNS}
    one_piece = {c.name: np.full((1, 1), np.nan) for c in COLUMNS}
    breaks = np.array([0.0, float(asked[0].duration)])
    unknown = Values(nothing, nothing), Dense(hi=one_piece, lo=one_piece, breaks=breaks)
    parameters = said["bicycle"]["parameters"]
    found = [
        ReferenceManeuver(
            maneuver.name,
            {key: x for key, x in given.items() if key != "name"},
            *rounded_times(maneuver),
            *rows.get(n, unknown),
            units={c.name: c.unit for c in COLUMNS},
            parameters=parameters,
        )
        for n, (maneuver, given) in enumerate(zip(asked, said["maneuvers"], strict=True), start=1)
    ]
    return RowsAlone("rows alone", "", bike.name, parameters, tuple(found), Path(folder))


def _silent(_):
    """Progress goes nowhere."""


def _proved(bicycle, maneuver):
    """Correctly rounded rows of a maneuver, and what lies between."""
    for digits in DIGITS:
        run = integrate(bicycle, maneuver, Precision.of(digits))
        try:
            rows = round_rows(run, enclose(run, _silent), _silent)
        except UndecidedError:
            continue
        return Values(rows.hi, rows.lo, rows.bound), _between(run, rows)
    raise UndecidedError(f"{maneuver.name}: a rounding is not decided with {DIGITS[-1]} digits")


def _computed(bicycle, maneuver):
    """Rows of a run, rounded, and what lies between."""
    run = integrate(bicycle, maneuver, Precision.of(DIGITS[0]))
    at = evaluator(run)
    with at.balls.precision():
        found = [at.columns(maneuver.time(i)) for i in range(maneuver.rows)]
        hi = {c.name: np.array([float(x[c.name].mid()) for x in found]) for c in COLUMNS}
        lo = {
            name: np.array([float((x[name] - y).mid()) for x, y in zip(found, values, strict=True)])
            for name, values in hi.items()
        }
    rows = Values(hi, lo)
    return rows, _between(run, rows)


def _between(run, rows):
    scales = {name: rows.scale(name) for name in rows.hi}
    at = evaluator(run)

    def near(t, about):
        return at.columns(t, run.piece_at(about))

    return interpolate(near, run.breaks[-1], at.balls, scales, constant_columns(run), _silent)
