"""Charts of the pages as SVG: drawing functions, and the charts of results."""
