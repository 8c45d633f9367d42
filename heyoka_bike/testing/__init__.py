"""For other projects and installations: the pytest plugin, and the self-check."""
