"""The states of ``heyoka-bike check``: data/maneuvers/states.toml, by a fixed rule.

Run as a script, this writes the file. Each state is a maneuver of one second, so that a program can
go on from it.
"""

from itertools import product
from pathlib import Path

from heyoka_bike.reference.load import load_reference

FILE = Path(__file__).parents[2] / "data" / "maneuvers" / "states.toml"
KEYS = ("speed", "roll_rate", "roll", "steer", "steer_rate")
UNITS = ("m/s", "rad/s", "rad", "rad", "rad/s")
COLUMNS = ("forward_speed", "roll_rate", "roll_angle", "steer_angle", "steer_rate")

UPRIGHT = ("0", "1", "2", "3", "4", "4.6", "5", "6", "7", "8", "10")
RATES = (("0.5", "0"), ("0", "0.5"), ("0.5", "-1"))
ANGLES = ("0.1", "-0.2", "0.4", "-0.8")
BOTH = (("0.1", "0.05"), ("0.2", "-0.3"), ("-0.4", "0.2"), ("-0.6", "-0.5"))
TURNING = (("0", "0"), ("0.5", "-1"), ("-1", "2"))


def states():
    """Name, and the values of `KEYS`, of each state in its order."""
    for v in UPRIGHT:
        yield "upright", (v, "0", "0", "0", "0")
    for (p, d), v in product(RATES, ("0", "4.6")):
        yield "upright, turning", (v, p, "0", "0", d)
    for x, v in product(ANGLES, ("0", "2", "6")):
        yield "leaned", (v, "0", x, "0", "0")
    for x, v in product(ANGLES, ("0", "2", "6")):
        yield "steered", (v, "0", "0", x, "0")
    for (roll, steer), (p, d), v in product(BOTH, TURNING, ("0.5", "4.6", "8")):
        yield "leaned and steered", (v, p, roll, steer, d)
    for number, maneuver in load_reference().items():
        for second in range(11):
            at = maneuver.evaluate(str(second))
            yield f"maneuver {number}, near {second} s", tuple(decimal(at.hi[c]) for c in COLUMNS)


def decimal(x):
    """With six places, without zeros at the end."""
    text = f"{float(x):.6f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def text():
    """The file."""
    lines = [
        'name = "states of single instants"',
        'source = "made by docs/_site/states.py; those near a maneuver are rounded to six places"',
    ]
    for number, (name, values) in enumerate(states(), start=1):
        lines += ["", "[[maneuver]]", f'name = "{number}: {name}"']
        lines += [
            f'{key} = {{ value = "{x}", unit = "{unit}" }}'
            for key, x, unit in zip(KEYS, values, UNITS, strict=True)
        ]
        lines += ['duration = "1"', 'spacing = "0.01"']
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
