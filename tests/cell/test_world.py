"""Worlds: shapes, distances to them in closed form, tables, and what is refused."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from chains import collision, joint, robot

import urdf_ik
from urdf_ik import (
    ArgumentError,
    Box,
    Capsule,
    Cylinder,
    HalfSpace,
    Mesh,
    Points,
    PoseError,
    Sphere,
    UrdfError,
    World,
    pose,
)
from urdf_ik.cell import CollisionModel, Nearest
from urdf_ik.cell.shapes import Shape
from urdf_ik.model import urdf

RADIUS = 0.1
# A ball on three sliders: q is its place.
SPHERE = f'sphere radius="{RADIUS}"'
BALL = robot(
    joint("x", "prismatic", "base", "a", axis="1 0 0"),
    joint("y", "prismatic", "a", "b", axis="0 1 0"),
    joint("z", "prismatic", "b", "ball", axis="0 0 1"),
    ball=collision(SPHERE),
)
Distance = Callable[[np.ndarray], float]


@pytest.fixture(scope="module")
def ball() -> CollisionModel:
    """The ball's collision model."""
    return CollisionModel(urdf.read(BALL))


def to_box(half: tuple[float, float, float]) -> Distance:
    """Distance of a point from a box about the origin."""
    return lambda p: float(np.linalg.norm(np.maximum(np.abs(p) - half, 0.0)))


def to_cylinder(p: np.ndarray) -> float:
    """Distance of a point from the cylinder of radius 0.2 and length 0.6."""
    return math.hypot(max(math.hypot(p[0], p[1]) - 0.2, 0.0), max(abs(p[2]) - 0.3, 0.0))


def to_capsule(p: np.ndarray) -> float:
    """Distance of a point from the capsule of radius 0.2 and length 0.6."""
    return max(float(np.linalg.norm(p - [0.0, 0.0, np.clip(p[2], -0.3, 0.3)])) - 0.2, 0.0)


CLOUD = np.random.default_rng(3).uniform(-0.3, 0.3, (200, 3))


def solids(folder: Path) -> dict[str, tuple[Shape, Distance]]:
    """Every kind of shape with the distance of a point from it."""
    trimesh.creation.box((0.4, 0.6, 0.8)).export(folder / "box.stl")
    return {
        "box": (Box((0.4, 0.6, 0.8)), to_box((0.2, 0.3, 0.4))),
        "sphere": (Sphere(0.25), lambda p: max(float(np.linalg.norm(p)) - 0.25, 0.0)),
        "cylinder": (Cylinder(0.2, 0.6), to_cylinder),
        "capsule": (Capsule(0.2, 0.6), to_capsule),
        "half-space": (HalfSpace((0.0, 3.0, 4.0), 0.1), lambda p: max(0.6 * p[1] + 0.8 * p[2] - 0.1, 0.0)),
        "mesh": (Mesh(folder / "box.stl"), to_box((0.2, 0.3, 0.4))),
        "points": (Points(CLOUD, 0.02), lambda p: max(float(np.linalg.norm(CLOUD - p, axis=1).min()) - 0.02, 0.0)),
    }


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder", "capsule", "half-space", "mesh", "points"])
def test_distances_in_closed_form(kind: str, ball: CollisionModel, tmp_path: Path) -> None:
    """A ball's distance from a shape, turned and shifted, is that of its centre less its radius; so are verdicts."""
    shape, distance = solids(tmp_path)[kind]
    T = pose([0.3, -0.2, 0.1], rpy=[0.4, -0.7, 1.1])
    world = World()
    world.add("it", shape, T)
    body = ball.in_world(world)
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (300, 3))
    expected = np.array([distance(T[:3, :3].T @ (p - T[:3, 3])) - RADIUS for p in q])
    q, expected = q[expected > 1e-3], expected[expected > 1e-3]
    assert len(q) > 50
    np.testing.assert_allclose(body.distance(q), expected, atol=5e-6)
    assert not np.any(body.in_collision(q))
    for p, d in zip(q[:40], expected, strict=False):
        assert body.in_collision(p, margin=d + 1e-5)
        assert not body.in_collision(p, margin=d - 1e-5)
    assert body.nearest_pair(q[0]) == Nearest(("ball", "it"), body.distance(q[0]))
    assert body.in_collision(T[:3, 3] + T[:3, :3] @ ([0.2, 0.0, 0.0] if kind != "points" else CLOUD[0]))


def test_a_cloud_is_never_thinner_than_its_balls(ball: CollisionModel) -> None:
    """Contact with one point of a cloud is exact to a tenth of a micrometre, and on the safe side."""
    world = World()
    world.add("cloud", Points([[0.5, 0.0, 0.0], [2.0, 2.0, 2.0]], 0.05))
    body = ball.in_world(world)
    assert body.distance([0.0, 0.0, 0.0]) == pytest.approx(0.35, abs=1e-7)
    assert float(body.distance([0.0, 0.0, 0.0])) <= 0.35 + 1e-12


def test_a_mesh_with_a_triangle_without_area(ball: CollisionModel, tmp_path: Path) -> None:
    """A triangle that is a line is at the distance of that line, also from a sphere."""
    corners = [(1, -1, 0), (1, 1, 0), (1, 0, 0)]
    facet = "facet normal 0 0 1\nouter loop\n" + "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners)
    (tmp_path / "line.stl").write_text(f"solid s\n{facet}endloop\nendfacet\nendsolid s\n")
    (tmp_path / "arm.urdf").write_text(BALL.replace(SPHERE, f'mesh filename="{tmp_path / "line.stl"}"'))
    world = World()
    world.add("sphere", Sphere(0.1))
    body = CollisionModel(urdf.read(tmp_path / "arm.urdf")).in_world(world)
    assert body.distance([0.0, 0.3, 0.0]) == pytest.approx(0.9, abs=1e-6)


def test_what_moves_counts_at_once(ball: CollisionModel) -> None:
    """A model follows its world: obstacles added, moved and removed; moved away, the distance grows by as much."""
    world = World()
    body = ball.in_world(world)
    assert body.distance([0.0, 0.0, 0.0]) == np.inf
    world.add("post", Sphere(0.1), pose([1.0, 0.0, 0.0]))
    assert body.distance([0.0, 0.0, 0.0]) == pytest.approx(0.8)
    world.move("post", pose([1.5, 0.0, 0.0]))
    assert body.distance([0.0, 0.0, 0.0]) == pytest.approx(1.3)
    world.move("post", pin.SE3(np.eye(3), np.array([0.15, 0.0, 0.0])))
    assert body.in_collision([0.0, 0.0, 0.0]) is True
    assert body.colliding_pairs([0.0, 0.0, 0.0]) == (("ball", "post"),)
    world.remove("post")
    assert body.in_collision([0.0, 0.0, 0.0]) is False
    assert ball.distance([0.0, 0.0, 0.0]) == np.inf
    assert ball.in_world(None) is ball
    assert ball.in_world(world) is body


def cell(folder: Path, mesh: str = "box.stl", kind: str = "fixed") -> Path:
    """A cell's URDF beside its mesh."""
    trimesh.creation.box((1.0, 1.0, 1.0)).export(folder / "box.stl")
    path = folder / "cell.urdf"
    table = collision('box size="2 1 0.2"', "0 0 0.1", "0 0 1.5707963267948966") + collision('sphere radius="0.3"')
    fixture = collision(f'mesh filename="{mesh}" scale="0.5 0.5 0.5"')
    joints = (
        joint("a", kind, "room", "table", "1 0 0", axis="0 0 1"),
        joint("b", "fixed", "table", "fixture", "0 0 0.5"),
    )
    path.write_text(robot(*joints, table=table, fixture=fixture))
    return path


def test_a_cell_as_a_urdf(ball: CollisionModel, tmp_path: Path) -> None:
    """Every collision shape stands where the fixed joints put it, under its link's name."""
    world = World.from_urdf(cell(tmp_path))
    assert world.names == ("table", "table/1", "fixture")
    np.testing.assert_allclose(world["table"].pose, pose([1.0, 0.0, 0.1], rpy=[0.0, 0.0, math.pi / 2]), atol=1e-12)
    body = ball.in_world(world)
    # Above the fixture, 0.5 m on a side, whose centre is at 0.5.
    assert body.distance([1.0, 0.0, 1.2]) == pytest.approx(0.35, abs=1e-6)
    # Beside the table, 1 m long along x when turned.
    assert body.distance([1.8, 0.9, 0.1]) == pytest.approx(0.2, abs=1e-6)


def test_cells_that_are_refused(tmp_path: Path) -> None:
    """A joint that moves, a mesh that is missing and a cell without shapes are named."""
    with pytest.raises(ArgumentError, match=r"'a' \(revolute\).*type=\"fixed\""):
        World.from_urdf(cell(tmp_path, kind="revolute"))
    with pytest.raises(UrdfError, match=r"gone\.stl"):
        World.from_urdf(cell(tmp_path, mesh="gone.stl"))
    with pytest.raises(ArgumentError, match="no link has a collision shape"):
        World.from_urdf('<robot name="r"><link name="a"/></robot>')
    with pytest.raises(ArgumentError, match="'a'.*radius is 0"):
        World.from_urdf(robot(joint("f", "fixed", "room", "a"), a=collision('sphere radius="0"')))


def test_bad_changes_of_a_world() -> None:
    """Names that are taken, unknown or empty, what is no shape, a mesh that is missing, and what is no pose."""
    world = World()
    world.add("table", Box(1.0))
    with pytest.raises(ArgumentError, match="'table' already"):
        world.add("table", Box(1.0))
    with pytest.raises(ArgumentError, match="did you mean 'table'"):
        world.move("tabel", np.eye(4))
    with pytest.raises(ArgumentError, match="there are: table"):
        world.remove("x")
    with pytest.raises(ArgumentError, match="needs a name"):
        world.add("", Box(1.0))
    with pytest.raises(ArgumentError, match=r"gone\.stl"):
        world.add("x", Mesh("gone.stl"))
    with pytest.raises(PoseError, match="nan"):
        world.add("x", Box(1.0), np.full((4, 4), np.nan))
    with pytest.raises(PoseError, match="single pose"):
        world.add("x", Box(1.0), np.stack([np.eye(4)] * 2))
    assert world.names == ("table",)


def test_an_obstacle_with_a_links_name_is_refused(ball: CollisionModel) -> None:
    """Pairs are of names, so a link's name cannot be an obstacle's."""
    world = World()
    world.add("ball", Box(1.0))
    with pytest.raises(ArgumentError, match="'ball' has the name of a link"):
        ball.in_world(world).in_collision([0.0, 0.0, 0.0])


def test_the_table_is_read_printed_and_changed(ball: CollisionModel) -> None:
    """Pairs with obstacles are allowed and checked by new models; the old ones stay as they are."""
    world = World()
    world.add("table", Box(1.0))
    world.add("post", Sphere(0.1))
    body = ball.in_world(world)
    assert body.checked_pairs == (("ball", "table"), ("ball", "post"))
    free = body.allow("table", "ball").allow("ball", "post")
    assert dict(free.table().allowed) == {("ball", "table"): "allowed", ("ball", "post"): "allowed"}
    assert free.in_collision([0.0, 0.0, 0.0]) is False
    assert body.in_collision([0.0, 0.0, 0.0]) is True
    assert free.check("ball", "post").colliding_pairs([0.0, 0.0, 0.0]) == (("ball", "post"),)
    lines = str(free.check("ball", "post").table()).splitlines()
    assert [line.split() for line in lines[1:]] == [["ball", "post", "checked"], ["ball", "table", "allowed"]]
    with pytest.raises(ArgumentError, match="did you|there are"):
        body.allow("ball", "tabel")
    with pytest.raises(ArgumentError, match="both obstacles"):
        body.allow("table", "post")
    with pytest.raises(ArgumentError, match="itself"):
        body.allow("ball", "ball")
    with pytest.raises(ArgumentError, match="'base' has no collision shape"):
        body.allow("base", "table")


def test_the_table_among_links() -> None:
    """Neighbours can be checked, checked pairs allowed; links that stand still may touch the world."""
    arm = urdf_ik.load("zyyzyz_6r")
    body = arm.cell.collisions
    neighbours = next(pair for pair, why in body.table().allowed.items() if why == "adjacent")
    assert neighbours in body.check(*neighbours).checked_pairs
    pair = body.checked_pairs[0]
    assert pair not in body.allow(*pair).checked_pairs
    assert body.allow(*pair).table().allowed[pair] == "allowed"
    world = World()
    world.add("floor", HalfSpace((0.0, 0.0, 1.0), 0.0))
    reasons = body.in_world(world).table().allowed
    still = {link for (link, other), why in reasons.items() if other == "floor" and why == "rigid"}
    assert still
    moving = {link for link, other in body.in_world(world).checked_pairs if other == "floor"}
    poses = [arm.link_poses(q) for q in np.random.default_rng(0).uniform(-1, 1, (5, 6))]
    assert all(np.allclose(T[link], poses[0][link]) for T in poses for link in still)
    assert not any(np.allclose(poses[0][link], poses[1][link]) for link in moving)


def test_the_base_need_not_be_the_root() -> None:
    """Obstacles stand in the base link, wherever the URDF has it: from its tip, an arm moves its root."""
    arm = urdf_ik.load("zyyzyz_6r")
    back = urdf_ik.load(arm.model.path, base=arm.tip, tip=arm.base)
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (20, 6))
    there = np.array([3.0, 0.5, 0.7])
    for one in q:
        world, reverse = World(), World()
        world.add("it", Sphere(0.2), pose(there))
        reverse.add("it", Sphere(0.2), np.linalg.inv(arm.fk(one)) @ pose(there))
        pairs = arm.cell.collisions.in_world(world).checked_pairs
        body = back.cell.collisions.in_world(reverse)
        for link, _ in [pair for pair in body.checked_pairs if pair[1] == "it" and pair not in pairs]:
            body = body.allow(link, "it")
        for link, _ in [pair for pair in pairs if pair[1] == "it" and pair not in body.checked_pairs]:
            body = body.check(link, "it")
        assert body.distance(one[::-1]) == pytest.approx(arm.clearance(one, world), abs=5e-6)


def test_solutions_free_of_a_world() -> None:
    """Filtered solutions are those that the model calls free; a margin leaves fewer, no world only the arm itself."""
    arm = urdf_ik.load("ur5")
    world = World()
    world.add("table", HalfSpace((0.0, 0.0, 1.0), 0.0))
    s = arm.ik(arm.fk([0.1, -1.0, 1.2, 0.3, 0.4, 0.5]))
    body = arm.cell.collisions.in_world(world)
    free = s.collision_free(world)
    np.testing.assert_array_equal(free.valid[s.valid], ~np.asarray(body.in_collision(s.q[s.valid])))
    assert 0 < free.count < s.collision_free().count
    assert s.collision_free(world, margin=0.3).count < free.count
    np.testing.assert_array_equal(np.asarray(arm.clearance(free.q[free.valid], world)) > 0.0, True)


def test_an_arm_without_shapes_says_so() -> None:
    """Every question about its contacts is refused: nothing is called free that was not checked."""
    bare = urdf_ik.load(BALL.replace(collision(SPHERE), ""))
    for ask in (bare.clearance, bare.cell.nearest_pair):
        with pytest.raises(UrdfError, match="no link has a collision shape"):
            ask([0.0, 0.0, 0.0], World())
    with pytest.raises(UrdfError, match="no link has a collision shape"):
        bare.motion_is_free([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])
