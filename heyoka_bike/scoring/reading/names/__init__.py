"""The meaning of the names of columns, alone and beside each other."""
