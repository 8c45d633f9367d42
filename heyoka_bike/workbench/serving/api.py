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
    text = _SCHEMA.read_text(encoding="utf-8")
    # What it is made of stands beside it: generators of clients follow no deeper references.
    schema = json.loads(text.replace('"#/$defs/', '"#/components/schemas/score_'))
    parts = {f"score_{name}": part for name, part in schema.pop("$defs").items()}
    for key in ("$schema", "$id"):
        schema.pop(key, None)
    error: dict[str, Any] = {
        "type": "object",
        "required": ["error"],
        "properties": {
            "error": {"type": "string", "description": "One line: found, expected."},
            "exit_code": {
                "type": "integer", "description": "With which the command ends: 1 unreadable, 2 "
                "nothing to score, 70 internal.",
            },
        },
    }  # fmt: skip
    job: dict[str, Any] = {
        "type": "object",
        "required": ["id", "kind", "state", "progress", "job"],
        "properties": {
            "id": {"type": "string"},
            "kind": {"enum": ["score", "diagnose", "replay"]},
            "state": {"enum": ["waiting", "working", "done", "refused", "failed"]},
            "progress": {"type": "number", "minimum": 0, "maximum": 1},
            "job": {"type": "string", "description": "Address to ask again."},
            "page": {"type": "string", "description": "Address of the result for people."},
            "result": {"type": "string", "description": "Address of the result for programs."},
            **error["properties"],
        },
    }

    def answer(name: str, said: str) -> dict[str, Any]:
        content = {"application/json": {"schema": {"$ref": f"#/components/schemas/{name}"}}}
        return {"description": said, "content": content}

    refusals = {
        "400": answer("error", "A request that cannot be understood."),
        "413": answer("error", f"More than {limits.upload} bytes."),
        "422": answer("error", "Files that cannot be scored; the error is the command's."),
        "500": answer("error", "A fault of the program."),
        "503": answer("error", "Too much to do; Retry-After says when to try again [s]."),
    }
    options = {
        "maneuver": "That a file of one maneuver holds, 1 to 3.",
        "columns": "What the columns are: time,roll_angle,m2_steer_angle,...",
        "step": "Step size of each file [s], separated by commas: runs of one program.",
        "tolerance": "Tolerance of each file, separated by commas.",
        "name": "Name of the program of each file, separated by commas.",
        "require": "Requirement such as scd >= 6; passed and requirements of the report say what "
        "came of it. May be repeated.",
    }
    form = {
        "type": "object",
        "properties": {
            "file": {"type": "array", "items": {"type": "string", "format": "binary"}},
            "pasted": {"type": "string", "description": "Rows, in place of a file."},
            **{key: {"type": "string", "description": said} for key, said in options.items()},
        },
    }
    query = [
        {"name": key, "in": "query", "schema": {"type": "string"}, "description": said}
        for key, said in {"filename": "Of a file that is the body.", **options}.items()
    ]
    body = {
        "required": True,
        "content": {
            "multipart/form-data": {"schema": form},
            "application/octet-stream": {"schema": {"type": "string", "format": "binary"}},
        },
    }
    place = [
        {"name": "id", "in": "path", "required": True, "schema": {"type": "string"}},
        {"name": "kind", "in": "path", "required": True, "schema": job["properties"]["kind"]},
    ]
    paths: dict[str, Any] = {
        "/score": {
            "post": {
                "operationId": "score", "summary": "Score result files; nothing is kept.",
                "parameters": query, "requestBody": body,
                "responses": {"200": answer("score", "The report, as of `heyoka-bike score "
                                            "--format json`."), **refusals},
            }
        },
        "/jobs/{id}/{kind}": {
            "get": {
                "operationId": "job", "summary": "How far a piece of work is.",
                "parameters": place,
                "responses": {"200": answer("job", "Its state."),
                              "404": answer("error", "None, or its time is over.")},
            }
        },
        "/health": {
            "get": {
                "operationId": "health", "summary": "Whether the server works.",
                "responses": {"200": {"description": "It does.",
                                      "content": {"application/json": {}}}},
            }
        },
    }  # fmt: skip
    if limits.has_diagnosis:
        paths["/diagnose"] = {
            "post": {
                "operationId": "diagnose", "summary": "Begin to look why result files differ.",
                "parameters": query, "requestBody": body,
                "responses": {"202": answer("job", "Begun."), **refusals},
            }
        }  # fmt: skip
    return {
        "openapi": "3.1.0",
        "info": {"title": "heyoka_bike", "version": __version__,
                 "description": "Scores results of the IFToMM benchmark Uncontrolled bicycle."},
        "paths": paths,
        "components": {"schemas": {"score": schema, **parts, "job": job, "error": error}},
    }  # fmt: skip


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
