"""An atlas as a page: a map, and the motion of any of its points."""
