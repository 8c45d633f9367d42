"""Motions in binary64, as fast as possible."""
