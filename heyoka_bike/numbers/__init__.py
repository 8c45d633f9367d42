"""Number types without a bicycle in them."""
