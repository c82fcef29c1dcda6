"""Worlds of many obstacles: the same answers as pair by pair, whatever the world went through, and no work that grows.

The oracle asks coal about every pair of a link's shape and an obstacle, one by one, without bounds or hulls.
"""

from concurrent.futures import ThreadPoolExecutor

import coal
import numpy as np
import pinocchio as pin
import pytest
from worlds import random_pose, random_shape, random_world

import urdf_ik
from urdf_ik import Box, HalfSpace, World, pose
from urdf_ik.cell import CollisionModel
from urdf_ik.cell.coal_shapes import geometry
from urdf_ik.cell.swept_motions import TOUCH

Array = np.ndarray


def large_world(rng: np.random.Generator, count: int, reach: float) -> World:
    """``count`` obstacles of all kinds, and a floor."""
    world = random_world(rng, count, 0.1 * reach, 0.4 * reach, 2.5 * reach)
    world.add("floor", HalfSpace((0.0, 0.1, 1.0), -0.7 * reach))
    return world


def pairwise(model: CollisionModel, world: World, q: Array) -> dict[tuple[str, str], float]:
    """Distance of every checked pair of a link and an obstacle, each by coal alone, to the names."""
    reference, arm = model.reference, model.shapes
    plain, shapes = reference.pin_model, arm.geometry
    data, placed = plain.createData(), shapes.createData()
    pin.updateGeometryPlacements(plain, data, shapes, placed, reference.configuration(q))
    frame = plain.frames[reference.base_frame]
    base = data.oMi[frame.parentJoint] * frame.placement
    out: dict[tuple[str, str], float] = {}
    checked = set(model.checked_pairs)
    for each in world:
        place, solid = base * pin.SE3(each.pose), geometry(each.shape)
        there = coal.Transform3s(place.rotation, place.translation)
        for link, shape, at in zip(arm.links, arm.solids, placed.oMg, strict=True):
            if (link, each.name) in checked:
                here = coal.Transform3s(at.rotation, at.translation)
                result = coal.DistanceResult()
                coal.distance(shape.exact, here, solid, there, coal.DistanceRequest(), result)
                apart = max(result.min_distance - each.shape.inflation, 0.0)
                out[link, each.name] = min(apart, out.get((link, each.name), np.inf))
    return out


@pytest.mark.parametrize(("name", "reach"), [("ur5", 0.9), ("zyyzyz_6r", 2.0), ("scara_rrpr", 0.8)])
@pytest.mark.parametrize("count", [5, 200])
def test_the_same_as_pair_by_pair(name: str, reach: float, count: int) -> None:
    """Distances, verdicts, margins and colliding pairs are those of all pairs, one by one."""
    arm, rng = urdf_ik.load(name), np.random.default_rng(count)
    world = large_world(rng, count, reach)
    # Allowed pairs are honoured; so are pairs of a link that stands still, which are checked where a user says so.
    model = arm.cell.collisions.in_world(world)
    model = model.allow(*model.checked_pairs[-1]).allow(*model.checked_pairs[-2])
    still = [pair for pair, why in model.table().allowed.items() if why == "rigid" and pair[1] == "o1"]
    for pair in still[:1]:
        model = model.check(*pair)
    hits = []
    for q in rng.uniform(-2.0, 2.0, (12, arm.dof)):
        apart = pairwise(model, world, q)
        own = arm.cell.collisions.distance(q)
        least = min(own, min(apart.values()))
        assert model.distance(q) == pytest.approx(least, abs=5e-6)
        assert model.in_collision(q) == (least == 0.0)
        if least:
            assert model.in_collision(q, least + 1e-5)
            assert not model.in_collision(q, least - 1e-5)
        among = set(arm.cell.collisions.colliding_pairs(q))
        touching = {pair for pair, distance in apart.items() if distance == 0.0}
        found = model.colliding_pairs(q)
        assert set(found) == touching | among
        assert list(found) == [pair for pair in model.checked_pairs if pair in touching | among]
        assert model.distance_with(arm.link_poses(q)) == pytest.approx(least, abs=5e-6)
        hits.append(least == 0.0)
    assert any(hits) or count == 5


def test_a_world_that_was_changed_answers_like_a_new_one() -> None:
    """Moved, removed and added obstacles, few and many, leave the answers of a world that was made as it is now."""
    arm, rng = urdf_ik.load("zyyzyz_6r"), np.random.default_rng(5)
    world = large_world(rng, 400, 2.0)
    q = rng.uniform(-2.0, 2.0, (15, 6))
    arm.clearance(q[0], world)
    for changes in (1, 1, 30, 300, 7):
        for _ in range(changes):
            name = str(rng.choice(world.names))
            match int(rng.integers(3)):
                case 0:
                    world.move(name, random_pose(rng, 0.8, 5.0))
                case 1:
                    world.remove(name)
                case 2:
                    world.add(f"n{world.version}", random_shape(rng, 0.2), random_pose(rng, 0.8, 5.0))
        fresh = World()
        for each in world:
            fresh.add(*each)
        model, other = (arm.cell.collisions.in_world(each) for each in (world, fresh))
        assert model.checked_pairs == other.checked_pairs
        np.testing.assert_array_equal(model.distance(q), other.distance(q))
        np.testing.assert_array_equal(model.in_collision(q, 0.05), other.in_collision(q, 0.05))
        assert [model.colliding_pairs(x) for x in q] == [other.colliding_pairs(x) for x in q]
        assert [model.nearest_pair(x) for x in q] == [other.nearest_pair(x) for x in q]
        ends = q + rng.uniform(-0.3, 0.3, q.shape)
        ours, theirs = model.motions_free(q, ends), other.motions_free(q, ends)
        np.testing.assert_array_equal(ours.share, theirs.share)
        assert ours.pairs == theirs.pairs


def test_how_often_coal_is_asked_does_not_grow(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a world of 20,000 boxes around a free space, a clearance asks coal about as few pairs as among 200."""
    arm, rng = urdf_ik.load("ur5"), np.random.default_rng(7)
    asked: list[int] = []
    distance = coal.distance
    monkeypatch.setattr(coal, "distance", lambda *args: (asked.append(1), distance(*args))[1])
    counts = []
    q = np.array([0.3, -1.2, 1.0, -0.5, 0.7, 0.1])
    for count in (200, 20_000):
        world = World()
        for i in range(count):
            at = rng.normal(size=3)
            world.add(f"b{i}", Box(0.05), pose(rng.uniform(1.2, 6.0) * at / np.linalg.norm(at)))
        asked.clear()
        assert arm.clearance(q, world) > 0.0
        counts.append(len(asked))
    assert counts[1] <= counts[0] + 20


@pytest.mark.parametrize("seed", range(3))
def test_motions_through_many_obstacles(seed: int) -> None:
    """No sample of a motion that is called free touches; the first contact of the others is one, within two TOUCH."""
    arm, rng = urdf_ik.load("zyyzyz_6r"), np.random.default_rng(seed)
    world = World()
    for i in range(500):
        world.add(f"b{i}", random_shape(rng, 0.1), random_pose(rng, 1.0, 6.25))
    model = arm.cell.collisions.in_world(world)
    q0 = rng.uniform(-2.0, 2.0, (200, 6))
    q0 = q0[~np.asarray(model.in_collision(q0, 1e-3))][:25]
    q1 = q0 + rng.uniform(-1.0, 1.0, q0.shape) * rng.choice([0.1, 0.5, 2.0], (len(q0), 1))
    found = model.motions_free(q0, q1)
    for a, b, free, share in zip(q0, q1, found.free, found.share, strict=True):
        end = b if free else a + (share - 1e-9) * (b - a)
        assert not np.any(model.in_collision(a + np.linspace(0.0, 1.0, 60)[:, None] * (end - a)))
        assert free or model.in_collision(a + share * (b - a), 2.1 * TOUCH)
    assert 0 < found.free.sum() < len(q0)


def test_one_large_world_from_many_threads() -> None:
    """While one thread moves an obstacle to and fro, each answer is that of one of its two places."""
    arm, rng = urdf_ik.load("zyyzyz_6r"), np.random.default_rng(13)
    world = large_world(rng, 200, 2.0)
    world.add("shuttle", Box(0.3))
    q = rng.uniform(-2.0, 2.0, (6, 6))
    model = arm.cell.collisions.in_world(world)
    places = [arm.fk(q[0]), pose([9.0, 0.0, 0.0])]
    expected = []
    for place in places:
        world.move("shuttle", place)
        expected.append(np.asarray(model.distance(q)))

    def ask(k: int) -> bool:
        if k % 4 == 0:
            world.move("shuttle", places[k // 4 % 2])
        got = model.distance(q)
        return any(np.array_equal(got, each) for each in expected)

    with ThreadPoolExecutor(8) as pool:
        assert all(pool.map(ask, range(80)))
