"""A report in every format, figures, the motion in 3D, and the page of an atlas."""
