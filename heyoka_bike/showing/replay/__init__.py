"""The motion in 3D: as numbers, in a page, in a film."""
