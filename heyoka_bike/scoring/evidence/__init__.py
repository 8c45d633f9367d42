"""Evidence seen in a result file: one class for each kind, with its code, values and sentence.

Faults of the rows, and most evidence of a diagnosis, are defined beside the functions that find
them, in `scoring.rows` and `scoring.diagnosis`.
"""
