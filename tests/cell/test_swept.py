"""Motions proven free: what is called free never touches, what touches is found, and how little is refused."""

import numpy as np
import pytest
from chains import collision, joint, robot
from worlds import random_world

import urdf_ik
from urdf_ik import Box, HalfSpace, Sphere, World, pose
from urdf_ik.cell import CollisionModel
from urdf_ik.cell.swept_motions import TOUCH

Array = np.ndarray

# A thin arm of one joint: a bar 1 m long that turns about z, and its ball at the end.
BAR = robot(
    joint("turn", "continuous", "base", "bar", axis="0 0 1"), bar=collision('box size="1 0.02 0.02"', "0.5 0 0")
)

# Two bars, the second on the end of the first, and a slider above.
TWO = robot(
    joint("a", "continuous", "base", "one", axis="0 0 1"),
    joint("b", "continuous", "one", "two", "1 0 0", axis="0 0 1"),
    joint("c", "prismatic", "two", "pin", "1 0 0", axis="0 0 1"),
    one=collision('box size="1 0.02 0.02"', "0.5 0 0"),
    two=collision('cylinder radius="0.01" length="1"', "0.5 0 0", "0 1.5707963 0"),
    pin=collision('sphere radius="0.01"'),
)


def touches(body: CollisionModel, q0: Array, q1: Array, samples: int, margin: float = 0.0) -> bool:
    """Whether any of the evenly spaced joint vectors of a motion is in contact."""
    share = np.linspace(0.0, 1.0, samples)[:, None]
    return bool(np.any(body.in_collision(q0 + share * (q1 - q0), margin)))


def test_a_thin_wall_between_two_samples() -> None:
    """A wall of 0.1 mm between the ends of a motion is seen, however few joint vectors would miss it."""
    arm, world = urdf_ik.load(BAR), World()
    world.add("wall", Box((0.5, 1e-4, 1.0)), pose([0.8, 0.0, 0.0]))
    body = arm.cell.collisions.in_world(world)
    q0, q1 = np.array([-1.1]), np.array([0.7])
    assert not touches(body, q0, q1, 10)
    motion = arm.motion_is_free(q0, q1, world)
    assert not motion
    assert motion.pair == ("bar", "wall")
    # The bar's flank, 0.01 m from its middle line, meets the wall's near end at x = 0.55 first, or its far end later.
    assert motion.share == pytest.approx((1.1 - np.arcsin(0.01005 / 0.55)) / 1.8, abs=2e-3)
    assert arm.motion_is_free(q0, [-0.1], world)
    assert arm.motion_is_free([0.1], q1, world)


def test_turns_count() -> None:
    """Motions with the same ends up to a turn are different motions."""
    arm, world = urdf_ik.load(BAR), World()
    world.add("wall", Box((0.5, 1e-4, 1.0)), pose([-0.8, 0.0, 0.0]))
    assert arm.motion_is_free([-3.0], [3.0], world)
    assert not arm.motion_is_free([-3.0], [3.0 - 2.0 * np.pi], world)
    assert not arm.motion_is_free([0.5], [0.5 + 2.0 * np.pi], world)


def test_the_first_contact_is_reported() -> None:
    """Of two walls in the way the one that comes first is named, from either end."""
    arm, world = urdf_ik.load(BAR), World()
    for name, angle in (("first", 0.5), ("second", 1.5)):
        world.add(name, Sphere(0.05), pose([0.8 * np.cos(angle), 0.8 * np.sin(angle), 0.0]))
    forth, back = arm.motion_is_free([0.0], [2.0], world), arm.motion_is_free([2.0], [0.0], world)
    assert (forth.pair, back.pair) == (("bar", "first"), ("bar", "second"))
    width = np.arcsin(0.06 / 0.8)
    assert forth.share == pytest.approx((0.5 - width) / 2.0, abs=2e-4)
    assert back.share == pytest.approx((0.5 - width) / 2.0, abs=2e-4)


def test_how_close_a_free_motion_may_come() -> None:
    """A motion that keeps more than TOUCH away is found free; one that keeps less is not, and its pair is named."""
    arm = urdf_ik.load(BAR)
    for gap, free in ((1.5 * TOUCH, True), (0.5 * TOUCH, False), (-0.5 * TOUCH, False)):
        world = World()
        world.add("below", HalfSpace((0.0, 0.0, 1.0), -0.01 - gap))
        motion = arm.motion_is_free([0.0], [0.3], world)
        assert bool(motion) == free
        assert motion.pair == (None if free else ("bar", "below"))
    world = World()
    world.add("below", HalfSpace((0.0, 0.0, 1.0), -0.03))
    assert arm.motion_is_free([0.0], [0.3], world, margin=0.0198)
    assert not arm.motion_is_free([0.0], [0.3], world, margin=0.02)


def test_a_motion_that_stands_still_or_begins_in_contact() -> None:
    """A point is a motion; one that begins in contact has it at share 0, and so has one that only leaves it."""
    arm, world = urdf_ik.load(BAR), World()
    world.add("post", Sphere(0.05), pose([0.8, 0.0, 0.0]))
    assert arm.motion_is_free([1.0], [1.0], world)
    still = arm.motion_is_free([0.0], [0.0], world)
    assert not still
    assert still.share == 0.0
    leaving = arm.motion_is_free([0.0], [1.0], world)
    assert leaving.share == 0.0
    assert leaving.pair == ("bar", "post")


def test_links_of_the_arm_itself() -> None:
    """A pin that sweeps through the first bar on its way round is a contact of two links."""
    arm = urdf_ik.load(TWO)
    body = arm.cell.collisions
    assert body.checked_pairs == (("one", "pin"),)
    # Folded back, the pin is at the first joint; unfolded again, on the other side.
    q0, q1 = np.array([0.0, np.pi - 0.3, 0.0]), np.array([0.0, np.pi + 0.3, 0.0])
    assert arm.motion_is_free(q0, q1).pair == ("one", "pin")
    assert arm.motion_is_free(q0 + [0, 0, 0.1], q1 + [0, 0, 0.1])
    # The first joint alone moves both, and nothing comes closer.
    assert arm.motion_is_free(q0, q0 + [40.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("name", "reach"), [("zyyzyz_6r", 2.0), ("srs_7r", 1.0), ("stanford_rrprrr", 1.0), ("scara_rrpr", 0.8)]
)
def test_no_free_motion_touches(name: str, reach: float) -> None:
    """Random motions in random worlds: of none that is called free does any of 200 joint vectors touch.

    Of the others, everything before the first contact is free, and there the pair is within two TOUCH of it.
    """
    arm, rng = urdf_ik.load(name), np.random.default_rng(4)
    frees = []
    for _ in range(4):
        world = random_world(rng, 3, 0.3 * reach, 0.3 * reach, reach)
        body = arm.cell.collisions.in_world(world)
        starts = rng.uniform(-np.pi, np.pi, (60, arm.dof))
        starts = starts[~np.asarray(body.in_collision(starts, 1e-3))][:15]
        ends = starts + rng.uniform(-1.0, 1.0, starts.shape) * rng.choice([0.05, 0.3, 1.0], (len(starts), 1))
        found = arm.motion_is_free(starts, ends, world)
        for q0, q1, free, share, pair in zip(starts, ends, found.free, found.share, found.pairs, strict=True):
            assert np.isnan(share) == free
            assert (pair is None) == free
            if free:
                assert not touches(body, q0, q1, 200)
            else:
                stop = q0 + share * (q1 - q0)
                assert body.in_collision(stop, 2.1 * TOUCH)
                assert not touches(body, q0, q0 + (1.0 - 1e-9) * (stop - q0), 200)
        frees += found.free.tolist()
    assert np.mean(frees) > 0.3


def test_almost_every_motion_that_is_free_is_called_free() -> None:
    """Short motions that no sample brings within a millimetre of anything are all called free."""
    arm, rng = urdf_ik.load("zyyzyz_6r"), np.random.default_rng(9)
    world = random_world(rng, 6, 0.6, 0.6, 2.0)
    body = arm.cell.collisions.in_world(world)
    q0 = rng.uniform(-np.pi, np.pi, (100, 6))
    q1 = q0 + rng.uniform(-0.1, 0.1, q0.shape)
    clear = np.array([not touches(body, a, b, 50, 1e-3) for a, b in zip(q0, q1, strict=True)])
    assert clear.sum() > 30
    assert body.motions_free(q0, q1).free[clear].all()
