"""after-ten-seconds.json: what is proved of the motions after their ten seconds, and its check.

It lies in a folder of its own, beside the candidates that it follows from (candidate.h5). Numbers
are correctly rounded to the digits they have.
"""

import json
from collections.abc import Callable, Sequence
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

from heyoka_bike.bicycle.parameters import Maneuver, benchmark, describe_inputs
from heyoka_bike.errors import DatasetError, NotCertifiedError
from heyoka_bike.motion.trajectory import Trajectory
from heyoka_bike.numbers.rounding import Enclosure
from heyoka_bike.reference.layout import AFTER, CANDIDATE
from heyoka_bike.reference.proof.candidate import parse_candidate
from heyoka_bike.system.jobs import Report
from heyoka_bike.system.parallel import Progress, side_by_side
from heyoka_bike.system.resources import after_folder
from heyoka_bike.workbench.after_ten_seconds.facts import (
    USED,
    Fact,
    cycle_fact,
    fall_fact,
    settling_fact,
)

_MOST_DIGITS = 30
_SHOWN = 60  # characters of what is found in a file

Digits = Callable[[Enclosure, str, str], int]
"""The number of digits of a value, by maneuver and name."""


def prove_facts(
    cycle: Trajectory, fall: Trajectory, progress: Progress | None = None
) -> tuple[Fact, ...]:
    """All that is said of the maneuvers of the benchmark, from the two candidates.

    Raises
    ------
    NotCertifiedError
        Something is not shown, or a candidate is about other inputs.
    """
    bicycle, maneuvers = benchmark()
    for run in (cycle, fall):
        if describe_inputs(run.bicycle, []) != describe_inputs(bicycle, []):
            raise NotCertifiedError(f"{run.maneuver.name}: it is not about the benchmark's bicycle")
    if _start(fall.maneuver) != _start(maneuvers[2]):
        raise NotCertifiedError(f"{fall.maneuver.name}: it does not start as {maneuvers[2].name}")
    weaving, falling = side_by_side(
        _prove,
        [(cycle, maneuvers[0]), (fall, None)],
        [(run.maneuver.name, float(run.breaks[-1])) for run in (cycle, fall)],
        progress,
    )
    return weaving, settling_fact(bicycle, maneuvers[1]), falling


def _prove(run: Trajectory, like: Maneuver | None, report: Report) -> Fact:
    def progress(t: float) -> None:
        report("certify", t)

    return fall_fact(run, progress) if like is None else cycle_fact(run, like, progress)


def _start(m: Maneuver) -> tuple[Any, ...]:
    return m.speed, m.roll_rate, m.roll, m.steer, m.steer_rate


def render_facts(facts: Sequence[Fact], digits: Digits | None = None) -> bytes:
    """Bytes of after-ten-seconds.json.

    Raises
    ------
    NotCertifiedError
        A number is not decided to its digits.
    """
    count = digits or (lambda x, about, name: _decided(x))
    document = {
        "schema_version": 1,
        "inputs": describe_inputs(*benchmark()),
        "proved": [
            {
                "about": fact.about,
                "statement": fact.statement,
                "numbers": {
                    name: _text(x, count(x, fact.about, name), name)
                    for name, x in fact.numbers.items()
                },
            }
            for fact in facts
        ],
        "used": USED,
    }
    return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


def _decided(x: Enclosure) -> int:
    """The most digits that an enclosure decides."""
    return next((n for n in range(_MOST_DIGITS, 0, -1) if x.decimal(n) is not None), 1)


def _text(x: Enclosure, digits: int, name: str) -> str:
    text = x.decimal(digits)
    if text is None:
        raise NotCertifiedError(f"{name}: {digits} digits are not decided")
    return str(Decimal(text))


def certify_after(
    folder: str | Path | None = None, *, progress: Progress | None = None
) -> tuple[Fact, ...]:
    """Prove again what after-ten-seconds.json says, from the candidates beside it.

    Parameters
    ----------
    folder
        By default the one that comes with the package.
    progress
        As for `certify`; the stage is ``certify``.

    Raises
    ------
    NotCertifiedError
        Something is not shown, or the file says something else.
    DatasetError
        A file is missing, or not of its kind.
    """
    where = after_folder() if folder is None else Path(folder)
    raw = _read(where / AFTER)
    runs = parse_candidate(_read(where / CANDIDATE), where / CANDIDATE)
    try:
        said = {x["about"]: x["numbers"] for x in json.loads(raw)["proved"]}
        found = {(about, name): text for about, x in said.items() for name, text in x.items()}
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as e:
        raise DatasetError(f"{where / AFTER}: is not a file of proved facts ({e})") from None
    if len(runs) != 2:
        raise DatasetError(f"{where / CANDIDATE}: found {len(runs)} motions, expected 2")
    facts = prove_facts(*runs, progress)
    proved = {(fact.about, name): x for fact in facts for name, x in fact.numbers.items()}
    for key in found.keys() ^ proved.keys():
        what = "nothing proves it" if key in found else "it is missing"
        raise NotCertifiedError(f"{where / AFTER}: {', '.join(key)}: {what}")
    for key, x in proved.items():
        text = _text(x, _digits(found[key]), ", ".join(key))
        if text != found[key]:
            raise NotCertifiedError(
                f"{where / AFTER}: {', '.join(key)}: published {found[key]!r:.{_SHOWN}}, "
                f"proved {text}"
            )
    if raw != render_facts(facts, lambda x, about, name: _digits(found[about, name])):
        raise NotCertifiedError(f"{where / AFTER}: its inputs or sentences are not what is proved")
    return facts


def _digits(text: object) -> int:
    """Significant digits of a published number; 1 if it is none."""
    try:
        return max(len(Decimal(str(text)[:_SHOWN]).as_tuple().digits), 1)
    except InvalidOperation:
        return 1


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as e:
        raise DatasetError(f"{path}: cannot be read: {e.strerror or e}") from None
