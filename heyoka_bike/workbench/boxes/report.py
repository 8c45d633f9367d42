"""Stability over a box of parameters, as ``heyoka-bike linear --uncertainty`` shows it."""

from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction

from heyoka_bike.bicycle.parameters import Bicycle
from heyoka_bike.errors import InputError, quoted
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.showing.document import Block, Paragraph, TableBlock
from heyoka_bike.workbench.boxes.box import BoxStability, CriticalSpeed, Interval, stability_box

# It is of first order only.
_DEVIATION_DIGITS = 3


@dataclass(frozen=True, slots=True)
class UncertainStability:
    """Statements that hold for every bicycle of a box, in decimals of so many digits."""

    box: BoxStability
    digits: int

    def as_json(self) -> dict[str, object]:
        """Every number as a decimal string that says no more than is proved."""
        box, digits = self.box, self.digits
        return {
            "standard_deviations": str(box.sigmas),
            "parameters": box.parameters,
            **{
                name: None if speeds is None else [_bounds(v, digits) for v in speeds]
                for name, speeds in (("weave", box.weave), ("capsize", box.capsize))
            },
            "all_stable": _ends(box.every, digits, inward=True),
            "some_stable": _ends(box.some, digits, inward=False),
        }

    def blocks(self) -> tuple[Block, ...]:
        """As a table."""
        box, digits = self.box, self.digits
        said = (
            f"Every bicycle whose {box.parameters} uncertain parameters are each within "
            f"{box.sigmas} standard deviation(s):"
        )
        rows = []
        for name, speeds in (("weave", box.weave), ("capsize", box.capsize)):
            if speeds is None:
                rows.append([f"{name} speed [m/s]", "not decided", "", "", "", ""])
            elif not speeds:
                rows.append([f"{name} speed [m/s]", "none", "", "", "", ""])
            rows += [[f"{name} speed [m/s]", *_bounds(v, digits).values()] for v in speeds or ()]
        for name, interval, inward in (
            ("all are stable [m/s]", box.every, True),
            ("none is stable outside [m/s]", box.some, False),
        ):
            ends = _ends(interval, digits, inward=inward)
            found = ["no speed", ""] if ends is None else [x or "no end" for x in ends.values()]
            rows.append([name, *found, "", "", ""])
        heading = ("proved", "from", "to", "attained from", "attained to", "standard deviation")
        return Paragraph(said), TableBlock(heading, rows)


def uncertain_stability(bicycle: Bicycle, sigmas: str, digits: int) -> UncertainStability:
    """Weave and capsize speeds if each parameter is within so many standard deviations.

    Raises
    ------
    InputError
        `sigmas` is no positive number, or the bicycle has no uncertainties.
    """
    return UncertainStability(stability_box(bicycle, parse_sigmas(sigmas), digits), digits)


def parse_sigmas(text: str) -> Fraction:
    """A positive number of standard deviations.

    Raises
    ------
    InputError
        The text is not one.
    """
    try:
        sigmas = Exact.parse(text).fraction()
    except ValueError:
        sigmas = Fraction(0)
    if sigmas <= 0:
        raise InputError(
            f"--uncertainty: found {quoted(text)}, expected a positive number of standard "
            "deviations"
        )
    return sigmas


def below(x: Fraction, digits: int) -> str:
    """A decimal at or below x."""
    return str(_divided(x, digits, ROUND_FLOOR))


def above(x: Fraction, digits: int) -> str:
    """A decimal at or above x."""
    return str(_divided(x, digits, ROUND_CEILING))


def _divided(x: Fraction, digits: int, rounding: str) -> Decimal:
    return Context(prec=digits, rounding=rounding).divide(
        Decimal(x.numerator), Decimal(x.denominator)
    )


def _bounds(v: CriticalSpeed, digits: int) -> dict[str, str]:
    """Decimals that say no more than is proved or was attained."""
    return {
        "from": below(v.low, digits),
        "to": above(v.high, digits),
        "attained_from": above(v.least, digits),
        "attained_to": below(v.most, digits),
        "standard_deviation": above(v.deviation, _DEVIATION_DIGITS),
    }


def _ends(interval: Interval | None, digits: int, *, inward: bool) -> dict[str, str | None] | None:
    """An interval of speeds, rounded inward or outward."""
    if interval is None:
        return None
    low, high = interval
    begin, end = (above, below) if inward else (below, above)
    return {"from": begin(low, digits), "to": None if high is None else end(high, digits)}
