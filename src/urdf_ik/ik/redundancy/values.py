"""The redundancy parameters of given joint vectors."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError, UnsupportedArm
from urdf_ik.ik.families import FamilyMember
from urdf_ik.ik.solver import Solver
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.kinematics.chain.serial import filled
from urdf_ik.model.poses import check_poses
from urdf_ik.support.angles import amount
from urdf_ik.typing import Array

REACHED = 1e-6
"""m and rad: a joint vector whose pose is farther from a target, whatever the rotation about a free axis, misses it."""


def redundancy_of(solver: Solver, q: ArrayLike, T: Any = None) -> Array:
    """Values of the redundancy parameters at joint vectors: ``ik`` finds them again at these.

    Args:
        solver: of an arm with redundancy parameters.
        q: (..., n) rad or m; a row of NaN gives NaN.
        T: (..., 4, 4) m, the poses that they are to reach, which say what the rotation about a free axis is;
            default: the poses that the tip has, so that this rotation is zero. Other parameters follow from ``q``.

    Returns:
        (...) of one parameter, (..., k) of k of them.

    Raises:
        ArgumentError: ``q`` does not fit, or does not reach ``T``, whatever the rotation about the free axis.
        PoseError: ``T`` holds an invalid pose.
        UnsupportedArm: the arm has no such parameter.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("srs_7r")
        >>> q = [0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]
        >>> value = arm.redundancy_of(q)
        >>> arm.ik(arm.fk(q), redundancy=value).nearest(q).to_array().round(6).tolist()
        [[0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]]
    """
    member = solver.redundant_member
    Q, gone = filled(solver.chain.check(q, padded=True))
    reached = np.asarray(solver.chain.fk(Q))
    target = reached if T is None else check_poses(T)
    batch = np.broadcast_shapes(Q.shape[:-1], target.shape[:-2])
    gone = np.broadcast_to(gone, batch)
    target = np.where(gone[..., None, None], reached, np.broadcast_to(target, (*batch, 4, 4)))
    if T is not None and solver.free_axis is not None:
        _require_reached(solver.free_axis, np.broadcast_to(reached, target.shape), target)
    Q = np.broadcast_to(Q, (*batch, solver.dof))
    values = np.array(member.value_of(Q.reshape(-1, solver.dof), target.reshape(-1, 4, 4)))
    if T is None and solver.free_axis is not None:
        values[:, 0] = 0.0  # not what rounding makes of it
    values[gone.reshape(-1)] = np.nan
    return values.reshape(batch if len(member.parameters) == 1 else (*batch, len(member.parameters)))


def nearest_values(solver: Solver, q: Array, T: Array) -> Array:
    """(m, k) values of the parameters at joint vectors (m, n), whose poses need not be the targets (m, 4, 4).

    The rotation about a free axis is the one that comes nearest.
    """
    return solver.redundant_member.value_of(q, np.broadcast_to(T, (len(q), 4, 4)))


def only_parameter(solver: Solver, what: str) -> FamilyMember:
    """The member of a family with one redundancy parameter.

    Raises:
        UnsupportedArm: a pose leaves nothing free, or several values.
    """
    member = solver.redundant_member
    first, *rest = member.parameters
    if rest:
        raise UnsupportedArm(
            f"{solver.name}: {what} takes one redundancy parameter, and this arm has {1 + len(rest)}: "
            f"{', '.join(each.label for each in (first, *rest))}; hold a joint, arm.with_locked({{...}}), or give "
            f"the rotation about a free axis: {what}(T @ arm.solver.free_axis.rotation(value)) of the arm without it"
        )
    return member


def _require_reached(axis: FreeAxis, reached: Array, target: Array) -> None:
    far, turned = axis.apart(reached, target)
    if not far.size:
        return
    worst = np.unravel_index(np.argmax(np.maximum(far, turned)), far.shape)
    if max(far[worst], turned[worst]) > REACHED:
        raise ArgumentError(
            f"joint vector{[int(k) for k in worst] or ''} does not reach the pose, whatever the rotation about "
            f"{axis}: it is {far[worst]:.3g} m and {amount(turned[worst], form='.3g')} off"
        )
