"""Why a result differs: `diagnose` adds the answer to a score.

`explain` finds causes: by what the file's own motion leaves of the exact equations (`residual`),
and by simulated programs that make the usual mistakes (`mistakes`, `programs`) beside the file
(`seen_file`), step by step (`search`). It compares them by their odds (`odds`, `ranking`).
`answers` gives the `conclusions` as evidence, and asks `numerical` what the error looks like if
nothing explains it.
"""
