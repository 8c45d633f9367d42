"""Ratios of two errors that justify a conclusion, and odds that justify a claim.

Two causes, two columns or two parts of a run are always compared by one of these ratios. They rest
on these experiments:

- Fitting one value reduces the errors of correct programs by a factor of up to 9, and of up to 47
  if only two columns are fitted.
- Among columns with only one definition, one error is at most 5.4 times as large as the others,
  relative to the variation of each column. This holds for the maneuvers of `data/results` and
  `data/peers` that are right to a hundredth.
- Subtracting a constant from a growing error leaves half of it.
"""

AS_GOOD = 2.0
"""Two explanations are equally good if their errors differ by less than this factor: the simpler
one is chosen."""

CLEARLY = 10.0
"""A fitted value explains an error if it reduces it by this factor and other evidence agrees."""

BY_FAR = 100.0
"""A fitted value explains an error without other evidence if it reduces it by this factor."""

FEW_COLUMNS = 2
"""With this many columns or fewer, any fit looks too good: `BY_FAR` is required."""

MOST_ROWS = 0.9
"""Fraction of the rows that must agree. The others may be affected by an end, an event or a gap."""

ODDS_CLAIMED = 20.0
"""Odds to 1 above which a definition is claimed, or a unit or sign other than the default: at most
one claim in twenty may be wrong."""
