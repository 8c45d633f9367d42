"""Comparison of result files with the reference."""
