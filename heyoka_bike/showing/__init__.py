"""A report in every format, figures, and the motion in 3D."""
