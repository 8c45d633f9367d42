"""The usual mistakes, and the search among them."""
