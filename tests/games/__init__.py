"""Randomly drawn files with known properties, and the programs that judge them."""
