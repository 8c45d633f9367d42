"""What the error of a file looks like."""
