"""Programs with mistakes, and the simulation of their motions."""
