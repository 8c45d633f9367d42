"""Compute motions: integrate with heyoka, store exact polynomials, find events on the way."""
