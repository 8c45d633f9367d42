"""Metadata of a set, for people and for machines: attributes, a card, an RO-Crate."""
