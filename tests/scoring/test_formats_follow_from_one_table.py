"""The readers of files and the messages on formats both follow from one table of formats."""

import re

import pytest

pytest.importorskip("uvicorn")


from heyoka_bike.cli import main
from heyoka_bike.errors import InputError, MissingPackageError
from heyoka_bike.scoring.reading import formats, source
from heyoka_bike.scoring.reading.formats import FORMATS, Format, listed
from heyoka_bike.scoring.reading.source import read_results
from heyoka_bike.scoring.reading.text.rows import read_text
from heyoka_bike.workbench.serving import pages
from heyoka_bike.workbench.serving.tasks import Limits

MAGIC = b"MBSIM 1\n"
ROWS = b"time roll steer\n" + b"".join(b"%d 0.5 0.25\n" % i for i in range(5))


def plain(text):
    return " ".join(text.split())


@pytest.mark.parametrize("format_", FORMATS, ids=lambda f: f.name)
def test_every_format_has_a_reader_and_a_sentence(format_):
    assert callable(format_.reader())
    assert format_.about


def test_no_two_have_one_name():
    assert len({f.name for f in FORMATS}) == len({f.label for f in FORMATS}) == len(FORMATS)


def test_help_page_and_message_name_all(capsys, tmp_path):
    with pytest.raises(SystemExit):
        main(["score", "--help"])
    help_ = plain(capsys.readouterr().out)
    page = plain(pages.home("", Limits(), has_leaderboard=False))
    path = tmp_path / "x.bin"
    path.write_bytes(bytes(range(256)) * 20)
    with pytest.raises(InputError) as refused:
        read_results(path)
    for f in FORMATS:
        assert f"{f.label} (with {f.package})" in help_ if f.package else f.label in help_
        assert f.label in page
        assert re.search(rf"(, |expected |or ){re.escape(f.label)}", refused.value.message)


@pytest.fixture
def with_another(monkeypatch):
    """Add a format that is recognised by its first bytes, followed by text; its package is
    `package`."""

    class Other:
        package = None

        @classmethod
        def read(cls, file):
            if cls.package:
                raise ModuleNotFoundError(name=cls.package)
            text = file.content().removeprefix(MAGIC)
            return [read_text((text,), "utf-8", file.request)] if text else None

    def add(package=None):
        Other.package = package
        monkeypatch.setattr(Format, "reader", lambda self: Other.read)
        other = Format("mbsim", "MBSim", "rows", formats._begins(MAGIC), "none", package)
        monkeypatch.setattr(source, "FORMATS", (other,))

    return add


def test_one_more_is_read(with_another, tmp_path):
    with_another()
    path = tmp_path / "x"
    path.write_bytes(MAGIC + ROWS)
    results = read_results(path)
    assert results.format == "mbsim"
    assert list(results.maneuvers[0].values) == ["roll_angle", "steer_angle"]
    # A reader that returns None leaves the file to other readers. None of those accepts this file.
    path.write_bytes(MAGIC)
    with pytest.raises(InputError, match=re.escape(listed())):
        read_results(path)


def test_its_package_is_named_where_it_is_missing(with_another, tmp_path):
    with_another("mbsim-io")
    path = tmp_path / "x"
    path.write_bytes(MAGIC + ROWS)
    with pytest.raises(MissingPackageError, match=r"mbsim-io, which.*pip install mbsim"):
        read_results(path)


@pytest.mark.parametrize("word", [b"IM", b"MI"])
def test_a_text_with_the_letters_of_matlab_is_a_text(word, tmp_path):
    path = tmp_path / "x.txt"
    path.write_bytes(b"#".ljust(126) + word + b"\n" + ROWS)
    assert read_results(path).format == "text"
