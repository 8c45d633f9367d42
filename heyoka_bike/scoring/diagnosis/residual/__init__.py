"""The file's own motion in the exact equations, and what remains: which force is missing."""
