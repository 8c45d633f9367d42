"""The help lists commands in groups, with working examples; without arguments it shows three
commands."""

import re
import shlex

import pytest

from heyoka_bike import cli
from heyoka_bike.cli import DESCRIPTION, WELCOME, main, parser
from heyoka_bike.commands.registry import COMMANDS, GROUPS

NAMED = re.compile(r"^ *(heyoka-bike (?!--).*?)(?:  .*)?$", re.MULTILINE)


@pytest.fixture
def shown(capsys):
    with pytest.raises(SystemExit, match="0"):
        main(["--help"])
    return capsys.readouterr().out


def test_the_three_jobs_stand_before_the_groups(shown):
    assert shown.index(DESCRIPTION) < shown.index("commands:\n")
    jobs = [shlex.split(line)[1] for line in NAMED.findall(DESCRIPTION)]
    assert jobs == ["score", "score", "generate"]


def test_each_command_stands_below_its_group(shown):
    listed = shown[shown.index("commands:\n") : shown.index("exit codes:\n")]
    found, group = {}, ""
    for line in listed.splitlines():
        if title := re.fullmatch(r"  (\S.*), for example: .*", line):
            group = title[1]
        elif command := re.match(r"    ([a-z]+)(?:  |$)", line):
            found[command[1]] = group
    assert found == {name: group.title for group in GROUPS for name in group.commands}
    assert list(found) == list(COMMANDS)


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.title)
def test_an_example_is_a_command_of_its_group(group, shown):
    program, *words = shlex.split(group.example)
    assert (program, words[0] in group.commands) == ("heyoka-bike", True)
    parser(words[:1]).parse_args(words)
    assert f"{group.title}, for example: {group.example}\n" in shown


def test_a_group_without_commands_here_is_left_out():
    said = parser(["score"]).format_help()
    assert "  checking results, for example:" in said
    assert "  pictures, for example:" not in said


@pytest.mark.parametrize("text", [DESCRIPTION, WELCOME], ids=["jobs", "welcome"])
def test_what_is_said_can_be_called(text):
    calls = NAMED.findall(text)
    assert len(calls) == 3
    for _, *words in map(shlex.split, calls):
        parser(words[:1]).parse_args(words)


def test_without_words_three_commands_are_said(capsys, monkeypatch):
    monkeypatch.setattr(cli, "command", lambda name: pytest.fail(f"{name} was imported"))
    assert main([]) == 0
    assert capsys.readouterr().out == f"{WELCOME}\n"
    assert [shlex.split(call)[1] for call in NAMED.findall(WELCOME)] == [
        "score", "diagnose", "animate",
    ]  # fmt: skip
