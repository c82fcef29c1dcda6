"""Arms whose workpiece is carried by a positioner."""

from typing import Any

from urdf_ik.arm.arm import Arm, assemble
from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.chain import from_urdf
from urdf_ik.model.poses import check_poses
from urdf_ik.model.urdf.edits import joined
from urdf_ik.model.xml import require_name
from urdf_ik.support import inputs


def with_positioner(arm: Arm, positioner: Arm, pose: Any, name: str = "positioner") -> Arm:
    """An arm with a positioner from another URDF that carries the workpiece; poses are in the positioner's tip frame.

    The new arm is the chain from the positioner's tip, back to its base, and up the arm: its base is the link
    ``f"{name}_{positioner.tip}"``, its first joints are the positioner's, from its tip to its base. The
    joints beyond six give redundancy parameters. For a positioner in the same URDF, ``load(..., base=workpiece)`` is
    enough.

    Args:
        arm: the arm.
        positioner: the chain from its base to the link that carries the workpiece, as ``load`` returns it.
        pose: (4, 4) m of the positioner's root link in the arm's base, or a ``pinocchio.SE3``.
        name: prefix of the names of the positioner's links and joints.

    Raises:
        PoseError: an invalid pose.
        ArgumentError: a name is taken, or ``name`` is not valid in a URDF.
        UnsupportedArm: no solver takes the joints.

    Example:
        >>> import urdf_ik
        >>> from urdf_ik.arm import with_positioner
        >>> table = urdf_ik.load("planar_2r", tip="link_1")
        >>> cell = with_positioner(urdf_ik.load("puma_560"), table, urdf_ik.pose([0.6, 0.0, 0.2]), name="table")
        >>> cell.base, cell.dof, cell.redundancy.joint
        ('table_link_1', 7, 'table_joint_1')
    """
    inputs.arm(arm)
    inputs.arm(positioner, "positioner")
    at = check_poses(pose)
    if at.ndim != 2:
        raise ArgumentError(f"a pose of shape {at.shape} given; one pose (4, 4) is needed")
    require_name(name, "the positioner")
    model = joined(arm.model, positioner.model, arm.base, at, f"{name}_")
    held = {**dict(arm.chain.locked), **{f"{name}_{joint}": value for joint, value in positioner.chain.locked}}
    chain = from_urdf(model, f"{name}_{positioner.tip}", arm.tip).lock(held)
    before = arm.solver
    return assemble(
        model,
        chain,
        task=before.task,
        free_axis=before.free_axis,
        chosen=before.chosen,
        cell=arm.cell.moved_to(model, chain),
    )
