"""Find out why a result differs from the reference: `diagnose` adds the causes to a score.

`pursue` is the loop: the row checks in `row_checks` find faults of the rows, which are undone. Then
`explain` searches for the cause of the remaining error. If the motion has such a cause, `beside`
looks for further faults of the rows.

`explain` finds causes in two ways: from the residual of the exact equations along the file's own
motion (`residual`), and by comparing the file (`seen_file`) with simulated programs that make usual
mistakes (`mistakes`, `programs`). `search` lists the steps. Causes are compared by their odds
(`odds`, `ranking`). `answers` returns them as evidence (`conclusions`). If no cause explains the
error, `numerical` describes its shape.
"""
