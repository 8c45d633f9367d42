"""Evidence seen in a result file: one class for each kind, with its code, values and sentence."""
