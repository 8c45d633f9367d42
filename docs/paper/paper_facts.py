"""Numbers of the paper about the problem, the reference, and scoring."""

import json
import os
import re
import subprocess
import sys
import tomllib
from functools import cache

import numpy as np

from heyoka_bike import __version__, load_reference, read_bicycle, read_maneuvers
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.stability.linear import linearise
from heyoka_bike.system.resources import benchmark_bicycle, benchmark_maneuvers
from paper_fact import ROOT, among, document, fact, part, power, text_of
from speed_page import STEP


@fact("data/maneuvers/benchmark.toml", "cat FILE")
def given(what, maneuver="1"):
    """A quantity of a maneuver: speed, roll_rate, duration, spacing."""
    return f"{float(getattr(read_maneuvers(benchmark_maneuvers())[int(maneuver) - 1], what)):g}"


@fact("data/bicycles, data/maneuvers", "cat FILE")
def count(what):
    """How many there are: parameters of the bicycle, columns of a result file, rows here."""
    bicycle, maneuvers = read_bicycle(benchmark_bicycle()), read_maneuvers(benchmark_maneuvers())
    return {
        "parameters": f"{len(bicycle.values)}",
        "columns": f"{1 + len(maneuvers) * len(BENCHMARK_COLUMNS)}",
        "rows": f"{1 + maneuvers[0].duration / maneuvers[0].spacing}",
    }[what]


@fact("the model", "heyoka-bike linear --digits 20")
def critical(which, digits):
    """Weave or capsize speed [m/s]."""
    linear = linearise(read_bicycle(benchmark_bicycle()), 20)
    ((weave, _),), (capsize,) = linear.weave_speeds, linear.capsize_speeds
    return f"{float({'weave': weave, 'capsize': capsize}[which]):.{digits}f}"


@fact("heyoka_bike/version.py", "heyoka-bike --version")
def version():
    """Of the package."""
    return __version__


@fact("reference/manifest.json", "heyoka-bike generate")
def published(what):
    """Of the set: digits of the run, dataset_version, the first digits of content_sha256."""
    manifest = document("reference/manifest.json")
    return str(manifest["made_by"]["digits"]) if what == "digits" else manifest[what][:12]


@fact("reference/certificate.json", "heyoka-bike certify")
def proved(what, maneuver=""):
    """What the certificate says of a maneuver, or the largest or the sum over all."""
    said = document("reference/certificate.json")["maneuvers"]
    if maneuver:
        said = [said[int(maneuver) - 1]]
    if what == "bound":
        return power(max((m["bound"] for m in said), key=float))
    if what == "dense":
        relative = [x for m in said for x in m["dense_relative_bounds"].values()]
        return power(max(relative, key=float))
    counted = {
        "steps": lambda m: m["steps"],
        "ambiguous": lambda m: m["ambiguous"] + m["sensitivities"]["ambiguous"],
        "values": lambda m: sum(x["entries"] for x in (m, m["motion"], m["sensitivities"])),
    }[what]
    return f"{sum(map(counted, said)):,}"


@fact("docs/verify.md, tests/checker", "tests/checker/check")
def checker(what):
    """Of the checker in C++: its bound in a maneuver, the values it found right, its lines."""
    page = text_of("docs/verify.md")
    said = among(page, r"(?s)## The digits: a checker of its own(.*?)\n## ")
    if what == "values":
        return among(said, r"all ([\d,]+) values of the benchmark's eight columns")
    if what == "damages":
        return among(said, r"the (\d+) kinds of damage")
    if what == "lines":
        files = [p for p in (ROOT / "tests" / "checker").iterdir() if p.suffix in (".hpp", ".cpp")]
        lines = [x.strip() for p in files for x in p.read_text(encoding="utf-8").splitlines()]
        return str(sum(bool(x) and not x.startswith("//") for x in lines))
    return power(among(said, rf"\| {what} \| \S+ \| (\S+) \|"))


@fact(
    "tests/bicycle/test_the_equations_are_identities.py",
    "pytest tests/bicycle/test_the_equations_are_identities.py",
)
def overlooked():
    """With what probability a false identity passes, at most."""
    test = text_of("tests/bicycle/test_the_equations_are_identities.py")
    return f"$10^{{-{among(test, r'OVERLOOKED = Fraction.1, 10..([0-9]+)')}}}$"


@fact(
    "reference/after-ten-seconds/after-ten-seconds.json", "heyoka-bike certify --after-ten-seconds"
)
def after(what, digits):
    """A certified number of what follows the ten seconds."""
    proofs = document("reference/after-ten-seconds/after-ten-seconds.json")["proved"]
    return f"{float({k: x for p in proofs for k, x in p['numbers'].items()}[what]):.{digits}g}"


@fact("data/peers", "heyoka-bike score data/peers/FILE --format json")
def wrong(file, maneuver, column):
    """Largest error of a column of a result file, in percent of its largest value."""
    said = _score(file)["maneuvers"][int(maneuver) - 1]["columns"]
    return f"{100 * next(c['max_rel_error'] for c in said if c['key'] == column):.2g}"


@fact("data/peers", "heyoka-bike score data/peers/FILE --format json")
def drift(file, maneuver):
    """Eq. (1) of a result file [%]."""
    return power(_score(file)["maneuvers"][int(maneuver) - 1]["performance"])


@cache
def _score(file):
    return json.loads(_said("score", f"data/peers/{file}", "--format", "json"))


@fact("data/peers", "heyoka-bike score data/peers/FILE --summary")
def summary(file):
    """What `score` says of a result file in short."""
    return _said("score", f"data/peers/{file}", "--summary").strip()


def _said(*arguments):
    """What a command prints, at a terminal as wide as the page."""
    command = [sys.executable, "-m", "heyoka_bike", *arguments]
    env = os.environ | {"COLUMNS": "92", "NO_COLOR": "1"}
    done = subprocess.run(command, cwd=ROOT, env=env, text=True, stdout=subprocess.PIPE, check=True)
    return done.stdout


@fact("reference/uncontrolled-bicycle.h5", "docs/definitions.md")
def apart(column, definition, maneuver):
    """How far a definition is from the default one, in percent of the largest value."""
    rows = load_reference()[int(maneuver)].rows
    far = np.abs(rows[f"{column}_{definition}"] - rows[column]).max()
    return f"{100 * far / np.abs(rows[column]).max():.2g}"


@fact("docs/speed.md", "python docs/_site/speed_page.py")
def midpoint(what, maneuver="1"):
    """Of the implicit midpoint rule: its step [s], its eq. (1) [%], its error of the roll [%]."""
    if what == "step":
        return f"{STEP:g}"
    line = among(part("speed.md", "energy"), rf"\| {maneuver} (\| .* %)")
    return power(among(line, r"([0-9.]+e-[0-9]+)")) if what == "drift" else among(line, r"(\d+) %")


@fact("docs/reference/mistakes.md", "python docs/_site/recognised_table.py")
def recognised(error):
    """How many mistakes are named right, of those that show beside an integrator's error."""
    return among(part("reference/mistakes.md", "recognised"), rf"\| {error} \| (\d+ of \d+) \|")


@fact("docs/reference/mistakes.md", "cat FILE")
def foreign(what):
    """Of mistakes by somebody who knew nothing of the library: made, and what was said of them."""
    found = re.search(
        r"Another (\d+) mistakes .*?: (\d+) were named first, (\d+) nearly, for (\d+) nothing was "
        r"reported, and for (\d+)\s", " ".join(text_of("docs/reference/mistakes.md").split()),
    )  # fmt: skip
    names = ("made", "first", "nearly", "silent", "wrong")
    counts = dict(zip(names, map(int, found.groups()), strict=True))
    if counts["made"] != sum(counts[x] for x in names[1:]):
        raise ValueError(f"docs/reference/mistakes.md: found {counts}, expected all of those made")
    return str(counts[what])


@fact("tests/games/play.py", "python tests/games/play.py wrong, and honest")
def played(game):
    """How many files a game against the scorer has."""
    files = among(text_of("tests/games/play.py"), rf'COUNTS = .*"{game}": ([0-9]+)')
    return f"{int(files):,}"


@fact("data/peers/exudyn.toml", "cat FILE")
def step(file):
    """Step of a run of Exudyn [s]."""
    runs = tomllib.loads(text_of("data/peers/exudyn.toml"))["run"]
    return next(r["step"] for r in runs if r["file"] == file)


@fact("docs/reference/mistakes.md", "python docs/_site/recognised_table.py")
def level(error):
    """An integrator's error, in parts of each column's scale."""
    return power(among(part("reference/mistakes.md", "recognised"), rf"\| ({error}) \| \d+ of"))


@fact("docs/proof.md", "grep -c '^- ..H' docs/proof.md")
def hypotheses():
    """How many the whole proof has."""
    found = {
        int(n) for n in re.findall(r"^- \*\*H(\d+)\. ", text_of("docs/proof.md"), re.MULTILINE)
    }
    if not found or found != set(range(1, len(found) + 1)):
        raise ValueError(f"docs/proof.md: found hypotheses {sorted(found)}, expected no gap")
    return str(len(found))


@fact("docs/harder-tier.json", "python docs/_site/harder_tier.py H1 H3")
def condition(problem):
    """Largest factor by which a motion of a problem magnifies a small error of its start."""
    largest = max(
        m["condition"] for m in document("docs/harder-tier.json")[problem]["maneuvers"].values()
    )
    return f"{largest:.0f}" if largest < 1000 else power(largest)
