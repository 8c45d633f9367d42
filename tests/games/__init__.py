"""Files that are drawn, each with what is true of it, and who judges them."""
