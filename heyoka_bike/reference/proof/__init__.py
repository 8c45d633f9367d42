"""From a candidate to certified bounds and rounded numbers."""
