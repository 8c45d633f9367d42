"""Text that the output formats share, by subject."""
