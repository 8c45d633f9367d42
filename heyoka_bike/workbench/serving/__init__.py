"""Scoring for people with a browser: a page to drop result files on."""
