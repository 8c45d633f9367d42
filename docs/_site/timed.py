"""How long commands take, and whether what they write is the same."""

import resource
import subprocess
import time


def timed(words):
    """Wall and processor time [s] of a command, with those of processes that it has waited for."""
    before, start = processor_time(), time.monotonic()
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - start, processor_time() - before


def processor_time():
    """Of all processes that were started here and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def content(folder):
    """Bytes of each file in a folder."""
    return {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
