"""The bundled arms: they load, and are what their sources say."""

import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import DHTable
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.model import catalogue

Array = NDArray[np.float64]
PI = math.pi
ARMS = ("planar_2r", "planar_2r_unit", "positioning_3r", "scara_rrpr", "stanford_rrprrr", "srs_7r", "puma_560")
KINDS = dict(zip(ARMS, ("RR", "RR", "RRR", "RRPR", "RRPRRR", "RRRRRRR", "RRRRRR"), strict=True))

# alpha [deg], a [m], d [m], theta [deg], in the standard convention, as the sources have them.
PUMA = [
    (90, 0, 0.672, 0),
    (0, 0.4318, 0, 0),
    (-90, 0.0203, 0.15005, 0),
    (90, 0, 0.4318, 0),
    (-90, 0, 0, 0),
    (0, 0, 0, 0),
]
STANFORD = [(-90, 0, 0.412, 0), (90, 0, 0.154, 0), (0, 0, 0, 0), (-90, 0, 0, 0), (90, 0, 0, 0), (0, 0, 0.263, 0)]
IIWA = [
    (-90, 0, 0.36, 0),
    (90, 0, 0, 0),
    (90, 0, 0.42, 0),
    (-90, 0, 0, 0),
    (-90, 0, 0.4, 0),
    (90, 0, 0, 0),
    (0, 0, 0.126, 0),
]


def path_of(name: str) -> Path:
    """The arm's file."""
    return catalogue.resolve(name).path


def draw(arm: urdf_ik.Arm, m: int) -> Array:
    """Joint vectors (m, n) inside the limits."""
    return np.random.default_rng(0).uniform(*arm.limits.T, (m, arm.dof))


@pytest.mark.parametrize("name", ARMS)
def test_loads_and_agrees_with_pinocchio(name: str) -> None:
    """Its joints are of the kinds that its name says; pose and Jacobian equal Pinocchio's."""
    arm = urdf_ik.load(name)
    kinds = {"revolute": "R", "prismatic": "P"}
    assert arm.name == name
    assert "".join(kinds[kind] for kind in arm.chain.joint_types) == KINDS[name]
    reference = Reference(path_of(name), "base_link", "tool0")
    Q = draw(arm, 20)
    np.testing.assert_allclose(arm.fk(Q), reference.pose(Q), atol=1e-14)
    np.testing.assert_allclose(arm.jacobian(Q), reference.jacobian(Q), atol=1e-14)
    assert str(arm.structure)


@pytest.mark.parametrize("name", ARMS)
def test_readers_take_it_without_a_word(name: str, capfd: pytest.CaptureFixture[str]) -> None:
    """check_urdf and Pinocchio find one chain with visuals and collision shapes, and neither warns."""
    folders = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])
    command = shutil.which("check_urdf", path=folders)
    if command is None:
        pytest.skip("check_urdf is not installed: neither Pinocchio's wheel nor liburdfdom-tools is here")
    done = subprocess.run([command, path_of(name)], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    model = pin.buildModelFromUrdf(str(path_of(name)))
    for kind in (pin.GeometryType.VISUAL, pin.GeometryType.COLLISION):
        shapes = pin.buildGeomFromUrdf(model, str(path_of(name)), kind).geometryObjects
        assert len(shapes) >= 3
        if kind == pin.GeometryType.VISUAL:
            links = {model.frames[shape.parentFrame].name for shape in shapes}
            assert links == {"base_link", *(f"link_{i + 1}" for i in range(len(KINDS[name])))}
    printed = capfd.readouterr()
    assert (printed.out, printed.err) == ("", "")


@pytest.mark.parametrize("name", ARMS)
def test_contacts_are_collisions(name: str) -> None:
    """No pair of links touches in nearly every posture, and at most a small part of the postures has contacts."""
    arm = urdf_ik.load(name)
    body = arm.cell.collisions
    assert "always" not in body.table().allowed.values()
    share = float(np.mean(body.in_collision(draw(arm, 300))))
    # Planar arms and the SCARA cannot reach themselves.
    free = name in ("planar_2r", "planar_2r_unit", "scara_rrpr")
    assert share == 0.0 if free else 0.0 < share < 0.3


@pytest.mark.parametrize("name", ARMS)
def test_file_states_its_table(name: str) -> None:
    """The remark at the top of the file holds the table, and the file's joints have it."""
    arm = urdf_ik.load(name)
    remark = path_of(name).read_text().partition("-->")[0]
    stated = [line.split() for line in remark.splitlines() if line.split()[:1] and line.split()[0].startswith("joint_")]
    assert len(stated) == arm.dof
    rows = [[float(x) if "q" not in x else 0.0 for x in cells[1:5]] for cells in stated]
    limits = np.where(arm.chain.prismatic[:, None], arm.limits, np.rad2deg(arm.limits))
    table = DHTable.from_array(rows, "standard", joint_types=KINDS[name], limits=limits, degrees=True)
    assert table.deviation(arm.chain) < 1e-14


@pytest.mark.parametrize(("name", "rows"), [("puma_560", PUMA), ("stanford_rrprrr", STANFORD), ("srs_7r", IIWA)])
def test_published_tables(name: str, rows: list[tuple[float, ...]]) -> None:
    """The table of the chain, in the source's convention, is the source's."""
    table = DHTable.from_chain(urdf_ik.load(name).chain, "standard")
    back = np.stack([np.rad2deg(table.alpha), table.a, table.d, np.rad2deg(table.theta)], axis=1)
    np.testing.assert_allclose(back, rows, atol=1e-12)
    for frame in (table.base, table.tool):
        np.testing.assert_array_equal(frame, np.eye(4))


def test_zyyzyz_is_six_rotations_and_six_lengths() -> None:
    """Pinocchio's pose is the product of the rotations about z y y z y z, each with a step along z."""
    reference = Reference(path_of("zyyzyz_6r"), "base_link", "tool0")
    for q in draw(urdf_ik.load("zyyzyz_6r"), 50):
        T = pin.SE3.Identity()
        for axis, angle, length in zip("zyyzyz", q, (1.0, 1.0, 1.0, 0.1, 0.1, 0.1), strict=True):
            R = pin.exp3(angle * np.eye(3)["xyz".index(axis)])
            T = T * pin.SE3(R, R @ [0.0, 0.0, length])
        np.testing.assert_allclose(reference.pose(q), T.homogeneous, atol=1e-14)


def test_puma_at_its_nominal_posture() -> None:
    """Corke, Robotics, Vision and Control: the wrist at q_n = (0, pi/4, pi, 0, pi/4, 0) and at q_z = 0.

    The book measures from the shoulder, which is 0.672 m above the base.
    """
    arm = urdf_ik.load("puma_560")
    nominal = [[0, 0, 1, 0.5963], [0, 1, 0, -0.1501], [-1, 0, 0, 0.672 - 0.01435], [0, 0, 0, 1]]
    np.testing.assert_allclose(arm.fk([0, PI / 4, PI, 0, PI / 4, 0]), nominal, atol=5.01e-5)
    zero = [[1, 0, 0, 0.4521], [0, 1, 0, -0.1500], [0, 0, 1, 0.672 + 0.4318], [0, 0, 0, 1]]
    np.testing.assert_allclose(arm.fk(np.zeros(6)), zero, atol=5.01e-5)
    assert len(arm.ik(np.array(arm.fk([0, PI / 4, PI, 0, PI / 4, 0])))) == 8


def test_planar_arm_has_its_lengths_and_limits() -> None:
    """The published arm's millimetres and degrees, in metres and rad."""
    arm = urdf_ik.load("planar_2r")
    np.testing.assert_allclose(np.rad2deg(arm.limits), [(-105, 99), (-145, 25.5)], atol=1e-12)
    np.testing.assert_allclose(arm.fk([0, 0])[:3, 3], [0.066 + 0.130, 0, 0], atol=1e-15)
    np.testing.assert_allclose(arm.fk([PI / 2, -PI / 2])[:3, 3], [0.130, 0.066, 0], atol=1e-15)
