"""Check every byte, structure and number of a dataset without heyoka, or integrate it again."""
