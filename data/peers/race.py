"""The race of the field: the cheapest run of maneuver 2 of each program that passes eq. (1), timed.

Digits do not depend on what else the machine does, times do. So this part is short, can be run
alone, and measures the C code beside which times are given right before and after each run.
"""

import os

from apart import AbsentError
from measured import H1, now
from peer import NAME, Peer

MANEUVER, PASSES = 2, 1e-3
"""The maneuver that the benchmark judges, and its limit of eq. (1) [%]."""
# A run is repeated until it has taken so long [s], so many times at least and at most.
LEAST, MOST, SECONDS = 3, 9, 3.0


def cheapest(programs):
    """Name and line of the cheapest run that passes, by folder: ways to use a program share one.

    Equations that are linear or of this project are rows like the others. Of the family of the run
    that took least it is the coarsest run that passes: a finer one was faster by chance.
    """
    found = {}
    for name, said in programs.items():
        for line in said["runs"]:
            if line["failure"] is None and judged(line)["performance"] < PASSES:
                folder = said["script"].partition("/")[0]
                known = found.get(folder)
                if known is None or judged(line)["cpu"] < judged(known[1])["cpu"]:
                    found[folder] = name, line
    return {folder: (name, coarsest(programs[name], x)) for folder, (name, x) in found.items()}


def coarsest(said, line):
    """The coarsest run of the family of a run that passes."""
    alike = [
        r for r in said["runs"]
        if r["failure"] is None and r["family"] == line["family"]
        and judged(r)["performance"] < PASSES
    ]  # fmt: skip
    return max(alike, key=lambda r: r["setting"][said["measure"]])


def judged(line):
    """What a run has of the maneuver."""
    return next(m for m in line["maneuvers"] if m["maneuver"] == MANEUVER)


def race(document, apart, names):
    """Time the cheapest runs of some programs and write the times down; print a line for each.

    Of the others, and of what is not here, times of an earlier race on this machine are kept.
    """
    against, rows = Peer(MANEUVER), {}
    before = document.content.get("race", {"machine": None})
    earlier = before["rows"] if before["machine"] == document.machine else {}
    document.content["race"] = {
        "machine": document.machine, "started": now(), "maneuver": MANEUVER,
        "peer": {"name": NAME, "digits": against.digits()}, "rows": rows,
    }  # fmt: skip
    fastest = cheapest(document.content["programs"]).values()
    for name, line in fastest:
        if earlier.get(name, {}).get("setting") == line["setting"]:
            rows[name] = earlier[name]
    for name, line in fastest:
        if name not in names:
            continue
        with apart(name) as program:
            try:
                program(H1, line["setting"], MANEUVER)  # to derive, compile and load
            except AbsentError as e:
                print(name, "is not here:", e, flush=True)
                continue
            times, beside = [], [against.time()]
            while len(times) < LEAST or (len(times) < MOST and sum(times) < SECONDS):
                _, [cost] = program(H1, line["setting"], MANEUVER)
                times.append(cost["cpu"])
                beside.append(against.time())
        ratio = min(times) / min(beside)
        rows[name] = {
            "setting": line["setting"],
            "times": [float(f"{x:.4g}") for x in times],
            "peer": [float(f"{x:.4g}") for x in beside],
            "ratio": float(f"{ratio:.3g}"),
            "load": round(os.getloadavg()[0], 1),
        }
        print(f"{name}, {line['words']}: {ratio:.3g} times the peer's {min(beside):.3g} s",
              f"slowest over fastest {max(times) / min(times):.2f}, the peer's "
              f"{max(beside) / min(beside):.2f}", sep="; ", flush=True)  # fmt: skip
        document.write()
