"""What was measured of the field: a JSON file, what of it still holds, and orders."""

import hashlib
import json
import math
import re
import subprocess
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from itertools import pairwise
from pathlib import Path
from typing import Any

from heyoka_bike.system.files import write_output

H1 = "H1"
"""The benchmark; its runs are kept apart from those of the harder tier."""
# Of a program: what is said of it, as field.toml has it.
_SAID = ("program", "kind", "version", "install", "model", "default_model", "measure", "follows",
         "digits", "default_digits")  # fmt: skip
# Neighbours whose steps differ by less show rounding, not an order.
_LEAST_RATIO = 1.2


@dataclass(frozen=True)
class Document:
    """The JSON file, written after each run.

    Attributes
    ----------
    path : Path or None
        None if nothing is to be written.
    order : list of str
        Of the programs.
    content : dict
    before : dict
        Its programs as they were at the start.
    started
        When this run of the field was.
    """

    path: Path | None
    order: list[str]
    content: dict[str, Any]
    before: dict[str, Any]
    started: str

    @classmethod
    def of(cls, path, machine, peer, order):
        """With what the file holds already, if it is of this machine and beside this peer."""
        started = datetime.now(UTC).strftime("%Y-%m-%dT%H:%MZ")
        content = {"machine": machine, "peer": peer, "started": [], "programs": {}}
        if path is not None and path.exists():
            before = json.loads(path.read_text(encoding="utf-8"))
            if (before["machine"], before["peer"]) == (machine, peer):
                content = before
        return cls(path, order, content, content["programs"], started)

    def line(self, name, problem, kind, made_of):
        """A run that was written down and holds still; None if there is none."""
        said = self.before.get(name, {})
        runs = said.get("runs", []) if problem == H1 else said.get("harder", {}).get(problem, [])
        same = (r for r in runs if (r["kind"], r["made_of"]) == (kind, made_of))
        return next((r for r in same if r["failure"] is None), None)

    def keep_runs(self, name, said, problem, lines):
        """Write the runs of a problem down, with what is said of their program."""
        found = {"runs": lines, "orders": orders(lines, said["measure"])}
        if problem != H1:
            others = self.content["programs"].get(name, {}).get("harder", {})
            found = {"harder": dict(sorted((others | {problem: lines}).items()))}
        self.keep(name, said | {"missing": None} | found)

    def absent(self, name, said, why):
        """Write down that a program is not here; what is known of it stays."""
        known = self.content["programs"].get(name, said)
        self.keep(name, known | {"missing": why})

    def keep(self, name, found):
        """Write down what was found of a program; what else is known of it stays."""
        programs = self.content["programs"]
        known = programs.get(name, {"missing": None, "runs": [], "orders": []})
        programs = programs | {name: known | found}
        self.content["programs"] = {x: programs[x] for x in self.order if x in programs}
        runs = [r for p in self.content["programs"].values() for r in p["runs"]]
        # One time: all of it was measured in one run.
        self.content["started"] = sorted({r["started"] for r in runs})
        if self.path is not None:
            write(self.path, self.content)


def write(path, content):
    """The file, whole."""
    text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    write_output(path, text.encode() + b"\n")


def settings(entry, problem=H1):
    """Kind and setting of each run of a program, none twice.

    Of the benchmark the default, the best and the sweep; of the harder tier those that it is said
    to do.
    """
    kept = [(kind, entry[kind]) for kind in ("default", "best") if kind in entry]
    if problem != H1:
        return [x for x in kept if _named(entry, x[0], problem)]
    others = [x for x in entry["sweep"] if x not in [setting for _, setting in kept]]
    return kept + [("sweep", x) for x in others]


def submitted(entry, problem):
    """Kinds of the runs of a problem whose results are published."""
    if problem == H1:
        return ("default", "best")
    return ("best",) if _named(entry, "submitted", problem) else ()


def _named(entry, what, problem):
    """Whether a program is said to do a problem of the harder tier, of which H3 is six."""
    return problem.startswith(tuple(entry.get("harder", {}).get(what, ())))


def named(entry, kind, setting):
    """What a run is."""
    words = entry.get(f"{kind}_words")
    return {"kind": kind, "setting": setting, "words": words, "family": family(entry, setting)}


def described(entry, folder):
    """What a program is: its entry, its versions here, its script."""
    script = next(p for p in sorted(folder.iterdir()) if p.stem == "bicycle")
    return {
        **{key: entry[key] for key in _SAID if key in entry},
        "installed": installed(entry["install"]),
        "script": f"{folder.name}/{script.name}",
        "sha256": _hash(folder, script.read_text(encoding="utf-8") + entry.get("build", "")),
    }


def _hash(folder, text):
    """Of the files of a program, with the models beside it that its script or build uses."""
    words, beside = (
        set(re.findall(r"(?:from |import |\.\./)([\w-]+)", text)),
        sorted(folder.parent.iterdir()),
    )
    folders = [folder, *(p for p in beside if p.is_dir() and p.name in words - {folder.name})]
    files = [p for x in folders for p in sorted(x.iterdir()) if p.is_file()]
    files += [p for p in beside if p.suffix == ".py" and p.stem in words - {"field"}]
    return hashlib.sha256(b"".join(p.read_bytes() for p in files)).hexdigest()


def fingerprint(said, *others):
    """Hash of what the numbers of a run follow from."""
    made_of = [said["version"], said["installed"], said["sha256"], *others]
    return hashlib.sha256(json.dumps(made_of).encode()).hexdigest()[:16]


def installed(line):
    """Versions that are here of the packages that a line installs with pip or apt-get."""
    found = {
        name: _of_pip(name) if manager == "pip" else _of_apt(name)
        for manager, word in _packages(line)
        for name in [re.split("[=<>]", word)[0]]
    }
    return {name: here for name, here in found.items() if here}


def pinned(line):
    """Versions that a line asks for."""
    return dict(word.split("==") for _, word in _packages(line) if "==" in word)


def lacking(line):
    """Packages of Python that a line installs and that are not here."""
    return [name for name in pinned(line) if _of_pip(name) is None]


def _packages(line):
    """Package manager and word of each package that a line installs."""
    for words in (part.split() for part in re.split("&&|;", line)):
        yield from ((words[0], w.strip("'\"")) for w in words[2:] if not w.startswith("-"))


def _of_pip(name):
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def _of_apt(name):
    asked = ["dpkg-query", "-W", "-f=${Version}", name]
    try:
        return subprocess.run(asked, capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return None


def family(entry, setting):
    """What neighbouring settings have in common: all but the step or tolerance.

    An entry that ``follows`` the step is taken in steps, by the number it begins with; one that is
    set ``beside`` it makes no other family.
    """
    measure, follows = entry["measure"], entry.get("follows")
    others = {measure, *entry.get("beside", ())}
    rest = {key: x for key, x in setting.items() if key not in others}
    if follows in rest:
        first, _, more = str(rest[follows]).partition(" ")
        rest[follows] = f"{float(first) / setting[measure]:.6g} {more}"
    return rest


def orders(runs, measure):
    """Order between neighbouring settings of a family, from the coarse to the fine.

    For a step the exponent p of an error h^p; for a tolerance that of the tolerance.
    """
    families = {}
    for run in runs:
        if run["failure"] is None:
            families.setdefault(json.dumps(run["family"], sort_keys=True), []).append(run)
    found = []
    for members in families.values():
        members.sort(key=lambda run: -run["setting"][measure])
        for coarse, fine in pairwise(members):
            ratio = coarse["setting"][measure] / fine["setting"][measure]
            fall = fine["digits"] - coarse["digits"]
            if ratio > _LEAST_RATIO:
                found.append({
                    "family": fine["family"], "from": coarse["setting"][measure],
                    "to": fine["setting"][measure], "order": round(fall / math.log10(ratio), 2),
                })  # fmt: skip
    return found
