"""MuJoCo and PyBullet draw the exported bicycle from the side, from behind and from above."""

import numpy as np
import pytest

from heyoka_bike.bicycle.parameters import benchmark
from heyoka_bike.bicycle.shapes import COLOURS
from heyoka_bike.reference.exports.models import MODELS, render
from support.engines import ENGINES, need, printed

pytestmark = [pytest.mark.peers, pytest.mark.timeout(600)]

COLUMNS = 5


def near(colour):
    """The hue of a colour, which light and shadow change little."""
    rgb = np.array(list(bytes.fromhex(COLOURS[colour][1:])), dtype=float)
    return rgb / np.linalg.norm(rgb)


@pytest.mark.parametrize("name", ["mujoco", "pybullet"])
def test_pictures_show_rider_and_bicycle(name, tmp_path, monkeypatch):
    need(name)
    image = pytest.importorskip("PIL.Image")
    # Off-screen drawing without a graphics card; Debian has it as libosmesa6.
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    kind = ENGINES[name][2]
    file = tmp_path / f"bicycle{MODELS[kind].suffix}"
    file.write_bytes(render(kind, *benchmark()))
    picture = tmp_path / "strip.png"
    printed(name, "run", file, "--strip", picture, "--seconds", "1")
    pixels = np.asarray(image.open(picture), dtype=float)
    height, width, _ = pixels.shape
    for row, view in enumerate(("side", "behind", "above")):
        for column in range(COLUMNS):
            part = pixels[
                row * height // 3 : (row + 1) * height // 3,
                column * width // COLUMNS : (column + 1) * width // COLUMNS,
            ]
            hue = part / np.maximum(np.linalg.norm(part, axis=2, keepdims=True), 1)
            shirt = hue @ near("shirt") > 0.998
            frame = hue @ near("frame") > 0.995
            # A rider of 0.6 m across the back, and tubes of 2 cm, at 150 pixels a metre.
            assert shirt.sum() > 1000, (view, column)
            assert frame.sum() > 50, (view, column)
            # The camera follows: the shirt stays near the middle of the picture.
            _, columns = np.nonzero(shirt)
            assert abs(columns.mean() / part.shape[1] - 0.5) < 0.2, (view, column)
