"""What can be done to the rows of a result: how it is written, seen and undone."""
