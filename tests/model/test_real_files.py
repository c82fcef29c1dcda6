"""Every URDF of example-robot-data, and those of robot_descriptions that are here: loaded limb by limb, and solved.

By default a limb of each file answers a few poses; with URDF_IK_SWEEP=all every chain of at most seven joints answers
24 random and 24 round ones, which takes some minutes.
"""

import os
from pathlib import Path

import numpy as np
import pytest

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import UnsupportedArm, UrdfError
from urdf_ik.model import catalogue, downloads
from urdf_ik.model.urdf import UrdfModel, read

WHOLE = os.environ.get("URDF_IK_SWEEP") == "all"
COUNT = 24 if WHOLE else 2
REGULAR = 1e-3
"""Least singular value of the Jacobian, lengths in units of the arm's size, from which a joint vector is regular."""
NO_CHAIN = {  # files that hold no arm, and why
    "ur_description/urdf/ur3.urdf": "there is no <link>",
    "hector_description/robots/quadrotor_base.urdf": "no movable chain",
    "iris_description/robots/iris_simple.urdf": "no movable chain",
}


def _files() -> dict[str, Path]:
    """Every URDF that is here, by its path below the robots of its package."""
    try:
        robots = catalogue.resolve("ur5").path.parents[2]
    except urdf_ik.ArgumentError:
        return {}
    files = {str(path.relative_to(robots)): path for path in sorted(robots.rglob("*.urdf"))}
    for name in downloads.names():
        if downloads.is_here(name) and not catalogue.resolve(name).path.is_relative_to(robots):
            files[name] = catalogue.resolve(name).path
    return files


FILES = _files()


def _chains(model: UrdfModel) -> dict[str, tuple[str, str]]:
    """Base and tip of each limb with at most seven joints; of the longest one unless all are asked for."""
    limbs = sorted((limb for limb in model.limbs() if len(limb.joints) <= 7), key=lambda limb: -len(limb.joints))
    return {limb.name: (limb.base, limb.tip) for limb in (limbs if WHOLE else limbs[:1])}


def _vectors(reference: Reference, rng: np.random.Generator) -> np.ndarray:
    """Random joint vectors, and round ones: multiples of a quarter of a turn and of 0.1 m."""
    lower, upper = reference.ranges.T
    random = rng.uniform(lower, upper, (COUNT, reference.dof))
    steps = np.where(reference.prismatic, 0.1, np.pi / 4.0)
    return np.concatenate([random, np.round(rng.uniform(lower, upper, (COUNT, reference.dof)) / steps) * steps])


def _is_regular(arm: urdf_ik.Arm, J: np.ndarray, q: np.ndarray) -> bool:
    """Whether the solution at a joint vector is alone: at its redundancy parameter, too, where there is one."""
    _, sizes, rows = np.linalg.svd(J)
    if sizes[min(arm.dof, 6) - 1] < REGULAR:
        return False
    if arm.dof < 7:
        return True
    step = 1e-4 * rows[6]  # the way on which the tip stands still
    change = np.angle(np.exp(1j * (arm.redundancy_of(q + step) - arm.redundancy_of(q - step)))) / 2e-4
    return bool(0.03 < np.abs(change) < 30.0)


@pytest.mark.skipif(not FILES, reason="example-robot-data is not installed")
@pytest.mark.parametrize("name", FILES)
def test_every_file_loads_or_is_refused_for_its_chains(name: str) -> None:
    """Each limb's poses are reached to 1e-9, and a regular joint vector is among the solutions of its pose."""
    if name in NO_CHAIN:
        with pytest.raises((UrdfError, urdf_ik.ChainError), match=NO_CHAIN[name]):
            urdf_ik.load(FILES[name])
        return
    model, rng = read(FILES[name]), np.random.default_rng(0)
    chains = _chains(model)
    assert chains
    for limb, (base, tip) in chains.items():
        arm, reference = urdf_ik.load(FILES[name], base, tip), Reference(model, base, tip)
        assert arm.joint_names == reference.joint_names
        scale = np.array([1.0 / arm.chain.size] * 3 + [1.0] * 3)[:, None]
        for q in _vectors(reference, rng):
            T = reference.pose(q)
            try:
                value = None if arm.redundancy is None else arm.redundancy_of(q)
                found = arm.ik(T, redundancy=value).to_array()
            except UnsupportedArm as error:
                assert "lock" in str(error), (limb, str(error))
                break
            assert len(found), (limb, q)
            position, angle = reference.errors(found, T)
            assert max(position.max() / max(arm.chain.size, 1.0), angle.max()) < 1e-9, (limb, q)
            if _is_regular(arm, reference.jacobian(q) * scale, q):
                off = np.abs(np.where(arm.chain.prismatic, found - q, np.angle(np.exp(1j * (found - q)))))
                assert off.max(axis=1).min() < 1e-6, (limb, q)


@pytest.mark.skipif(not FILES, reason="example-robot-data is not installed")
def test_icub_loads_with_a_length_that_rounding_left() -> None:
    """Its neck has an origin of 5.8e-34 m, which is zero, in the chain too."""
    arm = urdf_ik.load(FILES["icub_description/robots/icub.urdf"], chain="head")
    assert "neck_yaw" in arm.joint_names and arm.model.warnings == ()


@pytest.mark.skipif(not FILES, reason="example-robot-data is not installed")
def test_limbs_have_the_names_that_people_use() -> None:
    """A humanoid's limbs begin where they part from the trunk; the legs of a quadruped have numbers."""
    g1 = FILES["g1_description/urdf/g1_29dof_with_hand_rev_1_0.urdf"]
    limbs = {limb.name: len(limb.joints) for limb in read(g1).limbs()}
    assert {name: limbs[name] for name in ("left_arm", "right_arm", "left_leg", "right_leg", "torso")} == {
        "left_arm": 7, "right_arm": 7, "left_leg": 6, "right_leg": 6, "torso": 3,
    }  # fmt: skip
    arm = urdf_ik.load(g1, chain="left_arm")
    assert (arm.base, arm.dof) == ("torso_link", 7)
    four = [limb.name for limb in read(FILES["go1_description/urdf/go1.urdf"]).limbs()]
    assert len(set(four)) == 4 and all("leg" in name for name in four)


@pytest.mark.skipif(not FILES, reason="example-robot-data is not installed")
def test_groups_of_the_srdf_beside_a_file_are_found() -> None:
    """Talos' SRDF lies in the folder beside, and calls its arm l_arm; a group that it lacks is a limb."""
    file = FILES["talos_data/robots/talos_reduced.urdf"]
    group, limb = urdf_ik.load(file, chain="l_arm"), urdf_ik.load(file, chain="left_arm")
    assert (group.base, group.tip) == ("torso_2_link", "wrist_left_ft_tool_link")
    assert group.joint_names == limb.joint_names
    with pytest.raises(urdf_ik.ChainError, match="did you mean 'left_arm'"):
        urdf_ik.load(file, chain="lefd_arm")
