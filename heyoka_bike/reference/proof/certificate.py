"""certificate.json: what is proved about a dataset, and what is assumed.

This module makes the document from the proved facts, and compares a published one with them.
"""

import json
import re
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.column import Column
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS
from heyoka_bike.bicycle.instant_columns import QUANTITIES
from heyoka_bike.errors import NotCertifiedError
from heyoka_bike.motion.trajectory import Drift
from heyoka_bike.numbers.rounding import decimal_above
from heyoka_bike.reference import layout, structure
from heyoka_bike.reference.layout import STATES, STATES_HDF5, TEXT, TEXT_50
from heyoka_bike.reference.load import ReferenceManeuver
from heyoka_bike.reference.proof.compute_table import Table
from heyoka_bike.reference.values import Dense, Sensitivity, Values

STATEMENT_1_5_0 = (
    "For every maneuver, at every time of the interval, each state variable of the exact motion "
    "differs from the polynomial in candidate.h5 by at most the bound given. Every value of the "
    "rows is the binary64 nearest to the exact one, its _lo the binary64 nearest to the rest, and "
    "the 50-digit text is correctly rounded. The dense output differs from the exact columns by at "
    "most the bounds given, relative to the largest absolute value of the column's rows. The same "
    "holds of motion.h5, where a value is zero if an enclosure as narrow as its bound holds zero, "
    "and where the friction demands have rows only. In sensitivities.h5 each piece differs from "
    "the exact derivatives by at most its bound, by column and unknown; the rows there are the "
    "exact derivatives, each rounded to the nearest binary64 but for the number of ambiguous "
    "roundings, and zero where an enclosure as narrow as its bound holds zero; of NaN nothing is "
    "said. Nothing is proved of what is only computed."
)
"""The statement of the datasets 1.4.0 and 1.5.0."""

_OF_UNDECIDED = (
    " Of the rows that a dataset with _undecided lists it is not decided what is nearest: there "
    "value and _lo are some that are within the bound. A number of the 50-digit text that has "
    "fewer digits, or the exponent of a zero, differs from the exact one by at most one unit of "
    "the last digit. 'ambiguous' counts both."
)

STATEMENT = (
    f"{STATEMENT_1_5_0} Of the integration it is proved, from the state of candidate.h5 at the "
    "rows alone, how large the benchmark's eq. (1) is at most [%], how far the mechanical energy "
    "is at most from its first value, over that, and the front wheel from the floor [m]. Where "
    "there are states.csv and states.h5, every value there is the binary64 nearest to the exact "
    "one, in the state whose coordinates are the decimals written there; it is zero where a ball "
    "narrower than 2^-160 holds zero."
)


def statement_of(*, is_decided: bool) -> str:
    """Return the statement of a certificate, which mentions roundings that may be undecided."""
    return STATEMENT if is_decided else STATEMENT + _OF_UNDECIDED


def proved(files: Container[str], columns: Mapping[str, Sequence[Column]]) -> dict[str, list[str]]:
    """Return the names of the proved columns by file; the text files of all maneuvers share a key.

    Parameters
    ----------
    files
        Files of the dataset.
    columns
        Columns of each HDF5 file of the maneuvers.
    """
    found = {name: [c.name for c in of_file] for name, of_file in columns.items()}
    found |= {TEXT: list(BENCHMARK_COLUMNS), TEXT_50: list(BENCHMARK_COLUMNS)}
    return found | {name: list(QUANTITIES) for name in (STATES, STATES_HDF5) if name in files}


TRUSTED = (
    "that the equations of motion in heyoka_bike (modules constants, kinematics, model, outputs) "
    "are those of the Carvallo-Whipple bicycle; that they are identically those of an independent "
    "Newton-Euler model is shown in the tests, at random points of a random prime field, where a "
    "false equation passes with a probability below 1e-140",
    "that they conserve the mechanical energy, which is published as its initial value, and that "
    "straight running is a solution: identities, shown in the tests in the same way, not by "
    "'certify'",
    "that with an initial steer angle the pitch is the root followed from zero steer (the root "
    "itself is enclosed)",
    "the ball arithmetic of FLINT/Arb, through python-flint",
    "the modules of heyoka_bike that 'certify' imports, and the Python interpreter that runs them; "
    "NumPy, h5py and HDF5, which read the files",
)
"""Assumptions of the proof. heyoka, its tolerance and its rounding are not among them."""


@dataclass(frozen=True)
class Proof:
    """Proved facts about a maneuver.

    Attributes
    ----------
    name : str
    steps, entries, motion_entries, ambiguous, motion_ambiguous : int
        Pieces of the candidate; rounded entries of the rows in either HDF5 file; entries of either
        file whose rounding is undecided, the first number including the text of 50 digits.
    states : mapping of str to (Fraction, Fraction)
        Bound over the interval and at its end, by state variable [rad, rad/s].
    dense, motion_dense : mapping of str to Fraction
        Bound of the dense output relative to the column's scale, in either HDF5 file.
    derivatives : mapping of str to Fraction
        Bound of the derivatives of each column relative to the largest, for the worst unknown.
    drift : Drift
        Drift of the candidate in energy and contact, which the exact motion conserves.
    bits : int
        Bits of the significand in the run.
    derivative_entries, derivatives_ambiguous : int
        Rounded entries of the rows of derivatives; undecided roundings among them and among the
        coefficients.
    cpu : float
        Processor time [s].
    """

    name: str
    steps: int
    entries: int
    motion_entries: int
    ambiguous: int
    motion_ambiguous: int
    states: Mapping[str, tuple[Fraction, Fraction]]
    dense: Mapping[str, Fraction]
    motion_dense: Mapping[str, Fraction]
    derivatives: Mapping[str, Fraction]
    drift: Drift
    bits: int
    derivative_entries: int
    derivatives_ambiguous: int
    cpu: float = 0.0

    @property
    def is_decided(self) -> bool:
        """True if every entry of the rows could be rounded."""
        return not (self.ambiguous or self.motion_ambiguous)

    @property
    def bound(self) -> Fraction:
        """Largest bound on a state variable over the interval."""
        return max(x for x, _ in self.states.values())

    @property
    def bound_end(self) -> Fraction:
        """Largest bound on a state variable at the end of the interval."""
        return max(x for _, x in self.states.values())


def summarise(x: Table) -> Proof:
    """Collect the proved facts about a maneuver from its table."""
    worst = [max(column) for column in zip(*x.certificate.pieces, strict=True)]
    pairs = zip(worst, x.certificate.end, strict=True)
    return Proof(
        name=x.maneuver.name,
        steps=x.trajectory.steps,
        entries=_count(x.rows),
        motion_entries=_count(x.motion_rows),
        ambiguous=x.rows.ambiguous,
        motion_ambiguous=x.motion_rows.ambiguous,
        states=dict(zip(x.certificate.states, pairs, strict=True)),
        dense=_relative(x.dense, x.rows),
        motion_dense=_relative(x.motion_dense, x.motion_rows),
        derivatives={name: _of_largest(x.sensitivity, name) for name in x.sensitivity.bound},
        drift=x.drift,
        bits=x.trajectory.bits,
        derivative_entries=sum(values.size for values in x.sensitivity.values.values()),
        derivatives_ambiguous=x.sensitivity.ambiguous,
        cpu=x.cpu,
    )


def _count(rows: Values) -> int:
    return sum(x.size for x in rows.hi.values())


def _relative(dense: Dense, rows: Values) -> Mapping[str, Fraction]:
    return {
        name: Fraction(float(x.max())) / Fraction(rows.scale(name) or 1.0)
        for name, x in dense.bound.items()
    }


def relative_bounds(m: ReferenceManeuver) -> dict[str, str]:
    """Return the relative bounds of a maneuver's dense output, for its entry in the certificate."""
    return _above(_relative(m.dense, m.rows))


def _of_largest(sensitivity: Sensitivity, name: str) -> Fraction:
    """Return the bound of a column relative to its largest coefficient, for the worst unknown."""
    sizes = np.fmax.reduce(np.abs(sensitivity.coefficients[name]), axis=(0, 1))
    bounds = np.fmax.reduce(sensitivity.bound[name], axis=0)
    pairs = zip(bounds, sizes, strict=True)
    return max(
        (Fraction(float(b)) / Fraction(float(x)) for b, x in pairs if x > 0), default=Fraction(0)
    )


def document(
    inputs: Mapping[str, Any], files: Container[str], maneuvers: Sequence[Any],
    columns: Mapping[str, Sequence[Column]] = structure.COLUMNS_OF, statement: str = STATEMENT,
) -> dict[str, Any]:  # fmt: skip
    """Return the content of certificate.json for these files; see `proved` for the parameters."""
    return {
        "schema_version": 1,
        "statement": statement,
        "inputs": inputs,
        "proved": proved(files, columns),
        # Files are published only with a proof, so no file is listed as merely computed.
        "computed": {},
        "maneuvers": maneuvers,
        "trusted": list(TRUSTED),
        "software": {"flint": flint.__FLINT_VERSION__, "python-flint": flint.__version__},
    }


def entry(proof: Proof) -> dict[str, Any]:
    """Return the entry of a maneuver in the certificate; its decimals are bounds."""
    return {
        "maneuver": proof.name,
        "steps": proof.steps,
        "entries": proof.entries,
        "ambiguous": proof.ambiguous,
        "bound": decimal_above(proof.bound),
        "bound_end": decimal_above(proof.bound_end),
        "state_bounds": {
            state: {"interval": decimal_above(x), "end": decimal_above(y)}
            for state, (x, y) in proof.states.items()
        },
        "dense_relative_bounds": _above(proof.dense),
        "motion": {
            "entries": proof.motion_entries,
            **({"ambiguous": proof.motion_ambiguous} if proof.motion_ambiguous else {}),
            "dense_relative_bounds": _above(proof.motion_dense),
        },
        "sensitivities": {
            "entries": proof.derivative_entries,
            "ambiguous": proof.derivatives_ambiguous,
            "relative_bounds": _above(proof.derivatives),
        },
        "integration": drift_entry(proof.drift, proof.bits),
    }


def drift_entry(drift: Drift, bits: int) -> dict[str, str]:
    """Return the entry on the drift of energy and contact, for a run with this many bits."""
    return {
        "performance_percent": decimal_above(Fraction(drift.performance)),
        "energy": decimal_above(Fraction(drift.energy) / 2**bits),
        "contact": decimal_above(Fraction(drift.contact)),
    }


def _above(bounds: Mapping[str, Fraction]) -> dict[str, str]:
    return {name: decimal_above(x) for name, x in bounds.items()}


def compare_certificate(raw: bytes, proofs: Sequence[Proof]) -> None:
    """Check certificate.json against the proofs: bounds must cover them, all else must be equal.

    Raises
    ------
    NotCertifiedError
        The certificate claims something else.
    """
    said = json.loads(raw)
    statement = statement_of(is_decided=all(proof.is_decided for proof in proofs))
    if said["statement"] not in (statement, STATEMENT_1_5_0):
        raise NotCertifiedError(
            f"{layout.CERTIFICATE}: its 'statement' differs from the proved value"
        )
    for published, proof in zip(said["maneuvers"], proofs, strict=True):
        found = entry(proof)
        if said["statement"] == STATEMENT_1_5_0:
            del found["integration"]
        _covers(published, found, f"{layout.CERTIFICATE}, {proof.name}")


def _covers(published: Any, proved: Any, where: str) -> None:
    """Check that published decimals are no smaller than the proved ones, and all else is equal."""
    if isinstance(proved, dict):
        if not isinstance(published, dict) or set(published) != set(proved):
            raise NotCertifiedError(f"{where}: expected the entries {', '.join(proved)}")
        for key, x in proved.items():
            _covers(published[key], x, f"{where}, {key}")
        return
    bound = _as_bound(proved)
    if bound is not None and (said := _as_bound(published)) is not None and said >= bound:
        return
    if published != proved:
        raise NotCertifiedError(f"{where}: published {published!r:.80}, proved {proved!r}")


BOUND = re.compile(r"[0-9](\.[0-9]+)?e[+-]?[0-9]{1,5}|0(e[+-]?[0-9]{1,5})?")
"""A bound in the notation of a certificate. Longer exponents are rejected, because computing the
fraction could take forever."""


def _as_bound(x: Any) -> Fraction | None:
    return Fraction(x) if isinstance(x, str) and BOUND.fullmatch(x) else None
