"""An unknown word is reported with the word that was probably meant; the exit code is 1."""

import pytest

from heyoka_bike.cli import main
from heyoka_bike.errors import did_you_mean


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["scorre", "x.txt"], "heyoka-bike: COMMAND: found 'scorre', expected one of generate, "),
        (["scorre", "x.txt"], "; did you mean score? (see heyoka-bike --help)"),
        (
            ["score", "x.txt", "--fromat", "json"],
            "heyoka-bike score: unrecognized arguments: --fromat json; did you mean --format? "
            "(see heyoka-bike score --help)",
        ),
        (["score", "x.txt", "--reqire=scd>1"], "did you mean --require?"),
        (["export", "--format", "jsn"], "--format: found 'jsn', expected one of c, fortran"),
        (["export", "--format", "jsn"], "did you mean json?"),
        (["verify", "--format", "jsno"], "expected table or json; did you mean json?"),
        (["plot", "--figure", "stabilty"], "did you mean stability?"),
        (["score", "x.txt", "--format", "tableau"], "did you mean table?"),
        (["score", "x.txt", "--require", "max_abs_eror < 1"], "did you mean max_abs_error?"),
        (["score", "x.txt", "--require", "roll_agle.scd > 1"], "did you mean roll_angle?"),
    ],
)
def test_slip(words, said, capsys):
    try:
        code = main(words)
    except SystemExit as ended:
        code = ended.code
    out, err = capsys.readouterr()
    assert (code, out) == (1, "")
    assert said in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("words", [["score", "x.txt", "--zzz"], ["linear", "extra"]])
def test_nothing_is_guessed_of_words_like_none(words, capsys):
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 1
    err = capsys.readouterr().err
    assert "unrecognized arguments: " in err
    assert "did you mean" not in err


def test_case_does_not_matter():
    assert did_you_mean("JSON", ["table", "json"]) == "; did you mean json?"
