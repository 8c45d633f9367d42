"""A report as a document with charts, in every format, and the display of objects in notebooks."""
