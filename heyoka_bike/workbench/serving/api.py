"""The interface of the server for programs, as OpenAPI."""

import json
from pathlib import Path
from typing import Any

from heyoka_bike.showing import formats
from heyoka_bike.version import __version__
from heyoka_bike.workbench.serving.limits import Limits

_SCHEMA = Path(formats.__path__[0]) / "score-1.schema.json"
_OPENAPI = Path(__file__).with_name("openapi.json")


def description(limits: Limits, root: str = "") -> dict[str, Any]:
    """The interface as OpenAPI 3.1, of a server that is hosted below a path."""
    text = _OPENAPI.read_text(encoding="utf-8")
    found: dict[str, Any] = json.loads(text.replace("{upload}", str(limits.upload)))
    found["info"]["version"] = __version__
    found["servers"] = [{"url": root or "/"}]
    text = _SCHEMA.read_text(encoding="utf-8")
    # Its parts stand beside it: generators of clients follow no deeper references.
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
