"""Base positions: scores against ``arm.ik`` pose by pose, the published helix, a shelf, what is refused."""

import re
from typing import Any

import arms
import numpy as np
import pytest
from numpy.typing import NDArray

import urdf_ik

Array = NDArray[np.float64]


def crx() -> urdf_ik.Arm:
    """FANUC's CRX-10iA/L as the code that comes with Elias and Wen describes it: joints without limits.

    "Path planning and optimization for cuspidal 6R manipulators" (2025), rpiRobotics/cuspidal-path-planning.
    """
    x, y, z = np.eye(3)
    points = np.cumsum([0 * z, 0 * z, 0.71 * z, 0 * z, 0.54 * y + 0.15 * x, 0 * z], axis=0)
    text = arms.from_screws("crx", "general", np.array([z, x, x, y, x, y]), points, points[-1]).urdf
    text = re.sub(r"<limit[^>]*/>", "", text.replace('type="revolute"', 'type="continuous"'))
    return urdf_ik.load(text, base="base", tip="tool")


def helix(count: int = 500) -> Array:
    """Their tool path: 5 turns, radius 0.1 m, height 0.3 m; the tool leans 30 degrees and turns along."""
    along = np.linspace(0.0, 1.0, count)
    leaning = urdf_ik.pose([0.0, 0.0, 0.0], rotvec=[0.0, np.pi + np.pi / 6.0, 0.0])
    turns = 10.0 * np.pi * along
    points = np.stack([0.1 * np.cos(turns), 0.1 * np.sin(turns), 0.3 * along], axis=-1)
    return np.array([urdf_ik.pose(p, rotvec=[0.0, 0.0, turn]) @ leaning for p, turn in zip(points, turns, strict=True)])


def shelf() -> Array:
    """200 grasps: 5 boards, 20 places along each, from the front and 30 degrees from above."""
    return np.array(
        [
            urdf_ik.pose([1.2, along, height], rotvec=[0.0, 0.5 * np.pi + down, 0.0])
            for height in np.linspace(0.3, 1.5, 5)
            for along in np.linspace(-0.8, 0.8, 20)
            for down in (0.0, np.pi / 6.0)
        ]
    )


def test_scores_are_those_of_every_single_pose() -> None:
    """Counts, branches and margins by ``arm.ik`` in the base's own frame, for turned and hanging bases."""
    arm = urdf_ik.load("zyyzyz_6r")
    targets = arm.fk(np.random.default_rng(4).uniform(-1.2, 1.2, (6, 6)))
    mount = urdf_ik.pose([0, 0, 0], rotvec=[np.pi, 0, 0])[:3, :3]
    bounds = [[-0.4, -0.4, 0.0], [0.4, 0.4, 0.3]]
    found = urdf_ik.maps.placement(arm, targets, bounds=bounds, step=0.4, turns=3, mount=mount)
    assert found.reached.shape == (3, 3, 1, 3)
    for index in np.ndindex(found.reached.shape):
        base = found.base(index)
        np.testing.assert_allclose(
            base[:3, :3], urdf_ik.pose([0, 0, 0], rotvec=[0, 0, 2 * np.pi * index[3] / 3])[:3, :3] @ mount
        )
        each = [arm.ik(np.linalg.inv(base) @ target).within_limits() for target in targets]
        counts = [len(one) for one in each]
        assert found.reached[index] == np.count_nonzero(counts)
        if all(counts):
            assert found.solutions[index] == min(counts)
            common = set.intersection(*({one.branch for one in solutions} for solutions in each))
            assert found.branches[index] == len(common)
            assert found.margin[index] > 0.0
        else:
            assert found.solutions[index] == found.branches[index] == 0 and np.isnan(found.margin[index])


def test_the_published_helix() -> None:
    """At the optimum that Elias and Wen publish the path is followed; the map finds places where it is, and where not.

    Their offset is applied before their rotation: the base stands, in the helix's frame, where both bring it back.
    """
    arm, T = crx(), helix()
    w, x, y = np.array([-0.0180, 0.1960, -2.1002]) / np.linalg.norm([-0.0180, 0.1960, -2.1002])
    base = np.linalg.inv(urdf_ik.pose([0, 0, 0], quat_wxyz=[w, x, y, 0]) @ urdf_ik.pose([0.0491, 0.7073, -0.7461]))
    at = base[:3, 3]
    found = urdf_ik.maps.placement(arm, T, bounds=[at, at], step=0.1, mount=base[:3, :3], path=True)
    best = found.best()
    np.testing.assert_allclose(best.pose, base, atol=1e-12)
    assert best.reached == 500 and best.followed and best.branches == 8
    assert best.cost == pytest.approx(arm.follow(np.linalg.inv(base) @ T).cost, rel=1e-6)
    around = urdf_ik.maps.placement(arm, T, bounds=[[-0.6, -0.7, 0.0], [0.6, -0.7, 0.0]], step=0.3, path=True)
    assert around.followed is not None and around.followed[:, 0, 0, 0].tolist() == [0, 1, 1, 1, 0]
    assert around.best().pose[:2, 3] == pytest.approx([0.0, -0.7], abs=1e-12)


def test_a_shelf_of_two_hundred_grasps() -> None:
    """The best place reaches the most grasps of all places, and the obstacles of a cell take some away."""
    arm, targets = urdf_ik.load("zyyzyz_6r"), shelf()
    options: dict[str, Any] = {"bounds": [[-0.8, -0.4, 0.0], [0.4, 0.4, 0.0]], "step": 0.4}
    found = urdf_ik.maps.placement(arm, targets, **options)
    best = found.best()
    assert len(targets) == 200 and best.reached == found.reached.max()
    assert [place.reached for place in found.places(4)] == sorted(found.reached.ravel(), reverse=True)[:4]
    index = np.argwhere(found.reached == found.reached.max())[0]
    reached = arm.ik(np.linalg.inv(found.base(tuple(index))) @ targets).within_limits().valid.any(axis=1)
    assert reached.sum() == best.reached
    world = urdf_ik.World()
    world.add("board", urdf_ik.Box((0.4, 2.0, 0.02)), urdf_ik.pose([1.4, 0.0, 0.95]))
    free = urdf_ik.maps.placement(arm, targets[:20], **{**options, "step": 0.6}, world=world)
    alone = urdf_ik.maps.placement(arm, targets[:20], **{**options, "step": 0.6})
    assert (free.reached <= alone.reached).all() and free.clearance is not None
    for index in np.argwhere(free.reached == 20)[:1]:
        base = free.base(tuple(index))
        moved = urdf_ik.World()
        moved.add("board", world["board"].shape, np.linalg.inv(base) @ world["board"].pose)
        left = arm.ik(np.linalg.inv(base) @ targets[:20]).within_limits().collision_free(moved)
        assert left.valid.any(axis=1).all()
        clearances = [arm.clearance(q[good], moved).max() for q, good in zip(left.q, left.valid, strict=True)]
        assert free.clearance[tuple(index)] == pytest.approx(min(clearances), rel=1e-5)


def test_seven_joints_are_asked_at_many_values() -> None:
    """A pose that the default value does not reach is reached at another one."""
    arm = urdf_ik.load("srs_7r")
    rng = np.random.default_rng(8)
    targets = arm.fk(rng.uniform(*arm.limits.T, (40, 7)))
    found = urdf_ik.maps.placement(arm, targets, bounds=[[0, 0, 0], [0, 0, 0]], step=1.0)
    alone = int(arm.ik(targets).within_limits().valid.any(axis=1).sum())
    assert alone < int(found.reached[0, 0, 0, 0]) <= 40


def test_a_picture_and_what_is_refused() -> None:
    """The layer of the best place; numbers that are impossible."""
    from urdf_ik.show import plot

    arm = urdf_ik.load("zyyzyz_6r")
    target = arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])
    good: dict[str, Any] = {"bounds": [[-1, -1, 0], [1, 1, 0]], "step": 0.5}
    found = urdf_ik.maps.placement(arm, target, **good)
    figure = plot.placements(found, "margin")
    assert figure.axes[0].get_ylabel() == "y [m]"
    for wrong in ({"bounds": [[1, 0, 0], [0, 0, 0]]}, {"step": 0.0}, {"mount": 2.0 * np.eye(3)}):
        with pytest.raises(urdf_ik.ArgumentError):
            urdf_ik.maps.placement(arm, target, **{**good, **wrong})
