"""Pages of the server. What comes from a file or a user is escaped; none of it is script."""

from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path

from heyoka_bike.bicycle.parameters import read_maneuvers
from heyoka_bike.showing.formats.markup import prose
from heyoka_bike.system.resources import benchmark_maneuvers
from heyoka_bike.version import __version__
from heyoka_bike.workbench.serving.crew import Job
from heyoka_bike.workbench.serving.limits import Limits
from heyoka_bike.workbench.serving.store import Kept
from heyoka_bike.workbench.serving.tasks import Kind

STATIC = Path(__file__).with_name("static")
BAR_STYLE = (STATIC / "serve.css").read_text(encoding="utf-8")

_HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<link rel="stylesheet" href="/static/page.css">
<link rel="stylesheet" href="/static/serve.css">
"""

_OPTIONS = (
    ("maneuver", "Maneuver", "1, 2 or 3, of a file of one maneuver that does not say it"),
    ("columns", "Columns", "time,roll_angle,m2_steer_angle,... in the order of the file; - for one "
     "that is left out"),
    ("name", "Names", "of the programs, one for each file, separated by commas"),
    ("step", "Step sizes [s]", "0.01,0.001: the files are runs of one program"),
    ("tolerance", "Tolerances", "1e-6,1e-8: the same, for a program that chooses its steps"),
)  # fmt: skip

_HINT = """<p>Options are fields of the form. Go back and open “What the file does not say”: Columns
takes <code>time,roll_deg,steer_deg</code>, or whatever they are, in the order of the file, and
<code>-</code> for one that is left out.</p>
"""

_SAID: dict[Kind, str] = {
    "score": "Scoring", "diagnose": "Looking for the cause", "replay": "Drawing the replay",
}  # fmt: skip


def shell(title: str, body: str, *, head: str = "", bar: str = "") -> str:
    """A page of the server; all but the title is HTML."""
    return f"""{_HEAD}{head}<title>{escape(title)}</title>
</head>
<body>
{bar or bar_of_home()}
<main>
{body}
</main>
<footer><p>heyoka_bike {escape(__version__)}, IFToMM benchmark “Uncontrolled bicycle”; SI units
throughout. <a href="/api">For programs</a></p></footer>
<script src="/static/serve.js"></script>
</body>
</html>
"""


def bar_of_home(links: str = "") -> str:
    """Links of a page that is no result's."""
    return (
        '<nav class="bar" aria-label="Pages"><a class="home" href="/">Score a file</a>'
        f"{links}</nav>"
    )


def home(limits: Limits, has_leaderboard: bool) -> str:
    """The page with the form."""
    fields = "".join(
        f'<label>{said}<input name="{name}" autocomplete="off" aria-describedby="about-{name}">'
        f'<span id="about-{name}">{about}</span></label>'
        for name, said, about in _OPTIONS
    )
    most = limits.upload // 1_000_000
    board = '<a href="/leaderboard">Leaderboard</a>' if has_leaderboard else ""
    body = f"""<h1>How wrong is your bicycle?</h1>
<p class="lead">Drop the result file of your program. It is compared with the exact motion of the
benchmark <em>Uncontrolled bicycle</em>: the answer says how many digits are right, column by
column, which definitions and units your file follows, and why it differs.</p>
<form class="upload" action="/results" method="post" enctype="multipart/form-data"
 data-most="{limits.upload}" data-files="{limits.files}">
<label class="drop"><b>Drop a result file here, or choose one</b>
text, CSV, JSON, .npy, .npz, .mat, HDF5, netCDF, .xlsx, Parquet, gzip of these; {most} MB at most.
Several files are compared side by side.
<input type="file" name="file" multiple><span class="chosen" aria-live="polite"></span></label>
<details><summary>or paste rows</summary>
<label for="pasted">Rows of numbers, with or without headings</label>
<textarea id="pasted" name="pasted" spellcheck="false"></textarea></details>
<details><summary>What the file does not say</summary>
<div class="fields">{fields}</div></details>
<p class="error" role="alert" tabindex="-1"></p>
<div class="actions"><button class="main" type="submit">Score</button>
<span class="busy" role="status"></span></div>
</form>
<div class="actions"><form action="/example" method="post"><button type="submit">Try it with an
example: Exudyn, step 0.01 s</button></form></div>
<h2>What a file holds</h2>
<p>One row for each time. 25 columns: the time, then for each of the three maneuvers roll angle,
roll angular velocity, forward speed, potential, kinetic and mechanical energy, steer angle, steer
angular velocity. Or 9 columns of one maneuver; or any columns with headings, such as
<code>t,roll_deg,steer_deg</code>. Any separator, any times from 0 to 10 s. Write 17 digits.</p>
<p>The bicycle starts upright and straight, with forward speed and roll rate: {_starts()}.</p>
<h2>What is kept</h2>
<p>Your file and its result are kept for {_duration(limits.kept_seconds)} under an address that
only you are given, so that the diagnosis and the links work; then they are removed. You can remove
them at once. Nothing is sent anywhere else; there are no cookies. The log has times and sizes, no
names and no contents.</p>
"""
    return shell("Score a file – uncontrolled bicycle", body, bar=bar_of_home(board))


@cache
def _starts() -> str:
    return ", ".join(
        f"{m.name} {float(m.speed):g} m/s and {float(m.roll_rate):g} rad/s"
        for m in read_maneuvers(benchmark_maneuvers())
    )


def waiting(kept: Kept, kind: Kind, job: Job, ahead: int) -> str:
    """The page while something is done."""
    names = ", ".join(kept.task.files)
    place = f"/results/{kept.key}/{kind}"
    queue = f"{ahead} wait for a free processor." if job.state == "waiting" and ahead else ""
    body = f"""<h1>{_SAID[kind]}: {escape(names)}</h1>
<div data-state="/jobs/{kept.key}/{kind}">
<p><progress aria-label="{_SAID[kind]}" max="1"></progress> <span class="share"></span></p>
<p role="status">{queue}</p></div>
<p><a href="{place}">Look again</a></p>"""
    # Without script the page asks again by itself.
    head = '<noscript><meta http-equiv="refresh" content="2"></noscript>\n'
    return shell(_SAID[kind], body, head=head, bar=bar(kept, kind))


def error(title: str, message: str, *, kept: Kept | None = None, kind: Kind = "score") -> str:
    """A page that says what is wrong, in one line."""
    # The message is the command's; here its options are fields.
    hint = _HINT if "column names" in message or "--" in message else ""
    body = f"""<h1>{escape(title)}</h1>
<p class="error" role="alert">{escape(message)}</p>
{hint}<p><a href="/">Score another file</a></p>"""
    links = "" if kept is None else bar(kept, kind)
    return shell(title, body, bar=links)


def with_bar(page: str, links: str, diagnosis: Sequence[str] = ()) -> str:
    """A page of the package with links above it, and what a diagnosis says.

    It stands by itself, styles too, as a page that is taken away does.
    """
    said = "".join(f"<p>{prose(text)}</p>" for text in diagnosis)
    if said:
        said = f'<section class="answer"><h2>Why it differs</h2>{said}</section>\n'
    page = page.replace("</style>\n</head>", f"{BAR_STYLE}</style>\n</head>", 1)
    return page.replace("<body>\n<main>\n", f"<body>\n{links}\n<main>\n{said}", 1)


def bar(kept: Kept, current: Kind, downloads: Sequence[str] = ()) -> str:
    """Links of a result.

    Parameters
    ----------
    downloads
        Suffixes of what can be taken away of this page.
    """
    root = f"/results/{kept.key}"
    is_one_run = any((job.answer or {}).get("is_one_run") for job in kept.jobs.values())
    parts = [_asked(kept, "score", "Report", current)]
    if is_one_run and kept.has_diagnosis:
        parts.append(_asked(kept, "diagnose", "Why it differs", current))
    if is_one_run and len(kept.task.files) == 1:
        parts.append(_asked(kept, "replay", "Replay", current))
    parts += [
        f'<a href="{root}/{current}{suffix}" download>{said}</a>'
        for suffix, said in (
            (".html", "HTML"), (".json", "JSON"), (".csv", "CSV"), (".xml", "JUnit")
        )
        if suffix in downloads
    ]  # fmt: skip
    parts.append(f'<form action="{root}/remove" method="post"><button>Remove</button></form>')
    return bar_of_home("".join(parts))


def _asked(kept: Kept, kind: Kind, said: str, current: Kind) -> str:
    root = f"/results/{kept.key}/{kind}"
    if kind in kept.jobs:
        return _link(root, said, current == kind)
    return f'<form action="{root}" method="post"><button>{said}</button></form>'


def _link(address: str, said: str, is_here: bool) -> str:
    mark = ' aria-current="page"' if is_here else ""
    return f'<a href="{address}"{mark}>{said}</a>'


def _duration(seconds: float) -> str:
    if seconds >= 7200:
        return f"{seconds / 3600:.0f} hours"
    return f"{seconds / 60:.0f} minutes" if seconds >= 120 else f"{seconds:.0f} seconds"
