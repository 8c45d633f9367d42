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
    """Return the direction of a colour in RGB, which light and shadow hardly change."""
    rgb = np.array(list(bytes.fromhex(COLOURS[colour][1:])), dtype=float)
    return rgb / np.linalg.norm(rgb)


@pytest.mark.parametrize("name", ["mujoco", "pybullet"])
def test_pictures_show_rider_and_bicycle(name, tmp_path, monkeypatch):
    need(name)
    image = pytest.importorskip("PIL.Image")
    # OSMesa draws off-screen without a graphics card (on Debian: libosmesa6).
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
            # The picture has 150 pixels per metre. The rider's back is 0.6 m wide, and tubes are 2
            # cm thick.
            assert shirt.sum() > 1000, (view, column)
            assert frame.sum() > 50, (view, column)
            # The camera follows the bicycle, so the shirt stays near the middle of the picture.
            _, columns = np.nonzero(shirt)
            assert abs(columns.mean() / part.shape[1] - 0.5) < 0.2, (view, column)
