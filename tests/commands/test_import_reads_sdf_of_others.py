"""``heyoka-bike import`` reads SDFormat as its versions define frames, axes and defaults."""

import pytest

from heyoka_bike.bicycle.foreign.imported import import_bicycle
from heyoka_bike.bicycle.parameters import PARAMETERS, read_bicycle
from heyoka_bike.errors import InputError
from heyoka_bike.reference.exports.models import render
from heyoka_bike.system.resources import find_input

# Files are read with 15 digits, so the error is half a unit of the fifteenth digit.
ROUNDOFF = 5e-15


@pytest.fixture
def bicycle():
    """A bicycle whose parameters are all decimals."""
    return read_bicycle(find_input("bicycles", "pista"))


@pytest.fixture
def changed(bicycle, tmp_path):
    """Return a function that replaces texts in the exported file and imports it; a change is
    (old, new)."""

    def read(*changes):
        text = render("sdf", bicycle, (), has_visuals=False).decode().partition("-->")[2].strip()
        for old, new in changes:
            assert old in text, old
            text = text.replace(old, new)
        path = tmp_path / "model.sdf"
        path.write_text(text)
        return import_bicycle(path)

    return read


def places(text):
    """Return the text of each link's pose, by the name of the link."""
    return {
        name: text.partition(f'<link name="{name}">')[2].partition("<pose>")[2].partition("</")[0]
        for name in "BRHF"
    }


@pytest.fixture
def pose(bicycle):
    return places(render("sdf", bicycle, ()).decode())


def same(found, bicycle):
    for symbol in PARAMETERS:
        right = float(bicycle[symbol])
        value = float(found.bicycle[symbol])
        assert value == pytest.approx(right, rel=ROUNDOFF, abs=ROUNDOFF), symbol


def test_a_model_that_is_turned_and_moved_in_its_world(changed, bicycle):
    """The model has a pose of its own, with angles in degrees; all others are relative to it."""
    found = changed(
        (
            '<model name="bicycle">',
            '<model name="bicycle"><pose degrees="true">1 2 3 0 0 50</pose>',
        )
    )
    same(found, bicycle)


def test_a_link_is_placed_relative_to_another(changed, bicycle, pose):
    """The front wheel is placed relative to a rotated frame, which is attached to the fork."""
    wheel, fork = ([float(a) for a in pose[link].split()[:3]] for link in "FH")
    x, _, z = (a - b for a, b in zip(wheel, fork, strict=True))
    half = "0.70710678118654752440"
    found = changed(
        (
            f"<pose>{pose['F']}</pose>",
            '<pose relative_to="hub">0 0 0 0 -1.5707963267948966192 0</pose>',
        ),
        (
            '<link name="F">',
            f'<frame name="hub" attached_to="H"><pose rotation_format="quat_xyzw">{x!r} 0 {z!r} '
            f'0 {half} 0 {half}</pose></frame><link name="F">',
        ),
    )  # fmt: skip
    same(found, bicycle)


@pytest.mark.parametrize(
    ("version", "axis"),
    [
        # In all cases the frame of the joint is rotated by half a turn about z.
        ("1.6", "<xyz>{-x} 0 {z}</xyz>"),
        ("1.6", "<xyz>{x} 0 {z}</xyz><use_parent_model_frame>true</use_parent_model_frame>"),
        ("1.9", '<xyz expressed_in="__model__">{x} 0 {z}</xyz>'),
        ("1.4", "<xyz>{x} 0 {z}</xyz>"),
    ],
)
def test_axes_are_along_the_frame_of_their_version(version, axis, changed, bicycle):
    text = render("sdf", bicycle, ()).decode()
    old = "<xyz>" + text.partition('"steer_axis"')[2].partition("<xyz>")[2].partition("</xyz>")[0]
    x, _, z = old.removeprefix("<xyz>").split()
    new = axis.replace("{-x}", f"-{x}").replace("{x}", x).replace("{z}", z)
    turned = "<pose>0 0 0 0 0 3.1415926535897932384626</pose>"
    found = changed(
        (f"{old}</xyz>", new),
        ('<sdf version="1.5">', f'<sdf version="{version}">'),
        ('<joint name="steer_axis" type="revolute">',
         f'<joint name="steer_axis" type="revolute">{turned}'),
    )  # fmt: skip
    same(found, bicycle)


def test_links_that_are_fixed_are_one_body(changed, bicycle):
    """A rider of 3 kg, fixed at the frame's centre of mass, counts as a part of the frame."""
    rider = (
        '<link name="rider"><pose relative_to="B">{} 0 {} 0 0 0</pose><inertial><mass>3</mass>'
        "<inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia></inertial></link>"
        '<joint name="seat" type="fixed"><parent>B</parent><child>rider</child></joint></model>'
    ).format(str(float(bicycle["xB"])), str(-float(bicycle["zB"])))
    mass = str(float(bicycle["mB"]))
    found = changed(
        ("</model>\n  </world>", rider + "\n  </world>"),
        (f"<mass>{mass}</mass>", f"<mass>{float(bicycle['mB']) - 3:.17g}</mass>"),
    )
    same(found, bicycle)


def test_defaults_are_those_of_the_format_and_are_reported(changed, bicycle):
    found = changed(("<gravity>0 0 -9.81</gravity>", ""))
    assert float(found.bicycle["g"]) == 9.8
    assert found.notes == (
        "g is set to 9.8 m/s^2, the default of SDFormat, because the world has no <gravity>",
    )


def test_gravity_is_read_in_the_world_too(changed):
    old = "<gravity>0 0 -9.81</gravity>"
    found = changed((old, ""), ("<physics", "<gravity>0 0 -1.62</gravity><physics"))
    assert (float(found.bicycle["g"]), found.notes) == (1.62, ())


def test_a_model_without_a_world_has_no_gravity(bicycle, tmp_path):
    text = render("sdf", bicycle, ()).decode()
    model = text[text.index('<model name="bicycle">') : text.index("  </world>")]
    path = tmp_path / "model.sdf"
    path.write_text(f'<sdf version="1.6">{model}</sdf>')
    found = import_bicycle(path)
    same(found, bicycle)
    assert found.notes == ("g is set to 9.81 m/s^2, because the file has no world",)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("<child>F</child>", "<child>Q</child>", "found link 'Q', expected the name of a link of"),
        ('type="revolute"', 'type="ball"', "found a joint of type 'ball', expected revolute, cont"),
        ('<link name="F">', '<link name="F"><pose relative_to="F"/>', "found frame 'F', expected"),
        ("<mass>4.49</mass>", "<mass>heavy</mass>", "<mass>: found 'heavy', expected a number"),
        ('<joint name="front_axle"', '<include/><joint name="front_axle"', "found <include> in a"),
        ("</world>", '<model name="c"><joint name="j"/></model></world>', "found 2 models with jo"),
        ("<gravity>0 0 -9.81", "<gravity>0 1 -9.81", "found gravity that does not point along -z"),
        ("<radius>", "<radius>1 ", "<radius>: found '1 "),
    ],
)  # fmt: skip
def test_what_is_not_read_is_refused_in_one_line(old, new, said, changed):
    with pytest.raises(InputError) as caught:
        changed((old, new))
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
