"""Options that several commands have."""

import os
from argparse import Action, ArgumentParser, Namespace
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext

from heyoka_bike.errors import InputError, unknown_word


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


def add_format(parser: ArgumentParser, formats: Sequence[str]) -> None:
    """Add ``--format``, by default the first."""
    said = f"{' or '.join(formats)} (default {formats[0]})"
    parser.add_argument(
        "--format", metavar="FORMAT", choices=formats, default=formats[0], help=said
    )


def print_json(document: Mapping[str, object]) -> None:
    """Print one document, the only text on standard output."""
    import json

    print(json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False))


def check_format(found: str, formats: Sequence[str]) -> None:
    """Raise `InputError` if that is none of the formats."""
    if found not in formats:
        raise InputError(f"--format: {unknown_word(found, formats)}")
