"""What Python and notebooks show of an object.

Each module has ``blocks(shown)``, and ``text(shown)`` if an object's text is more than a line.
Objects find their module by `display.Displayed`. The HTML has no script, and is no page of its own.
"""
