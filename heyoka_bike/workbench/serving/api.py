"""What the server offers to programs: for people, and as OpenAPI."""

import json
from html import escape
from pathlib import Path
from typing import Any

from heyoka_bike.showing import formats
from heyoka_bike.version import __version__
from heyoka_bike.workbench.serving import pages
from heyoka_bike.workbench.serving.limits import Limits

_SCHEMA = Path(formats.__path__[0]) / "score-1.schema.json"
_OPENAPI = Path(__file__).with_name("openapi.json")
_EXAMPLES = (
    ("curl", """curl -F file=@my-results.txt {address}score
curl -F file=@my-results.txt {address}diagnose   # 202, then ask for "job" """),
    ("MATLAB", """rows = fileread('my-results.txt');
how = weboptions('MediaType', 'application/octet-stream', 'Timeout', 60);
report = webwrite('{address}score', rows, how);
report.maneuvers(1).columns(1).scd"""),
)  # fmt: skip


def description(limits: Limits) -> dict[str, Any]:
    """The interface as OpenAPI 3.1."""
    text = _OPENAPI.read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text.replace("{upload}", str(limits.upload)))
    found["info"]["version"] = __version__
    text = _SCHEMA.read_text(encoding="utf-8")
    # What it is made of stands beside it: generators of clients follow no deeper references.
    schema = json.loads(text.replace('"#/$defs/', '"#/components/schemas/score_'))
    parts = {f"score_{name}": part for name, part in schema.pop("$defs").items()}
    for key in ("$schema", "$id"):
        schema.pop(key, None)
    found["components"]["schemas"] |= {"score": schema, **parts}
    paths = found["paths"]
    score, diagnose = paths["/score"]["post"], paths["/diagnose"]["post"]
    if limits.has_diagnosis:
        # It is asked, and refused, as a score is.
        refusals = {code: x for code, x in score["responses"].items() if code != "200"}
        paths["/diagnose"]["post"] = score | diagnose
        paths["/diagnose"]["post"]["responses"] = diagnose["responses"] | refusals
    else:
        del paths["/diagnose"]
    return found


def api_page(limits: Limits, address: str) -> str:
    """The interface for people.

    Parameters
    ----------
    address
        At which this server was asked, with a slash at its end.
    """
    examples = "".join(
        f'<h2>{escape(name)}</h2><pre tabindex="0"><code>'
        f"{escape(text.format(address=address))}</code></pre>"
        for name, text in _EXAMPLES
    )
    body = f"""<h1>For programs</h1>
<p><code>POST /score</code> with a file gives the JSON of <code>heyoka-bike score --format
json</code>, and keeps nothing. <code>POST /diagnose</code> begins a diagnosis and answers 202 with
the address to ask. All of it: <a href="/openapi.json">OpenAPI</a>. A file that cannot be scored
gives 422 and one line, {limits.upload // 1_000_000} MB or more 413, a full queue 503 with
<code>Retry-After</code>.</p>
{examples}"""
    return pages.shell("For programs", body)
