"""Compare the diagnosis of the corpus's files with the right answers, and print a table.

``python -m corpus.answers [--every N]`` diagnoses every Nth file and prints how many mistakes were
named, helped, missed or answered falsely. Then it prints one line for each file whose mistake was
not named. With ``--answers FOLDER`` it does not diagnose but reads earlier outputs of ``heyoka-bike
diagnose --format json``, one file for each result file.
"""

import argparse
import json
import re
import tempfile
import time
import tomllib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

from corpus.files import files
from corpus.writing import HERE, Runs, text
from heyoka_bike import load_reference
from heyoka_bike.commands.result_files import read
from heyoka_bike.errors import NothingScoredError
from heyoka_bike.scoring.diagnosis.diagnose import diagnose

NAMES_A_CAUSE = ("mistake", "parameters")
NAMES_NOTHING = ("direction", "no_mistake_found")
SAYS_LITTLE = (*NAMES_NOTHING, "smooth_error", "definitions", "stopped_early")
"""Codes of findings that do not help to find a mistake."""
ACCUSES = (*NAMES_A_CAUSE, "direction", "term_unexplained")
"""Codes of findings that blame the program, its input or its output."""

_REAR, _FORK, _BOTH = "rear frame", "fork", "rear frame and of the fork"
_TILTED = "inertia of the {} is used as if it were in axes along the steer axis"
_WRONG_WAY = "inertia of the {} is rotated by the tilt in the wrong direction"
_OWN_SIGN = "product of inertia of the {} has the opposite sign in axes along the steer"

ANSWERS = {
    "rear frame inertia not rotated": _TILTED.format(_REAR),
    "fork inertia not rotated": _TILTED.format(_FORK),
    "rear frame and fork inertia not rotated": _TILTED.format(_BOTH),
    "rear frame inertia rotated the wrong way": _WRONG_WAY.format(_REAR),
    "fork inertia rotated the wrong way": _WRONG_WAY.format(_FORK),
    "rear frame and fork inertia rotated the wrong way": _WRONG_WAY.format(_BOTH),
    "rear frame and fork inertia rotated by the head angle": "rotated by the head angle",
    "rear frame product of inertia with the other sign": "I_Bxz.*opposite sign",
    "fork product of inertia with the other sign": "I_Hxz.*opposite sign",
    "rear frame and fork product of inertia with the other sign": "both products.*opposite sign",
    "rear frame product of inertia with the other sign in its own axes": _OWN_SIGN.format(_REAR),
    "fork product of inertia with the other sign in its own axes": _OWN_SIGN.format(_FORK),
    "rear frame and fork product of inertia with the other sign in their own axes":
        _OWN_SIGN.format(_BOTH),
    "rear frame product of inertia missing": "I_Bxz.* missing",
    "fork product of inertia missing": "I_Hxz.* missing",
    "rear frame and fork product of inertia missing": "both products of inertia are missing",
    "rear frame is a point mass": "rear frame.* is a point mass",
    "fork is a point mass": "fork is a point mass",
    "rear frame Ixx and Izz exchanged": "Ixx and Izz of the rear frame are exchanged",
    "front and rear wheel exchanged": "the wheels are exchanged",
    "wheel radii exchanged": "radii are exchanged",
    "wheel masses exchanged": "masses of the wheels are exchanged",
    "wheel inertias exchanged": "inertias of the wheels are exchanged",
    "wheel masses and inertias exchanged": "masses and inertias of the wheels are exchanged",
    "both wheels with the rear radius": "both wheels have the radius of the rear",
    "start 6/7 too slow: speed divided by the front radius":
        "spin of the rear wheel is the speed over the radius of the front",
    "start 7/6 too fast: the front wheel was given the rear wheel's rate":
        "spin of the front wheel is the speed over the radius of the rear",
    "steer axis offset from the wrong wheel's radius":
        "rear hub to the steer axis is computed with the front wheel's radius",
    "fork offset from the wrong wheel's radius": "computed.* with the rear wheel's radius",
    "no fork offset": r"goes through the front hub|trail \(c\) is 0\.1137",
    "fork offset with the other sign": "front hub is behind the steer axis",
    "trail with the other sign": "trail is negative",
    "trail taken across the steer axis": "trail is used as the distance .*from the steer axis",
    "no trail": "trail is zero",
    "another steer axis tilt": r"tilt.*\(lam\) is (1[67]|20|0\.(29|34))",
    "gravity 9.8": r"Gravity is 9\.8 ",
    "gravity 9.80665": r"Gravity is 9\.80665",
    "gravity 9.82": r"Gravity is 9\.82",
    "gravity 10": "Gravity is 10 ",
    "gravity 9.8, and rear frame product of inertia with the other sign":
        r"(?=.*gravity is 9\.8 )(?=.*I_Bxz.*opposite sign)",
    "wheel spin inertia missing": "wheels have no inertia about their axles",
    "rear wheel spin inertia missing": "rear wheel has no inertia about its axle",
    "rear wheel Ixx and Iyy exchanged": "Ixx and Iyy of the rear wheel are exchanged",
    "front wheel Ixx and Iyy exchanged": "Ixx and Iyy of the front wheel are exchanged",
    "wheels' Ixx and Iyy exchanged": "Ixx and Iyy of both wheels are exchanged",
    "wheels taken as solid discs": "wheels have the inertia of discs",
    "wheels taken as rings": "wheels have the inertia of rings",
    "weight of the wheels missing": "wheels.* (weight|gravity)",
    "fork inertia about the front axle": "inertia of the fork is taken about the front hub",
    "rear frame centre of mass measured from the hub":
        "centre of mass of the rear frame is measured from the rear hub",
    "rear frame centre of mass not rotated":
        "centre of mass of the rear frame is used as if it were in axes along",
    "fork centre of mass not rotated":
        "centre of mass of the fork is used as if it were in axes along",
    "roll rate given along the tilted axis": r"roll rate .*(is 0\.0?47|tilt)",
    "roll rate taken as degrees": "initial roll rate is read as degrees",
    "no roll rate at the start": "initial roll rate is zero",
    "steer rate at the start": "steer rate .*(is 0.05|as large as the roll rate)",
    "velocities at the start without the roll": "centres of mass do not move sideways",
    "front wheel not turning at the start": "front wheel starts without spin",
    "wheels not turning at the start": "both wheels start without spin",
    "another mass of the rear frame": r"mass of the rear frame with rider \(mB\)",
    "another mass of the fork": r"\(mH\) is 2\.(4|3999|3998)",
    "another wheel base": r"\(w\) is 1\.2",
    "another inertia of the rear frame": r"\(IBxx\) is 2\.(9|8999)",
    "another centre of mass of the rear frame": r"\(zB\) is -0\.8",
    "gyroscopic torque missing": "gyroscopic torque",
    "gyroscopic torque of the wheels missing": "gyroscopic torque",
    "inertia not turned with the body": "inertia.* does not turn",
    "contact point straight below the hub": "contact.* below the hub",
    "rows one step late": "one step (late|early)|first one at t = h",
    "rows one step early": "one step (late|early)|first one at t = h",
    "time stretched": "advances by 0.01 s from row to row|1.001 times",
    "time in milliseconds": "milliseconds| ms|1000 times",
    "time a second late": "times.* 1 s (later|too late)|1 s|time_shift",
    "roll rate and steer angle exchanged": "in the place of",
    "roll and steer exchanged": "in the place of",
    "roll angle and roll rate exchanged": "in the place of",
    "potential and kinetic energy exchanged": "in the place of",
    "mechanical energy is kinetic minus potential": "kinetic minus the potential",
    "potential energy with the other sign": "potential energy falls with the height",
    "mechanical energy over its first value": "mechanical_energy|mechanical energy",
    "kinetic energy without the wheels' spin": "leaves out the wheels' spin",
    "rates by forward differences": "forward differences",
    "rates by central differences": "central differences",
    "speed times 7/6: spin times the front radius":
        "spin of the rear wheel times the radius of the front",
    "speed is the constant of the start": "speed.*(never filled in|that of the start in every row)",
    "pitch in place of the roll": "pitch angle is in the place of the roll angle",
    "yaw in place of the steer": "yaw angle is in the place of the steer angle",
    "interpolated between few rows": "interpolat|step size of|Every 10 rows|Every 2 rows",
    "noise": "noise",
    "roll rate with the other sign than the roll angle": "turned round|opposite sign",
    "steer angle with the other sign than its rate": "turned round|opposite sign",
    "steer rate in degrees per second alone": "steer_rate is in deg",
    "one maneuver in several places": "in the place of maneuver",
    "maneuvers exchanged": "in the place of maneuver",
    "linearised": "motions of the linearised equations",
    "linearised, rear frame product of inertia with the other sign": "linearised",
    "linearised, wheel spin inertia missing": "linearised",
    "linearised, another mistake in the equations": "linearised",
}  # fmt: skip
"""Pattern of a right answer, by the mistake."""


@dataclass(frozen=True)
class Judged:
    """An entry of the index, the outcome for its file, and the message that decided.

    The outcome is ``fair`` or ``unfair`` for an honest file; else ``right``, ``wrong`` if another
    cause is named, ``helpful`` if anything is described, or ``silent``.
    """

    entry: dict
    outcome: str
    said: str


def judged(entry, report):
    """Compare the diagnosis of a file with the right answer."""
    answer = entry["expected"]
    accused = [f.message for f in report.diagnosis if f.code in ACCUSES]
    if answer in ("correct", "convention", "linearised"):
        if accused:
            return Judged(entry, "unfair", accused[0])
        told = any(re.search(ANSWERS["linearised"], f.message) for f in report.diagnosis)
        if answer == "linearised" and not told:
            return Judged(entry, "silent", "")
        return Judged(entry, "fair", "")
    named = [f for f in report.diagnosis if f.code in NAMES_A_CAUSE]
    others = [f for f in (*report.diagnosis, *report.findings) if f.code not in NAMES_NOTHING]
    told = [f.message for f in named[:1] or others]
    # An answer that names more mistakes than the program has counts as wrong, because the surplus
    # mistakes may cancel each other.
    made = 2 if ", " in answer or "several" in answer else 1
    is_surplus = any(len(f.evidence.get("mistakes", ())) > made for f in named[:1])
    if not is_surplus and any(
        re.search(ANSWERS[answer], message, re.IGNORECASE) for message in told
    ):
        return Judged(entry, "right", "")
    if named:
        return Judged(entry, "wrong", told[0])
    is_helped = any(f.code not in SAYS_LITTLE for f in report.diagnosis)
    return Judged(entry, "helpful" if is_helped else "silent", told[0] if told else "")


def report_of(file, path, reference):
    """Diagnose a file; pass its maneuver if the scorer needs it."""
    try:
        return diagnose([read(str(path), None, reference)], reference)
    except NothingScoredError as e:
        if "--maneuver" not in str(e):
            raise
        (number,) = file.maneuvers
        return diagnose([read(str(path), number, reference)], reference)


def judge(names, folder, reference):
    """Diagnose the files with these names, or all files, and judge each answer."""
    index, runs = read_index(), Runs()
    found = []
    for file in files(runs.index):
        if names is None or file.name in names:
            path = folder / f"{file.name}.txt"
            path.write_text(text(file, runs))
            found.append(judged(index[file.name], report_of(file, path, reference)))
    assert names is None or len(found) == len(names)
    return found


def read_index():
    """Return the entries of the index by file name."""
    with open(HERE / "index.toml", "rb") as stream:
        return {entry["name"]: entry for entry in tomllib.load(stream)["file"]}


def answered_before(path):
    """Return a report for `judged`, from the JSON that the command line printed."""
    content = path.read_text()
    given = json.loads(content[content.index("\n{") :] if "\n{" in content else content)
    said = [SimpleNamespace(**{"evidence": {}, **f}) for f in given.get("findings", ())]
    return SimpleNamespace(diagnosis=said, findings=[])


def table(found):
    """Count the outcomes of honest files, visible and hidden mistakes, and list the failures."""
    counts = {kind: Counter() for kind in ("honest", "visible", "hidden")}
    lines = []
    for j in found:
        kind = (
            "visible" if j.entry.get("visible") else "hidden" if "visible" in j.entry else "honest"
        )
        counts[kind][j.outcome] += 1
        if j.outcome not in ("right", "fair"):
            lines.append(f"{j.outcome:8}{j.entry['name']} ({j.entry['expected']}): {j.said[:150]}")
    head = [f"{kind:8} {sum(c.values()):4}: " + ", ".join(f"{n} {k}" for k, n in sorted(c.items()))
            for kind, c in counts.items()]  # fmt: skip
    return "\n".join([*head, *lines])


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--every", type=int, default=1, help="diagnose every Nth file only")
    parser.add_argument("--answers", type=Path, help="folder with NAME.json of earlier answers")
    asked = parser.parse_args()
    index = read_index()
    names = [*index][:: asked.every]
    if asked.answers:
        paths = {name: asked.answers / f"{name}.json" for name in names}
        print(table([judged(index[n], answered_before(p)) for n, p in paths.items() if p.exists()]))
        return
    begun = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        print(table(judge(names, Path(folder), load_reference())))
    print(f"{(time.process_time() - begun) / len(names):.2f} s of processor time for each file")


if __name__ == "__main__":
    main()
