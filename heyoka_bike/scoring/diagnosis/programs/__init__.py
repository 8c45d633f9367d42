"""A program with mistakes, and its motion."""
