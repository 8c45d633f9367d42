"""Why a result differs: `diagnose` adds the answer to a score.

`explain` finds causes: by what the file's own motion leaves of the exact equations (`residual`),
and by simulated programs that make the usual mistakes (`mistakes`, `programs`) beside the file
(`seen_file`). It compares them by their odds (`evidence`). `answers` says what was found, and asks
`numerical` what the error looks like if nothing explains it.
"""

UNITS_BESIDE = "units_beside"
"""Finding of a diagnosis that the file has other units than those that were scored."""
