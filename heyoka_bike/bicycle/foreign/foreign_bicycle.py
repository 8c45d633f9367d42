"""The content of a bicycle file of another program."""

from dataclasses import dataclass, field

from heyoka_bike.numbers.exact import Exact


@dataclass
class ForeignBicycle:
    """Parameters of a bicycle, read from a file of another program.

    Attributes
    ----------
    name
        Name of the bicycle; empty if the file has none.
    values, uncertainties : dict
        Numbers by symbol, in SI units and the benchmark's axes.
    notes : list of str
        Omissions and assumptions, one per line.
    """

    name: str = ""
    values: dict[str, Exact] = field(default_factory=dict)
    uncertainties: dict[str, Exact] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
