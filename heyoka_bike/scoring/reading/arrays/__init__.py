"""Arrays in any shape as columns by name: in files, in memory, in data frames."""
