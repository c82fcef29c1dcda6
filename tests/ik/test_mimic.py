"""Chains whose joints mimic others: Pinocchio's kinematics, every solution, limits, images, and clear refusals."""

import math

import chains
import numpy as np
import pinocchio as pin
import pytest
from arms import Y, Z, random_arm
from arms_few import few_urdf
from arms_mimic import LINKAGES, limited, linkage, mimicking
from numpy.typing import NDArray
from searches import newton
from with_reference import arm_and_reference, distances, holds, scaled_jacobian

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UnsupportedArm
from urdf_ik.kinematics.chain.mimic import CoupledChain
from urdf_ik.verify.crosscheck import check

Array = NDArray[np.float64]


def drawn(reference: Reference, count: int, seed: int = 1) -> Array:
    """Joint vectors (count, n) within the limits."""
    lower, upper = reference.ranges.T
    return np.random.default_rng(seed).uniform(lower, upper, (count, reference.dof))


@pytest.mark.parametrize("name", LINKAGES)
def test_kinematics_are_pinocchios(name: str) -> None:
    """Names, limits, poses and Jacobians, of the links beside the tip too, are those that Pinocchio computes."""
    for seed in range(4):
        arm, reference = arm_and_reference(linkage(name, seed))
        assert arm.joint_names == reference.joint_names
        assert arm.dof == len(LINKAGES[name].images)
        assert tuple(arm.chain.image_turns) == LINKAGES[name].images
        np.testing.assert_allclose(arm.limits, reference.limits, atol=1e-15)
        q = drawn(reference, 5)
        np.testing.assert_allclose(arm.fk(q), reference.pose(q), atol=1e-13)
        np.testing.assert_allclose(arm.jacobian(q), reference.jacobian(q), atol=1e-13)
        for link, pose in arm.link_poses(q).items():
            np.testing.assert_allclose(pose, reference.link_poses(q)[link], atol=1e-13)
        assert isinstance(arm.chain, CoupledChain)
        np.testing.assert_allclose(arm.chain.reversed().fk(q[:, ::-1]), np.linalg.inv(reference.pose(q)), atol=1e-13)


def test_against_pinocchio_that_mimics_by_itself() -> None:
    """Pinocchio's own mimic joints give the same pose and the same Jacobian."""
    text = linkage("palletizer", 1)
    arm = urdf_ik.load(text, "base", "tool")
    model = pin.buildModelFromXML(text, mimic=True)
    data = model.createData()
    base, tip = (model.getFrameId(link, pin.FrameType.BODY) for link in ("base", "tool"))
    for q in np.random.default_rng(0).uniform(-3.0, 3.0, (5, 3)):
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        np.testing.assert_allclose(arm.fk(q), data.oMf[base].actInv(data.oMf[tip]).homogeneous, atol=1e-13)
        J = pin.getFrameJacobian(model, data, tip, pin.LOCAL_WORLD_ALIGNED)
        turn = data.oMf[base].rotation.T
        np.testing.assert_allclose(arm.jacobian(q), np.vstack([turn @ J[:3], turn @ J[3:]]), atol=1e-13)


@pytest.mark.parametrize("name", LINKAGES)
def test_planted_vectors_are_found(name: str) -> None:
    """The planted joint vector is found; all solutions are exact, and none is given twice."""
    for seed in range(3):
        arm, reference = arm_and_reference(linkage(name, seed))
        holds(arm, reference, drawn(reference, 12, seed))


@pytest.mark.parametrize("name", [n for n in LINKAGES if n != "palletizer with wrist"])
def test_nothing_is_missing(name: str) -> None:
    """Every solution that Newton's method finds from many starts over the whole joint space is there."""
    rng = np.random.default_rng(7)
    arm, reference = arm_and_reference(linkage(name, 3))
    turns = np.array(LINKAGES[name].images, dtype=np.float64)
    lower, upper = (
        np.where(turns, side * math.pi * turns, limit) for side, limit in zip((-1, 1), arm.limits.T, strict=True)
    )
    for planted in drawn(reference, 3, 5):
        target = reference.pose(planted)
        found = arm.ik(target).to_array()
        starts = rng.uniform(lower, upper, (60, arm.dof))
        for q in newton(reference.pose, reference.jacobian, reference.size, target, starts, 1e-3):
            if ((q >= lower) & (q <= upper) | (turns > 0.0)).all():
                assert distances(arm, found, q).min() < 1e-6


@pytest.mark.parametrize("name", ["planar 4R, one follows", "palletizer, tool kept upright"])
def test_at_and_near_singularities(name: str) -> None:
    """Where the Jacobian loses rank, and 1e-1 to 1e-7 rad beside that, the planted vector is found."""
    met = 0
    for seed in range(6):
        arm, reference = arm_and_reference(linkage(name, seed))
        singular = a_singularity(reference, seed)
        if singular is None:
            continue
        met += 1
        q, joint = singular
        s = arm.ik(reference.pose(q))
        assert s.singular.any()
        assert max(e.max() for e in reference.errors(s.to_array(), reference.pose(q))) <= 1e-9
        for k in range(1, 8):
            beside = q.copy()
            beside[joint] += 10.0**-k
            sigma = np.linalg.svd(scaled_jacobian(reference, beside), compute_uv=False)[-1]
            found = arm.ik(reference.pose(beside)).to_array()
            assert distances(arm, found, beside).min() < 1e-6 + 1e-11 / sigma
    assert met


def test_last_axis_on_the_first_gives_a_marked_representative() -> None:
    """With the last axis on the first only the sum of their angles counts: an exact, marked representative."""
    heights = [0.0, 0.3, 0.7, 1.1, 1.1, 1.2]
    axes = np.array([Z, Y, Y, Y, Y, Z])
    text = few_urdf("R" * 6, axes, np.array(heights)[:, None] * Z, 1.25 * Z, np.random.default_rng(0))
    text = mimicking(mimicking(text, 4, "joint_2", -1.0), 5, "joint_3", -1.0)
    arm, reference = urdf_ik.load(text, "base", "tool"), Reference(text, "base", "tool")
    target = reference.pose([0.3, 0.5, -1.0, 0.2])
    s = arm.ik(target)
    assert s.singular.any()
    assert max(e.max() for e in reference.errors(s.to_array(), target)) <= 1e-9
    np.testing.assert_allclose(np.sin(s.to_array()[:, [0, 3]].sum(axis=1)), math.sin(0.5), atol=1e-9)


def a_singularity(reference: Reference, seed: int) -> tuple[Array, int] | None:
    """A joint vector at which the smallest singular value vanishes along one joint, and that joint."""
    for q in drawn(reference, 10, seed):
        for joint in range(reference.dof):
            x = q.copy()

            def least(value: float, x: Array = x, joint: int = joint) -> float:
                x[joint] = value
                return float(np.linalg.svd(scaled_jacobian(reference, x), compute_uv=False)[-1])

            values = np.linspace(-math.pi, math.pi, 61)
            k = int(np.argmin([least(v) for v in values]))
            low, high = values[k] - 0.11, values[k] + 0.11
            for _ in range(90):
                a, b = low + 0.381966 * (high - low), low + 0.618034 * (high - low)
                low, high = (low, b) if least(a) < least(b) else (a, high)
            if least(0.5 * (low + high)) < 1e-10:
                return x, joint
    return None


@pytest.mark.parametrize("name", LINKAGES)
def test_poses_out_of_reach(name: str) -> None:
    """A pose that the arm does not reach has no solution, and the explanation names a number or the joints."""
    arm, reference = arm_and_reference(linkage(name, 0))
    T = reference.pose(drawn(reference, 2))
    T[0, :3, 3] += 1e3
    T[1, :3, :3] = T[1, :3, :3] @ pin.exp3(np.array([0.3, 0.5, -0.4]))
    s = arm.ik(T)
    assert not s.valid.any()
    assert all("m from axis 1" in why or arm.joint_names[0] in why for why in s.explain().splitlines())
    assert arm.ik(T[:0]).shape == (0,)
    with pytest.raises(urdf_ik.PoseError):
        arm.ik(np.full((4, 4), np.nan))


def test_halves_linkage_repeats_after_two_turns() -> None:
    """A joint that drives another by 3/2 repeats after two turns; one turn more is another solution, or none."""
    text = limited(limited(limited(linkage("halves", 0), 1, -20.0, 20.0), 2, -99.0, 99.0), 3, -3.0, 3.0)
    arm, reference = urdf_ik.load(text, "base", "tool"), Reference(text, "base", "tool")
    q = np.array([0.5, -0.8])
    s = arm.ik(reference.pose(q))
    assert np.abs(s.to_array()).max() <= 2.0 * math.pi
    images = s.turns()
    assert len(images) > len(s)
    assert max(e.max() for e in reference.errors(images.to_array(), reference.pose(q))) < 1e-9
    assert any("q1+720°" in one.branch for one in images)
    assert not any("q1+360°" in one.branch for one in images)
    far = q + [4.0 * math.pi, 0.0]
    np.testing.assert_allclose(images.nearest(far)[0].q, far, atol=1e-9)
    lower, upper = arm.limits.T
    assert ((images.to_array() >= lower - 1e-9) & (images.to_array() <= upper + 1e-9)).all()


def test_limits_of_a_driver_and_its_followers() -> None:
    """A joint's limits are those that its followers allow, unless these allow nothing at all."""
    plain = random_arm("wrist, 2||3", 3).urdf

    def limits(multiplier: float, offset: float, lower: float, upper: float) -> Array:
        text = limited(limited(mimicking(plain, 3, "joint_2", multiplier, offset), 2, -1.0, 2.0), 3, lower, upper)
        arm, reference = urdf_ik.load(text, "base", "tool"), Reference(text, "base", "tool")
        np.testing.assert_allclose(arm.limits, reference.limits, atol=1e-15)
        return arm.limits[arm.joint_names.index("joint_2")]

    np.testing.assert_allclose(limits(-2.0, 0.5, -1.5, 5.0), [-1.0, 1.0])
    np.testing.assert_allclose(limits(0.5, 0.0, -0.25, 9.0), [-0.5, 2.0])
    np.testing.assert_allclose(limits(1.0, 0.0, 0.0, 0.0), [-1.0, 2.0])
    np.testing.assert_allclose(limits(1.0, 50.0, -1.0, 1.0), [-1.0, 2.0])


@pytest.mark.parametrize("multiplier", [1.0, -1.0])
def test_a_driver_beside_the_chain(multiplier: float) -> None:
    """A joint that mimics one beside the chain is free in effect, by the other's name; an arm of six is then one."""
    plain = random_arm("wrist, 2||3", 2).urdf
    crank = '<link name="crank"/>' + chains.joint("crank", "revolute", "base", "crank", axis="0 0 1")
    text = mimicking(plain, 2, "crank", multiplier, 0.3).replace("</robot>", f"{crank}</robot>")
    arm, reference = urdf_ik.load(text, "base", "tool"), Reference(text, "base", "tool")
    assert arm.joint_names == ("joint_1", "crank", "joint_3", "joint_4", "joint_5", "joint_6") == reference.joint_names
    assert arm.structure.family == urdf_ik.load(plain, "base", "tool").structure.family
    planted = drawn(reference, 10)
    np.testing.assert_allclose(arm.fk(planted), reference.pose(planted), atol=1e-13)
    np.testing.assert_allclose(arm.jacobian(planted), reference.jacobian(planted), atol=1e-13)
    s = arm.ik(reference.pose(planted))
    gap = np.abs((s.q - planted[:, None] + math.pi) % (2.0 * math.pi) - math.pi).max(axis=-1)
    assert np.nanmin(gap, axis=-1).max() < 1e-7
    np.testing.assert_allclose(
        arm.link_poses(planted[0])["crank"], reference.link_poses(planted[0])["crank"], atol=1e-13
    )


def test_held_joints() -> None:
    """A held driver holds what mimics it; the arm that is left is plain where nothing mimics any more."""
    text = linkage("palletizer with wrist", 0)
    for locked in ({"joint_2": 0.4}, {"joint_2": 0.4, "joint_3": -0.3}, {"joint_1": 1.0}):
        arm, reference = (
            urdf_ik.load(text, "base", "tool", locked=locked),
            Reference(text, "base", "tool", locked=locked),
        )
        assert arm.joint_names == reference.joint_names
        q = drawn(reference, 4)
        np.testing.assert_allclose(arm.fk(q), reference.pose(q), atol=1e-13)
        np.testing.assert_allclose(arm.jacobian(q), reference.jacobian(q), atol=1e-13)
        assert isinstance(arm.chain, CoupledChain) == ("joint_3" not in locked)
        assert {each.driver for each in arm.chain.followers} == {"joint_2", "joint_3"} - set(locked)


def refused() -> dict[str, tuple[str, str]]:
    """URDF text of arms that are not solved, and words of the reason."""
    endless = linkage("of no fraction", 0)
    for joint in (2, 3):
        endless = limited(endless, joint, -math.inf, math.inf)
    return {
        "five": (mimicking(random_arm("wrist, 2||3", 1).urdf, 4, "joint_2", -1.0), "at most 4 independent ones"),
        "endless": (endless, "'joint_2'.*0.707107.*does not repeat"),
    }


@pytest.mark.parametrize("case", ["five", "endless"])
def test_what_is_refused(case: str) -> None:
    """An arm that is not solved loads, has its kinematics, and says which joints are the reason when asked for more."""
    text, reason = refused()[case]
    arm, reference = urdf_ik.load(text, "base", "tool"), Reference(text, "base", "tool")
    q = drawn(reference, 3)
    np.testing.assert_allclose(arm.fk(q), reference.pose(q), atol=1e-13)
    with pytest.raises(UnsupportedArm, match=reason) as error:
        arm.ik(arm.fk(q))
    assert "joint_" in str(error.value)
    assert "independent:" in str(error.value)


@pytest.mark.parametrize("name", ["planar, forearm kept", "halves", "palletizer", "telescope"])
def test_the_cross_check_passes(name: str) -> None:
    """``check`` finds nothing against such an arm, collision of its shapes included."""
    box = "<collision><geometry><box size='0.05 0.05 0.05'/></geometry></collision>"
    text = linkage(name, 1)
    for link in ("base", "link_1", "link_2", "tool"):
        text = text.replace(f'<link name="{link}" />', f'<link name="{link}">{box}</link>')
    arm = urdf_ik.load(text, "base", "tool")
    report = check(arm, 20, collision=True)
    assert report.passed, str(report)
    q = drawn(Reference(text, "base", "tool"), 3)
    assert arm.ik(arm.fk(q)).collision_free().valid.shape == arm.ik(arm.fk(q)).valid.shape
    assert arm.structure.cuspidal is None
    assert arm.manipulability(q).shape == (3,)
