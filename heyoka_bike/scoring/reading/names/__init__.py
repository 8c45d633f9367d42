"""Meanings of column names, of each alone and of all together, and evidence of unknown names."""
