"""Reading of arrays of any shape as columns by name, in files, in memory and in data frames."""
