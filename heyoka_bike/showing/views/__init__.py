"""What Python and notebooks show of an object: each module has ``text(shown)`` and ``html(shown)``.

Objects find their module by `display.Displayed`. The HTML has no script, and is no page of its own.
"""
