"""The equations of motion of a bicycle as source code, with its parameters as constants.

All functions are written from the one `Equations`, see `numbers.languages`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.equations.configuration import INTEGRALS, whole_rates
from heyoka_bike.bicycle.equations.descriptor import (
    COORDINATES,
    MULTIPLIERS,
    Descriptor,
    from_reduced,
    to_reduced,
)
from heyoka_bike.bicycle.equations.initial import initial_state
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.bicycle.parameters import PARAMETERS, Bicycle, Maneuver
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.arithmetic import Balls, Number
from heyoka_bike.numbers.dual import Duals
from heyoka_bike.numbers.languages import FORTRAN, JULIA, MATLAB, PYTHON, RUST, C, Language
from heyoka_bike.reference.description.facts import COPYRIGHT
from heyoka_bike.reference.exports.selection import AXES, commented, wrapped
from heyoka_bike.version import __version__

_BITS = 200
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")  # MATLAB's namelengthmax

_Vector = Sequence[Number]


@dataclass(frozen=True, slots=True)
class _File:
    """How a language writes files.

    Attributes
    ----------
    language : Language
    suffixes
        Of the file, and of a header before it that declares its functions.
    mark
        Begins a comment.
    use
        How it is compiled or called, with ``{stem}``.
    opening, closing
        Of the file, with ``{stem}``, ``{about}`` for the comment, and ``{each}``.
    each
        A line there for each function's ``{name}``.
    is_descriptor
        Whether the descriptor form is written too.
    """

    language: Language
    suffixes: tuple[str, ...]
    mark: str
    use: str
    opening: str
    closing: str = ""
    each: str = ""
    is_descriptor: bool = False


_HEADER = """{about}
#ifndef BICYCLE_EQUATIONS_H
#define BICYCLE_EQUATIONS_H

#ifdef __cplusplus
extern "C" {{
#endif

{each}
#ifdef __cplusplus
}}
#endif

#endif
"""

LANGUAGES = {
    "c": _File(
        C, (".h", ".c"), "//",
        "Compile: cc -std=c99 -O2 your-code.c {stem}.c -lm, with #include \"{stem}.h\".",
        '{about}\n#include "{stem}.h"\n#include <math.h>\n', is_descriptor=True,
    ),
    "fortran": _File(
        FORTRAN, (".f90",), "!",
        "Compile: gfortran -O2 {stem}.f90 your-code.f90, with 'use bicycle_equations'.",
        "{about}\nmodule bicycle_equations\n    use, intrinsic :: iso_fortran_env, only: real64\n"
        "    implicit none\n    private\n{each}\ncontains\n",
        "end module bicycle_equations\n", "    public :: {name}\n",
    ),
    "matlab": _File(
        MATLAB, (".m",), "%",
        "Use: b = {stem}(); [t, y] = ode45(b.rates, [0 10], b.start_1());",
        "function b = {stem}()\n{about}{each}end\n", "", "    b.{name} = @{name};\n",
    ),
    "julia": _File(
        JULIA, (".jl",), "#",
        'Use: include("{stem}.jl"); using .BicycleEquations, OrdinaryDiffEq; '
        "solve(ODEProblem(rates, start_1(), (0.0, 10.0)), Vern9(), reltol = 1e-13, abstol = 1e-13)",
        "{about}\nmodule BicycleEquations\n\n{each}", "end\n", "export {name}\n",
    ),
    "python": _File(
        PYTHON, (".py",), "#",
        'Use: solve_ivp(rates, (0, 10), start_1(), "DOP853", rtol=1e-13, atol=1e-13) of SciPy.',
        "{about}\nfrom math import cos, sin, sqrt\n", is_descriptor=True,
    ),
    "rust": _File(
        RUST, (".rs",), "//",
        "Use: mod {stem}; and then {stem}::rates(&y).",
        "{about}\n#![allow(dead_code)]\n\nfn sin(x: f64) -> f64 {{\n    x.sin()\n}}\n\n"
        "fn cos(x: f64) -> f64 {{\n    x.cos()\n}}\n",
    ),
}  # fmt: skip
"""By the names that the command line takes."""


def render(
    language: str, bicycle: Bicycle, maneuvers: Sequence[Maneuver], stem: str
) -> dict[str, bytes]:
    """Source files by their suffixes.

    Raises
    ------
    InputError
        The name cannot be that of a module, or a maneuver cannot start.
    """
    if not _NAME.fullmatch(stem):
        raise InputError(
            f"--output: found {quoted(stem)}, expected the name of a module: a letter, then "
            "letters, digits and _"
        )
    file = LANGUAGES[language]
    functions = list(_functions(file, bicycle, maneuvers))
    use = file.use.format(stem=stem)
    about = commented(wrapped(_about(language, bicycle, use)), file.mark)
    says = [commented(wrapped([f.says]), file.mark) for f in functions]
    texts = [f.written(file.language) for f in functions]

    def filled(opening: str, each: Sequence[str]) -> str:
        return opening.format(about=about, stem=stem, each="".join(each))

    parts = [f"\n{said}{text}" for said, text in zip(says, texts, strict=True)]
    opening = filled(file.opening, [file.each.format(name=f.name) for f in functions])
    found = {file.suffixes[-1]: "".join([opening, *parts, file.closing])}
    if file.suffixes[1:]:
        heads = [text.partition("\n")[0] + ";\n" for text in texts]
        each = [f"{said}{head}\n" for said, head in zip(says, heads, strict=True)]
        found[file.suffixes[0]] = filled(_HEADER, each)
    return {suffix: found[suffix].encode("ascii") for suffix in file.suffixes}


def _about(language: str, bicycle: Bicycle, use: str) -> Iterator[str]:
    yield (
        f"The uncontrolled Carvallo-Whipple bicycle {quoted(bicycle.name)}: its equations of "
        "motion, not linearised."
    )
    yield f"Written by heyoka-bike export --equations {language}, {__version__}."
    yield f"Licence: {COPYRIGHT}."
    yield f"{AXES} What the names mean is in docs/how-to/equations.md of heyoka_bike."
    yield use
    yield "Parameters:"
    for symbol, p in PARAMETERS.items():
        yield f"  {symbol} = {bicycle[symbol]} {p.unit}".rstrip() + f": {p.description}"


@dataclass(frozen=True, slots=True)
class _Function:
    """A function of the file: what it says of itself, takes and gives; see `Language.function`."""

    name: str
    says: str
    inputs: Mapping[str, int]
    result: str
    formulas: Callable[..., Sequence[Number]]
    is_timed: bool = False

    def written(self, language: Language) -> str:
        return language.function(
            self.name, self.inputs, self.result, self.formulas, is_timed=self.is_timed
        )


def _functions(file: _File, bicycle: Bicycle, maneuvers: Sequence[Maneuver]) -> Iterator[_Function]:
    rounded = Equations.binary64(bicycle)
    state = (*rounded.states, *INTEGRALS)
    y = {"y": len(state)}
    listed = f"y: {', '.join(state)}"

    def jacobian(code: Number, y: _Vector) -> Sequence[Number]:
        duals = Duals(code)
        rates = whole_rates(rounded.convert(code.literal, duals), duals.variables(y))
        return [x.slopes for x in rates]

    def columns(code: Number, y: _Vector) -> Sequence[Number]:
        found = rounded.convert(code.literal, code).columns(y)
        return [found[name] for name in BENCHMARK_COLUMNS]

    yield _Function(
        "rates", f"Time derivative f of the state {listed}.", y, "f",
        lambda code, y: whole_rates(rounded.convert(code.literal, code), y), is_timed=True,
    )  # fmt: skip
    yield _Function(
        "jacobian", "Jacobian: row i has the derivatives of rate i by the state.", y, "j",
        jacobian, is_timed=True,
    )  # fmt: skip
    yield _Function(
        "columns", f"The benchmark's columns after the time: {', '.join(BENCHMARK_COLUMNS)}.",
        y, "c", columns,
    )  # fmt: skip
    starts = [_start(bicycle, m) for m in maneuvers]
    for i, (m, (start, *_)) in enumerate(zip(maneuvers, starts, strict=True), 1):
        yield _Function(f"start_{i}", f"State at the start of {_named(m)}.", {}, "y", _given(start))
    if file.is_descriptor:
        yield from _descriptor(rounded, maneuvers, starts)


def _descriptor(
    rounded: Equations, maneuvers: Sequence[Maneuver], starts: Sequence[Sequence[_Vector]]
) -> Iterator[_Function]:
    """The descriptor form: M(q) v' = f(q, v) + G(q)^T lambda."""
    n = len(COORDINATES)
    z = {"z": 2 * n + len(MULTIPLIERS)}
    both = {**z, "zp": z["z"]}

    def form(code: Number) -> Descriptor:
        return Descriptor(rounded.b.convert(code.literal), code)

    def force(code: Number, z: _Vector) -> Sequence[Number]:
        return [-x for x in form(code).inertia_forces(z[:n], z[n : 2 * n], [code.number(0)] * n)]

    yield _Function(
        "mass", f"Mass matrix by the coordinates q: {', '.join(COORDINATES)}. Descriptor form: z "
        f"has q, their rates v, and the forces of the floor: {', '.join(MULTIPLIERS)}.",
        z, "m", lambda code, z: form(code).mass(z[:n]),
    )  # fmt: skip
    yield _Function("force", "f in mass v' = f + g^T forces.", z, "f", force)
    yield _Function(
        "constraint_jacobian", "g, with g v = 0: velocities of the wheels' lowest points.", z, "g",
        lambda code, z: form(code).rolling(z[:n]),
    )  # fmt: skip
    yield _Function(
        "heights", "Heights of both wheels' lowest points, which vanish.", z, "h",
        lambda code, z: form(code).heights(z[:n]),
    )  # fmt: skip
    for index, what in ((2, "all constraints on velocities"), (3, "the heights of the wheels")):
        yield _Function(
            f"residual_{index}", f"Residual of the equations of index {index}, with {what}: it "
            "vanishes for z and its derivative zp.", both, "r",
            lambda code, z, zp, index=index: form(code).residual(z, zp, index=index),
            is_timed=True,
        )  # fmt: skip
    yield _Function(
        "reduced", "State y, for columns, of z.", z, "y",
        lambda code, z: to_reduced(form(code).b, code, z),
    )  # fmt: skip
    for i, (m, (_, start, rates)) in enumerate(zip(maneuvers, starts, strict=True), 1):
        for name, what, values in (("start", "z", start), ("start_rates", "zp", rates)):
            yield _Function(
                f"descriptor_{name}_{i}", f"{what} at the start of {_named(m)}.", {}, what,
                _given(values),
            )  # fmt: skip


def _given(values: Sequence[float]) -> Callable[..., Sequence[Number]]:
    return lambda code: [code.literal(x) for x in values]


def _named(m: Maneuver) -> str:
    return f"{quoted(m.name)}: forward speed {m.speed} m/s, roll rate {m.roll_rate} rad/s"


def _start(bicycle: Bicycle, m: Maneuver) -> tuple[list[float], list[float], list[float]]:
    """State, descriptor state and its derivative at the start; what is not known there is zero."""
    equations = Equations.of(bicycle, Balls(_BITS))
    state = initial_state(equations, m)
    with equations.precision():
        whole = [*state, *(equations.a.number(0) for _ in INTEGRALS)]
        found = (whole, *from_reduced(equations, whole))
        return tuple([float(x.mid()) for x in part] for part in found)
