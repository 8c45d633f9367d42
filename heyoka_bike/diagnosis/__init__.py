"""Why a result differs: `diagnosing` adds the answer to a score.

`ranking` tries the usual `mistakes` (through `search`, which simulates programs that make them),
then has `estimation` fit parameters; `words` says what was found, and asks `numerical` what the
error looks like if nothing explains it.
"""
