"""Tools beyond the reference and its score: figures, speed records, maps, a server, longer proofs.

These modules may use the whole package except the commands, which use them.
"""
