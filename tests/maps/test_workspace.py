"""Workspaces: planar regions against their formulas and draws, maps against ``arm.ik`` pose by pose."""

import json
from pathlib import Path

import numpy as np
import pytest
from chains import joint, robot
from command import call, succeed
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.maps import workspaces
from urdf_ik.maps.workspaces.creation import directions, rotations

Array = NDArray[np.float64]


def two_links(base: tuple[str, str], lengths: Array, bend: float, signs: Array, limits: Array) -> urdf_ik.Arm:
    """Two turning joints in the x, y plane, the first one at ``base`` (xyz, rpy)."""
    ranges = [f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/>' for low, high in limits]
    text = robot(
        joint("one", "revolute", "base", "a", *base, f"0 0 {signs[0]}", ranges[0]),
        joint("two", "revolute", "a", "b", f"{lengths[0]} 0 0", f"0 0 {bend}", f"0 0 {signs[1]}", ranges[1]),
        joint("end", "fixed", "b", "tip", f"{lengths[1]} 0 0"),
    )
    return urdf_ik.load(text, "base", "tip")


def random_links(rng: np.random.Generator) -> urdf_ik.Arm:
    """Random base, links, axis signs and limits."""
    lower, (x, y) = rng.uniform(-4.0, 2.0, 2), rng.uniform(-1, 1, 2)
    base = (f"{x} {y} 0", f"{rng.choice([0.0, np.pi])} 0 {rng.uniform(-3, 3)}")
    limits = np.stack([lower, lower + rng.uniform(0.3, 7.0, 2)], axis=-1)
    return two_links(base, rng.uniform(0.3, 1.0, 2), rng.uniform(-3, 3), rng.choice([-1, 1], 2), limits)


def side_of_elbow(arm: urdf_ik.Arm, q: Array) -> Array:
    """Positive where the elbow is left of the line from the first axis to the tip, by forward kinematics alone."""
    plane = arm.solver.control.plane
    assert plane is not None
    poses = arm.link_poses(q)
    first, elbow, tip = (poses[link][..., :3, 3] @ plane.axes.T for link in _links(arm))
    line, arm_1 = tip - first, elbow - first
    return line[..., 0] * arm_1[..., 1] - line[..., 1] * arm_1[..., 0]


def _links(arm: urdf_ik.Arm) -> tuple[str, str, str]:
    one, two = (next(j for j in arm.model.joints if j.name == name) for name in arm.joint_names)
    return one.child, two.child, arm.tip


@settings(max_examples=15)
@given(seed=st.integers(0, 2**31))
def test_planar_regions_are_what_joint_vectors_within_the_limits_reach(seed: int) -> None:
    """The tip of every joint vector drawn is in the region of its elbow; points of a region have one that gives it."""
    rng = np.random.default_rng(seed)
    arm = random_links(rng)
    region = workspaces.planar(arm)
    q = rng.uniform(*arm.limits.T, (400, 2))
    points = arm.solver.control.plane.coordinates(arm.fk(q))[:, :2]
    np.testing.assert_allclose(region.tip(q), points, atol=1e-12)
    side = side_of_elbow(arm, q)
    left = side > 0.0
    clear = np.abs(side) > 1e-6
    assert region.reaches(points[clear & left], "elbow left").all()
    assert region.reaches(points[clear & ~left], "elbow right").all()
    reach = region.lengths.sum()
    anywhere = region.centre + rng.uniform(-reach, reach, (400, 2))
    found = arm.ik(anywhere, task="planar position").within_limits()
    for column, name in enumerate(found.branches):
        np.testing.assert_array_equal(region.reaches(anywhere, name), found.valid[:, column])
        q = region.joints(anywhere, name)
        there = ~np.isnan(q[:, 0])
        np.testing.assert_allclose(region.tip(q[there]), anywhere[there], atol=1e-9)
        np.testing.assert_array_equal(side_of_elbow(arm, q[there]) > 0, np.full(there.sum(), name == "elbow left"))


@settings(max_examples=15)
@given(seed=st.integers(0, 2**31))
def test_areas_are_those_of_a_count_of_points(seed: int) -> None:
    """Area inside the arcs = share of a fine lattice that is reached, for each region, the union and the overlap."""
    arm = random_links(np.random.default_rng(seed))
    region = workspaces.planar(arm)
    reach = 1.01 * region.lengths.sum()
    n = 300
    line = (np.arange(n) + 0.5) / n * 2.0 * reach - reach
    points = region.centre + np.stack(np.meshgrid(line, line), axis=-1)
    cell = (2.0 * reach / n) ** 2
    left, right = (region.reaches(points, name) for name in workspaces.ELBOWS)
    for part, inside in (
        (region.regions["elbow left"], left),
        (region.regions["elbow right"], right),
        (region.boundary, left | right),
        (region.overlap, left & right),
    ):
        # A lattice is off by no more than the cells that the boundary crosses.
        crossed = sum(arc.radius * abs(arc.sweep) for arc in part.arcs) / (2.0 * reach / n) + 4.0
        assert abs(part.area - inside.sum() * cell) <= 1.5 * crossed * cell


def test_the_bundled_two_link_arm_has_the_published_region() -> None:
    """Areas by l1 l2 |cos b - cos a| times the range of joint 1; two solutions near the outer edge only."""
    arm = urdf_ik.load("planar_2r")
    region = workspaces.planar(arm)
    swing = np.ptp(arm.limits[0])
    left, right = (region.regions[name].area for name in workspaces.ELBOWS)
    assert left == pytest.approx(swing * 0.066 * 0.130 * (1.0 - np.cos(np.deg2rad(145.0))), rel=1e-12)
    assert right == pytest.approx(swing * 0.066 * 0.130 * (1.0 - np.cos(np.deg2rad(25.5))), rel=1e-12)
    assert region.overlap.area == pytest.approx(left + right - region.boundary.area, rel=1e-9)
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.2, 0.2, (20000, 2))
    twice = np.sum([region.reaches(points, name) for name in workspaces.ELBOWS], axis=0) == 2
    solved = arm.ik(points, task="planar position").within_limits().count
    np.testing.assert_array_equal(twice, solved == 2)
    assert np.linalg.norm(points[twice], axis=1).min() > 0.1916


def test_without_limits_the_region_is_a_ring() -> None:
    """Joints that turn all the way round reach the ring between the links' difference and sum, in two ways."""
    arm = two_links(("0 0 0", "0 0 0"), (0.7, 0.4), 0.0, (1, 1), ((-3.2, 3.2), (-4, 4)))
    region = workspaces.planar(arm)
    for part in (region.boundary, region.overlap, *region.regions.values()):
        assert sorted(round(arc.radius, 12) for arc in part.arcs) == [0.3, 1.1]
        assert part.area == pytest.approx(np.pi * (1.1**2 - 0.3**2))


def test_samples_are_rotations_and_directions_and_well_spread() -> None:
    """Determinant one, unit length; no two near each other, and the gaps are those of an even spread."""
    R = rotations(300)
    np.testing.assert_allclose(R @ np.swapaxes(R, 1, 2), np.broadcast_to(np.eye(3), R.shape), atol=1e-14)
    assert (np.linalg.det(R) > 0.0).all()
    cosines = 0.5 * (np.einsum("aij,bij->ab", R, R) - 1.0)
    apart = np.arccos(np.clip(cosines - 3.0 * np.eye(300), -1.0, 1.0))
    # 300 balls of this radius fill the volume pi^2 of all rotations: (angle - sin(angle)) / pi = 1 / 300.
    nearest = apart.min(axis=1)
    assert nearest.min() > 0.35 and nearest.max() < 0.9
    d = directions(200)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1.0)
    assert np.linalg.norm(d.mean(axis=0)) < 1e-2
    np.testing.assert_array_equal(rotations(300), R)


@pytest.mark.parametrize("name", ["zyyzyz_6r", "puma_560", "positioning_3r", "scara_rrpr", "planar_2r"])
def test_counts_are_those_of_ik(name: str) -> None:
    """Every pose of the map, taken one by one: solutions, within limits, branches, manipulability, margin."""
    arm = urdf_ik.load(name)
    size = arm.chain.size
    found = workspaces.workspace(arm, 0.35 * size, 6, manipulability=True, margin=True)
    assert found.reached.any() and not found.reached.all()
    rng = np.random.default_rng(1)
    places = np.argwhere(found.counts >= 0)
    chosen = np.concatenate([places[rng.permutation(len(places))[:60]], np.argwhere(found.counts > 0)[:40]])
    for i, j, k, s in chosen:
        centre = np.array([found.grid.coordinates(axis)[place] for axis, place in enumerate((i, j, k))])
        target = target_of(arm, centre, found.samples[s])
        solutions = arm.ik(target, task=arm.task)
        inside = solutions.within_limits()
        assert found.solutions[i, j, k, s] == len(solutions)
        assert found.within[i, j, k, s] == found.counts[i, j, k, s] == len(inside)
        if not len(inside):
            assert np.isnan(found.manipulability[i, j, k, s]) and np.isnan(found.margin[i, j, k, s])
            continue
        part = "translation" if arm.task in ("position", "planar position") else "all"
        best = arm.manipulability(inside.to_array(), part).max()
        assert found.manipulability[i, j, k, s] == pytest.approx(best, rel=1e-6, abs=1e-9)
        lower, upper = arm.limits.T
        q = inside.to_array()
        share = np.minimum(q - lower, upper - q) / (0.5 * (upper - lower))
        assert found.margin[i, j, k, s] == pytest.approx(share.min(axis=1).max(), abs=1e-6)
    for i, j, k in np.argwhere(found.reached)[:3]:
        centre = np.array([found.grid.coordinates(axis)[place] for axis, place in enumerate((i, j, k))])
        targets = np.array([target_of(arm, centre, sample) for sample in found.samples])
        solved = arm.ik(targets, task=arm.task).within_limits()
        np.testing.assert_array_equal(found.branch_poses[i, j, k], solved.valid.sum(axis=0))


def target_of(arm: urdf_ik.Arm, centre: Array, sample: Array) -> Array:
    """The target of a voxel's centre and one sample."""
    if arm.task == "pose":
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = sample, centre
        return T
    return np.concatenate([centre[:2] if arm.task.startswith("planar") else centre, sample])


def test_the_map_does_not_depend_on_chunks_or_threads() -> None:
    """Any number of poses at a time, and of threads, gives the same arrays."""
    arm = urdf_ik.load("zyyzyz_6r")
    one = workspaces.workspace(arm, 0.9, 300, margin=True)
    for options in ({"chunk": 1}, {"chunk": 1777}, {"chunk": 10**6, "threads": 2}):
        other = workspaces.workspace(arm, 0.9, 300, margin=True, **options)
        for name in ("solutions", "within", "branch_poses", "margin"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_solutions_in_collision_are_left_out() -> None:
    """The free ones are those that the filter of the solutions leaves."""
    arm = urdf_ik.load("zyyzyz_6r")
    bounds = [[0.2, -0.3, 0.2], [0.8, 0.3, 1.4]]
    found = workspaces.workspace(arm, 0.6, 10, bounds=bounds, collision_free=True)
    assert found.about["counted"] == "free" and found.grid.shape == (1, 1, 2)
    targets = np.zeros((2, 10, 4, 4))
    targets[..., :3, :3], targets[..., 3, 3] = found.samples, 1.0
    targets[..., :3, 3] = found.grid.centres_in(found.grid.whole)[:, None]
    free = arm.ik(targets).within_limits().collision_free().count
    np.testing.assert_array_equal(found.free[0, 0], free)
    assert free.sum() < found.within.sum()


def test_a_file_gives_the_map_back(tmp_path: Path) -> None:
    """Every array, the header and the grid; the header is JSON with the arm's numbers, and there is no pickle."""
    arm = urdf_ik.load("zyyzyz_6r")
    path = tmp_path / "map.npz"
    found = workspaces.workspace(arm, 0.8, 7, manipulability=True, margin=True)
    found.save(path)
    again = workspaces.opened(path)
    assert again.about == found.about and again.grid.shape == found.grid.shape
    for name in ("samples", "solutions", "within", "branch_poses", "manipulability", "margin"):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
    assert again.free is None and [each.name for each in tmp_path.iterdir()] == ["map.npz"]
    with np.load(path, allow_pickle=False) as file:
        header = json.loads(str(file["header"]))
    assert header["version"] == 2 and header["base"] == arm.base and header["tip"] == arm.tip
    assert header["limits"] == arm.limits.tolist() and len(header["urdf_sha256"]) == 64
    assert header["grid"]["voxel"] == 0.8 and header["made_by"] == urdf_ik.__version__
    other = workspaces.workspace(urdf_ik.load("puma_560"), 1.0, 1)
    assert other.about["urdf_sha256"] != found.about["urdf_sha256"]


def test_questions_to_a_map() -> None:
    """Slices are layers, shares are counts."""
    arm = urdf_ik.load("positioning_3r")
    found = workspaces.workspace(arm, 0.05)
    layer = found.slice("z", 0.41, "solutions")
    k = int((0.41 - found.grid.lower[2]) / 0.05)
    np.testing.assert_array_equal(np.nan_to_num(layer.values), found.counts[:, :, k, 0])
    assert layer.axes == ("x", "y") and abs(layer.at - 0.41) <= 0.025
    shares = found.totals()["branches"]
    for b, name in enumerate(found.about["branches"]):
        assert shares[name]["voxels"] == pytest.approx(found.branch_poses[..., b].sum() / found.reached.sum())
    assert found.cell == pytest.approx(0.05**3)
    with pytest.raises(urdf_ik.ArgumentError):
        found.slice("z", 9.0)


def test_a_map_of_a_planar_arm_agrees_with_the_exact_region() -> None:
    """Voxel centres are reached where the region says so, by each branch."""
    arm = urdf_ik.load("planar_2r")
    found, region = workspaces.workspace(arm, 0.01), workspaces.planar(arm)
    x, y = np.meshgrid(found.grid.coordinates(0), found.grid.coordinates(1), indexing="ij")
    for b, name in enumerate(found.about["branches"]):
        np.testing.assert_array_equal(found.branch_poses[:, :, 0, b], region.reaches(np.stack([x, y], -1), name))


def test_a_map_that_does_not_fit_is_refused_before_any_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """An error with the numbers, and nothing was solved."""
    arm = urdf_ik.load("zyyzyz_6r")
    monkeypatch.setattr(urdf_ik.Arm, "ik", lambda *_, **__: pytest.fail("it was solved"))
    with pytest.raises(urdf_ik.ArgumentError, match=r"4600 x 4600 x 4600 voxels.*GiB of memory.*are free"):
        workspaces.workspace(arm, 0.001)


def test_arms_with_seven_joints_are_mapped_at_a_value_of_their_parameter() -> None:
    """The header holds the value; counts are those of ``ik`` there."""
    arm = urdf_ik.load("srs_7r")
    found = workspaces.workspace(arm, 0.5, 5, redundancy=0.4, within_limits=False)
    assert found.about["redundancy"] == 0.4 and found.about["counted"] == "solutions"
    i, j, k, s = np.argwhere(found.counts > 0)[0]
    centre = np.array([found.grid.coordinates(axis)[place] for axis, place in enumerate((i, j, k))])
    assert found.counts[i, j, k, s] == len(arm.ik(target_of(arm, centre, found.samples[s]), redundancy=0.4))


def test_the_command_prints_regions_and_maps(tmp_path: Path) -> None:
    """Exact areas of the two-link arm; a map's sums and its file; errors with their status."""
    text = succeed("workspace", "planar_2r", "--degrees")
    assert "elbow left" in text and "0.055573" in text
    path = tmp_path / "map.npz"
    text = succeed("workspace", "zyyzyz_6r", "--voxel", "0.6", "--orientations", "5", "-o", str(path))
    found = workspaces.opened(path)
    assert f" {found.solutions.sum()}\n" in text and "shoulder front" in text
    result = call("workspace", "zyyzyz_6r", "--voxel", "0.0001")
    assert result.exit_code == 2 and "of memory" in result.stderr
