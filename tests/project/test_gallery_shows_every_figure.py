"""The gallery shows every kind of figure with the command that makes it; its pictures are small."""

import shlex

import pytest

pytest.importorskip("PIL")

import figures
from gallery import IMAGES, PAGE, SHOTS, entries
from heyoka_bike.workbench.figures import FIGURES

_LARGEST = 200e3  # [bytes] size limit of a picture in the repository


def test_every_figure_of_plot_is_there():
    words = [shlex.split(line) for block in entries().values() for line in block.splitlines()]
    drawn = {w[w.index("--figure") + 1] for w in words if "--figure" in w}
    drawn |= {"maneuvers" for w in words if w[1] == "plot" and "--figure" not in w}
    assert drawn == {*FIGURES, "atlas"}
    assert {w[1] for w in words} >= {"plot", "score", "animate", "leaderboard", "atlas"}


def test_every_figure_of_the_pages_is_there():
    words = [shlex.split(line) for block in entries().values() for line in block.splitlines()]
    drawn = {w[2] for w in words if w[:2] == ["python", "docs/_site/figures"]}
    assert drawn == figures.FIGURES.keys()


def test_every_command_makes_the_picture_below_it():
    for name, block in entries().items():
        suffix = ".html" if name in SHOTS else ".png"
        *_, option, file = block.split()
        assert file == f"{name}{suffix}"
        assert option in ("-o", name)


def test_pictures_are_those_of_the_page_and_small():
    pictures = {p.stem: p.stat().st_size for p in IMAGES.iterdir()}
    assert pictures.keys() == entries().keys()
    assert max(pictures.values()) < _LARGEST
    shown = PAGE.read_text(encoding="utf-8").count("](images/gallery/")
    assert shown == len(pictures)
