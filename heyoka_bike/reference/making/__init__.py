"""Making of a set: the numbers of each maneuver, and the bytes of each file."""
