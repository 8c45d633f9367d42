"""Check the folder of a dataset within seconds and without heyoka.

The bytes come first: every file against the manifest, and the manifest against the hash that the
package knows. Undamaged files are then checked for their structure (`schema`), and well-formed
files for their numbers (`numbers`). Checks that need a damaged file are reported as not made.
"""

import json
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Any, Literal

from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import (
    PARAMETERS,
    STATE_INPUTS,
    Bicycle,
    Maneuver,
    describe_inputs,
)
from heyoka_bike.errors import DatasetError
from heyoka_bike.motion.heyoka_adapter import require_heyoka
from heyoka_bike.motion.trajectory import Certificate
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.reference import form, layout
from heyoka_bike.reference import manifest as manifest_file
from heyoka_bike.reference.description import describe
from heyoka_bike.reference.hdf5 import DAMAGE
from heyoka_bike.reference.layout import CANDIDATE, CERTIFICATE, HDF5, MOTION, TEXT, TEXT_50
from heyoka_bike.reference.load import load_motion, load_reference
from heyoka_bike.reference.manifest import (
    MANIFEST,
    PUBLISHED_MANIFESTS,
    UNLISTED_FILES_1_5_0,
    Manifest,
)
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.verification import numbers, schema
from heyoka_bike.reference.verification.numbers import run_again
from heyoka_bike.reference.verification.outcome import (
    BOUNDS,
    Check,
    StoredManeuver,
    Tally,
    Verification,
)
from heyoka_bike.system.jobs import OnStage
from heyoka_bike.system.parallel import Progress, side_by_side
from heyoka_bike.system.resources import reference_folder

_BITS_OF_START = 128  # precision of the check that the initial conditions can be reached

MEASURED: Mapping[str, str] = {
    "schema": "structure as in docs/files.md",
    "content_sha256": "the recorded hash matches the numbers",
    "states": "every value is the binary64 nearest to the exact value, proved again",
    "row_zero": "times and rational values of row 0 are correctly rounded",
    "energy": "potential + kinetic = mechanical energy = constant, to {largest:.1e} of it",
    "contact": "height of the front wheel above the floor is at most {largest:.1e} m",
    "columns": "all columns follow from each row's own state, to {largest:.1e} of their scale",
    "motion_state": "all columns follow from each row's state, to {largest:.1e} of their scale",
    "motion_identities": "unit quaternions, wheels on the floor, to {largest:.1e}",
    "rolling": "contact point and wheels move at the rates of the rows, to {largest:.1e}",
    "dense_rows": "dense output agrees with the rows, to {largest:.1e} of the scale",
    "dense_joins": "jumps between dense pieces are at most {largest:.1e} of the scale",
    "text": "every number agrees with the HDF5 file",
    "certificate": "bounds agree with the files; the largest is {largest:.2e}",
    "integration": "eq. (1) of the candidate's own energy is at most {largest:.1e} %",
    "candidate_joins": "pieces join exactly and begin at the initial state",
    "equations_of_motion": "the equations hold at the rows, to {largest:.1e} rad/s^2",
    "rounding": "hi and lo are the candidate's values, correctly rounded to the last bit",
    "row_bounds": "bounds are those of the certificate, at most {largest:.1e} of the scale",
    "digits": "all 50 digits are the candidate's values, correctly rounded",
    "numbers": "",
}
"""Message of each check that passes; ``{largest}`` is the largest measured value."""

CHECKS: tuple[tuple[Callable[..., None], tuple[str, ...], Mapping[str, str]], ...] = (
    (numbers.row_zero, (HDF5,), {"row_zero": HDF5}),
    (numbers.energies_add_up, (HDF5,), {"energy": HDF5}),
    (numbers.own_state, (HDF5,), {"contact": HDF5, "columns": HDF5}),
    (numbers.follows_from_state, (HDF5, MOTION), {"motion_state": MOTION}),
    (numbers.identities, (HDF5, MOTION), {"motion_identities": MOTION}),
    (numbers.rolling, (HDF5, MOTION), {"rolling": MOTION}),
    (numbers.dense, (HDF5,), {"dense_rows": HDF5, "dense_joins": HDF5}),
    (numbers.dense, (HDF5, MOTION), {"dense_rows": MOTION, "dense_joins": MOTION}),
    (numbers.text_17, (HDF5, TEXT), {"text": TEXT}),
    (numbers.text_50, (HDF5, TEXT_50), {"text": TEXT_50}),
    (numbers.certified, (HDF5, CERTIFICATE), {"certificate": CERTIFICATE}),
    (numbers.integration, (CANDIDATE, CERTIFICATE), {"integration": CANDIDATE}),
    (numbers.candidate_joins, (CANDIDATE,), {"candidate_joins": CANDIDATE}),
    (numbers.equations_of_motion, (BOUNDS,), {"equations_of_motion": CANDIDATE}),
    (
        numbers.rounded_rows,
        (HDF5, BOUNDS),
        {"rounding": HDF5, "row_bounds": HDF5, "digits": TEXT_50},
    ),
)
"""Checks of the numbers of a maneuver: a function, the files that it needs, and the names of its
checks with the file that each is about. The function is called with a `StoredManeuver` and a
`Tally` for each of its checks, in this order."""


@dataclass(frozen=True, slots=True)
class Content:
    """Contents of the files of a dataset.

    Attributes
    ----------
    parts : list of StoredManeuver
        Empty if the inputs in the manifest cannot be used.
    names : mapping of str to tuple of str
        Names of the files that the dataset has or should have, by their names in `CHECKS`.
    sound : set of str
        Names of the undamaged, well-formed files.
    """

    parts: list[StoredManeuver]
    names: Mapping[str, tuple[str, ...]]
    sound: set[str]


def verify(
    folder: str | Path | None = None,
    *,
    rerun: Literal["full", "quick"] | None = None,
    progress: Progress | None = None,
) -> Verification:
    """Check every file and every number of a dataset.

    This is what ``heyoka-bike verify`` does. Each maneuver is checked in its own process, so a
    script that calls this function needs the guard ``if __name__ == "__main__"``.

    Parameters
    ----------
    folder
        Folder of the dataset; by default the published one that comes with the package.
    rerun
        If given and no check fails, integrate the motion again and count the digits that agree:
        ``full`` with the precision of the dataset and with 20 more digits, ``quick`` with binary128
        and 40 digits.
    progress
        Called during a rerun with the name of the maneuver and the precision, the stage
        (``waiting``, ``integrate``, ``compare``) and the completed fraction of that stage, 0 to 1.

    Returns
    -------
    Verification
        Every check with its outcome; a failed check does not raise an error.

    Raises
    ------
    DatasetError
        The folder cannot be read, or is not a dataset.
    MissingPackageError
        `rerun` is given, but heyoka is not installed.
    """
    if rerun is None:
        return _verified(folder)
    require_heyoka()
    return run_again(_verified(folder), is_quick=rerun == "quick", progress=progress)


def _verified(folder: str | Path | None) -> Verification:
    where = reference_folder() if folder is None else Path(folder)
    manifest, data, checks = check_files(where, is_published=folder is None)
    if manifest is None:
        return Verification(str(where), None, tuple(checks))
    content, more = read_content(where, manifest, data)
    checks += more
    if content.parts:
        made = _joined(side_by_side(_look, [(part,) for part in content.parts]))
        checks += made + list(_not_made(made, content))
    return Verification(str(where), manifest.dataset_version, tuple(checks), tuple(content.parts))


@dataclass(frozen=True, slots=True)
class _File:
    """A file of a dataset: its structure check, its reader, and its name in `CHECKS`.

    `check` is the name of the check that reports the problems. `kind` is the name in `CHECKS`, by
    default the file name.
    """

    name: str
    problems: Callable[[bytes, form.SetForm], Iterator[str]]
    read: Callable[[], Iterable[tuple[int, Any]]] = tuple
    kind: str = ""
    is_optional: bool = False
    check: str = "schema"


def read_content(
    folder: Path, manifest: Manifest, data: Mapping[str, bytes]
) -> tuple[Content, list[Check]]:
    """Return the maneuvers of a dataset, and the checks of the structure of its files.

    Parameters
    ----------
    data
        Contents of the files that match the manifest.
    """
    try:
        bicycle, maneuvers = _inputs(manifest)
    except DAMAGE as e:
        message = f"the inputs cannot be used: {' '.join(str(e).split()):.200}"
        return Content([], {}, set()), [Check("inputs", False, MANIFEST, message, {"values": 0})]
    count = len(PARAMETERS) + len(STATE_INPUTS) * len(maneuvers)
    shown = f"{bicycle.name}, {len(maneuvers)} maneuvers"
    expected = form.expected(manifest, maneuvers, data)
    files = list(_files(folder, bicycle, data, expected))
    checks = [
        Check("inputs", True, MANIFEST, shown, {"values": count}),
        _file_list(manifest, files),
    ]
    sound: set[str] = set()
    found: list[dict[str, Any]] = [{} for _ in maneuvers]
    names: dict[str, tuple[str, ...]] = {BOUNDS: (CANDIDATE, CERTIFICATE), MOTION: ()}
    for file in files:
        if file.is_optional and file.name not in manifest.files:
            continue
        kind = file.kind or file.name
        names[kind] = (*names.get(kind, ()), file.name)
        check = _structure(file.check, file.name, file.problems, data, expected)
        checks.append(check)
        if check.passed:
            sound.add(file.name)
            for number, content in file.read():
                found[number - 1][kind] = content
        if check.passed and file.name == HDF5:
            # The numbers are checked even if the hash of the contents is wrong.
            differs = schema.content_differs
            checks.append(_structure("content_sha256", HDF5, differs, data, expected))
    parts = []
    for number, (maneuver, of_files) in enumerate(zip(maneuvers, found, strict=True), start=1):
        if of_files.keys() >= {CANDIDATE, CERTIFICATE}:
            run, states = of_files[CANDIDATE], of_files[CERTIFICATE]["state_bounds"]
            if set(states) == set(run.states):
                interval, end = (
                    tuple(Fraction(states[name][key]) for name in run.states)
                    for key in ("interval", "end")
                )
                of_files[BOUNDS] = Certificate(run.states, (interval,) * run.steps, end)
        parts.append(StoredManeuver(number, bicycle, maneuver, of_files))
    return Content(parts, names, sound), checks


def _files(
    folder: Path, bicycle: Bicycle, data: Mapping[str, bytes], expected: form.SetForm
) -> Iterator[_File]:
    """Yield the required and optional files of a dataset, in the order of their checks."""

    def groups(name: str) -> Callable[[bytes, form.SetForm], Iterator[str]]:
        return partial(form.of_groups, name=name)

    def read_text(file: layout.TextFile) -> Iterable[tuple[int, Any]]:
        return dict.fromkeys(file.numbers, schema.read_text(data[file.name], file)).items()

    yield _File(HDF5, groups(HDF5), lambda: load_reference(folder).items())
    yield _File(CANDIDATE, groups(CANDIDATE), lambda: enumerate(read_candidate(folder), start=1))
    yield _File(
        CERTIFICATE, schema.of_certificate,
        lambda: enumerate(json.loads(data[CERTIFICATE])["maneuvers"], start=1),
    )  # fmt: skip
    for file in layout.text_files(expected.maneuvers):
        kind, problems = TEXT_50 if file.is_long else TEXT, partial(schema.of_text, file=file)
        yield _File(file.name, problems, partial(read_text, file), kind)
    # Datasets of older versions may lack these files.
    optional = partial(_File, is_optional=True)
    yield optional(layout.SENSITIVITIES, groups(layout.SENSITIVITIES))
    yield optional(MOTION, groups(MOTION), lambda: load_motion(folder).items())
    for name in (layout.STATES, layout.STATES_HDF5):
        differ = partial(schema.of_states, name=name, bicycle=bicycle)
        yield optional(name, differ, check="states")
    for name, said in describe(expected.manifest, expected.columns[HDF5]).items():
        yield optional(name, partial(schema.of_description, text=said))


def _structure(
    check: str, name: str, look: Callable[..., Iterator[str]], data: Mapping[str, bytes],
    expected: form.SetForm,
) -> Check:  # fmt: skip
    """Return the check of the structure of a file."""
    if name not in data:
        message = f"not checked, because {name} does not match the manifest"
        return Check(check, None, name, message, {"values": 0})
    tally, message = Tally(check, name, values=len(data[name])), MEASURED[check]
    problems = form.problems_of(look, data[name], expected)
    unchecked = [x for x in problems if isinstance(x, form.Unchecked)]
    for problem in problems:
        if not isinstance(problem, form.Unchecked):
            tally.fail(problem)
    if unchecked:
        message += f"; not checked in this older dataset: {', '.join(dict.fromkeys(unchecked))}"
    return tally.done(message)


def _inputs(manifest: Manifest) -> tuple[Bicycle, tuple[Maneuver, ...]]:
    """Return bicycle and maneuvers of a manifest, after checking that the maneuvers can start."""
    given = manifest.inputs
    bicycle = Bicycle.parse(given["bicycle"]["name"], given["bicycle"]["parameters"])
    maneuvers = tuple(Maneuver.parse(entry["name"], entry) for entry in given["maneuvers"])
    if describe_inputs(bicycle, maneuvers) != given or not maneuvers:
        raise ValueError("their form is not that of 'heyoka-bike generate'")
    equations = Equations.of(bicycle, Balls(_BITS_OF_START))
    for m in maneuvers:
        if m.duration <= 0 or (m.duration / m.spacing).denominator != 1:
            raise ValueError(f"{m.name}: the duration is not a multiple of the spacing")
        initial_state(equations, m)
    return bicycle, maneuvers


def _file_list(manifest: Manifest, files: Sequence[_File]) -> Check:
    expected = [file.name for file in files if not file.is_optional]
    missing = [name for name in expected if name not in manifest.files]
    known = {*(file.name for file in files), *layout.AFTER_FILES}
    extra = [n for n in manifest.files if n not in known]
    problems = [f"has no entry for {name}" for name in missing]
    problems += [f"has an entry for {n!r:.60}, which is not part of a dataset" for n in extra]
    message = ", ".join(problems) or "lists the files of a dataset"
    evidence = {"values": len(expected), "failures": len(problems)}
    return Check("file_list", not problems, MANIFEST, message, evidence)


def _look(part: StoredManeuver, _: OnStage) -> list[Tally]:
    """Run all checks of a maneuver's numbers whose files are available."""
    found: list[Tally] = []
    for look, needed, made in CHECKS:
        if not part.files.keys() >= {*needed}:
            continue
        tallies = [Tally(name, part.name_of(kind)) for name, kind in made.items()]
        try:
            look(part, *tallies)
        except DAMAGE as e:
            # Numbers that are wrong by many orders of magnitude can overflow and raise an error,
            # which is reported as a failure.
            tally = Tally("numbers", tallies[0].file)
            what = f"{type(e).__name__}: {' '.join(str(e).split()):.200}"
            tally.fail(f"maneuver {part.number}: the numbers cannot be evaluated ({what})")
            found.append(tally)
        else:
            kinds = zip(tallies, made.values(), strict=True)
            found += [tally for tally, kind in kinds if kind in part.files]
    return found


def _joined(results: Sequence[Sequence[Tally]]) -> list[Check]:
    """Join the tallies of all maneuvers into one check of each kind and file."""
    order = list(MEASURED)
    joined: dict[tuple[str, str], Tally] = {}
    for tally in (tally for tallies in results for tally in tallies):
        key = (tally.check, tally.file)
        joined[key] = joined[key].joined(tally) if key in joined else tally
    checks = []
    for tally in sorted(joined.values(), key=lambda t: order.index(t.check)):
        message = MEASURED[tally.check]
        is_measured = "{largest" in message and not tally.failures
        evidence = {"largest": tally.largest} if is_measured else {}
        checks.append(tally.done(message.format(largest=tally.largest), **evidence))
    return checks


def _not_made(made: Sequence[Check], content: Content) -> Iterator[Check]:
    """Yield the checks of numbers that could not be made, because a file is damaged."""
    done = {(check.check, check.file) for check in made}
    for _, needed, tallies in CHECKS:
        for name, kind in tallies.items():
            for file in content.names[kind]:
                if (name, file) in done or not all(content.names[x] for x in needed):
                    continue
                done.add((name, file))
                others = [x for k in needed if k != kind for x in content.names[k]]
                missing = [x for x in dict.fromkeys((*others, file)) if x not in content.sound]
                what = (
                    f"{' and '.join(missing)} cannot be used" if missing else "see the other checks"
                )
                yield Check(name, None, file, f"not checked: {what}", {"values": 0})


def check_files(
    folder: Path, *, is_published: bool = False
) -> tuple[Manifest | None, Mapping[str, bytes], list[Check]]:
    """Compare the files of a folder with its manifest, and the manifest with its known hash.

    Parameters
    ----------
    folder
    is_published
        True if the folder must contain the latest published dataset; else any dataset is accepted.

    Returns
    -------
    Manifest or None
        None if the manifest cannot be used.
    mapping of str to bytes
        Contents of the files that match the manifest, by name.
    list of Check

    Raises
    ------
    DatasetError
        The folder cannot be read, or is not a dataset.
    """
    try:
        present = sorted(os.listdir(folder))
    except OSError as e:
        raise DatasetError(f"{folder}: cannot be read: {e.strerror or e}") from None
    try:
        raw = manifest_file.read_raw(folder)
        manifest = manifest_file.parse(raw, folder / MANIFEST)
    except DatasetError as e:
        # A folder that contains this file is a dataset, even if its manifest is damaged.
        if HDF5 not in present:
            raise DatasetError(str(e)) from None
        return None, {}, [Check("manifest", False, MANIFEST, str(e), {"values": 0})]
    checks = [_form(raw), _known(manifest, is_published=is_published)]
    data, expected = {}, dict(manifest.files)
    if manifest.sha256 == PUBLISHED_MANIFESTS["1.5.0"] and (
        is_published or layout.AFTER_FOLDER in present
    ):
        expected |= UNLISTED_FILES_1_5_0
    for name, size_and_digest in expected.items():
        check, content = _file(folder, name, *size_and_digest)
        checks.append(check)
        if content is not None:
            data[name] = content
    checks.append(_extra(sorted(_others(folder, {*expected, MANIFEST}))))
    return manifest, data, checks


def _form(raw: bytes) -> Check:
    problem = manifest_file.problem_of_form(raw)
    message = problem or "the form is that of 'heyoka-bike generate'"
    return Check("manifest", not problem, MANIFEST, message, {"values": len(raw)})


def _known(manifest: Manifest, *, is_published: bool) -> Check:
    """Check that the manifest of a published dataset has the hash that the package knows."""
    version, found = manifest.dataset_version, manifest.sha256
    short, last = f"sha256 {found[:12]}...", manifest_file.PUBLISHED_VERSION
    passed = True
    if found == manifest_file.PUBLISHED_MANIFEST_SHA256:
        message = f"{short} is that of the published dataset {version}"
    elif found == PUBLISHED_MANIFESTS.get(version) and not is_published:
        message = (
            f"{short} is that of the published dataset {version}; this version of the package "
            f"contains {last}"
        )
    elif version == manifest_file.CUSTOM and not is_published:
        message = f"your own dataset, for which the package knows no hash (found {short})"
    else:
        passed = False
        expected = (
            f"{manifest_file.PUBLISHED_MANIFEST_SHA256[:12]}... of the published dataset {last}"
        )
        message = f"found {short} of dataset version {version!r:.40}, expected {expected}"
    return Check("manifest_hash", passed, MANIFEST, message, {"values": 1, "sha256": found})


def _file(folder: Path, name: str, size: int, digest: str) -> tuple[Check, bytes | None]:
    """Return the check of a file, and its contents if they match the manifest."""
    try:
        data = manifest_file.contents(folder, name, size, digest)
    except manifest_file.MemberError as e:
        about = MANIFEST if e.is_of_manifest else name
        return Check("file", False, about, str(e), {"values": e.size}), None
    message = f"sha256 {digest[:12]}... as in the manifest"
    return Check("file", True, name, message, {"values": size}), data


def _others(folder: Path, known: Collection[str], inside: str = "") -> Iterator[str]:
    """Yield the names of unknown files; a folder without known files is named instead of them."""
    where = folder / inside
    for entry in os.listdir(where) if where.is_dir() else ():
        name = inside + entry
        if any(other.startswith(f"{name}/") for other in known):
            yield from _others(folder, known, f"{name}/")
        elif name not in known:
            yield name


def _extra(extra: Sequence[str]) -> Check:
    message = "no other files"
    if extra:
        shown = ", ".join(f"{name!r:.60}" for name in extra[:5])
        message = f"not part of the dataset: {shown}" + (", ..." if extra[5:] else "")
    evidence = {"values": len(extra), "files": list(extra)}
    return Check("other_files", True, MANIFEST, message, evidence)
