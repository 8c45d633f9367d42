"""Everything about a reference folder that can be checked in seconds, without heyoka.

First the bytes: every file against the manifest, the manifest against the hash that the package
knows. Then, in files that are whole, their structure (`verify_schema`), and in files that are built
as they should be, their numbers (`verify_numbers`). What a file that is not whole would be needed
for is not checked, and said to be so.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
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
from heyoka_bike.motion.expressions import require_heyoka
from heyoka_bike.numbers.arithmetic import Balls
from heyoka_bike.reference.description.describe import describe
from heyoka_bike.reference.layout import CANDIDATE, CERTIFICATE, HDF5, MOTION, SENSITIVITIES
from heyoka_bike.reference.load import load_motion, load_reference
from heyoka_bike.reference.manifest import MANIFEST, Manifest
from heyoka_bike.reference.proof.candidate import read_candidate
from heyoka_bike.reference.texts import TextFile, text_files
from heyoka_bike.reference.verification import agreement, motion_agreement, schema
from heyoka_bike.reference.verification.checks import Check, Tally
from heyoka_bike.reference.verification.hashes import check_files
from heyoka_bike.reference.verification.outcome import ManeuverFiles, Verification
from heyoka_bike.reference.verification.rerun import run_again
from heyoka_bike.system.jobs import Report
from heyoka_bike.system.parallel import Progress, side_by_side
from heyoka_bike.system.resources import reference_folder

_BITS = 128  # of a look at the initial state, to see whether there is one

_MEASURED: Mapping[str, str] = {
    "schema": "is built as docs/files.md says",
    "content_sha256": "is that of the numbers",
    "row_zero": "times, and what is rational in row 0: the nearest binary64 and the rest",
    "energy": "potential + kinetic = mechanical energy, constant, to {largest:.1e} of it",
    "contact": "height of the front wheel over the floor at most {largest:.1e} m",
    "columns": "all columns follow from each row's own state, to {largest:.1e} of their scale",
    "motion_state": "all columns follow from each row's state, to {largest:.1e} of their scale",
    "motion_identities": "unit quaternions, wheels on the floor, to {largest:.1e}",
    "rolling": "contact point and wheels move at the rates of the rows, to {largest:.1e}",
    "dense_rows": "dense output at the rows, to {largest:.1e} of the scale",
    "dense_joins": "jumps between dense pieces at most {largest:.1e} of the scale",
    "text": "every number is that of the HDF5 file",
    "certificate": "bounds agree with the files; the largest is {largest:.2e}",
    "candidate_joins": "pieces join exactly, from the initial state",
    "equations_of_motion": "the equations hold at the rows, to {largest:.1e} rad/s^2",
    "rounding": "hi and lo are the nearest to the candidate's values, to the last bit",
    "row_bounds": "bounds are those of the certificate, at most {largest:.1e} of the scale",
    "digits": "all 50 digits are the candidate's, correctly rounded",
    "numbers": "",
}
"""What a check of the numbers says when nothing is wrong."""


@dataclass(frozen=True, slots=True)
class Content:
    """What is in the files of a set.

    Attributes
    ----------
    parts : list of ManeuverFiles
        Empty if the inputs of the manifest are not usable.
    texts : tuple of TextFile
        The text files that the set should have.
    sound : set of str
        Names of the files that are whole and built as they should be.
    has_motion : bool
        Whether the set has a file of the whole motion, sound or not.
    """

    parts: list[ManeuverFiles]
    texts: tuple[TextFile, ...]
    sound: set[str]
    has_motion: bool = False


def verify(
    folder: str | Path | None = None,
    *,
    rerun: Literal["full", "quick"] | None = None,
    progress: Progress | None = None,
) -> Verification:
    """Check every file and every number of a reference set.

    As ``heyoka-bike verify`` does. A script that calls it has to guard itself by
    ``if __name__ == "__main__"``: each maneuver gets a process of its own.

    Parameters
    ----------
    folder
        The set; by default the published one that comes with the package.
    rerun
        Whether to integrate again too, if nothing else is wrong, and count the digits that agree:
        at the precision of the set and 20 digits more, or at binary128 and 40 digits.
    progress
        Called while integrating again with the maneuver and precision, the stage (``waiting``,
        ``integrate``, ``compare``) and the share of that stage that is done, 0 to 1.

    Returns
    -------
    Verification
        Every check with its outcome; a failed one is no error.

    Raises
    ------
    DatasetError
        The folder cannot be read, or is no reference set at all.
    MissingPackageError
        heyoka is not installed, and `rerun` is given.
    """
    if rerun is None:
        return _verified(folder)
    require_heyoka()
    return run_again(_verified(folder), is_quick=rerun == "quick", progress=progress)


def _verified(folder: str | Path | None) -> Verification:
    where = reference_folder() if folder is None else Path(folder)
    files, checks = check_files(where, is_published=folder is None)
    if files.manifest is None:
        return Verification(str(where), None, tuple(checks))
    content, more = read_content(where, files.manifest, files.data)
    checks += more
    if content.parts:
        jobs = [(part,) for part in content.parts]
        made = _joined(side_by_side(_look, jobs))
        checks += made + _not_made(made, content)
    return Verification(
        str(where), files.manifest.dataset_version, tuple(checks), tuple(content.parts)
    )


def read_content(
    folder: Path, manifest: Manifest, data: Mapping[str, bytes]
) -> tuple[Content, list[Check]]:
    """The maneuvers of a set, and the checks of how its files are built.

    Parameters
    ----------
    data
        Contents of the files that are what the manifest says.
    """
    try:
        bicycle, maneuvers = _inputs(manifest)
    except schema.DAMAGE as e:
        message = f"its inputs cannot be used: {' '.join(str(e).split()):.200}"
        return Content([], (), set()), [Check("inputs", False, MANIFEST, message, {"values": 0})]
    texts = text_files(maneuvers)
    count = len(PARAMETERS) + len(STATE_INPUTS) * len(maneuvers)
    shown = f"{bicycle.name}, {len(maneuvers)} maneuvers"
    checks = [
        Check("inputs", True, MANIFEST, shown, {"values": count}),
        _file_list(manifest, [HDF5, CANDIDATE, CERTIFICATE, *(t.name for t in texts)]),
    ]

    sound: set[str] = set()

    def look(name: str, problems: Callable[..., Iterator[str]]) -> bool:
        """Whether a file is whole and built as it should be; the check is noted."""
        check = _structure("schema", name, data, problems, manifest, maneuvers)
        checks.append(check)
        if check.passed:
            sound.add(name)
        return bool(check.passed)

    reference = runs = entries = None
    if look(HDF5, schema.of_hdf5):
        reference = load_reference(folder)
        # The numbers are looked at even where their hash is another one.
        checks.append(
            _structure("content_sha256", HDF5, data, schema.content_differs, manifest, maneuvers)
        )
    if look(CANDIDATE, schema.of_candidate):
        runs = read_candidate(folder)
    if look(CERTIFICATE, schema.of_certificate):
        entries = json.loads(data[CERTIFICATE])["maneuvers"]
    read = [
        schema.read_text(data[text.name], text)
        for text in texts
        if look(text.name, partial(schema.of_text, file=text))
    ]
    if SENSITIVITIES in manifest.files:
        look(SENSITIVITIES, schema.of_sensitivities)
    motion = None
    if MOTION in manifest.files and look(MOTION, schema.of_motion):
        motion = load_motion(folder)
    for name, expected in describe(manifest).items():
        if name in manifest.files:
            look(name, partial(schema.of_description, expected=expected))
    parts = []
    for i, maneuver in enumerate(maneuvers):
        stored = None
        if reference is not None:
            stored = agreement.Stored(i + 1, bicycle, maneuver, reference[i + 1])
        parts.append(
            ManeuverFiles(
                number=i + 1,
                stored=stored,
                run=None if runs is None else runs[i],
                entry=None if entries is None else entries[i],
                texts=tuple(text for text in read if i + 1 in text.file.numbers),
                motion=None if motion is None else motion[i + 1],
            )
        )
    return Content(parts, texts, sound, MOTION in manifest.files), checks


def _structure(
    check: str, name: str, data: Mapping[str, bytes], problems: Callable[..., Iterator[str]],
    manifest: Manifest, maneuvers: Sequence[Maneuver],
) -> Check:  # fmt: skip
    """A check of how a file is built."""
    if name not in data:
        message = f"not checked: {name} is not what the manifest says"
        return Check(check, None, name, message, {"values": 0})
    tally = Tally(check, name, values=len(data[name]))
    for problem in schema.problems_of(problems, data[name], manifest, maneuvers):
        tally.fail(problem)
    return tally.done(_MEASURED[check])


def _inputs(manifest: Manifest) -> tuple[Bicycle, tuple[Maneuver, ...]]:
    """Bicycle and maneuvers of a manifest, with an initial state that can be reached."""
    given = manifest.inputs
    bicycle = Bicycle.parse(given["bicycle"]["name"], given["bicycle"]["parameters"])
    maneuvers = tuple(Maneuver.parse(entry["name"], entry) for entry in given["maneuvers"])
    if describe_inputs(bicycle, maneuvers) != given or not maneuvers:
        raise ValueError("they are not written as 'heyoka-bike generate' writes them")
    equations = Equations.of(bicycle, Balls(_BITS))
    for m in maneuvers:
        if m.duration <= 0 or (m.duration / m.spacing).denominator != 1:
            raise ValueError(f"{m.name}: its duration is no number of its spacings")
        initial_state(equations, m)
    return bicycle, maneuvers


def _file_list(manifest: Manifest, expected: Sequence[str]) -> Check:
    missing = [name for name in expected if name not in manifest.files]
    # Sets of older versions have no sensitivities, no whole motion and no description.
    known = {*expected, SENSITIVITIES, MOTION, *describe(manifest)}
    extra = [n for n in manifest.files if n not in known]
    message = "lists the files of a set"
    if missing or extra:
        message = ", ".join(
            [f"has no entry for {name}" for name in missing]
            + [f"has an entry for {name!r:.60}, which is not part of a set" for name in extra]
        )
    evidence = {"values": len(expected), "failures": len(missing) + len(extra)}
    return Check("file_list", not (missing or extra), MANIFEST, message, evidence)


def _look(part: ManeuverFiles, _: Report) -> list[Tally]:
    """All checks of the numbers of a maneuver for which there are files."""
    stored, run, entry = part.stored, part.run, part.entry
    found: list[Tally] = []

    def add(file: str, look: Callable[..., list[Tally]], *arguments: Any) -> None:
        try:
            found.extend(look(*arguments))
        except schema.DAMAGE as e:
            # Numbers so far off that they overflow.
            tally = Tally("numbers", file)
            what = f"{type(e).__name__}: {' '.join(str(e).split()):.200}"
            tally.fail(f"maneuver {part.number}: its numbers cannot be evaluated ({what})")
            found.append(tally)

    if stored is not None:
        for look in (
            agreement.row_zero,
            agreement.energies_add_up,
            agreement.own_state,
            agreement.dense,
        ):
            add(HDF5, look, stored)
        for text in part.texts:
            same = agreement.text_50 if text.file.is_long else agreement.text_17
            add(text.file.name, same, stored, text)
        if entry is not None:
            add(CERTIFICATE, agreement.certified, stored, run, entry)
        if entry is not None and part.motion is not None:
            add(CERTIFICATE, agreement.certified_motion, stored, part.motion, entry)
        if part.motion is not None:
            for look_at_motion in motion_agreement.CHECKS:
                add(MOTION, look_at_motion, stored, part.motion)
    if run is None:
        return found
    add(CANDIDATE, agreement.candidate_joins, run)
    if entry is not None and set(entry["state_bounds"]) == set(run.states):
        certificate = agreement.certificate_of(run, entry)
        add(CANDIDATE, agreement.motion, run, certificate)
        if stored is not None:
            add(HDF5, agreement.rounded_rows, stored, run, certificate, part.long_text)
    return found


def _joined(results: Sequence[Sequence[Tally]]) -> list[Check]:
    """One check of each kind and file for all maneuvers."""
    joined: dict[tuple[str, str], Tally] = {}
    for tallies in results:
        for tally in tallies:
            key = (tally.check, tally.file)
            joined[key] = joined[key].joined(tally) if key in joined else tally
    order = list(_MEASURED)
    checks = []
    for tally in sorted(joined.values(), key=lambda t: order.index(t.check)):
        message = _MEASURED[tally.check]
        evidence = {"largest": tally.largest} if "{largest" in message else {}
        if tally.failures:
            evidence = {}
        checks.append(tally.done(message.format(largest=tally.largest), **evidence))
    return checks


def _not_made(made: Sequence[Check], content: Content) -> list[Check]:
    """The checks of the numbers for which a file was not whole."""
    done = {(check.check, check.file) for check in made}
    checks = []
    for name, file, needed in _needs(content.texts, has_motion=content.has_motion):
        if (name, file) not in done:
            missing = [x for x in needed if x not in content.sound]
            what = f"{' and '.join(missing)} cannot be used" if missing else "see the other checks"
            checks.append(Check(name, None, file, f"not checked: {what}", {"values": 0}))
    return checks


def _needs(
    texts: Sequence[TextFile], *, has_motion: bool
) -> Iterator[tuple[str, str, tuple[str, ...]]]:
    """Checks of the numbers, the file that each is about, and the files that it needs."""
    for name in ("row_zero", "energy", "contact", "columns", "dense_rows", "dense_joins"):
        yield name, HDF5, (HDF5,)
    for text in texts:
        yield "text", text.name, (HDF5, text.name)
    yield "certificate", CERTIFICATE, (HDF5, CERTIFICATE)
    if has_motion:
        for name in (*motion_agreement.NAMES, "dense_rows", "dense_joins"):
            yield name, MOTION, (HDF5, MOTION)
    yield "candidate_joins", CANDIDATE, (CANDIDATE,)
    yield "equations_of_motion", CANDIDATE, (CANDIDATE, CERTIFICATE)
    for name in ("rounding", "row_bounds"):
        yield name, HDF5, (HDF5, CANDIDATE, CERTIFICATE)
    for text in texts:
        if text.is_long:
            yield "digits", text.name, (HDF5, CANDIDATE, CERTIFICATE, text.name)
