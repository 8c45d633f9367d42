"""Parameters and starts whose other values explain a file."""
