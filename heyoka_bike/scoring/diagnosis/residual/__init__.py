"""Residual of the exact equations along the file's own motion, which shows missing forces."""
