"""Beside the reference and its score: figures, records of speed, maps, a server, longer proofs.

It uses the rest of the package below it; commands use it.
"""
