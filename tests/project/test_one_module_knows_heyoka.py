"""Only one module uses heyoka's API; all others use this module.

heyoka is imported at run time, by its name in a string, which no import contract sees.
"""

import ast
from pathlib import Path

import heyoka

ROOT = Path(__file__).resolve().parents[2]
ADAPTER = ROOT / "heyoka_bike" / "motion" / "heyoka_adapter.py"
ASKING = ("heyoka_bike", "data", "docs")
API = {
    "cfunc", "install_custom_numpy_mem_handler", "llvm_state", "make_vars", "nt_event", "real128",
    "recommended_simd_size", "t_event_batch", "taylor_adaptive", "taylor_adaptive_batch",
    "taylor_outcome",
}  # fmt: skip
"""Names of heyoka that nothing else here has."""


def uses(text):
    """How a module imports heyoka, and the names of the API that it uses."""
    tree = ast.parse(text)
    calls = (x for x in ast.walk(tree) if isinstance(x, ast.Call) and x.args)
    imports = {
        ast.unparse(x.func)
        for x in calls
        if isinstance(x.args[0], ast.Constant) and x.args[0].value == "heyoka"
    }
    # A table may contain the name of an integrator, which is not an import.
    imports &= {"required", "import_module", "importlib.import_module", "__import__"}
    return imports | {x.attr for x in ast.walk(tree) if isinstance(x, ast.Attribute)} & API


def test_the_names_are_those_of_heyoka():
    assert {name for name in API if not hasattr(heyoka, name)} == set()


def test_every_other_module_asks_the_adapter():
    modules = (p for folder in ASKING for p in (ROOT / folder).rglob("*.py") if p != ADAPTER)
    others = {p: uses(p.read_text(encoding="utf-8")) for p in modules}
    assert {p.relative_to(ROOT).as_posix(): names for p, names in others.items() if names} == {}


def test_the_adapter_is_seen_to_use_it():
    assert {"required", "taylor_adaptive", "cfunc", "make_vars"} <= uses(ADAPTER.read_text())
    assert uses("hy.taylor_outcome.success") == {"taylor_outcome"}
    assert uses('m = import_module("heyoka")') == {"import_module"}
