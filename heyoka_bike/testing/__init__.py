"""In other people's projects and installations: the pytest plugin, and the self-check."""
