"""Tables of single instants: what a program computes in a state, before anything moves."""
