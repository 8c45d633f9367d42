"""Long-term behaviour of a bicycle, on a grid of initial conditions or parameters."""
