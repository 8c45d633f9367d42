"""Making a reference set: from a bicycle and its maneuvers to the files in a folder."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from heyoka_bike.bicycle.parameters import (
    Bicycle,
    Maneuver,
    describe_inputs,
    read_bicycle,
    read_maneuvers,
)
from heyoka_bike.errors import InputError
from heyoka_bike.motion.endings import Ending, ending
from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.reference.making.dataset import check_overwrite, write_dataset
from heyoka_bike.reference.making.tabulate import Table, tabulate
from heyoka_bike.reference.manifest import CUSTOM, DATASET_VERSION
from heyoka_bike.system.parallel import Progress, side_by_side
from heyoka_bike.system.resources import (
    benchmark_bicycle,
    benchmark_maneuvers,
    collection,
    find_input,
)

MIN_DIGITS, MAX_DIGITS = 65, 1000


@dataclass(frozen=True)
class Generated:
    """A reference set that was made.

    Attributes
    ----------
    folder : Path
    dataset_version : str
        ``custom`` if the inputs are not those of the benchmark.
    changed : tuple of str
        Names of the files that were written; those of equal content are left untouched.
    endings : tuple of Ending
        How each maneuver ended.
    tables : tuple of Table
        What was computed of each maneuver.
    """

    folder: Path
    dataset_version: str
    changed: tuple[str, ...]
    endings: tuple[Ending, ...]
    tables: tuple[Table, ...]


def generate(
    folder: str | Path,
    *,
    bicycle: Bicycle | str | Path = "benchmark",
    maneuvers: Sequence[Maneuver] | str | Path | None = None,
    digits: int = 70,
    until: str | None = None,
    force: bool = False,
    say: Callable[[str], None] | None = None,
    progress: Progress | None = None,
) -> Generated:
    """Integrate maneuvers, prove how exact they are, and write a reference set of them.

    As ``heyoka-bike generate`` does. A script that calls it on more than one maneuver has to guard
    itself by ``if __name__ == "__main__"``: each maneuver gets a process of its own.

    Parameters
    ----------
    folder
        Where the set is written; made if need be.
    bicycle
        A bicycle, the name of one of the collection, or a TOML file.
    maneuvers
        Maneuvers, the name of some of the collection, or a TOML file; by default those that are
        called like the bicycle, else those of the benchmark.
    digits
        Decimal digits of the integration, 65 to 1000.
    until
        A time [s] in place of the maneuvers' durations, or ``fall``: to the last row before a wheel
        leaves the floor or the model ends.
    force
        Whether to replace a set of another version or of other inputs.
    say
        Called with a line of text for each warning about the bicycle, and where `until` or the end
        of the model shortens a maneuver, before the work begins.
    progress
        Called with the name of a maneuver, the stage of the work (``waiting``, ``integrate``,
        ``certify``, ``rows``, ``dense``, ``motion``, ``vary``) and the share of that stage that is
        done, 0 to 1.

    Returns
    -------
    Generated
        What was written, and what it was made of.

    Raises
    ------
    InputError
        Something given cannot be used, or the folder holds another set and `force` is not given.
    SingularMotionError
        A motion meets a singularity before its end, which the first look at it did not find.
    NotCertifiedError
        A motion cannot be certified.
    UndecidedError
        A rounding that more digits do not decide.
    DatasetError
        The folder cannot be written.
    MissingPackageError
        heyoka is not installed.
    """
    tell = say or (lambda text: None)
    require_heyoka()
    if not str(folder).strip():
        raise InputError("--out: found nothing, expected a folder")
    if not MIN_DIGITS <= digits <= MAX_DIGITS:
        raise InputError(f"--digits: found {digits}, expected {MIN_DIGITS} to {MAX_DIGITS}")
    own = "benchmark"
    if not isinstance(bicycle, Bicycle):
        own = str(bicycle) if str(bicycle) in collection("maneuvers") else own
        bicycle = read_bicycle(find_input("bicycles", str(bicycle)))
    asked = own if maneuvers is None else maneuvers
    if isinstance(asked, str | Path):
        asked = read_maneuvers(find_input("maneuvers", str(asked)))
    if not asked:
        raise InputError("maneuvers: found none, expected one or more")
    for warning in bicycle.warnings:
        tell(f"warning: {bicycle.name}: {warning}")
    endings = [ending(bicycle, m, until) for m in asked]
    for m, end in zip(asked, endings, strict=True):
        if end.said is not None:
            tell(
                f"{'stopped early: ' if end.is_early else ''}{m.name}: {end.said}; "
                f"what is written ends at {float(end.maneuver.duration):g} s"
            )
    given = [end.maneuver for end in endings]
    inputs = describe_inputs(bicycle, given)
    published = describe_inputs(
        read_bicycle(benchmark_bicycle()), read_maneuvers(benchmark_maneuvers())
    )
    version = DATASET_VERSION if inputs == published else CUSTOM
    check_overwrite(folder, version, inputs, force=force)
    tables = side_by_side(
        tabulate,
        [(bicycle, m, digits) for m in given],
        [(m.name, float(m.duration)) for m in given],
        progress,
    )
    changed = write_dataset(folder, bicycle, tables, digits, version)
    return Generated(Path(folder), version, tuple(changed), tuple(endings), tuple(tables))
