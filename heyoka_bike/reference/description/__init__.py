"""What a set says of itself, to people and to machines: attributes, a card, an RO-Crate."""
