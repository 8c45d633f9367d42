"""Pages of the server, and its description for programs in OpenAPI.

Text from files or users is escaped and never becomes script.
"""

import json
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.scoring.reading.formats import listed
from heyoka_bike.showing import formats
from heyoka_bike.showing.document.html import prose
from heyoka_bike.version import __version__
from heyoka_bike.workbench.serving.queue import QueuedTask
from heyoka_bike.workbench.serving.store import StoredResult
from heyoka_bike.workbench.serving.tasks import Kind, Limits

STATIC = Path(__file__).with_name("static")
BAR_STYLE = (STATIC / "serve.css").read_text(encoding="utf-8")

_SHELL, _HOME_PAGE, _API, _WAITING, _ERROR, _HINT = (
    Template(Path(__file__).with_name("templates").joinpath(name).read_text(encoding="utf-8"))
    for name in ("shell.html", "home.html", "api.html", "waiting.html", "error.html", "hint.html")
)

_SAID_OF_STAGES: dict[Kind, str] = {
    "score": "Scoring", "diagnose": "Looking for the cause", "replay": "Drawing the replay",
}  # fmt: skip


def shell(root: str, title: str, body: str, *, head: str = "", bar: str = "") -> str:
    """Return a page of the server; all arguments except the title are HTML.

    Parameters
    ----------
    root
        Path below which the server is hosted, in this and all other functions, without a trailing
        slash.
    """
    return _SHELL.substitute(
        root=root, title=escape(title), body=body, head=head, bar=bar or bar_of_home(root),
        version=escape(__version__),
    )  # fmt: skip


def bar_of_home(root: str, links: str = "") -> str:
    """Return the bar of links for a page that does not belong to a result."""
    return (
        f'<nav class="bar" aria-label="Pages"><a class="home" href="{root}/">Score a file</a>'
        f"{links}</nav>"
    )


def home(root: str, limits: Limits, has_leaderboard: bool) -> str:
    """Return the start page, with the form for result files."""
    board = f'<a href="{root}/leaderboard">Leaderboard</a>' if has_leaderboard else ""
    body = _HOME_PAGE.substitute(
        root=root, upload=limits.upload, files=limits.files, most=limits.upload // 1_000_000,
        starts=_starts(), kept=_duration(limits.kept_seconds), formats=listed("and"),
    )  # fmt: skip
    return shell(root, "Score a file – uncontrolled bicycle", body, bar=bar_of_home(root, board))


def api(root: str, limits: Limits, address: str) -> str:
    """Return the page about the interface for programs.

    Parameters
    ----------
    address
        Address of this server in the request, with a trailing slash.
    """
    body = _API.substitute(root=root, most=limits.upload // 1_000_000, address=escape(address))
    return shell(root, "For programs", body)


@cache
def _starts() -> str:
    return ", ".join(
        f"{m.name} {float(m.speed):g} m/s and {float(m.roll_rate):g} rad/s" for m in benchmark()[1]
    )


def waiting(root: str, result: StoredResult, kind: Kind, job: QueuedTask, ahead: int) -> str:
    """Return the page shown while a task is running."""
    names = ", ".join(result.task.files)
    queue = f"{ahead} wait for a free processor." if job.state == "waiting" and ahead else ""
    body = _WAITING.substitute(
        root=root,
        key=result.key,
        kind=kind,
        said=_SAID_OF_STAGES[kind],
        names=escape(names),
        queue=queue,
    )
    # In a browser without scripts the page reloads itself.
    head = '<noscript><meta http-equiv="refresh" content="2"></noscript>\n'
    return shell(root, _SAID_OF_STAGES[kind], body, head=head, bar=bar(root, result, kind))


def error(
    root: str, title: str, message: str, *, result: StoredResult | None = None,
    kind: Kind = "score",
) -> str:  # fmt: skip
    """Return a page with an error message."""
    # Messages are those of the command line and may mention its options. On the page these options
    # are form fields, so add a hint.
    hint = _HINT.template if "column names" in message or "--" in message else ""
    body = _ERROR.substitute(root=root, title=escape(title), message=escape(message), hint=hint)
    links = "" if result is None else bar(root, result, kind)
    return shell(root, title, body, bar=links)


def with_bar(page: str, links: str, diagnosis: Sequence[str] = ()) -> str:
    """Insert a bar of links and the lines of a diagnosis at the top of a report or replay.

    The result is self-contained, including styles, like a downloaded page.
    """
    said = "".join(f"<p>{prose(text)}</p>" for text in diagnosis)
    if said:
        said = f'<section class="answer"><h2>Why it differs</h2>{said}</section>\n'
    page = page.replace("</style>\n</head>", f"{BAR_STYLE}</style>\n</head>", 1)
    return page.replace("<body>\n<main>\n", f"<body>\n{links}\n<main>\n{said}", 1)


def bar(root: str, result: StoredResult, current: Kind, downloads: Sequence[str] = ()) -> str:
    """Return the bar of links for a result: its pages, downloads and removal.

    Parameters
    ----------
    downloads
        Suffixes of the files that can be downloaded from this page.
    """
    place = f"{root}/results/{result.key}"
    is_one_run = any(
        job.ending is not None and job.ending.is_one_run for job in result.jobs.values()
    )
    parts = [_asked(place, result, "score", "Report", current)]
    if is_one_run and result.has_diagnosis:
        parts.append(_asked(place, result, "diagnose", "Why it differs", current))
    if is_one_run and len(result.task.files) == 1:
        parts.append(_asked(place, result, "replay", "Replay", current))
    parts += [
        f'<a href="{place}/{current}{suffix}" download>{said}</a>'
        for suffix, said in (
            (".html", "HTML"), (".json", "JSON"), (".csv", "CSV"), (".xml", "JUnit")
        )
        if suffix in downloads
    ]  # fmt: skip
    parts.append(f'<form action="{place}/remove" method="post"><button>Remove</button></form>')
    return bar_of_home(root, "".join(parts))


def _asked(place: str, result: StoredResult, kind: Kind, said: str, current: Kind) -> str:
    if kind in result.jobs:
        mark = ' aria-current="page"' if current == kind else ""
        return f'<a href="{place}/{kind}"{mark}>{said}</a>'
    return f'<form action="{place}/{kind}" method="post"><button>{said}</button></form>'


def _duration(seconds: float) -> str:
    if seconds >= 7200:
        return f"{seconds / 3600:.0f} hours"
    return f"{seconds / 60:.0f} minutes" if seconds >= 120 else f"{seconds:.0f} seconds"


_SCHEMA = Path(formats.__path__[0]) / "score-1.schema.json"
_OPENAPI = Path(__file__).with_name("openapi.json")


def description(limits: Limits, root: str = "") -> dict[str, Any]:
    """Return the description of the interface for programs in OpenAPI 3.1.

    `root` is the path below which the server is hosted.
    """
    text = _OPENAPI.read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text.replace("{upload}", str(limits.upload)))
    found["info"]["version"] = __version__
    found["servers"] = [{"url": root or "/"}]
    text = _SCHEMA.read_text(encoding="utf-8")
    # Definitions of the JSON schema become components, because client generators do not follow
    # nested references.
    schema = json.loads(text.replace('"#/$defs/', '"#/components/schemas/score_'))
    parts = {f"score_{name}": part for name, part in schema.pop("$defs").items()}
    for key in ("$schema", "$id"):
        schema.pop(key, None)
    found["components"]["schemas"] |= {"score": schema, **parts}
    paths = found["paths"]
    score, diagnose = paths["/score"]["post"], paths["/diagnose"]["post"]
    if limits.has_diagnosis:
        # A diagnosis has the same request and the same errors as a score.
        refusals = {code: x for code, x in score["responses"].items() if code != "200"}
        paths["/diagnose"]["post"] = score | diagnose
        paths["/diagnose"]["post"]["responses"] = diagnose["responses"] | refusals
    else:
        del paths["/diagnose"]
    return found
