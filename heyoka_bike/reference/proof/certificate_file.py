"""certificate.json: what is proved about a set, and what is trusted."""

import json
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, QUANTITIES, Column
from heyoka_bike.motion.trajectory import Certificate, Drift, Trajectory
from heyoka_bike.numbers.rounding import decimal_above
from heyoka_bike.reference.layout import STATES, STATES_HDF5, TEXT, TEXT_50
from heyoka_bike.reference.sensitivities import Sensitivity
from heyoka_bike.reference.structure import COLUMNS_OF
from heyoka_bike.reference.values import Dense, Values

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
"""Of the sets 1.4.0 and 1.5.0."""

STATEMENT = (
    f"{STATEMENT_1_5_0} Of the integration it is proved, from the state of candidate.h5 at the "
    "rows alone, how large the benchmark's eq. (1) is at most [%], how far the mechanical energy "
    "is at most from its first value, over that, and the front wheel from the floor [m]. Where "
    "there are states.csv and states.h5, every value there is the binary64 nearest to the exact "
    "one, in the state whose coordinates are the decimals written there; it is zero where a ball "
    "narrower than 2^-160 holds zero."
)


def proved(files: Container[str], columns: Mapping[str, Sequence[Column]]) -> dict[str, list[str]]:
    """Columns that are proved, by file; a text may be several, one for each maneuver.

    Parameters
    ----------
    files
        Those of the set.
    columns
        Those of each HDF5 file of the maneuvers.
    """
    found = {name: [c.name for c in of_file] for name, of_file in columns.items()}
    found |= {TEXT: list(BENCHMARK_COLUMNS), TEXT_50: list(BENCHMARK_COLUMNS)}
    return found | {name: list(QUANTITIES) for name in (STATES, STATES_HDF5) if name in files}


COMPUTED: Mapping[str, str] = {}
"""Files that are published without a proof, and the way they are made."""

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
    steps, entries, motion_entries, ambiguous : int
        Pieces of the candidate; rounded entries of the rows of the one HDF5 file and of the other;
        those that were not decided.
    states : mapping of str to (Fraction, Fraction)
        Bound over the interval and at its end, by state variable [rad, rad/s].
    dense, motion_dense : mapping of str to Fraction
        Bound of the dense output over the column's scale, in either HDF5 file.
    derivatives : mapping of str to Fraction
        Bound of the derivatives of each column over the largest one, the worst of the unknowns.
    drift : Drift
        Drift of the candidate in energy and contact, which the exact motion keeps.
    bits : int
        Of the significand of the run.
    derivative_entries, derivatives_ambiguous : int
        Rounded entries of the rows of derivatives; roundings among them and among the coefficients
        that were not decided.
    cpu : float
        Processor time [s].
    """

    name: str
    steps: int
    entries: int
    motion_entries: int
    ambiguous: int
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
    def bound(self) -> Fraction:
        """Largest bound over the interval."""
        return max(x for x, _ in self.states.values())

    @property
    def bound_end(self) -> Fraction:
        """Largest bound at the end."""
        return max(x for _, x in self.states.values())


def summarise(
    run: Trajectory, certificate: Certificate, rows: Values, dense: Dense, motion_rows: Values,
    motion_dense: Dense, sensitivity: Sensitivity, drift: Drift, cpu: float = 0.0,
) -> Proof:  # fmt: skip
    """Gather what was proved."""
    worst = [max(column) for column in zip(*certificate.pieces, strict=True)]
    pairs = zip(certificate.states, zip(worst, certificate.end, strict=True), strict=True)
    return Proof(
        name=run.maneuver.name,
        steps=run.steps,
        entries=_count(rows),
        motion_entries=_count(motion_rows),
        ambiguous=0,
        states=dict(pairs),
        dense=_relative(dense, rows),
        motion_dense=_relative(motion_dense, motion_rows),
        derivatives={name: _of_largest(sensitivity, name) for name in sensitivity.bound},
        drift=drift,
        bits=run.bits,
        derivative_entries=sum(x.size for x in sensitivity.values.values()),
        derivatives_ambiguous=sensitivity.ambiguous,
        cpu=cpu,
    )


def _count(rows: Values) -> int:
    return sum(x.size for x in rows.hi.values())


def _relative(dense: Dense, rows: Values) -> Mapping[str, Fraction]:
    return {
        name: Fraction(float(x.max())) / Fraction(rows.scale(name) or 1.0)
        for name, x in dense.bound.items()
    }


def _of_largest(sensitivity: Sensitivity, name: str) -> Fraction:
    """The largest bound of a column over the largest coefficient, by unknown, then the worst."""
    sizes = np.fmax.reduce(np.abs(sensitivity.coefficients[name]), axis=(0, 1))
    bounds = np.fmax.reduce(sensitivity.bound[name], axis=0)
    pairs = zip(bounds, sizes, strict=True)
    return max(
        (Fraction(float(b)) / Fraction(float(x)) for b, x in pairs if x > 0), default=Fraction(0)
    )


def render_certificate(
    proofs: Sequence[Proof], inputs: Mapping[str, Any], files: Container[str]
) -> bytes:
    """Bytes of certificate.json, of a set with these files."""
    document = {
        "schema_version": 1,
        "statement": STATEMENT,
        "inputs": inputs,
        "proved": proved(files, COLUMNS_OF),
        "computed": COMPUTED,
        "maneuvers": [entry(proof) for proof in proofs],
        "trusted": TRUSTED,
        "software": {"flint": flint.__FLINT_VERSION__, "python-flint": flint.__version__},
    }
    return (json.dumps(document, indent=2, ensure_ascii=False) + "\n").encode()


def entry(proof: Proof) -> dict[str, Any]:
    """Return the entry of a maneuver; decimals are bounds."""
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
            "dense_relative_bounds": _above(proof.motion_dense),
        },
        "sensitivities": {
            "entries": proof.derivative_entries,
            "ambiguous": proof.derivatives_ambiguous,
            "relative_bounds": _above(proof.derivatives),
        },
        "integration": kept(proof.drift, proof.bits),
    }


def kept(drift: Drift, bits: int) -> dict[str, str]:
    """Return the entry on energy and contact of a run of so many bits."""
    return {
        "performance_percent": decimal_above(Fraction(drift.performance)),
        "energy": decimal_above(Fraction(drift.energy) / 2**bits),
        "contact": decimal_above(Fraction(drift.contact)),
    }


def _above(bounds: Mapping[str, Fraction]) -> dict[str, str]:
    return {name: decimal_above(x) for name, x in bounds.items()}
