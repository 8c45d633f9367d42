"""Computing time of the benchmark at equal accuracy, with heyoka and other integrators."""
