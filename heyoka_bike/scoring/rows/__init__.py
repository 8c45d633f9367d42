"""Changes of the rows of a result: how a program makes them, and how they are found and undone.

A row check finds one kind of fault in milliseconds, without simulating a program. So all row checks
precede the simulations. A row check returns its evidence, and the corrected rows (`table.Undone`):
with the fault undone, a useless column removed, or the digits replaced with a grid. The corrected
rows are then diagnosed like any file. So the fault is reported as a cause, and the error that it
does not explain is reported separately. Each module defines the evidence of the faults that it
finds.

- Faults of one column: `column_faults` lists the functions of `averages`, `bounds`,
  `other_columns`, `other_moments` and `scaled_columns`, which `deviating_columns` tries and undoes.
  Further checks are in `bounds`, `grids`, `single_rows` and `other_maneuvers`.
- Columns that contradict one another: `rates` and `sums`.
- Faults of a whole maneuver: `maneuvers`.
- Wrong times: `wrong_times` and `other_times`.
- Changes that simulated programs make, too: `edits`.
"""
