"""The programs of docs/examples/engines, each in its own process, as engines conflict."""

import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from heyoka_bike.system.resources import data_folder

PROGRAMS = data_folder().parent / "docs" / "examples" / "engines"

# For each program: the module of the engine, the installation command and the model format.
ENGINES = {
    "mujoco": ("mujoco", "pip install mujoco==4.0.0", "mjcf"),
    "pinocchio": ("pinocchio", "pip install pin==4.1.0", "urdf"),
    "drake": ("pydrake", "pip install drake==1.51.1", "sdf"),
    "dart": ("dartpy", "pip install dartpy==6.20.0", "sdf"),
    "pybullet": ("pybullet", "pip install pybullet==3.2.7", "urdf"),
}
SECONDS = 300


def need(name):
    """Skip the test if the engine is not installed."""
    module, install, _ = ENGINES[name]
    if find_spec(module) is None:
        pytest.skip(f"{module} is not here: {install}")


def printed(name, *arguments):
    """Return the output of a program."""
    command = [sys.executable, str(PROGRAMS / f"with_{name}.py"), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def apart(function, *arguments):
    """Return the result of a function of this module, run in another process."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result(SECONDS)


def mass_matrices(name, file, postures):
    """Return an engine's mass matrices in postures (position, axes and angles each)."""
    engine, bicycle = _engine(name, file)
    found = []
    for place, attitude, angles in postures:
        engine.set(bicycle.State(place, attitude, angles, np.zeros(3), np.zeros(3), np.zeros(3)))
        found.append(engine.mass_matrix())
    return found


def _engine(name, file):
    sys.path.insert(0, str(PROGRAMS))
    return import_module(f"with_{name}").Engine(str(file)), import_module("bicycle")


# Functions that show silent changes by engines, as listed in docs/how-to/engines.md


def mujoco_of_urdf(file):
    """Return degrees of freedom and masses."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(file))
    return model.nv, model.body_mass.tolist()


def mujoco_refuses(file):
    """Return the error message."""
    import mujoco

    try:
        mujoco.MjModel.from_xml_path(str(file))
    except ValueError as error:
        return str(error)
    return ""


def pinocchio_without_a_free_joint(file):
    """Return degrees of freedom and mass."""
    import pinocchio as pin

    model = pin.buildModelFromUrdf(str(file))
    return model.nv, pin.computeTotalMass(model)


def drake_gravity(file):
    """Return the gravity after a file is read."""
    from pydrake import all as drake

    plant, _ = drake.AddMultibodyPlantSceneGraph(drake.DiagramBuilder(), 0.0)
    drake.Parser(plant).AddModels(str(file))
    plant.Finalize()
    return plant.gravity_field().gravity_vector().tolist()


def drake_refuses(file):
    """Return the error message."""
    from pydrake import all as drake

    plant, _ = drake.AddMultibodyPlantSceneGraph(drake.DiagramBuilder(), 0.0)
    try:
        drake.Parser(plant).AddModels(str(file))
    except RuntimeError as error:
        return str(error)
    return ""


def dart_sine(angle):
    """Return the sine of the angle of the rotation."""
    import dartpy as dart

    pose = dart.dynamics.FreeJoint.convertToTransform([angle, 0, 0, 0, 0, 0])
    return float(pose.rotation()[2, 1])


def dart_masses(file):
    """Return the masses of the links."""
    import dartpy as dart

    bicycle = dart.utils.SdfParser.readWorld(str(file)).getSkeleton("bicycle")
    return [bicycle.getBodyNode(x).getMass() for x in "BRHF"]


def dart_reads_mjcf(file):
    """Return whether DART reads a world from a file."""
    import dartpy as dart

    return dart.utils.MjcfParser.readWorld(str(file)) is not None


def dart_wheel_shapes_of_urdf(file):
    """Return how many shapes of the wheels collide, and whether the base is free."""
    import dartpy as dart

    bicycle = dart.utils.DartLoader().parseSkeleton(str(file))
    nodes = [node for x in "RF" for node in bicycle.getBodyNode(x).getShapeNodes()]
    colliding = sum(node.hasCollisionAspect() for node in nodes)
    return colliding, bicycle.getRootJoint().getNumDofs() == 6


def dart_top_of_the_floor(file):
    """Return the height of a world's floor surface above the ground [m]."""
    import dartpy as dart

    world = dart.utils.SdfParser.readWorld(str(file))
    nodes = world.getSkeleton("floor").getBodyNode(0).getShapeNodes()
    (touching,) = (node for node in nodes if node.hasCollisionAspect())
    return float(touching.getShape().getBoundingBox().getMax()[2])


def pybullet_inertias(file, *, from_file):
    """Return the principal moments of the links B, R, H and F, and the name of the base."""
    import pybullet as bullet

    bullet.connect(bullet.DIRECT)
    bike = bullet.loadURDF(str(file), flags=bullet.URDF_USE_INERTIA_FROM_FILE if from_file else 0)
    return [bullet.getDynamicsInfo(bike, link)[2] for link in range(-1, 3)]


def pybullet_product():
    """Return a quaternion multiplied by itself with the engine's function."""
    import pybullet as bullet

    _, turned = bullet.multiplyTransforms([0, 0, 0], [0.6, 0, 0, 0.8], [0, 0, 0], [0.6, 0, 0, 0.8])
    return list(turned)


def pybullet_motor(file):
    """Return the largest force of the default motors after a file is read [N m]."""
    import pybullet as bullet

    bullet.connect(bullet.DIRECT)
    bike = bullet.loadURDF(str(file))
    bullet.resetJointState(bike, 0, 0, 10)
    bullet.stepSimulation()
    return bullet.getJointState(bike, 0)[1]


def tried(name, files, seconds):
    """Return the properties of each file in an engine, and roll and steer angle after a run.

    The properties are masses and centres of mass of the bodies, the axis of the steer joint,
    gravity, and mass matrices upright and steered. `files` gives each file with the number of the
    maneuver from whose start it runs.
    """
    # MuJoCo writes its log into the working folder, which should be a temporary one.
    os.chdir(Path(files[0][0]).parent)
    found = []
    for file, number in files:
        engine, bicycle = _engine(name, file)
        zero = np.zeros(3)
        upright = bicycle.State(zero, np.array([1.0, 0, 0, 0]), zero, zero, zero, zero)
        steered = upright._replace(angles=np.array([0, 0.4, 0]))
        engine.set(upright)
        bodies = engine.bodies()
        has = {
            "masses": {x: bodies[x].mass for x in "BRHF"},
            "centres": {x: bodies[x].centre for x in "BRHF"},
            "axis": bicycle.velocities(engine, upright)["H"][3:, 7],
            "gravity": engine.gravity,
            "matrices": [],
        }
        for state in (upright, steered):
            engine.set(state)
            has["matrices"].append(engine.mass_matrix())
        if name == "pybullet":
            import pybullet

            pybullet.disconnect()
        engine = type(engine)(file, engine.STEP)
        engine.set(bicycle.starts(file)[number - 1])
        engine.step(seconds)
        roll, *_, steer, _ = bicycle.columns(engine)
        found.append((has, roll, steer))
        if name == "pybullet":
            pybullet.disconnect()
    return found
