"""The equations of motion of a bicycle as source code, with its parameters as constants.

`Equations` generates all functions, see `numbers.straight_line`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.descriptor import (
    COORDINATES,
    MULTIPLIERS,
    Descriptor,
    from_reduced,
    to_reduced,
)
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.equations.whole_motion import INTEGRALS, whole_rates
from heyoka_bike.bicycle.parameters import Bicycle, Maneuver
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers import straight_line as languages
from heyoka_bike.numbers.arithmetic import Balls, Number
from heyoka_bike.numbers.dual import Duals
from heyoka_bike.numbers.straight_line import Language, StraightLine
from heyoka_bike.reference.description import COPYRIGHT
from heyoka_bike.reference.exports.formats import (
    AXES,
    check_name,
    commented,
    parameter_lines,
    value_text,
    wrapped,
)
from heyoka_bike.version import __version__

_BITS_OF_CONSTANTS = 200

_Numbers = Sequence[Number]
# The name of a function, its description, and the arguments of `Language.function`.
_Function = tuple[Any, ...]


@dataclass(frozen=True, slots=True)
class _SourceFile:
    """Parts of a source file in one programming language, and how the file is used.

    Attributes
    ----------
    language : Language
    suffixes
        Suffix of the file, after that of a header that declares its functions, if any.
    mark
        Begins a comment.
    use
        The way to compile or call it.
    opening, closing
        First and last lines of the file, with ``{about}`` for its comment.
    each
        Text about each function's ``{name}``, which replaces ``{each}`` in the opening.
    named
        Name of a function outside of the file. All of these texts may contain the file's
        ``{stem}``.
    is_descriptor
        True if the file also has the descriptor form.
    """

    language: Language
    suffixes: tuple[str, ...]
    mark: str
    use: str
    opening: str
    closing: str = ""
    each: str = ""
    named: str = "{name}"
    is_descriptor: bool = False


_HEADER_OF_C = """{about}
#ifndef {stem}_h
#define {stem}_h

#ifdef __cplusplus
extern "C" {{
#endif

{each}#ifdef __cplusplus
}}
#endif

#endif
"""

LANGUAGES = {
    "c": _SourceFile(
        languages.C, (".h", ".c"), "//",
        "Compile: cc -std=c99 -O2 your-code.c {stem}.c -lm, with #include \"{stem}.h\".",
        '{about}\n#include "{stem}.h"\n#include <math.h>\n', named="{stem}_{name}",
        is_descriptor=True,
    ),
    "fortran": _SourceFile(
        languages.FORTRAN, (".f90",), "!",
        "Compile: gfortran -O2 {stem}.f90 your-code.f90, with 'use {stem}'.",
        "{about}\nmodule {stem}\n    use, intrinsic :: iso_fortran_env, only: real64\n"
        "    implicit none\n    private\n{each}\ncontains\n",
        "\nend module {stem}\n", "    public :: {name}\n",
    ),
    "matlab": _SourceFile(
        languages.MATLAB, (".m",), "%",
        "Use: b = {stem}(); [t, y] = ode45(b.rates, [0 10], b.start_1());",
        "function b = {stem}()\n{about}{each}end\n", "", "    b.{name} = @{name};\n",
    ),
    "julia": _SourceFile(
        languages.JULIA, (".jl",), "#",
        'Use: include("{stem}.jl"); using OrdinaryDiffEq; '
        "solve(ODEProblem({stem}.rates, {stem}.start_1(), (0.0, 10.0)), Vern9())",
        "{about}\nmodule {stem}\n", "\nend\n",
    ),
    "python": _SourceFile(
        languages.PYTHON, (".py",), "#",
        'Use: scipy.integrate.solve_ivp({stem}.rates, (0, 10), {stem}.start_1(), "DOP853").',
        "{about}\nfrom math import cos, sin, sqrt\n\n", is_descriptor=True,
    ),
    "rust": _SourceFile(
        languages.RUST, (".rs",), "//",
        "Use: mod {stem}; and then {stem}::rates(&{stem}::start_1()).",
        "{about}\n#![allow(dead_code)]\n\nfn sin(x: f64) -> f64 {{\n    x.sin()\n}}\n\n"
        "fn cos(x: f64) -> f64 {{\n    x.cos()\n}}\n",
    ),
}  # fmt: skip
"""Languages by the names that the command line accepts."""


def render(
    language: str, bicycle: Bicycle, maneuvers: Sequence[Maneuver], stem: str
) -> dict[str, bytes]:
    """Return the source files with the equations in a language, by file-name suffix.

    Raises
    ------
    InputError
        The name cannot be that of a module, or the code uses it, or a maneuver cannot start.
    """
    check_name(stem, "module")
    file = LANGUAGES[language]
    about = _about(language, bicycle, file.use.format(stem=stem))
    words = {"stem": stem, "about": commented(wrapped(about), file.mark)}
    each, parts, heads = [], [], []
    for name, says, *what in _functions(bicycle, maneuvers, is_descriptor=file.is_descriptor):
        says = commented(wrapped([says]), file.mark)
        text = file.language.function(file.named.format(name=name, stem=stem), *what)
        if re.search(rf"\b{stem}\b", text, re.IGNORECASE):  # Fortran ignores the case of names
            raise InputError(
                f"--output: {quoted(stem)} is a name in the code itself, expected another name of "
                "a module"
            )
        each.append(file.each.format(name=name))
        head, _, _ = text.partition("\n")
        heads.append(f"{says}{head};\n\n")
        parts.append(f"\n{says}{text}")
    opening = file.opening.format(each="".join(each), **words)
    found = [_HEADER_OF_C.format(each="".join(heads), **words)] if file.suffixes[1:] else []
    found.append("".join([opening, *parts, file.closing.format(**words)]))
    return {s: text.encode("ascii") for s, text in zip(file.suffixes, found, strict=True)}


def _about(language: str, bicycle: Bicycle, use: str) -> Iterator[str]:
    yield (
        f"The uncontrolled Carvallo-Whipple bicycle {quoted(bicycle.name)}: its equations of "
        "motion, not linearised."
    )
    yield f"Written by heyoka-bike export --equations {language}, {__version__}."
    yield f"Licence: {COPYRIGHT}."
    yield (
        f"{AXES} The state: roll, pitch and steer; roll_rate and steer_rate; spin, the forward "
        "speed over the radius rR of the rear wheel; yaw; the place of the rear contact point; the "
        "angles of the wheels in their frames. The pitch obeys the floor: a state that is not one "
        "of a motion needs the right one."
    )
    yield use
    yield "Parameters:"
    yield from parameter_lines(bicycle)


def _functions(
    bicycle: Bicycle, maneuvers: Sequence[Maneuver], *, is_descriptor: bool
) -> Iterator[_Function]:
    rounded = Equations.binary64(bicycle)
    state = (*rounded.states, *INTEGRALS)
    y = {"y": len(state)}

    def rates(code: StraightLine, y: _Numbers) -> _Numbers:
        return whole_rates(rounded.convert(code.literal, code), y)

    def jacobian(code: StraightLine, y: _Numbers) -> Sequence[_Numbers]:
        duals = Duals(code)
        found = whole_rates(rounded.convert(code.literal, duals), duals.variables(y))
        return [x.slopes for x in found]

    def columns(code: StraightLine, y: _Numbers) -> _Numbers:
        found = rounded.convert(code.literal, code).columns(y)
        return [found[name] for name in BENCHMARK_COLUMNS]

    says = f"Time derivative f of the state y: {', '.join(state)}."
    yield "rates", says, y, "f", rates, True
    says = "Jacobian: row i has the derivatives of rate i by the state."
    yield "jacobian", says, y, "j", jacobian, True
    says = f"The benchmark's columns after the time: {', '.join(BENCHMARK_COLUMNS)}."
    yield "columns", says, y, "c", columns
    starts = [_start(bicycle, m) for m in maneuvers]
    names = [
        f"{quoted(m.name)}: forward speed {value_text(m.speed)} m/s, roll rate "
        f"{value_text(m.roll_rate)} rad/s." for m in maneuvers
    ]  # fmt: skip
    for i, (name, start) in enumerate(zip(names, starts, strict=True), 1):
        yield f"start_{i}", f"State at the start of {name}", {}, "y", _given(start[0])
    if not is_descriptor:
        return
    yield from _descriptor_functions(rounded)
    for i, (name, start) in enumerate(zip(names, starts, strict=True), 1):
        yield f"descriptor_start_{i}", f"z at the start of {name}", {}, "z", _given(start[1])
        says = f"Derivative of z there, but for the forces: zero. {name}"
        yield f"descriptor_start_rates_{i}", says, {}, "zp", _given(start[2])


def _descriptor_functions(rounded: Equations) -> Iterator[_Function]:
    n = len(COORDINATES)
    z = {"z": 2 * n + len(MULTIPLIERS)}
    both = z | {"zp": z["z"]}

    def form(code: StraightLine) -> Descriptor:
        return Descriptor(rounded.b.convert(code.literal), code)

    def force(code: StraightLine, z: _Numbers) -> _Numbers:
        return [-x for x in form(code).inertia_forces(z[:n], z[n : 2 * n], [code.number(0)] * n)]

    says = (
        f"Mass matrix. Descriptor form: z has the coordinates q: {', '.join(COORDINATES)}; their "
        f"rates v; and the forces of the floor on the wheels: {', '.join(MULTIPLIERS)}."
    )
    yield "mass", says, z, "m", lambda code, z: form(code).mass(z[:n])
    yield "force", "f in mass v' = f + g^T forces.", z, "f", force
    says = "g in g v = 0: the velocities of the wheels' lowest points along the forces."
    yield "constraint_jacobian", says, z, "g", lambda code, z: form(code).rolling(z[:n])
    says = "Heights of both wheels' lowest points, which vanish; the third and sixth row of g."
    yield "heights", says, z, "h", lambda code, z: form(code).heights(z[:n])
    for index, what in ((2, "g v = 0"), (3, "heights = 0 and the other rows of g v = 0")):
        says = f"Of index {index}, {what}: vanishes for z and its time derivative zp."

        def residual(code: StraightLine, z: _Numbers, zp: _Numbers, index: int = index) -> _Numbers:
            return form(code).residual(z, zp, index=index)

        yield f"residual_{index}", says, both, "r", residual, True
    says = "The state y, for columns, of z."
    yield "reduced", says, z, "y", lambda code, z: to_reduced(form(code).b, code, z)


def _given(values: Sequence[float]) -> Callable[[StraightLine], _Numbers]:
    return lambda code: [code.literal(x) for x in values]


def _start(bicycle: Bicycle, m: Maneuver) -> list[list[float]]:
    """Return the initial state of a maneuver in both forms, and the descriptor state's rates."""
    equations = Equations.of(bicycle, Balls(_BITS_OF_CONSTANTS))
    state = initial_state(equations, m)
    with equations.precision():
        whole = [*state, *(equations.a.number(0) for _ in INTEGRALS)]
        found = (whole, *from_reduced(equations, whole))
        return [[float(x.mid()) for x in part] for part in found]
