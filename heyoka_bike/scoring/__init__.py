"""A result file against the reference."""
