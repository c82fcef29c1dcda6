"""The field of a large cloud: a lower bound on the distance to its points, wherever it is asked."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import urdf_ik
from urdf_ik.cell.coal_shapes import PIECE
from urdf_ik.cell.spatial_search import DistanceField

RNG = np.random.default_rng(0)
SHELL = RNG.normal(size=(20_000, 3))
SHELL *= RNG.uniform(0.8, 1.1, (len(SHELL), 1)) / np.linalg.norm(SHELL, axis=1, keepdims=True)
CLOUDS = {
    "shell": SHELL,
    "far away": SHELL + (1e3, -2e3, 5.0),
    "flat": SHELL * (1.0, 1.0, 0.0),
    "line": SHELL * (0.0, 1.0, 0.0),
    "small": SHELL * 1e-5,
    "two": np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]),
    "one": np.zeros((3, 3)),
}


@pytest.mark.parametrize("name", CLOUDS)
def test_a_field_is_never_above_the_distance_and_near_it(name: str) -> None:
    """The nearest point by a k-d tree is as far or farther, and by no more than four cells inside the grid."""
    points = CLOUDS[name]
    field = DistanceField(points)
    middle, size = points.mean(axis=0), np.ptp(points, axis=0).max()
    inside = points[RNG.integers(len(points), size=500)] + RNG.normal(size=(500, 3)) * 0.05 * size
    asked = np.concatenate([inside, middle + RNG.normal(size=(500, 3)) * (3.0 * size + 0.1), points[:100]])
    apart, _ = cKDTree(points).query(asked)
    least = field.least(asked)
    assert (least <= apart + 1e-12).all()
    within = ((asked >= points.min(axis=0)) & (asked <= points.max(axis=0))).all(axis=1)
    cell = max(size / 40.0, 1e-9)
    assert (least[within] >= apart[within] - 4.0 * cell).all()


def test_a_cloud_that_was_moved_is_where_it_stands_now() -> None:
    """In a world that has a tree: a shell about the arm that comes to touch it, and is taken away."""
    arm = urdf_ik.load("ur5")
    cloud = urdf_ik.Points(2.5 * SHELL, 0.05)
    away, here = urdf_ik.pose([0.0, 0.0, 0.0]), urdf_ik.pose([2.2, 0.2, 0.0])
    moved, fresh = urdf_ik.World(), urdf_ik.World()
    for world in (moved, fresh):
        for k in range(100):
            world.add(f"box {k}", urdf_ik.Box(0.05), urdf_ik.pose([3.0, 0.1 * k, 0.0]))
    moved.add("cloud", cloud, away)
    model = arm.cell.collisions.in_world(moved)
    q = RNG.uniform(-np.pi, np.pi, (60, 6))
    alone = arm.cell.collisions.in_collision(q)
    assert np.array_equal(model.in_collision(q), alone)
    moved.move("cloud", here)
    fresh.add("cloud", cloud, here)
    hits = model.in_collision(q)
    assert np.array_equal(hits, arm.cell.collisions.in_world(fresh).in_collision(q))
    assert (hits & ~alone).sum() > 5
    moved.remove("cloud")
    assert np.array_equal(model.in_collision(q), alone)


def test_what_touches_a_large_cloud_is_what_touches_its_parts() -> None:
    """Clouds too small to have a field answer the same, for joint vectors and for motions."""
    arm = urdf_ik.load("ur5")
    cloud = RNG.uniform(-1.0, 1.0, (3 * PIECE, 3))
    cloud = cloud[np.linalg.norm(cloud - (0.0, 0.0, 0.5), axis=1) > 0.7]
    turned = urdf_ik.pose([0.1, 0.2, 0.1], rpy=[0.3, -0.2, 0.5])
    whole, parts = urdf_ik.World(), urdf_ik.World()
    whole.add("cloud", urdf_ik.Points(cloud, 0.01), turned)
    for k, start in enumerate(range(0, len(cloud), PIECE)):
        parts.add(f"part {k}", urdf_ik.Points(cloud[start : start + PIECE], 0.01), turned)
    assert len(cloud) > PIECE
    q = RNG.uniform(-np.pi, np.pi, (150, 6))
    of_whole, of_parts = (arm.cell.collisions.in_world(world) for world in (whole, parts))
    hits = of_whole.in_collision(q)
    assert np.array_equal(hits, of_parts.in_collision(q))
    alone = arm.cell.collisions.in_collision(q)
    assert (hits & ~alone).sum() > 10 and (~hits).any()
    moved = q[:40] + 0.1
    assert np.array_equal(of_whole.motions_free(q[:40], moved).free, of_parts.motions_free(q[:40], moved).free)
    assert np.allclose(of_whole.distance(q[:40]), of_parts.distance(q[:40]), atol=1e-6)
