"""What was seen in a result file: one class for each thing, with its code, values and sentence."""
