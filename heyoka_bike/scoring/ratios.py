"""How many times as large one error must be as another to tell something, and what odds must be.

Whatever is compared, two causes, two columns or two parts of a run, is compared with one of these.
Their experiments:

- Errors of correct programs resemble one fitted value by a factor of up to 9, and in two columns
  alone by up to 47.
- Of the columns of one meaning one is at most 5.4 times as far off as the others, in the maneuvers
  of `data/results` and `data/peers` that are right to a hundredth, in parts of what each varies by.
- Taking a constant from an error that grows leaves half of it.
"""

AS_GOOD = 2.0
"""What leaves less than so many times as much is as good: the simpler one is meant."""

CLEARLY = 10.0
"""What one value makes so many times smaller is explained by it, beside others."""

BY_FAR = 100.0
"""What becomes so many times smaller is explained, with nothing else to speak for it."""

FEW_COLUMNS = 2
"""In so many columns whatever is fitted explains more than it should: only by far is enough."""

MOST_ROWS = 0.9
"""Of rows: the others may be of an end, an event or a gap, and are written otherwise."""

ODDS_CLAIMED = 20.0
"""Odds, to 1, from which a definition is not left open, and another unit or sign is taken: one
claim in twenty may be wrong at the most."""
