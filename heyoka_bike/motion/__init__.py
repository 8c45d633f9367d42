"""The whole motion: places, attitudes and forces, and the file that holds them."""
