"""The output formats of a score: each module has ``render(scored)``, which gives the text."""
