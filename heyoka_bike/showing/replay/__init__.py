"""The motion in 3D: as numbers, in a page, in a film."""

FORMATS = ("html", "gif", "mp4")
SUFFIXES = {".html": "html", ".htm": "html", ".gif": "gif", ".mp4": "mp4"}
"""Formats of a replay, and the endings of their files."""
