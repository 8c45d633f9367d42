"""Changes of the rows of a result: how a program writes them, and how they are seen and undone."""
