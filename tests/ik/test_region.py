"""Target regions, and arms with several redundancy parameters: the nearest joint vector, by sampling."""

import numpy as np
import pytest
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import Region
from urdf_ik.cell.pinocchio_reference import Reference

Array = NDArray[np.float64]
REGIONS = {
    "point": Region(),
    "box": Region(box=[[-0.01, 0.02], [0.0, 0.0], [-0.005, 0.005]]),
    "cone": Region(cone=0.2),
    "cone and any rotation": Region(box=0.01, cone=0.3, rotation=np.pi, at=(0.0, 0.02, 0.1)),
    "rotation about x": Region(rotation=0.5, axis="x"),
}


def inside(arm: urdf_ik.Arm, rng: np.random.Generator, count: int) -> Array:
    """Joint vectors (count, n) inside the limits, without turns."""
    return rng.uniform(*np.clip(arm.limits.T, -np.pi, np.pi), (count, arm.dof))


def off(region: Region, T: Array, reached: Array) -> tuple[Array, float, float]:
    """Place, axis tilt and rotation of a pose relative to a target, computed independently."""
    a, at = np.array(region.axis.direction), np.array(region.axis.at)
    R = T[:3, :3].T @ reached[:3, :3]
    place = T[:3, :3].T @ (reached[:3, :3] @ at + reached[:3, 3] - T[:3, 3]) - at
    tilt = float(np.arctan2(np.linalg.norm(np.cross(a, R @ a)), a @ R @ a))
    # The quaternion's twist about the axis.
    w = np.sqrt(max(0.0, 1.0 + np.trace(R))) / 2.0
    v = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / (4.0 * w)
    return place, tilt, float(2.0 * np.arctan2(v @ a, w))


@pytest.mark.parametrize("name", REGIONS)
@pytest.mark.parametrize("arm", ["puma_560", "ur5"])
def test_nothing_nearer_is_sampled(arm: str, name: str) -> None:
    """The answer is in the region and inside the limits by Pinocchio; no solution of 3000 poses in it is nearer."""
    loaded, region = urdf_ik.load(arm), REGIONS[name]
    reference, rng = Reference(loaded.model, loaded.base, loaded.tip), np.random.default_rng(1)
    q, near = inside(loaded, rng, 2), inside(loaded, rng, 2)
    T = reference.pose(q)
    found = loaded.ik_nearest(T, near, region=region)
    for k in range(2):
        answer = found.q[k, 0]
        place, tilt, turn = off(region, T[k], reference.pose(answer))
        low, high = np.array(region.box).T
        assert (place >= low - 1e-8).all()
        assert (place <= high + 1e-8).all()
        assert tilt <= region.cone + 1e-7
        assert abs(turn) <= region.rotation + 1e-7
        position, rotation = reference.errors(answer, found.poses[k])
        assert max(position, rotation) < 1e-9
        assert (answer >= loaded.limits[:, 0] - 1e-9).all()
        assert (answer <= loaded.limits[:, 1] + 1e-9).all()
        sampled = loaded.ik(region.sampled(T[k], rng.uniform(size=(3000, 6)))).nearest(near[k], within_limits=True)
        least = np.nanmin(np.linalg.norm(sampled.q[:, 0] - near[k], axis=1))
        assert np.linalg.norm(answer - near[k]) <= least + 1e-7


def test_zyyzyz_5_cm_out_of_reach_is_reached_with_a_box_of_6_cm() -> None:
    """A target just out of reach has a solution with a box around it, and none with a smaller box."""
    arm = urdf_ik.load("zyyzyz_6r")
    T = urdf_ik.pose([0.0, 0.0, 3.35])
    assert not arm.ik_nearest(T, np.zeros(6)).count
    assert arm.ik_nearest(T, np.zeros(6), region=Region(box=0.06)).count == 1
    assert not arm.ik_nearest(T, np.zeros(6), region=Region(box=0.04)).count


def test_several_parameters() -> None:
    """A joint vector is nearest to itself; of 20,000 values of both parameters none has a nearer solution."""
    rng = np.random.default_rng(2)
    for arm in (
        urdf_ik.load("positioner_6r", base="workpiece", tip="torch"),
        urdf_ik.load("srs_7r").with_free_axis("z"),
    ):
        q = inside(arm, rng, 3)
        T = arm.fk(q)
        own = arm.ik_nearest(T, q)
        np.testing.assert_allclose(own.q[:, 0], q, atol=1e-6)
        near = inside(arm, rng, 1)[0]
        found = arm.ik_nearest(T[0], near)
        low, high = np.array([parameter.range for parameter in arm.solver.parameters]).T
        every = arm.ik(T[0], redundancy=rng.uniform(low, high, (20000, 2))).nearest(near, within_limits=True)
        least = np.nanmin(np.linalg.norm(every.q[:, 0] - near, axis=1))
        assert np.linalg.norm(found.q[0] - near) <= least + 1e-7
