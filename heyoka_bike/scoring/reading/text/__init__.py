"""Reading of rows of numbers in a text, in the many forms in which programs write them."""
