"""What the names of columns mean, alone and beside each other."""
