"""Time of the benchmark at equal accuracy, with heyoka and with other integrators."""
