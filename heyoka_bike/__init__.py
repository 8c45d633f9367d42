"""Reference solutions and scoring for the IFToMM benchmark "Uncontrolled bicycle"."""

__version__ = "0.1.0"
