"""Start a page in the browser to drop result files on.

Start a web page on this machine: drop result files on it, or paste rows, and see the report, why it
differs, the replay, several programs side by side. Programs send files to /score; /api says how.
Each file is scored in a process of its own, with limits of time and memory. Nothing is sent
anywhere. Needs heyoka_bike[serve].

examples:
  heyoka-bike serve
  heyoka-bike serve --port 9000 --keep 60 --max-size 20
  heyoka-bike serve --host 0.0.0.0 --name bicycle.example.org --no-diagnose

Stop it with Ctrl-C. How to host it: docs/how-to/serve.md
"""

from __future__ import annotations

import argparse
import re
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from heyoka_bike.commands.options import add_command
from heyoka_bike.errors import Exit, InputError, quoted, required

if TYPE_CHECKING:
    from heyoka_bike.workbench.serving.limits import Limits

_LOCAL = ("127.0.0.1", "localhost", "::1")
_LARGEST_PORT = 65535


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = add_command(subparsers, run, __doc__)
    p.add_argument(
        "--host", metavar="ADDRESS", default="127.0.0.1",
        help="address to listen on (default 127.0.0.1: this machine only)",
    )  # fmt: skip
    p.add_argument(
        "--port", metavar="N", type=int, default=8000, help="port (default 8000; 0: a free one)"
    )
    p.add_argument(
        "--name", metavar="HOST", action="append", default=[],
        help="name by which browsers ask for it, where it is not this machine's; may be repeated",
    )  # fmt: skip
    p.add_argument(
        "--root-path", metavar="PATH", default="",
        help="path below which another server hosts it, such as /bicycle; that may take the path "
        "away from requests or leave it",
    )  # fmt: skip
    p.add_argument("--open", action="store_true", help="open it in the browser")
    p.add_argument(
        "--max-size", metavar="MB", type=float, default=100, help="of one request (default 100)"
    )
    p.add_argument(
        "--keep", metavar="MINUTES", type=float, default=1440,
        help="how long a result is kept (default 1440, a day)",
    )  # fmt: skip
    p.add_argument(
        "--workers", metavar="N", type=int, help="files at once (default: one for each processor)"
    )
    p.add_argument(
        "--queue", metavar="N", type=int, default=100,
        help="files that wait; more are answered 'busy' (default 100)",
    )  # fmt: skip
    p.add_argument(
        "--memory", metavar="MB", type=float, default=2000, help="for one file (default 2000)"
    )
    p.add_argument("--no-diagnose", action="store_true", help="do not offer the diagnosis")
    p.add_argument(
        "--leaderboard", metavar="DIR", help="folder of submissions to show, see 'leaderboard'"
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the command."""
    limits = _limits(args)
    for package in ("python_multipart", "starlette", "uvicorn"):
        said = f"the package '{package}' is not installed: pip install 'heyoka_bike[serve]'"
        required(package, said)
    from heyoka_bike.workbench.serving.running import serve

    if not 0 <= args.port <= _LARGEST_PORT:
        raise InputError(f"--port: found {args.port}, expected 0 to {_LARGEST_PORT}")
    root = args.root_path.rstrip("/")
    if not re.fullmatch(r"(/[\w.~-]+)*", root, re.ASCII):
        raise InputError(f"--root-path: found {quoted(root)}, expected one such as /bicycle")
    names = [*args.name, *(_LOCAL if args.host in _LOCAL else ())]
    if not names:
        raise InputError(
            f"--host: found {args.host}, expected --name too, by which browsers ask for it ('*' "
            "for any)"
        )
    with suppress(KeyboardInterrupt):
        serve(args.host, args.port, names, limits, _board(args), args.open, root)
    return Exit.OK


def _limits(args: argparse.Namespace) -> Limits:
    from heyoka_bike.system.parallel import processors
    from heyoka_bike.workbench.serving.limits import Limits

    given = {
        "--max-size": args.max_size, "--keep": args.keep, "--queue": args.queue,
        "--memory": args.memory, "--workers": args.workers,
    }  # fmt: skip
    for option, value in given.items():
        if value is not None and not 0 < value < 1e9:
            raise InputError(f"{option}: found {value:g}, expected more than zero")
    return replace(
        Limits(),
        upload=int(1e6 * args.max_size),
        kept_seconds=60 * args.keep,
        workers=args.workers or processors(),
        waiting=args.queue,
        memory=int(1e6 * args.memory),
        has_diagnosis=not args.no_diagnose,
    )


def _board(args: argparse.Namespace) -> str | None:
    """The leaderboard as a page."""
    if args.leaderboard is None:
        return None
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.scoring.leaderboard import leaderboard
    from heyoka_bike.showing.document import html
    from heyoka_bike.showing.formats.leaderboard import document
    from heyoka_bike.showing.wording import origin
    from heyoka_bike.system.console import progress_bar

    with progress_bar("scoring") as progress:
        board = leaderboard(args.leaderboard, [load_reference()], progress)
    return html.render(document(board, origin(("leaderboard", args.leaderboard))))
