"""Options that several commands have."""

import os
from argparse import Action, ArgumentError, ArgumentParser, Namespace
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from heyoka_bike.errors import unknown_word


def add_reference(parser: ArgumentParser, of: str = "") -> None:
    """Add ``--reference``."""
    said = f"folder of a reference set{of} (default: the published one)"
    parser.add_argument("--reference", metavar="DIR", help=said)


def add_folder(parser: ArgumentParser) -> None:
    """Add the folder of a reference set as an argument."""
    said = "folder (default: the published set)"
    parser.add_argument("folder", nargs="?", metavar="DIR", help=said)


def add_bicycle(parser: ArgumentParser) -> None:
    """Add ``--bicycle``."""
    said = "a bicycle of the collection, or a TOML file (default: benchmark)"
    parser.add_argument("--bicycle", metavar="NAME|FILE", default="benchmark", help=said)


def add_workers(parser: ArgumentParser) -> None:
    """Add ``--workers`` and ``--cluster``, which `using_workers` takes."""
    group = parser.add_mutually_exclusive_group()
    group.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="do the work in N processes of this machine (default: one for each processor)",
    )
    group.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="do the work on the workers of a running Dask scheduler, such as tcp://node7:8786, or "
        "of a scheduler file; needs heyoka_bike[cluster]",
    )


def using_workers(args: Namespace) -> AbstractContextManager[None]:
    """For the time of a command, what was asked for by the options of `add_workers`."""
    workers, cluster = getattr(args, "workers", None), getattr(args, "cluster", None)
    if workers is None and cluster is None:
        return nullcontext()
    from heyoka_bike.system.parallel import using

    return using(workers, cluster=cluster)


def lists(action: Action, words: Iterable[str]) -> None:
    """Let a shell complete the words of an option that takes several, or checks them itself."""
    vars(action)["words"] = tuple(words)


def add_verbose(parser: ArgumentParser) -> None:
    """Add ``--verbose``, which `telling` takes."""
    said = "say on standard error what is done; twice, why so"
    parser.add_argument("-v", "--verbose", action="count", default=0, help=said)


def telling(args: Namespace) -> AbstractContextManager[None]:
    """For the time of a command, what ``--verbose`` or ``HEYOKA_BIKE_LOG`` asks for."""
    asked = ("info", "debug")[min(args.verbose, 2) - 1] if args.verbose else ""
    level = asked or os.environ.get("HEYOKA_BIKE_LOG", "")
    if not level:
        return nullcontext()
    from heyoka_bike.system.log import shown

    return shown(level)


def add_format(
    parser: ArgumentParser, formats: Sequence[str], *, default: str | None = None,
    required: bool = False, said: str = "",
) -> None:  # fmt: skip
    """Add ``--format``.

    Parameters
    ----------
    default
        The format if none is asked for; None if that depends on something else.
    said
        About the default.
    """
    about = said or (f"default {default}" if default else "")
    parser.add_argument(
        "--format", metavar="FORMAT", choices=formats, default=default, required=required,
        help=f"one of {', '.join(formats)}{f' ({about})' if about else ''}",
    )  # fmt: skip


def add_formats(
    parser: ArgumentParser, formats: Sequence[str], said: str, *, nargs: str | None = None
) -> None:
    """Add ``--format`` for several, as ``formats``."""
    action = parser.add_argument(
        "--format", metavar="FORMAT", dest="formats", action=_Formats, nargs=nargs,
        help=f"one of {', '.join(formats)}; {said}",
    )  # fmt: skip
    lists(action, formats)


class _Formats(Action):
    """Takes formats, separated by commas or not, as often as they are given."""

    words: tuple[str, ...]

    def __call__(
        self, parser: ArgumentParser, namespace: Namespace, values: Any, option: Any = None
    ) -> None:
        given = [values] if isinstance(values, str) else values
        found = [word for value in given for word in value.split(",")]
        for word in found:
            if word not in self.words:
                raise ArgumentError(self, unknown_word(word, self.words))
        setattr(namespace, self.dest, [*(getattr(namespace, self.dest) or ()), *found])


def add_output(parser: ArgumentParser, said: str, **options: Any) -> None:
    """Add ``-o`` and ``--output``, a file unless another ``metavar`` is given."""
    parser.add_argument("-o", "--output", help=said, **{"metavar": "FILE"} | options)


def add_maneuver(parser: ArgumentParser, said: str, kind: Callable[[str], Any] = str) -> None:
    """Add ``--maneuver``."""
    parser.add_argument("--maneuver", metavar="N", type=kind, help=said)
