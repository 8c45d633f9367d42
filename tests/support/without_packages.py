"""A Python process in which some packages cannot be imported."""

import subprocess
import sys

BLOCK = """
import sys
class Block:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {blocked!r}:
            raise ModuleNotFoundError(f"{{name}} is blocked", name=name)
sys.meta_path.insert(0, Block())
"""
HEAVY = {"heyoka", "flint", "mpmath", "scipy", "matplotlib", "rich", "plotly"}


def python(code, blocked=()):
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", BLOCK.format(blocked=set(blocked)) + code],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
