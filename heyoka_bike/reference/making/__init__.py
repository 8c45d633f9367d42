"""Everything about a maneuver, and the bytes of each file."""
