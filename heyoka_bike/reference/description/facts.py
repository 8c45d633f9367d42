"""Title, creator, licence and sources of the published set, and what each of its files holds.

Stated once; the attributes of the HDF5 files (as ACDD-1.3 and CF name them), the card and the
RO-Crate repeat it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from heyoka_bike.reference import layout
from heyoka_bike.reference.manifest import CUSTOM, MANIFEST

TITLE = 'Reference solutions of the IFToMM multibody benchmark "Uncontrolled bicycle"'
CREATOR = "The heyoka_bike developers"
LICENCE = "https://spdx.org/licenses/MIT"
COPYRIGHT = f"MIT, Copyright (c) 2026 {CREATOR}"
SUMMARY = (
    "Three motions of the uncontrolled Carvallo-Whipple bicycle, ten seconds each: its exact "
    "nonlinear equations integrated with 70 digits, every published number proved, with a bound."
)
KEYWORDS = (
    "multibody dynamics", "bicycle", "benchmark", "reference solution", "Carvallo-Whipple model",
    "Taylor method", "ball arithmetic",
)  # fmt: skip
BENCHMARK = "https://www.iftomm-multibody.org/benchmark/problem/Uncontrolled_bicycle/"
CONVENTIONS = "CF-1.8, ACDD-1.3"
"""Of files whose columns are all in units of CF."""

Papers = Mapping[str, tuple[str, str, int]]

PAPERS: Papers = {
    "https://doi.org/10.1098/rspa.2007.1857": (
        "Meijaard, Papadopoulos, Ruina, Schwab",
        "Linearized dynamics equations for the balance and steer of a bicycle: a benchmark and "
        "review",
        2007,
    ),
    "https://doi.org/10.1093/mnras/stab1032": (
        "Biscani, Izzo",
        "Revisiting high-order Taylor methods for astrodynamics and celestial mechanics",
        2021,
    ),
}
"""Authors, title and year by address: where the bicycle and the integrator come from."""

_SOURCE = (
    "heyoka_bike: the equations of motion of the Carvallo-Whipple bicycle, integrated by heyoka's "
    "adaptive Taylor method and proved in ball arithmetic"
)
_HDF5, _TEXT, _JSON = "application/x-hdf5", "text/plain", "application/json"


@dataclass(frozen=True, slots=True)
class Holding:
    """Title, summary and media type of a file of a set.

    Attributes
    ----------
    title : str
    summary : str
    media_type : str
    """

    title: str
    summary: str
    media_type: str


FILES: Mapping[str, Holding] = {
    layout.HDF5: Holding(
        "Reference solution of the multibody benchmark Uncontrolled bicycle",
        "Roll, steer, speed and energies by every usual definition, pitch and yaw: rows and "
        "piecewise polynomials, hi + lo (32 digits), with certified bounds.",
        _HDF5,
    ),
    layout.TEXT: Holding(
        "The 25 columns of the benchmark",
        "Rows of time and eight columns of each maneuver, 17 digits, without a heading.",
        _TEXT,
    ),
    layout.TEXT_50: Holding(
        "The 25 columns of the benchmark with 50 digits",
        "The same rows, correctly rounded to 50 significant digits.",
        _TEXT,
    ),
    layout.MOTION: Holding(
        "The whole motion of the reference solution: configuration and forces",
        "Places, attitudes, wheel angles, angular velocities, contact and joint forces: rows and "
        "piecewise polynomials, hi + lo, with certified bounds.",
        _HDF5,
    ),
    layout.SENSITIVITIES: Holding(
        "Sensitivities of the reference solution: d column / d unknown",
        "Derivatives of every column with respect to the 26 parameters and the start, with "
        "certified bounds.",
        _HDF5,
    ),
    layout.STATES: Holding(
        "States: all that a program can compute at single instants",
        "110 states of the bicycle with 189 quantities each, from geometry to forces and "
        "eigenvalues, correctly rounded: to check a model before it moves.",
        "text/csv",
    ),
    layout.STATES_HDF5: Holding(
        "The same states", "The same numbers, each with its unit and meaning.", _HDF5
    ),
    layout.CANDIDATE: Holding(
        "Candidate solutions: exact piecewise polynomials",
        "The computed motions as exact integers: what the certificate is about.",
        _HDF5,
    ),
    layout.CERTIFICATE: Holding(
        "Certificate", "What is proved, with which bounds, and what is taken as known.", _JSON
    ),
    MANIFEST: Holding(
        "Manifest", "Sizes and hashes of the files, the inputs, and how the set was made.", _JSON
    ),
    layout.CARD: Holding(
        "Card of the dataset", "This page: what it is, how to read and to cite it.", "text/markdown"
    ),
    layout.CRATE: Holding(
        "RO-Crate metadata", "The same for machines (RO-Crate).", "application/ld+json"
    ),
    layout.AFTER_FILES[0]: Holding(
        "After ten seconds",
        "What becomes of the motions later: 23 proved numbers, and sentences.",
        _JSON,
    ),
    layout.AFTER_FILES[1]: Holding(
        "Candidate solutions after ten seconds",
        "The two computed motions from which they are proved.",
        _HDF5,
    ),
}
"""The files of the published set."""


def shared_attributes(version: str) -> dict[str, str]:
    """Attributes of every HDF5 file of a dataset version, or made from it, but its title.

    A set of one's own has its maker's name and licence: neither is known here.
    """
    papers = "; ".join(f"{who} ({year}), {at}" for at, (who, _, year) in PAPERS.items())
    said = {
        "Conventions": "ACDD-1.3",
        "keywords": ", ".join(KEYWORDS),
        "source": _SOURCE,
        "references": f"{papers}; {BENCHMARK}",
        "history": f"dataset version {version}, written by 'heyoka-bike generate'",
    }
    if version == CUSTOM:
        return said
    return said | {
        "product_version": version,
        "creator_name": CREATOR,
        "creator_type": "group",
        "license": f"{COPYRIGHT}, {LICENCE}",
    }


def attributes_of(file: str, version: str) -> dict[str, str]:
    """Attributes by which an HDF5 file of a set is found and cited.

    Parameters
    ----------
    file
        Its name, see `layout`.
    version
        Of the dataset, when the file was last changed.
    """
    about = FILES[file]
    said = {"title": about.title, "summary": about.summary, **shared_attributes(version)}
    return said if version == CUSTOM else {"id": f"heyoka_bike/{version}/{file}", **said}
