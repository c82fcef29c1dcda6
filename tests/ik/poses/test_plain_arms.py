"""Arms typed by hand from round numbers: zero lengths and slides, where solvers lose solutions."""

from collections.abc import Sequence

import numpy as np
import pytest
from cases import Array
from chains import joint, robot

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference

AXES = {"x": "1 0 0", "y": "0 1 0", "z": "0 0 1"}
OFFSETS = ("0 0 0", ".1 0 .05", "0 .2 .1", "0 .1 .25", ".25 .1 .1", ".1 .05 0")
SLIDES = '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
HALF = np.pi / 2.0


def typed(kinds: str, axes: str, origins: Sequence[str], tip: str = "0 0 0") -> urdf_ik.Arm:
    """An arm of continuous (R) and prismatic (P) joints, with the axes and the origins of its joints."""
    types = {"R": "continuous", "P": "prismatic"}
    joints = [
        joint(f"j{k}", types[kind], f"l{k - 1}", f"l{k}", origin, axis=AXES[axis], more="" if kind == "R" else SLIDES)
        for k, (kind, axis, origin) in enumerate(zip(kinds, axes, origins, strict=True), 1)
    ]
    return urdf_ik.load(robot(*joints, joint("flange", "fixed", f"l{len(kinds)}", "tip", tip)))


def missed(arm: urdf_ik.Arm, Q: Array) -> Array:
    """(m,) distance [rad, m] of each joint vector (m, n) to its pose's nearest solution; infinite without solutions.

    Every solution must reach the pose by Pinocchio.
    """
    reference = Reference(arm.model, arm.base, arm.tip)
    T = reference.pose(Q)
    s = arm.ik(T)
    for k in range(len(Q)):
        found = s[k].to_array()
        assert np.abs(reference.pose(found) - T[k]).max(initial=0.0) < 1e-9 * max(1.0, reference.size)
    off = np.where(arm.chain.prismatic, np.abs(s.q - Q[:, None]), np.abs(np.angle(np.exp(1j * (s.q - Q[:, None])))))
    return np.asarray(np.nan_to_num(off.max(axis=2), nan=np.inf).min(axis=1, initial=np.inf))


@pytest.mark.parametrize(
    ("kinds", "axes", "q"),
    [
        ("PRRRPR", "zxyxyz", [0.395, -1.117, -2.273, -1.058, 0.862, 1.738]),
        ("PRRRRP", "zxzyxy", [0.95, 0.073, -0.835, 0.457, 0.589, -0.524]),
        ("RRRRRP", "zxyxyz", [1.214, 0.0, -HALF, 0.0, HALF, 1.0]),
    ],
)
def test_arms_with_slides_find_the_pose_on_a_separate_surface(kinds: str, axes: str, q: list[float]) -> None:
    """The solutions of all poses of these arms form separate surfaces: the planted vector on another one is found."""
    assert missed(typed(kinds, axes, OFFSETS, "0 0 .1"), np.array([q]))[0] < 1e-8


@pytest.mark.parametrize("count", [5, pytest.param(90, marks=pytest.mark.slow)])
def test_regular_poses_of_arms_with_slides(count: int) -> None:
    """On random general arms with one to three slides all of 20 regular joint vectors each are found."""
    rng, arms = np.random.default_rng(2), 0
    while arms < count:
        kinds = np.array(list("RRRRRR"))
        kinds[rng.permutation(6)[: rng.choice([1, 1, 2, 3])]] = "P"
        offsets = rng.choice([0.0, 0.1, 0.2, 0.3], (6, 3)) * (rng.random((6, 1)) < 0.8)
        arm = typed("".join(kinds), "".join(rng.choice(list("xyz"), 6)), [" ".join(map(str, each)) for each in offsets])
        Q = rng.uniform(-np.pi, np.pi, (40, 6))
        Q[:, arm.chain.prismatic] *= max(arm.chain.size, 0.3) / np.pi
        scale = np.where(arm.chain.prismatic, arm.chain.size, 1.0)
        J = arm.jacobian(Q) / np.array([arm.chain.size] * 3 + [1.0] * 3)[:, None] * scale
        Q = Q[np.linalg.svd(J, compute_uv=False)[:, -1] > 1e-2][:20]
        try:
            off = missed(arm, Q)
        except urdf_ik.UnsupportedArm:
            continue
        assert (off < 1e-6).all()
        arms += len(Q) > 0


@pytest.mark.parametrize("noise", [0.0, 1e-12, 1e-9, 1e-8, 1e-7, 1e-6, 1e-4, 1e-2])
def test_axes_1_and_2_parallel_wrist_centre_on_axis_2_is_found(noise: float) -> None:
    """Axes 1 and 2 parallel, 3 meets 2: at the zero pose, and at joint 3 = 0, joint 2 barely moves the wrist centre."""
    arm = typed("RRRRRR", "zzyxyx", ("0 0 0", ".3 0 0", "0 0 0", "0 0 .25", "0 0 0", "0 0 0"))
    rng = np.random.default_rng(4)
    about_zero = noise * rng.uniform(-1.0, 1.0, (60, 6))
    third = rng.uniform(-3.0, 3.0, (60, 6))
    third[:, 2] = noise * rng.uniform(-1.0, 1.0, 60)
    for Q in (about_zero, third):
        least = np.linalg.svd(arm.jacobian(Q), compute_uv=False)[:, -1]
        off = missed(arm, Q)
        assert np.isfinite(off).all()
        assert (off < 1e-6 + 1e-11 / np.maximum(least, 1e-14)).all()


@pytest.mark.parametrize("noise", ["0", "1e-17", "1e-12", "1e-9", "1e-6", "1e-4"])
@pytest.mark.parametrize(
    ("kinds", "axes", "first"), [("PPP", "xyz", "0 0 0"), ("PPPR", "xyzz", "0 0 0"), ("RRR", "zyx", ".3 .1 1.2")]
)
def test_gantry_and_gimbal_with_a_rounding_step_lose_no_pose(kinds: str, axes: str, first: str, noise: str) -> None:
    """A gantry, and a gimbal 1.2 m up, whose only step is the rounded sine of a half turn: no pose is lost."""
    arm = typed(kinds, axes, [first, f"0 0 {noise}", *["0 0 0"] * (len(kinds) - 2)])
    Q = np.random.default_rng(1).uniform(-1.0, 1.0, (60, arm.dof))
    assert np.isfinite(missed(arm, Q)).all()
