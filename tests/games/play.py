"""Play the two games against the scorer: wrong files that must not pass, honest ones that must.

python tests/games/play.py wrong            # 20,000 files, 0.11 s of processor time each
python tests/games/play.py honest           # 5,000 files, 0.15 s each
python tests/games/play.py wrong --first 5000 --count 5000 --processes 1   # a slice, one process
python tests/games/play.py wrong --case 123 # one of them, with its outcome
"""

import argparse
import os
import sys
import tempfile
import traceback
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

from games import writing
from games.files import EIGHT, END, in_memory, references
from games.honest_files import honest_file, known
from games.wrong_files import wrong_file
from heyoka_bike import read_results, score
from heyoka_bike.bicycle.columns import COMPARED
from heyoka_bike.errors import BicycleError
from heyoka_bike.scoring import score as scoring

SEED = 1
COUNTS = {"wrong": 20000, "honest": 5000}
# Fraction of the drawn files that are written to disk and read back.
WRITTEN = {"wrong": 0.12, "honest": 0.4}
# Difference in digits between two correct computations: unit conversions turn an error of one unit
# in the last place into one or two units.
_ARITHMETIC = 0.1
# [s] Rows cover the run if neighbouring rows are at most this far apart.
MOST_APART = 0.25
# A file that covers this fraction of the run counts as covering the whole run.
_WHOLE = 0.99
# Values with at least this many correct digits are not called wrong.
_CLOSE = 3.0
# Largest number of correct digits that can be known: between the published rows, values are known
# to 31 digits.
_MOST = 30.5


@dataclass(frozen=True)
class Outcome:
    """The outcome of a file: `lost` describes the scorer's failures, and is empty without any.

    `claims` are the definitions that the scorer claims: decimal logarithms of the odds, and whether
    they contradict the truth.
    """

    number: int
    kind: str
    lost: tuple[str, ...] = ()
    is_refused: bool = False
    claims: tuple[tuple[float, bool], ...] = ()


def play_wrong(number, seed=SEED):
    """Play one wrong file; it is lost if a requirement that it does not fulfil is met."""
    wrong = wrong_file(seed, number)
    random = np.random.default_rng([seed, number, 1])
    form = "memory"
    try:
        with tempfile.TemporaryDirectory() as folder:
            if wrong.text:
                form, file = "text", Path(folder) / "file.csv"
                file.write_text(wrong.text)
                results = read_results(file)
            else:
                results = in_memory(wrong.parts, wrong.quantum)
            if not wrong.text and random.random() < WRITTEN["wrong"]:
                form, results = _through_files(random, wrong.parts, Path(folder))
            report = score(results, references()[0])
            # Check a requirement on the amount of data separately, because it would set the
            # required amount for the other requirements too.
            fails = dict.fromkeys(wrong.fails)
            asked = [text for text in fails if not _is_amount(text)]
            found = [*scoring.check(asked, report)]
            for text in fails.keys() - asked:
                found += scoring.check([text], report)
    except BicycleError as e:
        # A misread requirement hides the fault that it should show, so it counts as a failure of
        # the scorer.
        lost = (str(e),) if str(e).startswith("require") else ()
        return Outcome(number, wrong.kind, lost, is_refused=True)
    except Exception:
        return Outcome(number, wrong.kind, (f"{form}: {traceback.format_exc()[-400:]}",))
    lost = [f"{form}: {r.text} is met: {r.message}" for r in found if r.met]
    said = report.verdict.partition(": ")[2]
    is_favoured = said.startswith("right") and "compared only in part" not in said
    if wrong.is_not_right and (report.is_right or is_favoured):
        lost.append(f"{form}: is said to be {said}")
    return Outcome(number, wrong.kind, tuple(lost))


def _is_amount(text):
    """Return whether a requirement limits the amount of data from the benchmark."""
    return text.partition(" >= ")[0].rpartition(".")[2] in ("columns", "coverage")


def _through_files(random, parts, folder):
    """Write everything to one file, or one file per maneuver if the times differ, and read it."""
    shared = all(np.array_equal(p.time, parts[0].time) for p in parts)
    groups = [parts] if shared else [[p] for p in parts]
    form = _form(random, parts)
    digits = 32 if any(v.any() for p in parts for v in p.lo.values()) else 17
    found = []
    for i, group in enumerate(groups):
        source, _ = writing.write(random, group, folder / f"part{i}", form, digits)
        found.append(writing.read(source, group))
    return form, found


def _form(random, parts, digits=17):
    forms = [*writing.TEXTS, *writing.ARRAYS]
    if digits > 17 or any(v.any() for p in parts for v in p.lo.values()):
        forms = list(writing.TEXTS)
    elif not writing.is_plain(parts) or len({p.time.tobytes() for p in parts}) > 1:
        forms = [f for f in forms if f not in writing.NEEDS_ALL]
    if sum(len(p.time) * len(p.hi) for p in parts) > writing.MOST_AMONG_WORDS:
        # In longer texts, rows are recognised only if they consist of numbers alone.
        forms = [f for f in forms if f not in writing.AMONG_WORDS]
    return str(random.choice(forms))


def play_honest(number, seed=SEED):
    """Play one honest file; it is lost if rejected, short of a digit, or judged too badly."""
    random, honest = honest_file(seed, number)
    kind, said = "memory", honest.parts
    try:
        with tempfile.TemporaryDirectory() as folder:
            if random.random() < WRITTEN["honest"]:
                kind = _form(random, said, honest.digits)
                source, said = writing.write(
                    random, said, Path(folder) / "file", kind, honest.digits
                )
                results = writing.read(source, said)
            else:
                results = in_memory(said)
            true = known(honest, said)
            requirements = _fulfilled(said, true, honest)
            report = score(results, references()[0], requirements)
    except BicycleError as e:
        return Outcome(number, kind, (f"refused: {e}",), is_refused=True)
    except Exception:
        return Outcome(number, kind, (traceback.format_exc()[-400:],))
    lost = [f"{r.text} is not met: {r.message}" for r in report.requirements if not r.met]
    said = report.verdict.partition(": ")[2]
    is_close = min(_allowed(k)[1] for k in true.values()) >= _CLOSE
    if is_close and said.startswith(("wrong", "the signs")):
        lost.append(f"is said to be {said}")
    found = {(m.maneuver, c.key): c for m in report.maneuvers for c in m.columns}
    asked = set(true) | {(n, honest.own) for n, _ in true if honest.own}
    if set(found) != asked:
        lost.append(f"columns left out or added: {set(found) ^ asked}")
    for at, column in found.items():
        if at in true:
            lost += _digits_lost(at, column, true[at])
    return Outcome(number, kind, tuple(lost), claims=tuple(_claims(report, honest)))


def _claims(report, honest):
    """Return for each column the odds of its claimed definition, and whether it is wrong."""
    for key, places in report.by_column().items():
        c = places[0][1]
        told = [a.log10_odds for a in c.alternatives if a.log10_odds is not None]
        if c.none_odds is not None and told and not c.indistinguishable:
            name = next(x.name for x in COMPARED[key] if x.definition == c.definition)
            is_wrong = key == honest.own or name != honest.readings[key][0]
            yield min(*told, c.none_odds), is_wrong


def _allowed(true):
    """Return the largest error that the scorer may report, and the digits that it must report."""
    error = (true.max_abs_error + true.hidden) * 10**_ARITHMETIC
    digits = _MOST if error == 0.0 else -np.log10(error / true.scale)
    return error, min(digits, _MOST - _ARITHMETIC)


def _fulfilled(parts, true, honest):
    """Return requirements that the file barely fulfils, up to differences of arithmetic."""
    gap = max(np.diff(p.time, append=END).max() for p in parts) + 1e-9
    digits = min(_allowed(k)[1] for k in true.values())
    found = [f"gap <= {gap:.9f}"]
    if not honest.own:
        found.append(f"scd >= {digits - 1e-6:.6f}")
    gaps = [np.diff(p.time) for p in parts]
    covered = min(float(x[x <= MOST_APART].sum()) / END for x in gaps)
    if gap < MOST_APART and covered >= _WHOLE:
        found.append("coverage >= 1")
    elif covered < _WHOLE:
        found.append(f"coverage >= {covered - 1e-9:.9f}")
    if (count := min(sum(k in EIGHT for k in p.hi) for p in parts)) < len(EIGHT):
        found.append(f"columns >= {count}")
    for n in {n for n, key in true if key == "mechanical_energy"}:
        energy = true[n, "mechanical_energy"]
        if honest.zero and (n, "potential_energy") not in true:
            # The zero of this energy is unknown. Any constant energy would then meet the
            # requirement, so it is no fault if `score` does not count this energy.
            continue
        if 200 * _allowed(energy)[0] < 1e-3 * energy.scale:
            found.append(f"{n}.performance < 1e-3")
    for (n, key), k in true.items():
        if k.max_abs_error > 10**-_MOST * k.scale:
            found.append(f"{n}.{key}.max_abs_error <= {_allowed(k)[0]:.9e}")
    return found


def _digits_lost(at, column, true):
    found = column.as_understood.measures.scd
    if found is not None and found < _allowed(true)[1]:
        taken = column.as_understood
        yield (f"{at[0]}.{at[1]}: {found:.2f} digits, {true.scd:.2f} are right; taken as "
               f"{taken.definition}, sign {taken.sign:+d}, {taken.unit}")  # fmt: skip


GAMES = {"wrong": play_wrong, "honest": play_honest}


def play(game, numbers, seed=SEED, *, processes=None, show=lambda outcome: None):
    """Return the outcomes of the files of these numbers, each shown when it is known."""
    one = partial(GAMES[game], seed=seed)
    outcomes = []
    with ExitStack() as stack:
        if processes == 1:
            each = map(one, numbers)
        else:
            started = ProcessPoolExecutor(processes, get_context("spawn"))
            each = stack.enter_context(started).map(one, numbers, chunksize=20)
        for outcome in each:
            outcomes.append(outcome)
            show(outcome)
    return outcomes


def _describe(game, number, seed):
    if game == "wrong":
        wrong = wrong_file(seed, number)
        print(f"{wrong.kind}: {wrong.keys} of maneuvers {wrong.maneuvers}, not fulfilled:")
        print(*(f"  {text}" for text in wrong.fails), sep="\n")
    else:
        _, honest = honest_file(seed, number)
        drawn = {k: f"{name} x {float(f):.6g}" for k, (name, f) in honest.readings.items()}
        print(f"maneuvers {[p.maneuver for p in honest.parts]}, rows {honest.spacing}, "
              f"{honest.digits} digits, error {honest.size:.1e}, zero {honest.zero}")  # fmt: skip
        print(*(f"  {k}: {what}" for k, what in drawn.items()), sep="\n")
    outcome = GAMES[game](number, seed)
    print(*(outcome.lost or ["not lost" + ", refused" * outcome.is_refused]), sep="\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("game", choices=GAMES)
    parser.add_argument("--count", type=int, help="how many (20000 wrong or 5000 honest)")
    parser.add_argument("--first", type=int, default=0, help="number of the first (0)")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--case", type=int, help="one file by its number, and what was drawn")
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    given = parser.parse_args()
    if given.case is not None:
        _describe(given.game, given.case, given.seed)
        return
    count = given.count or COUNTS[given.game]

    numbers = range(given.first, given.first + count)

    def show(outcome):
        if outcome.lost:
            print(f"{outcome.number} ({outcome.kind}): {outcome.lost[0]}", flush=True)
        done = outcome.number - given.first + 1
        if sys.stderr.isatty() or done % 500 == 0:
            end = "\r" if sys.stderr.isatty() else "\n"
            print(f"{done} of {count}", end=end, file=sys.stderr, flush=True)

    found = play(given.game, numbers, given.seed, processes=given.processes, show=show)
    claims = [is_wrong for o in found for log10, is_wrong in o.claims if log10 > 2]
    if claims:
        print(f"{sum(claims)} of {len(claims)} claims at odds above 100 against the truth")
    lost = [o for o in found if o.lost]
    kinds, of = Counter(o.kind for o in lost), Counter(o.kind for o in found)
    for kind, n in kinds.most_common():
        print(f"{kind}: {n} of {of[kind]} lost")
    print(f"{given.game}: {len(lost)} of {len(found)} lost, {sum(o.is_refused for o in found)} "
          f"refused; seed {given.seed}, {len(of)} kinds")  # fmt: skip
    sys.exit(3 if lost else 0)


if __name__ == "__main__":
    main()
