"""What was measured of the field: a JSON file, what of it still holds, the best run, and orders."""

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
"""The benchmark; its runs are kept apart from those of the extended problem set."""
BUDGET = 30
"""Processor time that the best run may take, all maneuvers [s]."""
# Of a program: what is said of it, as field.toml has it.
_SAID = ("program", "kind", "version", "install", "model", "measure")
# Parts of this package that integrate: a run of them is kept while they are as they were.
INTEGRATING = ("bicycle/equations", "motion", "numbers", "workbench/fast")
# Neighbours whose steps differ by less show rounding, not an order.
_LEAST_RATIO = 1.2


def now():
    """The time, to the minute."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%MZ")


@dataclass(frozen=True)
class Document:
    """The JSON file, written after each run.

    Attributes
    ----------
    path : Path or None
        None if nothing is to be written.
    order : list of str
        Of the programs.
    machine : dict
        This one.
    content : dict
    before : dict
        Its programs as they were at the start.
    started
        When this run of the field was.
    """

    path: Path | None
    order: list[str]
    machine: dict[str, Any]
    content: dict[str, Any]
    before: dict[str, Any]
    started: str

    @classmethod
    def of(cls, path, machine, order):
        """With what the file holds already; its runs of the benchmark if they are of this machine.

        Those of the extended problem set have a machine of their own.
        """
        content = {"machine": machine, "started": [], "programs": {}}
        if path is not None and path.exists():
            before = json.loads(path.read_text(encoding="utf-8"))
            if before["machine"] == machine:
                content = before
            elif "harder" in before:
                content["harder"] = before["harder"]
        return cls(path, order, machine, content, content["programs"], now())

    def line(self, name, problem, made_of):
        """A run that was written down and holds still; None if there is none."""
        runs = self.before.get(name, {}).get("runs", [])
        if problem != H1:
            tier = self.content.get("harder", {"machine": None})
            runs = []
            if tier["machine"] == self.machine:
                runs = tier["programs"].get(name, {}).get("problems", {}).get(problem, [])
        return next((r for r in runs if r["made_of"] == made_of and r["failure"] is None), None)

    def keep_runs(self, name, said, lines):
        """Write the runs of the benchmark down, with what is said of their program."""
        found = {"runs": lines, "orders": orders(lines, said["measure"]), "best": best(lines)}
        self.keep(name, said | {"missing": None} | found)

    def keep_harder(self, name, said, problem, lines):
        """Write the runs of a problem of the extended problem set down."""
        tier = self.content.get("harder")
        if tier is None or tier["machine"] != self.machine:
            tier = self.content["harder"] = {"machine": self.machine, "programs": {}}
        known = tier["programs"].setdefault(name, {"program": said["program"], "problems": {}})
        known["problems"] = dict(sorted((known["problems"] | {problem: lines}).items()))
        self.write()

    def absent(self, name, said, why):
        """Write down that a program is not here; what is known of it stays."""
        self.keep(name, self.content["programs"].get(name, said) | {"missing": why})

    def keep(self, name, found):
        """Write down what was found of a program; what else is known of it stays."""
        programs = self.content["programs"]
        known = programs.get(name, {"missing": None, "runs": [], "orders": [], "best": None})
        programs = programs | {name: known | found}
        self.content["programs"] = {x: programs[x] for x in self.order if x in programs}
        runs = [r for p in self.content["programs"].values() for r in p["runs"]]
        # One time: all of it was measured in one run.
        self.content["started"] = sorted({r["started"] for r in runs})
        self.write()

    def write(self):
        """Write the file, whole."""
        if self.path is not None:
            text = json.dumps(self.content, indent=1, ensure_ascii=False, allow_nan=False)
            write_output(self.path, text.encode() + b"\n")


def best(runs):
    """Setting of the most right run within the budget; None if no run came to its end."""
    ended = [r for r in runs if r["failure"] is None and r["cpu"] <= BUDGET]
    return max(ended, key=lambda r: r["digits"])["setting"] if ended else None


def told(entry, kind, family, value):
    """What a run is: its setting, and that in words."""
    symbol = "h" if entry["measure"] == "step" else entry["measure"]
    words = f"{family['words']}, {symbol} = {value:.3g}" if family["words"] else f"h = {value:.3g}"
    return {
        "kind": kind,
        "words": words,
        "family": family["words"],
        "setting": {entry["measure"]: value, **family.get("set", {})},
        "language": family.get("language", entry["language"]),
    }


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
    """Of the files of a program, with what its script or build uses of here and of the package."""
    words = set(re.findall(r"(?:from |import |\.\./)([\w-]+)", text))
    beside = sorted(folder.parent.iterdir())
    folders = [folder, *(p for p in beside if p.is_dir() and p.name in words - {folder.name})]
    files = [p for x in folders for p in sorted(x.iterdir()) if p.is_file()]
    files += [p for p in beside if p.suffix == ".py" and p.stem in words - {"field"}]
    if "heyoka_bike" in words:
        package = folder.parent.parent.parent / "heyoka_bike"
        files += sorted(p for part in INTEGRATING for p in (package / part).rglob("*.py"))
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


def orders(runs, measure):
    """Order between neighbouring settings of a family, from the coarse to the fine.

    For a step the exponent p of an error h^p; for a tolerance that of the tolerance.
    """
    families = {}
    for run in runs:
        if run["failure"] is None:
            families.setdefault(run["family"], []).append(run)
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
