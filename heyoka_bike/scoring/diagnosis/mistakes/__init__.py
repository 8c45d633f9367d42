"""The library of usual mistakes."""
