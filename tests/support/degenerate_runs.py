"""The command line on degenerate files: outcome and resources of each call."""

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
"""Limit of a call's processor time [s]: the usual budget of a diagnosis, and a margin."""


class Ended:
    """The outcomes of a process's calls.

    Attributes
    ----------
    codes : Counter
        Number of calls by exit code.
    faults : list of str
        Calls with an undocumented exit code, too much time, or an error message not of one line.
    """

    def __init__(self):
        self.codes, self.faults = Counter(), []

    def call(self, what, words):
        """Run a command; `what` identifies the file, so that a failure can be reproduced."""
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
        """Return JSON values: codes, faults, and the process's maximum memory [bytes]."""
        return [list(self.codes.items()), self.faults, _most_memory()]


def on_tables(seed, first, count, words, folder):
    """Run a command on the tables of a seed."""
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
    """Run a command on every `every`-th row of one part of the corpus's files."""
    runs, ended = Runs(), Ended()
    path = Path(folder) / f"{os.getpid()}.txt"
    for file in list(files(runs.index))[part::parts]:
        lines = text(file, runs).splitlines()
        heading = lines[: lines[0].startswith("time")]
        rows = lines[len(heading) :]
        # Use all rows of a short file, not only every `every`-th one.
        few = rows[:: every if len(rows) > 10 * every else 1]
        path.write_text("\n".join([*heading, *few]) + "\n")
        call = [words[0], str(path), *words[1:]]
        if ended.call(file.name, call) == Exit.NOTHING_SCORED and len(file.maneuvers) == 1:
            ended.call(file.name, [*call, "--maneuver", str(file.maneuvers[0])])
    return ended.told()


def _most_memory():
    """Return this process's maximum memory so far [bytes]; 0 if the system does not report it."""
    try:
        import resource
    except ImportError:
        return 0
    # Linux reports the memory in kB.
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
