"""Long-term behaviour of the benchmark's motions after their ten seconds, proved."""
