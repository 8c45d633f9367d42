"""What Python and notebooks show of an object.

Each module has ``html(shown)``, and ``text(shown)`` if that is more than a line.
Objects find their module by `display.Displayed`. The HTML has no script, and is no page of its own.
"""
