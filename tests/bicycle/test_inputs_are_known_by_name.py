"""Bicycles of the collection are found by name, and bicycle files may contain uncertainties."""

import re
from fractions import Fraction

import pytest

from heyoka_bike.bicycle.parameters import describe_inputs, read_bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.numbers.exact import Exact
from heyoka_bike.system.resources import benchmark_bicycle, collection, data_folder, find_input


@pytest.fixture
def changed(tmp_path):
    """Reads the benchmark's file with the entry of one parameter changed."""

    def read(symbol, entry):
        text, n = re.subn(
            rf"^{symbol}\s*= .*", f"{symbol} = {entry}", benchmark_bicycle().read_text("utf-8"),
            flags=re.MULTILINE,
        )  # fmt: skip
        assert n == 1
        path = tmp_path / "b.toml"
        path.write_text(text, "utf-8")
        line = text[: text.index(f"\n{symbol} ")].count("\n") + 2
        return path, line

    return read


def test_names_are_paths_below_the_folder():
    folder = data_folder() / "bicycles"
    assert find_input("bicycles", "pista") == folder / "pista.toml"
    assert (
        find_input("bicycles", "adversarial/zero-trail") == folder / "adversarial/zero-trail.toml"
    )
    assert set(collection("bicycles")) <= set(collection("maneuvers"))


def test_a_file_is_meant_where_there_is_one_or_it_ends_in_toml(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pista").write_text("")
    (tmp_path / "mine").write_text("")
    assert find_input("bicycles", "mine").samefile(tmp_path / "mine")
    assert find_input("bicycles", "./pista").samefile(tmp_path / "pista")
    assert find_input("bicycles", "pista").suffix == ".toml"
    assert str(find_input("bicycles", "nowhere.toml")) == "nowhere.toml"


def test_a_wrong_name_gets_the_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as e:
        find_input("bicycles", "browsr")
    assert str(e.value).startswith("bicycle: found 'browsr', expected 'browser' or another of: adv")
    assert all(name in str(e.value) for name in collection("bicycles"))
    with pytest.raises(InputError, match=r"^maneuvers: found '\?', expected a TOML file or one of"):
        find_input("maneuvers", "?")


def test_an_uncertainty_is_exact_and_changes_nothing_else(changed, bicycle):
    path, _ = changed("c", '{ value = "0.08", uncertainty = "0.0017" }')
    found = read_bicycle(path)
    assert found.uncertainties == {"c": Exact(Fraction(17, 10000))}
    assert found == bicycle
    assert describe_inputs(found, ()) == describe_inputs(bicycle, ())


def test_a_tilt_may_be_uncertain_by_parts_of_pi(changed):
    path, _ = changed("lam", '{ value = "pi/10", uncertainty = "pi/900" }')
    assert read_bicycle(path).uncertainties["lam"] == Exact(Fraction(0), Fraction(1, 900))


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ('"-0.1"', "found -0.1 m, expected zero or more"),
        ('"pi/100"', "found 0.0314159265358979, expected a number without pi"),
        ('"a"', "found 'a', expected a decimal"),
        ("true", "found a boolean, expected a number as a decimal string"),
        ("[1]", "found a list, expected a number as a decimal string"),
    ],
)
def test_a_bad_uncertainty_is_named_with_its_key(changed, entry, found):
    path, _ = changed("c", f'{{ value = "0.08", uncertainty = {entry} }}')
    with pytest.raises(InputError) as e:
        read_bicycle(path)
    assert str(e.value).startswith(f"{path}: parameters.c.uncertainty: {found}")


def test_a_changed_parameter_has_no_uncertainty_any_more(changed):
    path, _ = changed("c", '{ value = "0.08", uncertainty = "0.0017" }')
    found = read_bicycle(path)
    assert found.replace(w=Exact(Fraction(1))).uncertainties == found.uncertainties
    assert found.replace(c=Exact(Fraction(0))).uncertainties == {}


def test_a_maneuver_has_no_uncertainties(tmp_path):
    from heyoka_bike.bicycle.parameters import read_maneuvers

    path = tmp_path / "m.toml"
    path.write_text(
        '[[maneuver]]\nspeed = { value = "4", uncertainty = "1" }\nroll_rate = "0"\n'
        'duration = "1"\nspacing = "1"\n'
    )
    with pytest.raises(InputError, match="unknown entry 'uncertainty'"):
        read_maneuvers(path)
