"""Derivatives by a URDF's numbers, against Pinocchio's model of changed URDFs."""

import numpy as np
import pytest
from lxml import etree
from numpy.typing import NDArray

import urdf_ik
from urdf_ik.cell.pinocchio_reference import Reference
from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.derivatives import Parameter, written

Array = NDArray[np.float64]
STEP = 1e-6
# Turning and sliding joints, a base that is not the root, a joint that mimics another.
ARMS = (
    ("puma_560", None, None),
    ("stanford_rrprrr", None, None),
    ("srs_7r", None, None),
    ("puma_560", "tool0", "base_link"),
)


def changed(arm: urdf_ik.Arm, parameter: Parameter, by: float) -> str:
    """The arm's URDF with one number of an origin or axis changed."""
    root = etree.fromstring(arm.model.xml)
    joint = next(each for each in root.iter("joint") if each.get("name") == parameter.joint)
    tag, attribute = ("axis", "xyz") if parameter.field == "axis" else ("origin", parameter.field)
    element = joint.find(tag)
    if element is None:
        element = etree.SubElement(joint, tag, xyz="1 0 0" if tag == "axis" else "0 0 0")
    numbers = [float(each) for each in element.get(attribute, "0 0 0").split()]
    numbers[parameter.part] += by
    element.set(attribute, " ".join(map(repr, numbers)))
    return etree.tostring(root).decode()


def twist(before: Array, after: Array, middle: Array, step: float) -> Array:
    """The twist (..., 6) that leads from one pose to another in a step, at ``middle``."""
    rate = (after - before) / step
    spin = rate[..., :3, :3] @ np.swapaxes(middle[..., :3, :3], -1, -2)
    return np.concatenate([rate[..., :3, 3], spin[..., [2, 0, 1], [1, 2, 0]]], axis=-1)


@pytest.mark.parametrize(("name", "base", "tip"), ARMS)
def test_twists_are_those_of_pinocchio_with_the_number_changed(name: str, base: str | None, tip: str | None) -> None:
    """Every number of every origin and axis moves Pinocchio's tip as ``twists`` says."""
    arm = urdf_ik.load(name, base, tip)
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (3, arm.dof))
    geometry = written(arm.chain)
    twists, T = geometry.twists(q), Reference(arm.model, arm.base, arm.tip).pose(q)
    for k, parameter in enumerate(geometry.parameters):
        if parameter.field == "offset":
            continue
        ends = [Reference(changed(arm, parameter, by), arm.base, arm.tip).pose(q) for by in (-STEP, STEP)]
        np.testing.assert_allclose(twists[..., k], twist(*ends, T, 2.0 * STEP), atol=2e-9, err_msg=str(parameter))


@pytest.mark.parametrize(("name", "base", "tip"), ARMS)
def test_an_offset_moves_the_tip_as_its_joint(name: str, base: str | None, tip: str | None) -> None:
    """The twist of a joint's offset is Pinocchio's column of that joint, for a base above the tip too."""
    arm = urdf_ik.load(name, base, tip)
    q = np.random.default_rng(2).uniform(-1.5, 1.5, (3, arm.dof))
    twists = written(arm.chain).twists(q, parameters=[(joint, "offset", 0) for joint in arm.joint_names])
    np.testing.assert_allclose(twists, Reference(arm.model, arm.base, arm.tip).jacobian(q), atol=1e-12)


def test_poses_of_changed_numbers_are_pinocchios() -> None:
    """Forward kinematics with a number changed is Pinocchio's of the URDF with that number."""
    arm = urdf_ik.load("stanford_rrprrr")
    q = np.random.default_rng(3).uniform(-1.0, 1.0, (4, arm.dof))
    geometry = written(arm.chain)
    for k in (0, 4, 7, 8, 13, 21):
        values = geometry.values.copy()
        values[k] += 0.05
        theirs = Reference(changed(arm, geometry.parameters[k], 0.05), arm.base, arm.tip).pose(q)
        np.testing.assert_allclose(geometry.fk(q, values), theirs, atol=1e-12)


@pytest.mark.parametrize("wrong", [("joint_9", "xyz", 0), ("joint_2", "mass", 0), ("joint_2", "xyz", 3), "joint_2"])
def test_an_unknown_parameter_is_refused_with_the_valid_ones(wrong: object) -> None:
    """The error lists the joint's parameters, or the joints."""
    with pytest.raises(ArgumentError, match="joint_2"):
        written(urdf_ik.load("planar_2r").chain).columns([wrong])
