"""An atlas as a page in the browser."""
