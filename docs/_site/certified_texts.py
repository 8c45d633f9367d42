"""A plain text for each maneuver: 15 certified digits at whole and half seconds.

Laid out as the files of NIST's Statistical Reference Datasets (https://www.itl.nist.gov/div898/strd/)
are: what it is, which lines hold what, then the values in columns of a fixed width. The digits are
those of the text with 50, rounded.
"""

from decimal import ROUND_HALF_EVEN, Context, Decimal

from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS, DEFINITIONS
from heyoka_bike.reference.layout import TEXT_50

DIGITS = 15
WIDTH = DIGITS + 9  # sign, point, exponent, a blank
_STEP = Decimal("0.5")
_EXACT = Context(prec=200)


def texts(reference, folder):
    """Content of each file, by its name."""
    lines = (folder / TEXT_50).read_text("ascii").splitlines()
    rows = [line.split() for line in lines]
    chosen = [row for row in rows if Decimal(row[0]) % _STEP == 0]
    return {
        f"maneuver-{number}.txt": _text(reference, number, chosen)
        for number in range(1, len(reference) + 1)
    }


def _text(reference, number, rows):
    first = 1 + len(BENCHMARK_COLUMNS) * (number - 1)
    columns = range(first, first + len(BENCHMARK_COLUMNS))
    units = [DEFINITIONS[key][0].unit for key in BENCHMARK_COLUMNS]
    headings = [("time", *BENCHMARK_COLUMNS), ("s", *units)]
    values = [[row[0], *(rounded(row[i]) for i in columns)] for row in rows]
    said = [
        "Reference data: uncontrolled bicycle",
        "",
        f"Dataset:        {reference[number].name} of the IFToMM benchmark Uncontrolled bicycle",
        f"Version:        {reference.dataset_version}, content sha256",
        f"                {reference.content_sha256}",
        f"Certified:      {DIGITS} significant digits, correctly rounded from a proved {TEXT_50}",
        f"Times:          {rows[0][0]} to {rows[-1][0]} s, every {_STEP} s",
        "Columns:        by their default definitions; SI units; roll and steer positive to the",
        "                right; zero of the potential energy on the floor",
        "File format:    ASCII, columns of {} characters after a time of 6",
        "Values:         lines {} to {}",
        "",
    ]
    begin = len(said) + len(headings) + 1
    said[-3] = said[-3].format(WIDTH)
    said[-2] = said[-2].format(begin, begin + len(values) - 1)
    lines = [*said, *map(_line, headings), *map(_line, values)]
    return "".join(f"{line.rstrip()}\n" for line in lines)


def _line(cells):
    time, *others = cells
    return f"{time:>6}" + "".join(f"{cell:>{WIDTH}}" for cell in others)


def rounded(text):
    """Correctly rounded to 15 digits.

    Raises
    ------
    ValueError
        What is written does not decide that: it ends in the middle of two such numbers, or has too
        few digits.
    """
    value = Decimal(text)
    if not value:
        return f"{0:.{DIGITS - 1}f}e+0"
    near = Context(prec=DIGITS, rounding=ROUND_HALF_EVEN).plus(value)
    half = Decimal((0, (5,), near.adjusted() - DIGITS))
    # What was cut off is at most half a unit of the last digit that is written.
    unknown = Decimal((0, (5,), value.as_tuple().exponent - 1))
    distance = abs(_EXACT.subtract(value, near))
    if _EXACT.add(distance, unknown) >= half:
        raise ValueError(f"found {text}, expected digits that decide {DIGITS} of them")
    return f"{near:.{DIGITS - 1}e}"
