"""Motions computed: integrated by heyoka, kept as exact polynomials; what happens on the way."""
