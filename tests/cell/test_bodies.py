"""Bounds that the proofs stand on: balls hold their shapes, no point goes farther than it may, hulls lose nothing."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from chains import LIMIT, collision, joint, robot

import urdf_ik

# A turning joint, one that follows it the other way round at twice the angle, a slider that follows it too, and a ball.
MIMIC = robot(
    joint("one", "revolute", "base", "a", axis="0 0.6 0.8"),
    joint("two", "revolute", "a", "b", "0.4 0 0", "0.1 0.2 0.3", "0 1 0",
          LIMIT.replace("3", "6") + '<mimic joint="one" multiplier="-2"/>'),
    joint("three", "prismatic", "b", "c", "0.4 0 0", axis="1 0 0",
          more='<mimic joint="one" multiplier="0.5" offset="0.1"/>'),
    **dict.fromkeys("abc", collision('box size="0.4 0.05 0.1"', "0.2 0.05 0.1", "0.3 0.2 0.1")),
)  # fmt: skip


def arms() -> dict[str, urdf_ik.Arm]:
    """Arms with meshes and without, with slides, with a base that moves the root, with joints that mimic."""
    six = urdf_ik.load("zyyzyz_6r")
    return {
        "zyyzyz_6r": six,
        "backwards": urdf_ik.load(six.model.path, base=six.tip, tip=six.base),
        "in the middle": urdf_ik.load(six.model.path, base=six.model.links[3], tip=six.tip),
        "ur5": urdf_ik.load("ur5"),
        "stanford_rrprrr": urdf_ik.load("stanford_rrprrr"),
        "scara_rrpr": urdf_ik.load("scara_rrpr"),
        "mimic": urdf_ik.load(MIMIC),
    }


ARMS = arms()


@pytest.mark.parametrize("name", ARMS)
def test_bodies_stand_where_pinocchio_puts_them(name: str) -> None:
    """The balls' centres are those of Pinocchio's placements, in the base link."""
    arm = ARMS[name]
    shapes = arm.cell.collisions.shapes
    balls = [solid.one_ball()[0] for solid in shapes.solids]
    for q in np.random.default_rng(0).uniform(-2, 2, (10, arm.dof)):
        placed = shapes.bodies.place(q[None])
        placing = shapes.place(q)
        to_base = placing.base.inverse()
        for i, ball in enumerate(balls):
            np.testing.assert_allclose(placed.centres[0, i], (to_base * placing.shapes[i]).act(ball), atol=1e-9)


@pytest.mark.parametrize("name", ARMS)
def test_no_point_goes_farther_than_it_may(name: str) -> None:
    """On the way from the middle of a motion, no point of a ball leaves its place by more than the joints' bounds."""
    arm, rng = ARMS[name], np.random.default_rng(1)
    bodies = arm.cell.collisions.shapes.bodies
    S, m = bodies.radii.shape
    tightest = 0.0
    for _ in range(40):
        middle = rng.uniform(-2, 2, arm.dof)
        way = rng.uniform(-1, 1, arm.dof) * rng.choice([0.01, 0.1, 1.0])
        placed = bodies.place(middle[None])
        bound = bodies.reaches(placed, np.abs(way)[None])[0].sum(axis=-1)
        direction = rng.normal(size=(S, m, 20, 3))
        direction *= bodies.radii[..., None, None] / np.linalg.norm(direction, axis=-1, keepdims=True)
        local = bodies.local_centres[:, :, None] + direction
        there = bodies.place(middle + np.linspace(-1.0, 1.0, 21)[:, None] * way).poses[:, bodies.body]
        here = placed.poses[0, bodies.body]

        def at(poses: np.ndarray, local: np.ndarray = local) -> np.ndarray:
            return np.einsum("...sij,smpj->...smpi", poses[..., :3, :3], local) + poses[..., :, None, None, :3, 3]

        gone = np.linalg.norm(at(there) - at(here), axis=-1).max(axis=(0, 3))
        assert np.all(gone <= bound + 1e-12)
        moving = bound > 1e-9
        if moving.any():
            tightest = max(tightest, float((gone[moving] / bound[moving]).max()))
    assert tightest > 0.7


@pytest.mark.parametrize("name", ["ur5", "zyyzyz_6r", "stanford_rrprrr"])
def test_balls_hold_their_shapes(name: str) -> None:
    """Every point of a shape's surface lies in one of its balls, and in its one ball."""
    rng = np.random.default_rng(2)
    for solid in ARMS[name].cell.collisions.shapes.solids:
        shape = solid.exact
        if isinstance(shape, coal.BVHModelBase):
            vertices = np.array(shape.vertices())
            corners = vertices[[[t[0], t[1], t[2]] for t in map(shape.tri_indices, range(shape.num_tris))]]
            weights = rng.dirichlet([1.0, 1.0, 1.0], len(corners))
            points = np.concatenate([vertices, np.einsum("tc,tci->ti", weights, corners)])
        else:
            shape.computeLocalAABB()
            points = rng.uniform(np.array(shape.aabb_local.min_), np.array(shape.aabb_local.max_), (500, 3))
            speck = coal.Sphere(1e-9)
            inside = [
                coal.distance(
                    shape,
                    coal.Transform3s(),
                    speck,
                    coal.Transform3s(np.eye(3), p),
                    coal.DistanceRequest(),
                    coal.DistanceResult(),
                )
                <= 0
                for p in points
            ]
            points = points[inside]
        centres, radii = solid.covering_balls()
        away = np.linalg.norm(points[:, None] - centres, axis=2) - radii
        assert away.min(axis=1).max() <= 1e-8
        centre, radius = solid.one_ball()
        assert np.linalg.norm(points - centre, axis=1).max() <= radius + 1e-8


def test_hulls_are_never_farther_apart_than_their_meshes() -> None:
    """Distances of hulls are those of meshes or less, for all pairs of an arm's meshes in many places."""
    solids = ARMS["ur5"].cell.collisions.shapes.solids
    meshes = [(solid.exact, solid.hull) for solid in solids if solid.hull is not None]
    assert len(meshes) > 3
    rng, here = np.random.default_rng(3), coal.Transform3s()
    for _ in range(150):
        (a, hull_a), (b, hull_b) = (meshes[i] for i in rng.integers(len(meshes), size=2))
        turn = pin.exp3(rng.normal(size=3))
        there = coal.Transform3s(turn, rng.normal(size=3) * 0.4)
        apart, apart_hulls = (
            coal.distance(one, here, other, there, coal.DistanceRequest(), coal.DistanceResult())
            for one, other in ((a, b), (hull_a, hull_b))
        )
        assert apart_hulls <= apart + 2e-6
