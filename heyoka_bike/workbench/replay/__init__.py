"""The motion in 3D: as numbers, and in a page."""
