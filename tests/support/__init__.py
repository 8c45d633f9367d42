"""How tests are run: browsers, servers, clusters, other processes, programs that are compiled."""
