"""A free axis of the tip: solutions and the nearest ones by Pinocchio, refusals, and the arm without a value."""

import pickle

import numpy as np
import pytest
from cases import from_catalogue, vectors
from numpy.typing import NDArray

import urdf_ik
from urdf_ik import ArgumentError, PoseError, UnsupportedArm
from urdf_ik.cell.pinocchio_reference import Reference

Array = NDArray[np.float64]

AXES = {
    "z": ("z", None),
    "x through a point": ("x", (0.02, -0.05, 0.1)),
    "oblique through a point": ((1.0, -2.0, 0.5), (0.1, 0.0, 0.2)),
}

NAMES = ("ur5", "puma_560", "zyyzyz_6r", "dh_6r")


def turned(axis: str | tuple[float, ...], at: tuple[float, ...] | None, values: Array) -> Array:
    """Rotations (..., 4, 4) about an axis through a point, by Pinocchio's exponential."""
    import pinocchio as pin

    h = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.array(axis) / np.linalg.norm(axis)
    p = np.zeros(3) if at is None else np.array(at)
    out = [pin.exp6(pin.Motion(-v * np.cross(h, p), v * h)).homogeneous for v in np.ravel(values)]
    return np.array(out).reshape(*np.shape(values), 4, 4)


@pytest.mark.parametrize("case", AXES)
@pytest.mark.parametrize("name", NAMES)
def test_solutions_reach_the_target_turned_by_the_value(name: str, case: str) -> None:
    """By Pinocchio each solution's pose is the target turned about the axis; none is lost, the value is read back."""
    axis, at = AXES[case]
    plain = urdf_ik.load(name)
    arm = plain.with_free_axis(axis, at)
    assert (arm.dof, arm.joint_names, arm.tip) == (6, plain.joint_names, plain.tip)
    assert arm.redundancy is not None
    assert (arm.redundancy.kind, arm.redundancy.default, arm.redundancy.round) == ("free axis", 0.0, True)
    rng = np.random.default_rng(1)
    q, values = vectors(arm, 30), rng.uniform(-np.pi, np.pi, 30)
    reference = Reference(arm.model, arm.base, arm.tip)
    target = reference.pose(q) @ np.linalg.inv(turned(axis, at, values))
    found = arm.ik(target, redundancy=values)
    position, rotation = reference.errors(found.q, (target @ turned(axis, at, values))[:, None])
    assert np.nanmax(position) < 1e-9
    assert np.nanmax(rotation) < 1e-9
    apart = np.abs(np.exp(1j * found.q) - np.exp(1j * q[:, None])).max(axis=2)
    assert np.nanmax(np.nanmin(apart, axis=1)) < 1e-6
    np.testing.assert_allclose(np.exp(1j * arm.redundancy_of(q, target)), np.exp(1j * values), atol=1e-9)
    assert not arm.redundancy_of(q).any()


def test_without_a_value_it_is_the_arm() -> None:
    """At the default the solutions are those of the arm, to the last bit; a batch is its members."""
    plain = urdf_ik.load("ur5")
    arm = plain.with_free_axis("z", at=(0.0, 0.01, 0.2))
    T = plain.fk(vectors(plain, 40))
    for pose in (T, T[0]):
        np.testing.assert_array_equal(arm.ik(pose).q, plain.ik(pose).q)
    values = np.linspace(-4.0, 4.0, 40)
    batch = arm.ik(T, redundancy=values)
    for k in range(40):
        np.testing.assert_array_equal(arm.ik(T[k], redundancy=values[k]).q, batch.q[k])
    assert arm.solver.fixed is plain.solver
    again = pickle.loads(pickle.dumps(arm))
    np.testing.assert_array_equal(again.ik(T, redundancy=values).q, batch.q)
    assert again.solver.fixed.parameter is None


@pytest.mark.parametrize("name", ["ur5", "zyyzyz_6r"])
def test_the_nearest_solution_is_no_farther_than_a_dense_scan_finds(name: str) -> None:
    """Of 3600 rotations none has a nearer solution inside the limits, and the answer reaches position and direction."""
    arm = urdf_ik.load(name).with_free_axis("z")
    assert arm.solver.free_axis is not None
    reference = Reference(arm.model, arm.base, arm.tip)
    q, near = vectors(arm, 8, 2), vectors(arm, 8, 3)
    T = reference.pose(q)
    found = arm.ik_nearest(T, near)
    for k in range(8):
        scan = arm.ik(T[k], redundancy=np.linspace(-np.pi, np.pi, 3600)).within_limits()
        every = scan.turns().q
        least = np.nanmin(np.linalg.norm(every - near[k], axis=-1))
        assert np.linalg.norm(found.q[k, 0] - near[k]) <= least + 1e-9
        far, off = arm.solver.free_axis.apart(reference.pose(found.q[k, 0]), T[k])
        assert max(far, off) < 1e-9
        np.testing.assert_allclose(arm.redundancy_of(found.q[k, 0], T[k]), found.redundancy[k], atol=1e-9)


def test_an_axis_that_is_the_last_joints_moves_only_that_joint() -> None:
    """The UR5's tip turned about its z axis is joint 6 turned: the solutions differ in it alone."""
    arm = urdf_ik.load("ur5").with_free_axis("z")
    q = vectors(arm, 10, 4)
    reference = Reference(arm.model, arm.base, arm.tip)
    # The description's tool0 lies on joint 6's axis; its z is that axis.
    straight = q.copy()
    straight[:, 5] += 0.3
    assert arm.solver.free_axis is not None
    far, off = arm.solver.free_axis.apart(reference.pose(q), reference.pose(straight))
    assert max(far.max(), off.max()) < 1e-11
    before, after = arm.ik(arm.fk(q)), arm.ik(arm.fk(q), redundancy=0.3)
    np.testing.assert_allclose(after.q[..., :5], before.q[..., :5], atol=1e-9)
    every = arm.intervals(arm.fk(q[0]), within_limits=False).merged()
    assert every.round(6).tolist() == [[-3.141593, 3.141593]]


def test_seven_joints_have_two_parameters() -> None:
    """The rotation first, the arm's own value second; both are read back, and the pose is right by Pinocchio."""
    case = from_catalogue("panda")
    arm = case.arm.with_free_axis("z", at=(0.0, 0.0, 0.1))
    assert [each.kind for each in arm.solver.parameters] == ["free axis", case.arm.redundancy.kind]
    q = vectors(arm, 20, 5)
    v = np.random.default_rng(6).uniform(-1.0, 1.0, 20)
    T = case.oracle.poses(q) @ np.linalg.inv(turned("z", (0.0, 0.0, 0.1), v))
    values = np.column_stack([v, case.arm.redundancy_of(q)])
    np.testing.assert_allclose(arm.redundancy_of(q, T), values, atol=1e-9)
    found = arm.ik(T, redundancy=values)
    assert found.redundancy.shape == (20, 2)
    assert np.nanmax(np.nanmin(np.abs(found.q - q[:, None]).max(axis=2), axis=1)) < 1e-6
    for k in range(20):
        np.testing.assert_array_equal(arm.ik(T[k], redundancy=values[k]).q, found.q[k])
    with pytest.raises(ArgumentError, match="2 parameters"):
        arm.ik(T, redundancy=v)


def test_empty_batches() -> None:
    """An empty batch has no values; ``explain`` takes one value of each parameter."""
    arm = urdf_ik.load("srs_7r").with_free_axis("z")
    T = arm.fk([0.3] * 7)
    assert arm.redundancy_of(np.zeros((0, 7)), T).shape == (0, 2)
    assert arm.redundancy_of(np.zeros((2, 0, 7)), np.zeros((2, 0, 4, 4))).shape == (2, 0, 2)
    for values in (np.zeros((0, 2)), np.zeros((3, 2))):
        with pytest.raises(ArgumentError, match="one value of each of the 2 parameters"):
            arm.explain(T, redundancy=values)


def test_free_axes_that_are_refused() -> None:
    """Invalid axes, arms that control less, a second axis, a tool behind it, joint vectors of another target."""
    arm = urdf_ik.load("puma_560")
    free = arm.with_free_axis("z")
    for axis, at in (("w", None), ((0, 0, 0), None), ("z", (1.0, 2.0)), ((1.0, np.nan, 0.0), None)):
        with pytest.raises(ArgumentError):
            arm.with_free_axis(axis, at)
    with pytest.raises(ArgumentError, match="only one axis"):
        free.with_free_axis("x")
    with pytest.raises(ArgumentError, match="mount the tool first"):
        free.with_tool(urdf_ik.pose([0.0, 0.0, 0.1]))
    with pytest.raises(ArgumentError, match="'position'"):
        urdf_ik.load("positioning_3r").with_free_axis("z")
    for few in (urdf_ik.load("scara_rrpr"), arm.with_locked({"joint_5": 0.3, "joint_6": 0.0})):
        with pytest.raises(ArgumentError, match="its 4 joints do not reach every pose, .* six joints or more"):
            few.with_free_axis("z")
    with pytest.raises(ArgumentError, match="without a free axis"):
        free.for_task("position")
    with pytest.raises(ArgumentError, match="does not reach"):
        free.redundancy_of(np.zeros(6), free.fk(np.ones(6)))
    with pytest.raises(UnsupportedArm, match="whole poses"):
        free.tracker(np.zeros(6), dt=0.01)
    with pytest.raises(PoseError):
        free.redundancy_of(np.zeros(6), np.ones((4, 4)))


def test_an_empty_answer_is_explained() -> None:
    """The reason is that of the turned target, and says that no other rotation helps."""
    arm = urdf_ik.load("zyyzyz_6r").with_free_axis("z")
    assert arm.explain(urdf_ik.pose([0.0, 0.0, 4.0])).endswith("nor at other values")
    tilted = urdf_ik.load("zyyzyz_6r").with_free_axis("z", at=(0.0, 0.5, 0.0))
    T = urdf_ik.pose([0.0, 1.0, 2.7], rpy=[0.0, 0.0, np.pi])
    answer = tilted.ik(T)
    assert answer.count or "there are solutions at" in answer.explain()
