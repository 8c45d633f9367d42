"""The equations of motion, and everything that follows from a state, in any number type."""
