"""Arrays, in whatever shape, as vectors by name."""
