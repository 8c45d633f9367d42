"""Values that were found in a file, as a program that has them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from heyoka_bike.scoring.diagnosis.programs.program import Found, Mistake, Program, changed
from heyoka_bike.scoring.diagnosis.programs.start import STATE


def other_values(
    changes: Mapping[str, float], uncertain: Mapping[str, float], program: Program
) -> Mistake:
    """A program with parameters and forces of other values than the right one."""
    found = []
    for name, change in changes.items():
        right = float(program.bicycle[name]) if name in program.bicycle.values else 0.0
        found.append(Found(name, None, right + change, right, uncertain[name]))
    return _mistake(found, lambda p: changed(p, changes), "model")


def other_start(found: Sequence[Found]) -> Mistake:
    """A program that starts otherwise."""
    added: dict[int, tuple[tuple[int, float], ...]] = {}
    for x in found:
        place = STATE.index(x.name.removeprefix("initial_"))
        assert x.maneuver is not None
        added[x.maneuver] = (*added.get(x.maneuver, ()), (place, x.value - x.right))

    def make(program: Program) -> Program:
        starts = {
            n: replace(s, added=(*s.added, *added.get(n, ()))) for n, s in program.starts.items()
        }
        return replace(program, starts=starts)

    return _mistake(found, make, "start")


def _mistake(found: Sequence[Found], change: Callable[[Program], Program], kind: str) -> Mistake:
    code = "_".join(["other", *(f"{x.name}_{x.maneuver or ''}".strip("_") for x in found)])
    check = ("it" if len(found) == 1 else "them") + " in your input"
    return Mistake(code, "", check, kind, change, is_fitted=True, found=tuple(found))
