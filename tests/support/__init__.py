"""Tools for running tests: browsers, servers, clusters, processes, compiled programs."""
