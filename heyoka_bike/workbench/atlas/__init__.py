"""What becomes of a bicycle, for a grid of starts or of parameters."""
