"""Evidence: what was seen in a result file, as values; every decision reads these.

One class answers one question: which columns were not compared, by how much the times are shifted,
which signs contradict each other. Its fields are numbers, whole names and places. What it means is
decided by `verdict` and `requirements`. The sentence that tells a person of it is made from it
last, in `showing.sayings`, and nothing is decided by a sentence.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum

Errors = tuple[float | None, ...]
"""The largest absolute error of a column in each maneuver that has it [SI unit]; None without a
value."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """Base of all evidence.

    Attributes
    ----------
    file
        The file in which it was seen, if a run consists of several; else empty.
    """

    file: str = ""

    def lost(self, compared: Collection[str]) -> Iterable["LostColumn"]:
        """Columns of the result that were not compared for this reason.

        Parameters
        ----------
        compared
            Keys of the columns that were compared, in any maneuver.
        """
        return ()


@dataclass(frozen=True, slots=True)
class LostColumn:
    """A column of a file that was not compared.

    Attributes
    ----------
    name
        Its name in the file, whole; of columns without names their place (``2.roll_angle``).
    key
        The column that it is, or whose name it is like; None if its name is like none.
    maneuver
        Number of the maneuver that it is of; None if that is not known, or if it is of all.
    """

    name: str
    key: str | None = None
    maneuver: int | None = None


@dataclass(frozen=True, slots=True)
class Odds:
    """Odds of the definition of a column against the likeliest other one.

    Attributes
    ----------
    log10
        Their decimal logarithm.
    against
        The other definition; None for all that are not known here.
    """

    log10: float
    against: str | None


# How a file was read.


class Reason(Enum):
    """Why a column was not compared."""

    UNKNOWN_NAME = "its name means nothing that is known"
    SET_ASIDE = "its name is known, and its number is not that of a maneuver"
    CONTRADICTS = "another column of this quantity is compared, and its values are others"
    BESIDE_A_TABLE = "its name is known, and a table beside it has all columns"
    NO_COLUMN = "its name is known, and it has not one value for each time"
    NO_SUCH_MANEUVER = "the reference has no such maneuver"
    NOT_UNDERSTOOD = "its name is like that of a quantity"


@dataclass(frozen=True, slots=True)
class NotCompared(Evidence):
    """Columns whose names decide that they are not compared.

    Attributes
    ----------
    reason : Reason
    columns : tuple of LostColumn
        The key of an unknown name is that of the quantity whose name it is like.
    how_to_tell
        The words of the option by which a user can tell the columns.
    """

    reason: Reason
    columns: tuple[LostColumn, ...]
    how_to_tell: str = ""

    def lost(self, compared: Collection[str]) -> Iterable[LostColumn]:
        if self.reason in (Reason.UNKNOWN_NAME, Reason.NOT_UNDERSTOOD):
            return ()
        # Where a quantity is not compared at all, the count of the columns says so.
        return (x for x in self.columns if x.key is None or x.key in compared)


@dataclass(frozen=True, slots=True)
class LastRowIncomplete(Evidence):
    """The last row of a text was cut while it was written; it is left out."""

    line: int | None


@dataclass(frozen=True, slots=True)
class CommonFactor(Evidence):
    """A line above the rows holds their common factor, 10 to this power; it was applied."""

    power: int


@dataclass(frozen=True, slots=True)
class LinesNotRead(Evidence):
    """Lines of a text look like rows of numbers and were not read.

    Attributes
    ----------
    count
    first : tuple of (int, str)
        The number of each of the first few lines, and what it holds.
    """

    count: int
    first: tuple[tuple[int, str], ...]


@dataclass(frozen=True, slots=True)
class NotFinite(Evidence):
    """Values that are not finite.

    Attributes
    ----------
    count
    counted_by, line, column
        The first of them: ``line`` or ``row``, its number, and the number of its column, from 1.
    """

    count: int
    counted_by: str
    line: int
    column: int


@dataclass(frozen=True, slots=True)
class NamesNotUsed(Evidence):
    """Columns taken by their place although a known name contradicts it.

    Attributes
    ----------
    columns
        Numbers of the columns whose names contradict their place, from 1.
    name
        Of the first of these.
    unknown
        The names for whose sake no name is used.
    """

    columns: tuple[int, ...]
    name: str
    unknown: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class UnknownUnit(Evidence):
    """The name of a column has something in the place of a unit that is none."""

    name: str
    unit: str
    key: str


@dataclass(frozen=True, slots=True)
class Transposed(Evidence):
    """The rows of an array are taken as columns."""

    rows: int
    columns: int


@dataclass(frozen=True, slots=True)
class TimesAsDecimals(Evidence):
    """Binary times that are next to decimals are read as these.

    Attributes
    ----------
    places
        Digits after the point of the decimals.
    unit
        ``s`` or ``ms``.
    changed
        How many times are not exactly the binary number.
    example
        The first of those.
    """

    places: int
    unit: str
    changed: int
    example: float


@dataclass(frozen=True, slots=True)
class TimeUnitContradicted(Evidence):
    """The heading of the times names one unit, and their span is the run in seconds.

    Attributes
    ----------
    named
        The unit that the heading names.
    span
        Of the times as they are written.
    """

    named: str
    span: float


@dataclass(frozen=True, slots=True)
class TimesFromFirst(Evidence):
    """Times that count from long ago, as clocks of computers do, are taken from the first one.

    Attributes
    ----------
    first
        The first time.
    unit
        Its unit.
    """

    first: float
    unit: str


@dataclass(frozen=True, slots=True)
class TimesOfDay(Evidence):
    """Times of day, perhaps with a date, are counted from the first of them."""

    first: str


@dataclass(frozen=True, slots=True)
class TimesUnsorted(Evidence):
    """Times go back, first in this line or row, so many times."""

    counted_by: str
    line: int
    count: int


@dataclass(frozen=True, slots=True)
class TimesRepeated(Evidence):
    """Rows that repeat the time of another row.

    Attributes
    ----------
    count
        Number of the rows whose time another row has.
    are_identical
        True if rows of one time also have the same values in every column.
    """

    count: int
    are_identical: bool


# How it lies beside the reference.


@dataclass(frozen=True, slots=True)
class ManeuverRecognised(Evidence):
    """The maneuver of a file that does not tell it was recognised by its values."""

    maneuver: int


@dataclass(frozen=True, slots=True)
class ManeuverGuessed(Evidence):
    """The values of a file that does not name its maneuver may be of several.

    Attributes
    ----------
    maneuver
        The nearest, with which the file is compared.
    may_be
        The others, the nearest first.
    option
        The option that names the maneuver.
    """

    maneuver: int
    may_be: tuple[int, ...]
    option: str


@dataclass(frozen=True, slots=True)
class NoReference(Evidence):
    """Columns that the reference does not have.

    Attributes
    ----------
    keys
    folder
        Of the reference.
    lacks
        The file that the reference lacks; empty if it has that, without these columns.
    """

    keys: tuple[str, ...]
    folder: str
    lacks: str = ""

    def lost(self, compared: Collection[str]) -> Iterable[LostColumn]:
        return (LostColumn(key, key) for key in self.keys)


@dataclass(frozen=True, slots=True)
class MeantByValues(Evidence):
    """A name with several meanings was decided by its values; key None: it is none of them."""

    key: str | None
    may_be: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class WheelRate(Evidence):
    """The forward speed is written as the rate of a wheel of this radius, with its unit."""

    radius: str


@dataclass(frozen=True, slots=True)
class OtherOrder(Evidence):
    """Columns of the benchmark that stand in the places of others.

    Attributes
    ----------
    keys
        What the columns are, in the order of the file.
    told
        The option that tells it, if one does.
    """

    keys: tuple[str, ...]
    told: str = ""


@dataclass(frozen=True, slots=True)
class OtherManeuver(Evidence):
    """Values in the place of a maneuver that are nearer to another one.

    Attributes
    ----------
    maneuver, nearest
    distance, own_distance
        Typical difference from the nearest maneuver and from their own, in parts of the columns.
    """

    maneuver: int
    nearest: int
    distance: float
    own_distance: float


@dataclass(frozen=True, slots=True)
class TimesInLargerUnit(Evidence):
    """Times that are those of a run in minutes or hours, of angles too fast for seconds.

    Attributes
    ----------
    unit
        Its name.
    seconds
        Seconds in the unit.
    span
        Of the times, as seconds [s].
    """

    unit: str
    seconds: float
    span: float


@dataclass(frozen=True, slots=True)
class RowsOutside(Evidence):
    """Rows outside the run of the reference, which are left out.

    Attributes
    ----------
    rows
        How many.
    t_first, t_last
        The earliest and the latest of their times [s].
    duration
        Of the reference [s].
    may_be_in
        The smaller unit that most times may have, in words; None if they fit none.
    """

    rows: int
    t_first: float
    t_last: float
    duration: float
    may_be_in: str | None = None


@dataclass(frozen=True, slots=True)
class TooLarge(Evidence):
    """Values that are too large to compute with, which are left out."""

    maneuver: int
    key: str
    values: int


@dataclass(frozen=True, slots=True)
class Unfilled:
    """A column of a maneuver with one number in every row, where the quantity varies."""

    maneuver: int
    key: str
    number: float


@dataclass(frozen=True, slots=True)
class NeverFilled(Evidence):
    """Columns that were never filled in; `maneuvers` is how many the file has."""

    columns: tuple[Unfilled, ...]
    maneuvers: int

    def lost(self, compared: Collection[str]) -> Iterable[LostColumn]:
        return (LostColumn(f"{x.maneuver}.{x.key}", x.key, x.maneuver) for x in self.columns)


# What its columns mean.


@dataclass(frozen=True, slots=True)
class TakenDefinition:
    """A column, and the definition that it is taken as.

    Attributes
    ----------
    key, definition
    odds : Odds or None
        None where nothing tells.
    may_also_be
        Definitions that fit as well.
    """

    key: str
    definition: str
    odds: Odds | None
    may_also_be: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class WholeTurns(Evidence):
    """Angles were written within one turn; the whole turns between their rows were added."""

    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ScalarLast(Evidence):
    """The quaternion of a frame, ``rear`` or ``front``, was written with its scalar last."""

    end: str


@dataclass(frozen=True, slots=True)
class PathTurned(Evidence):
    """The path on the floor starts in another direction [rad]; it was turned back."""

    heading: float


@dataclass(frozen=True, slots=True)
class Conventions(Evidence):
    """All conventions of a file that are not the default ones.

    Attributes
    ----------
    turned
        Columns with the other sign.
    units, offsets
        By key, the unit, and the zero [SI unit].
    definitions : tuple of TakenDefinition
    are_signs_contradicted
        True if other signs of the file contradict each other, which are none of these.
    """

    turned: tuple[str, ...]
    units: Mapping[str, str]
    offsets: Mapping[str, float]
    definitions: tuple[TakenDefinition, ...]
    are_signs_contradicted: bool


@dataclass(frozen=True, slots=True)
class Convention(Evidence):
    """A choice by which one column is read, and the errors with it and without any.

    Attributes
    ----------
    key
    errors, errors_as_written
        As understood, and taken as the default definition in SI units.
    """

    key: str
    errors: Errors
    errors_as_written: Errors


@dataclass(frozen=True, slots=True)
class OtherDefinition(Convention):
    """Another definition than the default, with the errors of the latter."""

    taken: TakenDefinition
    default: str
    errors_of_default: Errors


@dataclass(frozen=True, slots=True)
class OtherSign(Convention):
    """The other sign."""


@dataclass(frozen=True, slots=True)
class OtherUnit(Convention):
    """Another unit than that of the default."""

    unit: str
    default: str


@dataclass(frozen=True, slots=True)
class OtherZero(Convention):
    """Another zero: the constant that the values have too much [SI unit]."""

    offset: float


@dataclass(frozen=True, slots=True)
class UnitContradicted(Evidence):
    """The heading of a column names one unit, and its values are in another."""

    key: str
    heading: str
    unit: str


@dataclass(frozen=True, slots=True)
class SignContradiction(Evidence):
    """Columns whose signs no choice of axes and senses gives."""

    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SensesOpposed(Evidence):
    """Roll is positive to the left and steer to the right, which few axes give."""

    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class DefinitionUnknown(Evidence):
    """A column of no definition that is known here, beside others that are right.

    Attributes
    ----------
    key
    nearest
        The nearest definition.
    log10_odds
        Of that definition against all that are not known.
    errors : Errors
    digits_of_others
        Correct digits of the worst other column.
    """

    key: str
    nearest: str
    log10_odds: float
    errors: Errors
    digits_of_others: float


# What contradicts the rest of it, or the exact motion.


@dataclass(frozen=True, slots=True)
class TimeShift(Evidence):
    """All times are off by a constant.

    Attributes
    ----------
    shift
        How much too late they are [s].
    begins_at_start
        True if the first row holds the initial state.
    """

    shift: float
    begins_at_start: bool


@dataclass(frozen=True, slots=True)
class StoppedEarly(Evidence):
    """The diagnosis ended before every cause was tried, as its time was spent.

    Attributes
    ----------
    seconds
        Processor time that it was given [s].
    """

    seconds: float


@dataclass(frozen=True, slots=True)
class CoveredInPart(Evidence):
    """Parts of the run that no complete rows show.

    Attributes
    ----------
    maneuvers
        Those with the same rows.
    t_start, t_end, gap
        First and last complete row, and the longest time without one [s].
    has_holes
        True if it is between the rows that something is missing.
    """

    maneuvers: tuple[int, ...]
    t_start: float
    t_end: float
    gap: float
    has_holes: bool


@dataclass(frozen=True, slots=True)
class EnergyHidesError(Evidence):
    """The energy is within the limit of eq. (1) although something else is visibly wrong.

    Attributes
    ----------
    maneuvers
        All in which that is so.
    maneuver, key, max_rel_error, performance
        The worst column of these, its error in scales, and eq. (1) there [%].
    """

    maneuvers: tuple[int, ...]
    maneuver: int
    key: str
    max_rel_error: float
    performance: float


@dataclass(frozen=True, slots=True)
class EnergySum(Evidence):
    """Potential plus kinetic energy is not the mechanical energy; the largest difference [J]."""

    maneuvers: tuple[int, ...]
    energy_sum: float
    floor: float


@dataclass(frozen=True, slots=True)
class RateContradiction(Evidence):
    """A rate that is not the derivative of its own angle; root mean square [rad/s]."""

    maneuvers: tuple[int, ...]
    key: str
    rms_difference: float


@dataclass(frozen=True, slots=True)
class SinglePrecision(Evidence):
    """Numbers of single precision.

    Attributes
    ----------
    keys
    is_written
        True if the values are such numbers; else they were computed with on the way.
    are_all
        True if all values are.
    """

    keys: tuple[str, ...]
    is_written: bool
    are_all: bool = True


@dataclass(frozen=True, slots=True)
class FewDigits(Evidence):
    """Columns whose error is that of the digits written."""

    keys: tuple[str, ...]
    significant_digits: int


# What several files tell together.


class Grouping(Enum):
    """What several files are scored as."""

    PROGRAMS = "programs"
    FILES = "files"


@dataclass(frozen=True, slots=True)
class NoSharedColumns(Evidence):
    """No two of the programs or files have a column of one maneuver in common."""

    of: Grouping


@dataclass(frozen=True, slots=True)
class StepsUnknown(Evidence):
    """Nothing tells the runs of one program apart; `is_told` if equal steps were given."""

    is_told: bool


@dataclass(frozen=True, slots=True)
class ManeuversDiffer(Evidence):
    """Programs that hold different maneuvers, by their names."""

    maneuvers: Mapping[str, tuple[int, ...]]


@dataclass(frozen=True, slots=True)
class DefinitionsOfPrograms(Evidence):
    """A column that programs define in different ways: the programs of each definition."""

    key: str
    programs: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class DefinitionsOfRuns(Evidence):
    """Columns that files of one program seem to define in different ways."""

    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ErrorFalls(Evidence):
    """How the errors of a program fall with its step or its tolerance.

    Attributes
    ----------
    by
        ``step`` or ``tolerance``.
    exponent
        The median over the columns: the order, by the step.
    least, most, columns
        The range of the columns' exponents, and how many these are.
    """

    by: str
    exponent: float
    least: float
    most: float
    columns: int


@dataclass(frozen=True, slots=True)
class OrderNotSettled(Evidence):
    """Columns (``2.roll_angle``) whose order still changes from step to step."""

    places: tuple[str, ...]


class Staying(Enum):
    """What an error is that does not fall with the step or the tolerance."""

    ROUNDING = "it is as small as rounding of binary64"
    NOISE = "it is another curve in each run"
    SAME_CURVE = "it is the same curve in both runs"


@dataclass(frozen=True, slots=True)
class ErrorStays(Evidence):
    """Columns whose error does not fall.

    Attributes
    ----------
    how : Staying
    places
        The columns (``2.roll_angle``).
    max_rel_error
        The largest of their errors, in scales.
    by
        With what it should fall: ``step`` or ``tolerance``.
    """

    how: Staying
    places: tuple[str, ...]
    max_rel_error: float
    by: str


# What was done to columns or rows that are written of a motion, seen on the numbers alone.


@dataclass(frozen=True, slots=True)
class CoarseGrid(Evidence):
    """A column whose values are multiples of a step that is far coarser than its digits.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    step
        The largest of the maneuvers [SI unit].
    """

    key: str
    maneuvers: tuple[int, ...]
    step: float


@dataclass(frozen=True, slots=True)
class HalfPrecision(Evidence):
    """Columns whose values are numbers of half precision; `are_all` if every one is."""

    keys: tuple[str, ...]
    are_all: bool


@dataclass(frozen=True, slots=True)
class RowsReversed(Evidence):
    """Maneuvers whose rows are written from the last to the first."""

    maneuvers: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class SingleRows(Evidence):
    """Single rows of a column that do not fit the rows around them.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    rows
        How many.
    time
        Of the first [s].
    is_held
        True if each holds the value of the row before it.
    """

    key: str
    maneuvers: tuple[int, ...]
    rows: int
    time: float
    is_held: bool


@dataclass(frozen=True, slots=True)
class RateOfDifferences(Evidence):
    """A rate that is a difference of its own angle: ``forward``, ``backward`` or ``central``."""

    key: str
    how: str


@dataclass(frozen=True, slots=True)
class Mirrored(Evidence):
    """Maneuvers that are the right motion to the other side: it begins with the other roll rate.

    Attributes
    ----------
    maneuvers : tuple of int
    """

    maneuvers: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class RateOfOtherRow(Evidence):
    """A rate that is that of its own angle at another row, whatever the motion is.

    Attributes
    ----------
    key
    rows
        By how many rows it is late.
    """

    key: str
    rows: float


@dataclass(frozen=True, slots=True)
class OtherClock(Evidence):
    """The rows of one maneuver, or all of them, are the right ones of other times.

    Attributes
    ----------
    maneuver
        None of all.
    scale, shift
        Time meant = scale * time written + shift [s].
    rows
        The shift in distances of the rows; None if these are not even.
    keys
        The columns, where others are right at the times written; otherwise empty.
    """

    maneuver: int | None
    scale: float
    shift: float
    rows: float | None
    keys: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TimesAddedUp(Evidence):
    """The rows are the right ones of multiples of a step, from which the written times creep away.

    Attributes
    ----------
    step
        [s]
    creep
        What a time is off by, at most [s].
    is_single
        True if they are what adding up the step in single precision gives.
    """

    step: float
    creep: float
    is_single: bool


@dataclass(frozen=True, slots=True)
class ColumnRatio(Evidence):
    """A column is a factor times the right one, with another zero.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    factor, offset
        Written = factor * right + offset [SI unit].
    unit
        The unit that has this factor; None if there is none.
    """

    key: str
    maneuvers: tuple[int, ...]
    factor: float
    offset: float
    unit: str | None


@dataclass(frozen=True, slots=True)
class OtherColumn(Evidence):
    """A column holds the values of another one, in some maneuvers.

    Attributes
    ----------
    key
        What the column should be.
    maneuvers : tuple of int
    other
        The key of what it holds.
    of_maneuver
        The maneuver from which that is, if it is another one.
    """

    key: str
    maneuvers: tuple[int, ...]
    other: str
    of_maneuver: int | None = None


@dataclass(frozen=True, slots=True)
class UnsignedColumn(Evidence):
    """A column holds the right values without their signs, in some maneuvers.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    """

    key: str
    maneuvers: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ClippedColumn(Evidence):
    """A column stays at a bound.

    Attributes
    ----------
    key
    maneuvers : tuple of int
    low, high
        The bounds [SI unit]; None without one.
    is_right_within
        True if it is right elsewhere, and the right one is beyond the bounds there.
    """

    key: str
    maneuvers: tuple[int, ...]
    low: float | None
    high: float | None
    is_right_within: bool


@dataclass(frozen=True, slots=True)
class SmoothedColumns(Evidence):
    """Columns (``2.roll_angle``) that are moving averages over so many rows."""

    places: tuple[str, ...]
    rows: int


@dataclass(frozen=True, slots=True)
class Remainder(Evidence):
    """What is left where all that is wrong is explained: the largest error, and its place.

    Attributes
    ----------
    max_rel_error
        In the scale of the column.
    place
        Maneuver and column (``2.roll_angle``).
    """

    max_rel_error: float
    place: str


@dataclass(frozen=True, slots=True)
class TooFar(Evidence):
    """Half of the columns or more are off by half their own size: hardly any motion is left."""


@dataclass(frozen=True, slots=True)
class BlownUp(Evidence):
    """A motion that blows up.

    Attributes
    ----------
    maneuver, key
        The column that is off the most.
    time
        From then on it is off by half its size [s].
    max_rel_error
        In scales.
    """

    maneuver: int
    key: str
    time: float
    max_rel_error: float


@dataclass(frozen=True, slots=True)
class ErrorOfRounding(Evidence):
    """No column is off by more than what rounding leaves of a run, in scales."""

    max_rel_error: float


@dataclass(frozen=True, slots=True)
class TooFewRows(Evidence):
    """So few rows that the error has no shape."""


@dataclass(frozen=True, slots=True)
class SmoothError(Evidence):
    """An error that is smooth, as an integrator, another model or other times leave it.

    Attributes
    ----------
    missing : tuple of str
        Columns of the state that the file does not have: with them it would show more.
    """

    missing: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class WorkFromStart(Evidence):
    """Work that is done from the first row on, where gravity does none.

    Attributes
    ----------
    powers, forces
        By the number of the maneuver, with which the kinetic energy begins to change [W], and along
        the motion [N].
    """

    powers: Mapping[int, float]
    forces: Mapping[int, float]


@dataclass(frozen=True, slots=True)
class Unsymmetric(Evidence):
    """An error that begins alike in two maneuvers, though the roll rate of one is far larger.

    Attributes
    ----------
    key
    small, large
        The numbers of the maneuvers.
    times
        What the error of the latter is of that of the former.
    """

    key: str
    small: int
    large: int
    times: float


@dataclass(frozen=True, slots=True)
class BeginsAs(Evidence):
    """An error of angles that begins as a power of the time.

    Attributes
    ----------
    keys : tuple of str
    order
        1 as of another rate at the start, other times or an integrator; 2 as of a force or another
        speed at the start; 3 as of a force that is zero there. No more are told apart.
    maneuvers
    """

    keys: tuple[str, ...]
    order: int
    maneuvers: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class EnergyTrend(Evidence):
    """A mechanical energy that falls or grows steadily in every maneuver.

    Attributes
    ----------
    maneuvers
    changes : tuple of float
        Of each, in parts of the energy; all have one sign.
    """

    maneuvers: tuple[int, ...]
    changes: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class EnergyVaries(Evidence):
    """A mechanical energy that changes, and not steadily in every maneuver.

    Attributes
    ----------
    largest : mapping of int to (float, float)
        By the number of the maneuver, how much more it is than in the first row where that is most
        [J], and when [s]. Of maneuvers where it is seen.
    until
        From when on it stays in all of these [s]; None if it does not.
    """

    largest: Mapping[int, tuple[float, float]]
    until: float | None = None


@dataclass(frozen=True, slots=True)
class EnergyKept(Evidence):
    """A mechanical energy that stays, while its parts are wrong in every maneuver.

    Attributes
    ----------
    left
        The largest change [J].
    exchanged : mapping of int to float
        By the number of the maneuver, how far the parts are off [J].
    """

    left: float
    exchanged: Mapping[int, float]


@dataclass(frozen=True, slots=True)
class RoughError(Evidence):
    """Columns (``2.roll_angle``) whose error is noise, far above the digits written.

    Attributes
    ----------
    places : tuple of str
    are_all
        True if noise is most of the error, in most columns; otherwise it is beside another one.
    """

    places: tuple[str, ...]
    are_all: bool = True


@dataclass(frozen=True, slots=True)
class StepRinging(Evidence):
    """Maneuvers whose rates alternate from row to row."""

    maneuvers: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class IterationNoise(Evidence):
    """Maneuvers whose rates jump from row to row, much more than their angles."""

    maneuvers: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class SinglePrecisionBeside(Evidence):
    """Numbers of single precision, beside an error that is far larger."""

    single: SinglePrecision


@dataclass(frozen=True, slots=True)
class FallsOver(Evidence):
    """A bicycle that falls over, where the exact one does not.

    Attributes
    ----------
    times : mapping of int to float
        When the lean passes a quarter turn, by maneuver [s].
    """

    times: Mapping[int, float]


@dataclass(frozen=True, slots=True)
class RowsRepeated(Evidence):
    """Last rows that hold the same numbers, of a motion that does not stand still.

    Attributes
    ----------
    maneuver
    time
        Of the first of them [s].
    rows
        How many.
    keys
    are_all
        True if all columns stand still: the motion ended there.
    """

    maneuver: int
    time: float
    rows: int
    keys: tuple[str, ...]
    are_all: bool


@dataclass(frozen=True, slots=True)
class RowsBetween(Evidence):
    """Rows that were held or interpolated.

    Attributes
    ----------
    maneuvers : tuple of int
    order
        0 if rows repeat the one before, 1 if they are on straight lines between others, 2 if they
        are on curves between others.
    share
        Of the rows.
    keys : tuple of str
        Those of the angles and rates that show it, if these are less than half.
    every
        Every row of this count is right, where rows are on curves; otherwise 0.
    """

    maneuvers: tuple[int, ...]
    order: int
    share: float
    keys: tuple[str, ...] = ()
    every: int = 0


@dataclass(frozen=True, slots=True)
class Departs(Evidence):
    """A motion that is right up to some row, and soon after it a hundred times farther off.

    Attributes
    ----------
    maneuver
    t_right, time
        Of the last row that is right, and of the one that is so far off [s].
    before, after
        Errors until then and there, in scales.
    t_back
        Of the last row that is off, if those after it are right again [s].
    shift
        Where the rest is the right motion at another time, by how much that is later [s].
    keys : tuple of str
        The columns that show it, if others do not: their definition is not known.
    """

    maneuver: int
    t_right: float
    time: float
    before: float
    after: float
    t_back: float | None = None
    shift: float | None = None
    keys: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class OtherTimes(Evidence):
    """Rows that are the right motion at other times than those that are written.

    Attributes
    ----------
    ahead : mapping of int to (float, float)
        From how much later to how much later, of nine rows in ten of each maneuver [s].
    relief : tuple of float
        Factor by which that lets the error of each fall.
    is_one
        True if it is about the same time for all rows.
    """

    ahead: Mapping[int, tuple[float, float]]
    relief: tuple[float, ...]
    is_one: bool


@dataclass(frozen=True, slots=True)
class ColumnOfAnotherManeuver(Evidence):
    """Columns of a maneuver that hold the numbers of another one."""

    maneuver: int
    of: int
    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class AnotherStart(Evidence):
    """A first row with another value than the maneuver is given.

    Attributes
    ----------
    maneuver
    key
    found, given
        In the unit of the column.
    unit
    told
        The unit in which this would be what is given; None without one.
    """

    maneuver: int
    key: str
    found: float
    given: float
    unit: str
    told: str | None


@dataclass(frozen=True, slots=True)
class Scaled:
    """Values are a factor times the right ones, and an offset [SI]."""

    factor: float
    offset: float


@dataclass(frozen=True, slots=True)
class ColumnsApart(Evidence):
    """Columns that are wrong beside a motion that is right.

    Attributes
    ----------
    columns : mapping of str to tuple of int
        Their maneuvers, by their keys.
    every
        Number of maneuvers of the file.
    error_of_others
        The largest, in scales.
    fits : mapping of str to Scaled
        Of those that a factor or an offset explains.
    units : mapping of str to str
    is_sum_with_it
        True if the mechanical energy is wrong because one of its parts is.
    """

    columns: Mapping[str, tuple[int, ...]]
    every: int
    error_of_others: float
    fits: Mapping[str, Scaled]
    units: Mapping[str, str]
    is_sum_with_it: bool


@dataclass(frozen=True, slots=True)
class RightElsewhere(Evidence):
    """Some maneuvers are right, and what was found is about the others alone.

    Attributes
    ----------
    wrong, right : tuple of int
        Numbers of the maneuvers.
    max_rel_error
        Of the right ones, in scales.
    """

    wrong: tuple[int, ...]
    right: tuple[int, ...]
    max_rel_error: float


@dataclass(frozen=True, slots=True)
class NotDiagnosed(Evidence):
    """Columns beside the benchmark's that are wrong where those are, too."""

    keys: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ColumnBeside(Evidence):
    """A column beside the benchmark's that is wrong alone.

    Attributes
    ----------
    key
    maneuvers
    unit
    max_rel_error
        In scales.
    constant : tuple of float
        The number in every row of each maneuver, where the right one moves; empty if it varies.
    fit : Scaled or None
        What explains it.
    """

    key: str
    maneuvers: tuple[int, ...]
    unit: str
    max_rel_error: float
    constant: tuple[float, ...] = ()
    fit: Scaled | None = None
