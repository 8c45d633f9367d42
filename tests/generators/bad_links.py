"""Seeded damaged or forged links and files for the page of ``export --page``."""

import base64
import gzip
import json
import zlib
from random import Random

CELL = {
    "maneuver": 1, "key": 0, "rows": 11, "digits": 14.0, "mescd": 14.0, "max_error": 0.0,
    "time_of_max": 0.0, "rms_error": 0.0, "column": 0, "sign": 1, "factor": 1, "offset": 0,
    "grade": 1, "never_filled": 0, "errors": [None] * 40,
}  # fmt: skip
"""A cell of a result in a link, with the keys that the page writes."""

WORDS = (
    "__proto__", "constructor", "toString", "valueOf", "hasOwnProperty", "prototype", "length",
    "then", "toJSON", "line", "style", "remarks", "cells", "name", "whole", "text",
)  # fmt: skip
LETTERS = (
    "\u202e",
    "\ud83d\ude00",
    "\u2028",
    "\u0000",
    "\ufeff",
    "e\u0301",
    "<img src=x>",
    "&amp;",
)
VALUES = (
    None, True, False, 0, -1, 1.5, 1e308, -1e308, 5e-324, 2**53, "", "1", "14", [], {}, [None],
    [[]], {"toString": None}, {"__proto__": {"grade": 1}}, {"length": 1e9}, *WORDS, *LETTERS,
)  # fmt: skip


def deflated(data):
    """Return bytes compressed by raw deflate, as in a link."""
    compress = zlib.compressobj(9, zlib.DEFLATED, -15)
    return compress.compress(data) + compress.flush()


def encoded(data):
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


def packed(kind, text):
    return f"#{kind}={encoded(deflated(text.encode('utf-8', 'surrogatepass')))}"


def mutated(value, random):
    """Change JSON in one place: a value, a missing, new or duplicate name, or an order."""
    if isinstance(value, dict) and value and random.random() < 0.85:
        key = random.choice([*value])
        way = random.randrange(6)
        if way == 0:
            return {k: v for k, v in value.items() if k != key}
        if way == 1:
            return value | {random.choice(WORDS): random.choice(VALUES)}
        if way == 2:
            return {random.choice(WORDS) if k == key else k: v for k, v in value.items()}
        return value | {key: mutated(value[key], random)}
    if isinstance(value, list) and value and random.random() < 0.85:
        i, way = random.randrange(len(value)), random.randrange(5)
        if way == 0:
            return value[:i] + value[i + 1 :]
        if way == 1:
            return value * random.choice((2, 30))
        return [*value[:i], mutated(value[i], random), *value[i + 1 :]]
    if isinstance(value, float | int) and random.random() < 0.5:
        return random.choice((-value, value + 1, value * 1e6, value / 7, str(value), [value]))
    return random.choice(VALUES)


def result(random):
    """Return the result in a link, mostly of the right form."""
    places = random.sample([(m, k) for m in (1, 2, 3) for k in range(8)], random.randint(1, 24))
    cells = [
        CELL | {
            "maneuver": m, "key": k, "column": k, "digits": random.uniform(-3, 14),
            "grade": random.randint(1, 4), "max_error": 10 ** random.uniform(-16, 3),
            "errors": [random.choice((None, random.randint(-3000, 3000))) for _ in range(40)],
        }
        for m, k in places
    ]  # fmt: skip
    return {"name": "x.csv", "whole": random.random() < 0.5, "cells": cells}


def damaged(link, random):
    """Return a link with changed or missing letters."""
    kind, _, text = link.partition("=")
    i = random.randrange(len(text)) if text else 0
    return random.choice((
        f"{kind}={text[:i]}", f"{kind}={text[i:]}", f"{kind}={text[:i]}A{text[i + 1:]}",
        f"{kind}={text}{text}", f"{kind}={text}====", f"{kind}={text[:i]}%00{text[i:]}",
        f"{kind}={text[:i]}\u00e9{text[i:]}", f"{kind}s={text}", f"{kind}={text}&text={text}",
        f"{kind.upper()}={text}", f"{kind}", f"{kind}={text.swapcase()}",
    ))  # fmt: skip


def nested(random):
    """Return deeply nested JSON, which crashes a recursive reader."""
    deep = random.choice((100, 10_000, 300_000))
    inner = random.choice(("1", "null", '"x"'))
    opened, closed = random.choice((("[", "]"), ('{"cells":', "}"), ('{"__proto__":', "}")))
    within = opened * deep + inner + closed * deep
    return random.choice((within, f'{{"name":"x","whole":true,"cells":[{within}]}}'))


def text_of(rows, random):
    """Return a distorted result file: separators, numbers and names of all kinds."""
    lines = [" ".join(f"{x:.12g}" for x in row) for row in rows]
    width = len(rows[0])
    i = random.randrange(len(lines))
    way = random.randrange(14)
    long = random.choice((1000, 100_000))
    if way == 0:
        lines[i] = lines[i].replace(" ", random.choice((",", ";", "\t", "\u00a0", '","', "\u2028")))
    elif way == 1:
        lines[i] = random.choice(("1" * long + "x", "-" * long, "." * long, "1e" + "9" * long))
    elif way == 2:
        lines.insert(0, "time" + " " * long + random.choice(("roll", "roll_angle", "(")))
    elif way == 3:
        names = [
            random.choice((*WORDS, "time", "roll_angle", "m2_roll_rate", "")) for _ in range(width)
        ]
        lines.insert(0, random.choice((" ", ",", ";", "\t")).join(names))
    elif way == 4:
        lines[i] = " ".join(
            random.choice(("nan", "inf", "1e999", "-0", "1d5", "0x10", "")) for _ in range(width)
        )
    elif way == 5:
        lines = lines[::-1]
    elif way == 6:
        lines.insert(i, random.choice(LETTERS) * random.choice((1, 1000)))
    elif way == 7:
        lines.insert(i, random.choice("#%!/\"'([{") * long + "\u2028")
    elif way == 8:
        lines = lines[: random.randrange(3)]
    elif way == 9:
        lines[i] = " ".join(["0"] * random.choice((1, 8, 10, 25, 20_000)))
    elif way == 10:
        lines = [
            " ".join(
                [line.split()[0], *random.choice((["0"], ["1e308"], ["-1e-320"])) * (width - 1)]
            )
            for line in lines
        ]
    elif way == 11:
        keys, units = ("roll_angle", "steer_angle"), (*WORDS, "deg", "rad")
        names = ["time"]
        for _ in range(width - 1):
            m, key, unit = random.randint(0, 9), random.choice(keys), random.choice(units)
            names.append(f"m{m}_{key} [{unit}]")
        lines.insert(0, ",".join(names))
        lines[1:] = [line.replace(" ", ",") for line in lines[1:]]
    elif way == 12:
        lines = [line.replace(".", ",") for line in lines]
    return random.choice(("\n", "\r\n", "\r")).join(lines) + random.choice(("", "\n", "\n\n"))


def bad_link(rows, random):
    """Return a link that is wrong in some way; a few are valid all the same."""
    way = random.randrange(10)
    name = random.choice(("x.csv", *LETTERS, *WORDS))
    if way < 3:
        return packed("result", json.dumps(mutated(result(random), random)))
    if way == 3:
        return packed("text", json.dumps(mutated({"name": name, "text": "0 1\n"}, random)))
    if way == 4:
        return packed("text", json.dumps({"name": name, "text": text_of(rows, random)}))
    if way == 5:
        return damaged(packed("result", json.dumps(result(random))), random)
    if way == 6:
        return packed(random.choice(("result", "text")), nested(random))
    if way == 7:
        whole = json.dumps(result(random)).encode()
        other = random.choice((
            zlib.compress(whole), gzip.compress(whole), whole, deflated(whole) + b"more",
            deflated(deflated(whole)), deflated(whole)[: random.randrange(20)],
            deflated(whole.decode().encode("utf-16")), deflated(b"\xff\xfe" + whole),
        ))  # fmt: skip
        return f"#result={encoded(other)}"
    if way == 8:
        large = random.choice(
            (b" " * 65_000_000, b'{"name":"x","text":"' + b"0 " * 200_000 + b'"}')
        )
        return f"#text={encoded(deflated(large))}"
    return packed("result", json.dumps(result(random)))


def bad_links(rows, count, seed):
    random = Random(seed)
    return [bad_link(rows, random) for _ in range(count)]


def bad_files(rows, count, seed):
    """Yield names and bytes of files to drop: distorted texts, and files that are not text."""
    random = Random(seed)
    found = []
    for _ in range(count):
        data = text_of(rows, random).encode("utf-8", "surrogatepass")
        way = random.randrange(6)
        if way == 0:
            data = random.randbytes(random.choice((0, 1, 100, 5000)))
        elif way == 1:
            data = data.decode("utf-8", "replace").encode("utf-16")
        elif way == 2:
            at = random.randrange(len(data) or 1)
            data = data[:at] + random.randbytes(3) + data[at:]
        elif way == 3:
            data = gzip.compress(data)
        found.append((random.choice(("x.csv", "", "a/b\\c", *LETTERS)), data))
    return found
