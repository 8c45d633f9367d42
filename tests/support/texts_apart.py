"""Check that no text of a figure overlaps another or leaves the page."""

from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text


def assert_texts_are_apart(figure, monkeypatch):
    """Check the texts of a matplotlib figure after drawing."""
    texts = {}

    def draw(text, renderer):
        if text.get_text().strip():
            # Measure only the text of an annotation, without its arrow.
            texts[id(text)] = text.get_text(), Text.get_window_extent(text, renderer)
        return drawn(text, renderer)

    drawn = Text.draw
    with monkeypatch.context() as patch:
        patch.setattr(Text, "draw", draw)
        FigureCanvasAgg(figure).draw()
    assert texts
    width, height = figure.bbox.size
    for text, box in texts.values():
        assert box.x0 >= 0 <= box.y0, text
        assert (box.x1 <= width, box.y1 <= height) == (True, True), text
    for (one, a), (other, b) in combinations(texts.values(), 2):
        across = min(a.x1, b.x1) - max(a.x0, b.x0)
        up = min(a.y1, b.y1) - max(a.y0, b.y0)
        # The box of a text is slightly larger than its letters, so small overlaps are allowed
        # [hundredths of an inch].
        assert min(across, up) < 1.5, (one, other)
