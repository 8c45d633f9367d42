"""What a reader finds in a file of others."""

from dataclasses import dataclass, field

from heyoka_bike.numbers.exact import Exact


@dataclass
class Found:
    """Parameters of a file.

    Attributes
    ----------
    name
        Of the bicycle; empty if the file has none.
    values, uncertainties : dict
        By symbol, in SI units and the benchmark's axes.
    notes : list of str
        What was left out or taken for granted, each on one line.
    """

    name: str = ""
    values: dict[str, Exact] = field(default_factory=dict)
    uncertainties: dict[str, Exact] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
