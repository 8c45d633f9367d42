"""The judge without Python: the exact motion and the scoring as a C header, and a page of it."""
