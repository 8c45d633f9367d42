"""Rows of numbers in a text, in whatever way programs write them."""
