"""Changes of the rows of a result: how a program makes them, and how they are found and undone."""
