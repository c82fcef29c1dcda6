"""Tools at the tip: exact by Pinocchio, part of the URDF, in collision as any link, stacked and refused."""

from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import pytest
import trimesh
from cases import from_catalogue, vectors
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import ArgumentError, Box, Capsule, Cylinder, HalfSpace, Mesh, PoseError, Sphere
from urdf_ik.cell.coal_shapes import geometry
from urdf_ik.cell.pinocchio_reference import Reference

Array = NDArray[np.float64]

# At right angles with pitch at 90 degrees, where roll and yaw are one; oblique; and far from the tip.
TOOLS = {
    "straight": urdf_ik.pose([0.0, 0.0, 0.2]),
    "right angle": urdf_ik.pose([0.1, 0.0, 0.05], rpy=[0.3, np.pi / 2.0, -0.4]),
    "oblique": urdf_ik.pose([0.03, -0.21, 0.4], quat_xyzw=[0.1, -0.5, 0.3, 0.8]),
    "half a turn": urdf_ik.pose([-1.5, 0.7, 2.0], rpy=[np.pi, 0.0, np.pi]),
}


@pytest.mark.parametrize("tool", TOOLS)
@pytest.mark.parametrize("name", ["zyyzyz_6r", "ur5", "panda", "scara_rrpr", "puma_560"])
def test_the_centre_point_is_where_it_was_put(name: str, tool: str) -> None:
    """The tip is the old one times the tool, by Pinocchio on the new URDF; solutions are exact, none is lost."""
    arm = from_catalogue(name).arm
    new = arm.with_tool(TOOLS[tool], name="torch")
    assert (new.base, new.tip, new.joint_names) == (arm.base, "torch", arm.joint_names)
    np.testing.assert_array_equal(new.limits, arm.limits)
    reference = Reference(new.model, new.base, new.tip)
    q = vectors(arm, 20)
    np.testing.assert_allclose(
        reference.pose(q), Reference(arm.model, arm.base, arm.tip).pose(q) @ TOOLS[tool], atol=1e-13
    )
    np.testing.assert_allclose(new.fk(q), reference.pose(q), atol=1e-13)
    values = {} if new.redundancy is None else {"redundancy": new.redundancy_of(q)}
    before = {} if arm.redundancy is None else {"redundancy": arm.redundancy_of(q)}
    found, same = new.ik(new.fk(q), **values), arm.ik(arm.fk(q), **before)
    assert (found.count >= 1).all()
    if not values:
        np.testing.assert_array_equal(found.count, same.count)
    for k, pose in enumerate(reference.pose(q)):
        each = found[k].to_array()
        assert np.max(reference.errors(each, np.broadcast_to(pose, (len(each), 4, 4)))) <= 1e-9
        assert np.abs(np.angle(np.exp(1j * (each - q[k])))).max(axis=1).min() < 1e-5


def test_it_is_written_and_read_again(tmp_path: Path) -> None:
    """The file is a URDF of its own: the same kinematics to the last digit, the same collisions, Pinocchio's pose."""
    arm = from_catalogue("zyyzyz_6r").arm.with_tool(
        TOOLS["oblique"], [Box((0.1, 0.2, 0.3)), (Sphere(0.05), urdf_ik.pose([0, 0, 0.2]))], name="gripper"
    )
    arm.model.write(tmp_path / "with_tool.urdf")
    again = urdf_ik.load(tmp_path / "with_tool.urdf", arm.base, arm.tip, mesh_roots=arm.model.package_dirs)
    q = vectors(arm, 10)
    np.testing.assert_array_equal(again.fk(q), arm.fk(q))
    np.testing.assert_array_equal(again.clearance(q), arm.clearance(q))
    model = pin.buildModelFromUrdf(str(tmp_path / "with_tool.urdf"))
    data = model.createData()
    pin.framesForwardKinematics(model, data, q[0])
    placed = {frame.name: data.oMf[i].homogeneous for i, frame in enumerate(model.frames)}
    np.testing.assert_allclose(np.linalg.inv(placed[arm.base]) @ placed["gripper"], arm.fk(q[0]), atol=1e-13)


SHAPES = {
    "box": Box((0.1, 0.2, 0.3)),
    "sphere": Sphere(0.07),
    "cylinder": Cylinder(0.04, 0.3),
    "capsule": Capsule(0.04, 0.3),
}


@pytest.mark.parametrize("kind", [*SHAPES, "mesh"])
def test_shapes_lie_where_they_were_put(kind: str, tmp_path: Path) -> None:
    """In the frame that the tool is mounted in, wherever its centre point is: coal's distance to a ball far away."""
    shape: Any = SHAPES.get(kind)
    if kind == "mesh":
        trimesh.creation.box((100.0, 200.0, 300.0)).export(tmp_path / "finger.stl")
        shape = Mesh(tmp_path / "finger.stl", scale=1e-3)
    arm = from_catalogue("ur5").arm
    placed = urdf_ik.pose([0.05, -0.1, 0.3], rpy=[0.4, 1.0, -2.0])
    q = np.array([0.3, -1.0, 1.2, -0.7, 0.9, -0.5])
    at = np.array([2.0, 1.5, 2.5])
    world = urdf_ik.World()
    world.add("ball", Sphere(0.01), urdf_ik.pose(at))
    T = arm.fk(q) @ placed
    ball = coal.Sphere(0.01)
    expected = coal.distance(
        geometry(shape), coal.Transform3s(T[:3, :3], T[:3, 3]), ball, coal.Transform3s(np.eye(3), at),
        coal.DistanceRequest(), coal.DistanceResult(),
    )  # fmt: skip
    for centre in TOOLS.values():
        new = arm.with_tool(centre, [(shape, placed)], name="torch")
        table = new.cell.collisions.in_world(world)
        for pair in table.checked_pairs:
            table = table if pair == ("torch", "ball") else table.allow(*pair)
        assert table.checked_pairs == (("torch", "ball"),)
        # Each of the two distances is as exact as coal iterates, some 1e-6 m.
        assert float(table.distance(q)) == pytest.approx(expected, abs=1e-5)


def test_what_a_tool_may_touch() -> None:
    """What it is mounted on, as any link: rigidly joined links, and one joint further; the links before are checked."""
    arm = from_catalogue("ur5").arm
    new = arm.with_tool(urdf_ik.pose([0, 0, 0.3]), Cylinder(0.05, 0.2))
    allowed, checked = new.cell.collisions.table().allowed, new.cell.collisions.checked_pairs
    assert allowed["wrist_3_link", "tool"] == "rigid"
    assert allowed["wrist_2_link", "tool"] == "adjacent"
    assert ("forearm_link", "tool") in checked and ("base_link", "tool") in checked
    before = arm.cell.collisions
    assert {pair: why for pair, why in allowed.items() if "tool" not in pair} == dict(before.table().allowed)
    assert [pair for pair in checked if "tool" not in pair] == list(before.checked_pairs)


def test_a_long_tool_hits_the_arm() -> None:
    """A wand of 1.5 m collides with the arm's own links where the arm without it is free."""
    arm = from_catalogue("ur5").arm
    new = arm.with_tool(urdf_ik.pose([0, 0, 1.5]), [(Cylinder(0.02, 1.5), urdf_ik.pose([0, 0, 0.75]))])
    q = vectors(arm, 500, 3)
    free, held = ~arm.cell.collisions.in_collision(q), ~new.cell.collisions.in_collision(q)
    assert not (held & ~free).any()
    hit = np.flatnonzero(free & ~held)
    assert len(hit) > 5
    assert all("tool" in pair for k in hit for pair in new.cell.collisions.colliding_pairs(q[k]))


def test_what_the_arm_had_stays(tmp_path: Path) -> None:
    """Base, held joints, task, the SRDF, changes of the table, and the arm itself."""
    arm = urdf_ik.load("panda", base="panda_link1", locked={"panda_joint4": -1.2})
    new = arm.with_tool(TOOLS["oblique"], Box(0.05), name="torch")
    assert (new.base, new.joint_names) == ("panda_link1", arm.joint_names)
    assert dict(new.chain.locked) == {"panda_joint4": -1.2}
    q = vectors(arm, 5)
    np.testing.assert_allclose(new.fk(q), arm.fk(q) @ TOOLS["oblique"], atol=1e-13)

    two = urdf_ik.load("planar_2r").for_task("planar position")
    longer = two.with_tool(urdf_ik.pose([0.05, 0.0, 0.0]))
    target = longer.solver.control.target_of(longer.fk([0.3, -0.9]))
    assert longer.ik(target).count == 2

    srdf = '<robot name="ur5"><disable_collisions link1="forearm_link" link2="base_link"/></robot>'
    ur = urdf_ik.load("ur5", srdf=srdf)
    ur = ur.with_cell(ur.cell.allow("upper_arm_link", "wrist_1_link"))
    kept = ur.with_tool(np.eye(4), Box(0.05)).cell.collisions.table().allowed
    assert kept["base_link", "forearm_link"] == "srdf"
    assert kept["upper_arm_link", "wrist_1_link"] == "allowed"
    assert "tool" not in ur.model.links


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((np.diag([1.0, 1.0, -1.0, 1.0]),), PoseError, "."),
        ((np.stack([np.eye(4)] * 2),), PoseError, r"tool's centre point; one pose \(4, 4\)"),
        ((np.eye(4), [HalfSpace((0, 0, 1))]), ArgumentError, "HalfSpace.*Box, Sphere, Cylinder, Capsule or Mesh"),
        ((np.eye(4), [Mesh("/no/such.stl")]), ArgumentError, "/no/such.stl"),
        ((np.eye(4), (), "tool0"), ArgumentError, "'tool0' already"),
        ((np.eye(4), (), "a\x00b"), ArgumentError, "cannot be written"),
    ],
)
def test_what_is_no_tool_is_refused(arguments: tuple[Any, ...], error: type[Exception], message: str) -> None:
    """The message says what would be valid."""
    with pytest.raises(error, match=message):
        from_catalogue("zyyzyz_6r").arm.with_tool(*arguments)
