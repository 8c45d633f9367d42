"""The command line on files that are hardly any: how each call ends, and how much it takes."""

import os
import random
import time
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

from corpus.files import files
from corpus.writing import Runs, text
from generators import degenerate_tables
from heyoka_bike.cli import main
from heyoka_bike.errors import Exit
from heyoka_bike.reference.load import load_reference

DOCUMENTED = {Exit.OK, Exit.INPUT, Exit.NOTHING_SCORED, Exit.CHECK_FAILED, Exit.STOPPED_EARLY}
PRELOAD = ("support.degenerate_runs", "heyoka_bike.workbench.serving.preload")
LONGEST = 25.0
"""Processor time of a call [s]: the usual budget of a diagnosis, and by how much it may pass it."""


class Ended:
    """How calls of a process ended.

    Attributes
    ----------
    codes : Counter
        Calls by exit code.
    faults : list of str
        Calls whose code is not documented, that took too long, or that do not say one line.
    """

    def __init__(self):
        self.codes, self.faults = Counter(), []

    def call(self, what, words):
        """Carry out a command; `what` is the file, for those who have to make it again."""
        out, err, begin = StringIO(), StringIO(), time.process_time()
        with redirect_stdout(out), redirect_stderr(err):
            code = int(main(words))
        took, said = time.process_time() - begin, err.getvalue()
        self.codes[code] += 1
        has_result = code in (Exit.OK, Exit.CHECK_FAILED, Exit.STOPPED_EARLY)
        is_told = bool(out.getvalue()) and not said if has_result else said.count("\n") == 1
        if code not in DOCUMENTED or took > LONGEST or not is_told:
            del words[1]
            self.faults.append(f"{what}: {' '.join(words)}: {code}, {took:.1f} s: {said[-300:]}")
        return code

    def told(self):
        """What JSON can write: codes, faults, and the most memory of the process [bytes]."""
        return [list(self.codes.items()), self.faults, _most_memory()]


def on_tables(seed, first, count, words, folder):
    """A command on tables of a seed."""
    reference, ended = load_reference(), Ended()
    path = Path(folder) / f"{os.getpid()}.txt"
    for number in range(first, first + count):
        pick = random.Random(f"{seed}-{number}")
        written, maneuvers = degenerate_tables.text(reference, pick)
        path.write_text(written)
        is_named = maneuvers == 1 and pick.random() < 0.7
        more = ["--maneuver", "123"[pick.randrange(3)]] if is_named else []
        ended.call(f"{seed}-{number}", [words[0], str(path), *words[1:], *more])
    return ended.told()


def on_corpus(part, parts, every, words, folder):
    """A command on every so many rows of the corpus's files, of which this is one of some parts."""
    runs, ended = Runs(), Ended()
    path = Path(folder) / f"{os.getpid()}.txt"
    for file in list(files(runs.index))[part::parts]:
        lines = text(file, runs).splitlines()
        heading = lines[: lines[0].startswith("time")]
        rows = lines[len(heading) :]
        # A short file shows the same with all of its rows.
        few = rows[:: every if len(rows) > 10 * every else 1]
        path.write_text("\n".join([*heading, *few]) + "\n")
        call = [words[0], str(path), *words[1:]]
        if ended.call(file.name, call) == Exit.NOTHING_SCORED and len(file.maneuvers) == 1:
            ended.call(file.name, [*call, "--maneuver", str(file.maneuvers[0])])
    return ended.told()


def _most_memory():
    """The most memory that this process took so far [bytes]; 0 where the system does not say."""
    try:
        import resource
    except ImportError:
        return 0
    # On Linux in kB.
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
