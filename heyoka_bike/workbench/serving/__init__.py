"""Scoring in a browser: a page to drop result files on."""
