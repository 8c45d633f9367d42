"""The checker without Python: the exact motion and the scoring as a C header, and its page."""
