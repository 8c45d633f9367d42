"""Making after-ten-seconds.json: the two candidates by heyoka, and all that follows from them."""

from dataclasses import replace
from fractions import Fraction
from math import ceil
from pathlib import Path

from heyoka_bike.bicycle.parameters import benchmark, describe_inputs
from heyoka_bike.errors import InputError
from heyoka_bike.motion.events import REAR_LIFT, first_event
from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.motion.integrate import integrate
from heyoka_bike.reference.layout import AFTER, CANDIDATE
from heyoka_bike.reference.manifest import write_files
from heyoka_bike.reference.proof import candidate
from heyoka_bike.system.parallel import Progress
from heyoka_bike.workbench.after_ten_seconds.cycle_candidate import cycle_candidate
from heyoka_bike.workbench.after_ten_seconds.facts_file import prove_facts, render_facts

_VERSION = "after-ten-seconds"
"""Stands where files of the set have its version: the folder has none of its own."""

_DIGITS = 50
"""Of the candidates: the 30 that are published are then decided, with errors grown 10^12-fold."""


def generate_after(folder: str | Path, *, progress: Progress | None = None) -> tuple[str, ...]:
    """Compute, prove and write what becomes of the benchmark's maneuvers after ten seconds.

    Parameters
    ----------
    folder
        Where candidate.h5 and after-ten-seconds.json are written; made if need be.
    progress
        As for `certify`.

    Returns
    -------
    tuple of str
        Names of the files that were written; those of equal content are left untouched.

    Raises
    ------
    InputError
        No folder.
    NotCertifiedError
        Something is not shown.
    DatasetError
        The folder cannot be written.
    MissingPackageError
        heyoka is not installed.
    """
    require_heyoka()
    if not str(folder).strip():
        raise InputError("--out: found nothing, expected a folder")
    bicycle, maneuvers = benchmark()
    cycle = cycle_candidate(bicycle, maneuvers[0], _DIGITS)
    lift = first_event(bicycle, maneuvers[2], until=REAR_LIFT)
    assert lift is not None  # the benchmark's falls
    rows = ceil(Fraction(float(lift.time)) / maneuvers[2].spacing)
    until = replace(maneuvers[2], duration=rows * maneuvers[2].spacing)
    fall = integrate(bicycle, until, _DIGITS)
    facts = prove_facts(cycle, fall, progress)
    runs = (cycle, fall)
    inputs = describe_inputs(bicycle, [run.maneuver for run in runs])
    files = {CANDIDATE: candidate.render(runs, inputs, _VERSION), AFTER: render_facts(facts)}
    return tuple(write_files(folder, files))
