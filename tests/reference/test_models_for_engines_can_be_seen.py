"""URDF, SDFormat and MJCF show frame, fork, rider and wheels, in shapes without mass or contact."""

import re
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import heyoka_bike
from heyoka_bike.bicycle.parameters import read_bicycle, read_inputs
from heyoka_bike.bicycle.shapes import COLOURS
from heyoka_bike.reference.exports.models import MODELS, render
from heyoka_bike.system.resources import find_input
from support.model_files import about, numbers

# The files state sizes to 0.1 mm and angles to 1e-4 rad. Parts are at most about a metre long.
ROUNDING = 2e-4
# A tyre is drawn as 24 straight parts, so its radius varies by a fraction 1 - cos(pi / 24). The
# tolerance is about half of this fraction.
POLYGON = 0.005


def shown(name, root):
    """Return by link the colour, radius and ends (from its origin) of each visible shape."""
    found = {}
    for link in root.iter("body" if name == "mjcf" else "link"):
        if link.get("name") == "floor":
            continue
        seen = found.setdefault(link.get("name"), [])
        if name == "mjcf":
            for geom in link.findall("geom"):
                if geom.get("contype") != "0":
                    continue
                assert geom.get("conaffinity") == geom.get("mass") == "0"
                ends = numbers(geom.get("fromto") or f"{geom.get('pos')} {geom.get('pos')}")
                seen.append((geom.get("material"), float(geom.get("size")), ends.reshape(2, 3)))
            continue
        for visual in link.findall("visual"):
            shape = visual.find("geometry")[0]
            if name == "urdf":
                origin = visual.find("origin")
                place, angles = (numbers(origin.get(x)) for x in ("xyz", "rpy"))
                radius, length = (float(shape.get(x, 0)) for x in ("radius", "length"))
                colour = visual.find("material").get("name")
            else:
                place, angles = np.split(numbers(visual.findtext("pose")), 2)
                radius = float(shape.findtext("radius"))
                length = float(shape.findtext("length") or 0)
                rgb = numbers(visual.findtext("material/diffuse"))[:3]
                (colour,) = (
                    x for x, hexed in COLOURS.items()
                    if np.abs(rgb * 255 - list(bytes.fromhex(hexed[1:]))).max() < 1
                )  # fmt: skip
            x, y, z = map(about, np.eye(3), angles)
            along = z @ y @ x @ [0, 0, length / 2]
            seen.append((colour, radius, np.array([place - along, place + along])))
    return found


@pytest.fixture(params=MODELS)
def name(request):
    return request.param


def test_bicycles_of_all_kinds_are_shown_in_full(name):
    for other in ("benchmark", "browser", "bluenose", "two-mass-skate"):
        bicycle, _ = read_inputs(other, None)
        found = shown(name, ElementTree.fromstring(render(name, bicycle, ())))
        for link, radius in (("R", bicycle["rR"]), ("F", bicycle["rF"])):
            tyre = [ends for colour, _, ends in found[link] if colour == "tyre"]
            (section,) = {r for colour, r, _ in found[link] if colour == "tyre"}
            outer = np.linalg.norm(np.concatenate(tyre), axis=1) + section
            assert outer == pytest.approx(float(radius), rel=POLYGON, abs=ROUNDING)
            # The drawn tyre has a usual width. The shape that touches the floor may be far thinner
            # than the drawn one.
            assert section >= min(0.01, float(radius) / 10)
        colours = {link: {colour for colour, *_ in seen} for link, seen in found.items()}
        assert {"frame", "metal", "dark"} <= colours["B"]
        assert {"frame", "metal", "dark"} <= colours["H"]
        assert ("skin" in colours["B"]) == (float(bicycle["mB"]) > 40)


def test_formats_show_the_same(bicycle):
    models = [shown(name, ElementTree.fromstring(render(name, bicycle, ()))) for name in MODELS]
    for one, other in pairwise(models):
        assert one.keys() == other.keys()
        for link in one:
            assert len(one[link]) == len(other[link])
            for a, b in zip(one[link], other[link], strict=True):
                assert (a[0], a[1]) == (b[0], b[1])
                # The two ends of a cylinder may be exchanged.
                gaps = [np.abs(a[2] - b[2][::order]).max() for order in (1, -1)]
                assert min(gaps) < ROUNDING


def test_the_fork_ends_at_the_hub(name, bicycle):
    """Fork and front wheel are separate links, and their shapes meet at the hub."""
    found = shown(name, ElementTree.fromstring(render(name, bicycle, ())))
    hub = np.array([1.02, 0, 0.35])
    s, c = np.sin(np.pi / 10), np.cos(np.pi / 10)
    across = 1.1 * c - 0.3 * s
    pivot = np.array([across * c, 0, 0.3 + across * s])
    ends = np.concatenate([ends for _, _, ends in found["H"]]) + pivot
    gaps = np.abs(ends - hub) * [1, 0, 1]
    assert gaps.max(axis=1).min() < ROUNDING


def test_colours_are_those_of_the_replay():
    folder = Path(heyoka_bike.__file__).parent
    styles = [folder / "workbench/replay/replay.css", folder / "showing/document/page.css"]
    texts = [x.read_text(encoding="utf-8") for x in styles]
    light = texts[0].partition("@media screen and (prefers-color-scheme")[0]
    on_page = dict(re.findall(r"--(\w+): (#\w+)", light))
    on_page["frame"] = re.search(r"--red: (#\w+)", texts[1])[1]
    for colour in ("frame", "metal", "dark", "tyre", "skin", "shirt", "shorts", "helmet"):
        assert COLOURS[colour] == on_page[colour]


def test_mjcf_has_light_floor_and_cameras_that_follow(bicycle, maneuvers):
    root = ElementTree.fromstring(render("mjcf", bicycle, maneuvers))
    base = root.find("worldbody/body")
    assert base.find("light").get("mode") == "track"
    cameras = {x.get("name"): x for x in base.findall("camera")}
    assert set(cameras) == {"follow", "side", "behind", "above"}
    for camera in cameras.values():
        assert camera.get("mode") == "track"
        across, up = np.split(numbers(camera.get("xyaxes")), 2)
        ahead = -np.cross(across, up)
        # The line of sight must pass near the middle of bicycle and rider.
        gap = np.cross(ahead, np.array([0.5, 0, 0.85]) - numbers(camera.get("pos")))
        assert np.linalg.norm(gap) < 0.6
    material = root.find("worldbody/geom[@name='floor']").get("material")
    texture = root.find(f"asset/material[@name='{material}']").get("texture")
    assert root.find(f"asset/texture[@name='{texture}']") is not None


def test_models_without_visuals_have_wheels_that_touch(name):
    bicycle = read_bicycle(find_input("bicycles", "benchmark"))
    root = ElementTree.fromstring(render(name, bicycle, (), has_visuals=False))
    assert not any(shown(name, root).values())
    assert len(list(root.iter("collision"))) == {"urdf": 2, "sdf": 3, "mjcf": 0}[name]
    assert len(list(root.iter("geom"))) == {"urdf": 0, "sdf": 0, "mjcf": 3}[name]
