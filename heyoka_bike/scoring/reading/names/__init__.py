"""Names of columns: what they mean alone and beside each other, and what is said of them."""
