"""How long the benchmark takes, at equal accuracy, with heyoka and with other integrators."""
