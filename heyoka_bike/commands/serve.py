"""Start a local web page that scores the result files dropped on it.

Start a web server on this machine. Drop result files on its page, or paste rows, to see the report,
the diagnosis and the replay, or several programs side by side. Programs send files to /score, which
the page /api describes. Each file is scored in its own process, with limits of time and memory. The
server sends nothing to other machines. Needs heyoka_bike[serve].

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

from heyoka_bike.commands import options
from heyoka_bike.errors import Exit, InputError, quoted, required

if TYPE_CHECKING:
    from heyoka_bike.workbench.serving.tasks import Limits

_LOCAL = ("127.0.0.1", "localhost", "::1")
_LARGEST_PORT = 65535


def add_parser(subparsers: Any) -> None:
    """Add the command to the command line."""
    p = options.add_command(subparsers, run, __doc__)
    said = {
        "--host ADDRESS 127.0.0.1": "address to listen on (default 127.0.0.1: this machine only)",
        "--port N": "port (default 8000; 0: any free port)",
        "--name HOST...": "host name that browsers use for this server, if it is not the name of "
        "this machine; may be repeated",
        "--root-path PATH": "path at which a reverse proxy publishes the server, such as /bicycle; "
        "the proxy may strip the path from requests or keep it",
        "--open": "open the page in the browser",
        "--max-size MB": "largest size of a request [MB] (default 100)",
        "--keep MINUTES": "time for which a result is stored [minutes] (default 1440, a day)",
        "--workers N": "number of files scored at the same time (default: one for each processor)",
        "--queue N": "number of files that may wait; further files are answered 'busy' (default "
        "100)",
        "--memory MB": "memory limit for one file [MB] (default 2000)",
        "--no-diagnose": "do not offer the diagnosis",
        "--leaderboard DIR": "folder of submissions to rank on the page, see 'leaderboard'",
    }
    options.add_arguments(
        p, said, port={"type": int, "default": 8000}, root_path={"default": ""},
        max_size={"type": float, "default": 100}, keep={"type": float, "default": 1440},
        workers={"type": int}, queue={"type": int, "default": 100},
        memory={"type": float, "default": 2000},
    )  # fmt: skip


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
        raise InputError(f"--root-path: found {quoted(root)}, expected a path such as /bicycle")
    names = [*args.name, *(_LOCAL if args.host in _LOCAL else ())]
    if not names:
        raise InputError(
            f"--host {args.host} needs --name: the host name that browsers use ('*' accepts any)"
        )
    with suppress(KeyboardInterrupt):
        serve(args.host, args.port, names, limits, _board(args), args.open, root)
    return Exit.OK


def _limits(args: argparse.Namespace) -> Limits:
    from heyoka_bike.system.parallel import processors
    from heyoka_bike.workbench.serving.tasks import Limits

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
    """Return the leaderboard as a page; None without ``--leaderboard``."""
    if args.leaderboard is None:
        return None
    from heyoka_bike.reference.load import load_reference
    from heyoka_bike.showing.document import html
    from heyoka_bike.showing.wording.origin_text import origin
    from heyoka_bike.system.console import progress_bar
    from heyoka_bike.workbench.leaderboard.document import document
    from heyoka_bike.workbench.leaderboard.ranking import leaderboard

    with progress_bar("scoring") as progress:
        board = leaderboard(args.leaderboard, [load_reference()], progress)
    return html.render(document(board, origin(("leaderboard", args.leaderboard))))
