"""Charts of the pages, as SVG: how they are drawn, and those of results."""
