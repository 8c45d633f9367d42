"""A document is declared once, and text, pages and notebooks all show it."""

import pytest

from heyoka_bike.scoring.grades import Grade
from heyoka_bike.showing.document import (
    HTML,
    TEXT,
    Cell,
    Chapter,
    Chart,
    Document,
    Facts,
    Item,
    Listing,
    Paragraph,
    TableBlock,
    TableColumn,
    Words,
    html,
    text,
)
from support.pages import Page

TABLE = TableBlock(
    ["name", TableColumn("error", leave_out=1), TableColumn("said", is_prose=True)],
    [["one", "1e-3", "a word " * 20], ["two", Cell("7.1", grade=Grade.RIGHT), "b"]],
    about="Errors", note="All of it.",
)  # fmt: skip
BLOCKS = (
    Paragraph("Something is said.", lead="remark"),
    Listing((Item("three rows", "warning", "warning", "a.txt"),)),
    Facts((("energy", "1 J", "by its sum"),)),
    Chapter("Scores", (TABLE, Chart(lambda: "<svg></svg>")), "scores", "Scores", is_folded=True),
)
HOSTILE = "<b onclick=alert(1)>&\"'"


def page(blocks):
    return html.render(Document("title", "heading", "kind", tuple(blocks), [("by", "me")]))


def rendered(blocks):
    """The words of each medium."""
    parsed = (Page(made).text for made in (page(blocks), html.piece(blocks)))
    return [" ".join(text.render(blocks, 100).split()), *parsed]


def test_every_medium_says_all_of_it():
    for found in rendered(BLOCKS):
        for word in ("Something is said.", "three rows", "a.txt", "1 J", "Scores", "1e-3", "7.1",
                     "All of it.", "right: 6 correct digits or more"):  # fmt: skip
            assert word in found


@pytest.mark.parametrize("medium", [TEXT, HTML])
@pytest.mark.parametrize(
    "block",
    [
        lambda medium: Paragraph("secret", only=medium),
        lambda medium: Listing((Item("secret"),), medium),
        lambda medium: Facts((("name", "secret", ""),), medium),
        lambda medium: Chapter("secret", BLOCKS, only=medium),
        lambda medium: TableBlock(["a", TableColumn("b", only=medium)], [["c", "secret"]]),
    ],
)
def test_what_is_for_one_medium_is_not_in_another(block, medium):
    found = ["secret" in words for words in rendered([block(medium)])]
    assert found == [medium == TEXT, medium == HTML, medium == HTML]


def test_words_are_brief_in_text():
    lines, *others = rendered([Paragraph(Words("in full", "brief"))])
    assert lines == "brief"
    assert all("in full" in found for found in others)


def test_a_chapter_without_content_is_not_there():
    nothing = (Paragraph(""), Listing(()), Facts(()), TableBlock(["a"], []), Chart(lambda: ""))
    for found in rendered([Chapter("Chapter", nothing, "chapter", "Chapter")]):
        assert "Chapter" not in found


def test_a_chart_is_not_drawn_for_text():
    drawn = []
    chart = Chart(lambda: drawn.append(1) or "<svg></svg>")
    text.render([chart], 100)
    assert drawn == []
    assert page([chart]).count("<svg></svg>") == 1
    assert drawn == [1]


def test_prose_is_folded_and_what_may_go_is_left_out():
    columns = ["name", TableColumn("error" * 5, leave_out=1), TableColumn("said", is_prose=True)]
    table = TableBlock(columns, [["one", "1e-3", "word " * 20]])
    for width, is_there in ((120, True), (60, True), (40, False)):
        lines = text.render([table], width).splitlines()
        assert max(map(len, lines)) <= width
        assert ("error" in lines[0]) == is_there
        assert " ".join(lines).count("word") == 20


def test_a_table_in_parts_shows_every_column():
    table = TableBlock(["name", *map(str, range(40))], [["row", *["1.5e-3"] * 40]], in_parts=True)
    lines = text.render([table], 80).splitlines()
    assert max(map(len, lines)) <= 80
    assert sum(line.count("1.5e-3") for line in lines) == 40
    assert sum(line.startswith("row ") for line in lines) > 1


def test_nothing_of_a_text_becomes_markup():
    cells = [
        HOSTILE,
        Cell(HOSTILE, HOSTILE),
        Cell(HOSTILE, facts=Facts(((HOSTILE, HOSTILE, HOSTILE),))),
    ]
    blocks = (
        Paragraph(HOSTILE, lead=HOSTILE, sign="", link=(HOSTILE, "x"), note=HOSTILE),
        Listing((Item(HOSTILE, "info", HOSTILE, HOSTILE),)),
        Chapter(
            HOSTILE, (TableBlock([HOSTILE] * 3, [cells], HOSTILE, note=HOSTILE),), "x", HOSTILE
        ),
    )
    for made in (page(blocks), html.piece(blocks)):
        assert "<b onclick" not in made
        assert Page(made).text.count("onclick=alert(1)") > 10


def test_only_a_page_has_places_to_link_to():
    said = Paragraph("1001 rows", link=("1 warning", "findings"))
    blocks = [said, Chapter("Findings", [Paragraph("none")], "findings", "Findings")]
    assert '<a href="#findings">1 warning</a>' in page(blocks)
    assert 'id="findings"' in page(blocks)
    noted = html.piece(blocks)
    assert "1001 rows; 1 warning</p>" in noted
    assert "findings" not in noted
