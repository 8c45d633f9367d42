"""Checks of a reference folder (`verify`, `rerun`) and of an installation (`selfcheck`)."""
