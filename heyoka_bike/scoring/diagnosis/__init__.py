"""Why a result differs: `diagnose` adds the answer to a score.

`ranking` tries the usual mistakes (through `mistakes.search`, which simulates programs that make
them), then has `unknowns` fit parameters; `answers` says what was found, and asks `numerical` what
the error looks like if nothing explains it.
"""
