"""Checks of the values that a program computes in single states, before anything moves."""
