"""A report as a document with charts, in every format, and views of objects."""
