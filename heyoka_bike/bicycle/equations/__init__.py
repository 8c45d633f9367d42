"""Everything that follows from a state, in any number type."""
