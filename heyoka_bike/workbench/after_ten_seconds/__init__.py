"""Long-term behaviour of the benchmark's motions after their first ten seconds, proved."""
