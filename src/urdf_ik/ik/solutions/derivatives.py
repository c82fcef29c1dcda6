"""Derivatives of solutions, by the implicit function theorem.

A solution satisfies two equations: the tip is at the target, and each redundancy parameter has its value. Their
derivative by the joints is the matrix A, the Jacobian above one row a parameter. Whatever changes the target, the
values or the arm by a small amount b, the joints follow it by A^-1 b. Where A loses rank, there is no derivative.
"""

from typing import Any

import numpy as np

from urdf_ik.errors import UnsupportedArm
from urdf_ik.ik.solutions.solution import KeptSolutions
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import POSE
from urdf_ik.kinematics.chain.redundancy import FREE_AXIS, LOCKED_JOINT, SWIVEL
from urdf_ik.kinematics.derivatives import written
from urdf_ik.support import inputs
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

AXES = ("base", "tip")


def inverse(solutions: KeptSolutions) -> Array:
    """A^-1 (..., B, n, 6 + k), NaN where there is no solution or A loses rank: twists of the tip, then the parameters.

    Where a target fixes less than a pose, or joints are fewer than six: the least-squares inverse, lengths counted as
    shares of the arm's size. It gives the joint velocities of every twist that the arm can follow. The value of a free
    axis is none of the parameters here: it turns the target.
    """
    solver, chain = solutions.solver, solutions.solver.chain
    held = [each for each in solver.parameters if each.kind != FREE_AXIS]
    weights = _controlled(solutions)
    if weights is None and chain.axes is chain and 0 < chain.n <= 7 and len(held) == int(chain.n == 7):
        q, ends = np.ascontiguousarray(solutions.q), solver.redundant_member.swivel if held else None
        if not held:
            X = chain.motion.inverse(q, chain.size, DEFAULT.singular)
        elif ends is None:
            joint = chain.joint_names.index(held[0].joint)
            X = chain.motion.inverse(q, chain.size, DEFAULT.singular, held=joint)
        else:
            seen = [*ends.tool_point, *ends.base_origin, *ends.base_rotation[2]]
            X = chain.motion.inverse(q, chain.size, DEFAULT.singular, swivel=seen)
    else:
        X = _inverse_of_any(solutions, held, weights)
    singular = solutions.singular
    if singular.any():
        X[singular != 0] = np.nan
    return np.asarray(X)


def _inverse_of_any(solutions: KeptSolutions, held: list[Any], weights: Array | None) -> Array:
    """The same for any number of joints, mimicking ones too, and for the parts of a pose that a task fixes."""
    chain = solutions.solver.chain
    q = _finite(solutions)
    share = np.where(np.arange(6) < 3, 1.0 / chain.size, 1.0)
    own = np.where(chain.prismatic, chain.size, 1.0)
    J = chain.jacobian(q)
    if solutions.solver.asked.components == "look at":  # what counts is how the tip moves at the target
        lever = solutions.poses[..., None, :3, 3] - _reached(solutions)[..., :3, 3]
        J[..., :3, :] += np.cross(J[..., 3:, :], lever[..., None], axis=-2)
    W = np.eye(6) if weights is None else weights
    A = (W @ J) * share[:, None]
    if held:
        slopes = _slopes(solutions.solver, held)
        A = np.concatenate([A, np.broadcast_to(slopes, (*q.shape[:-1], *slopes.shape))], axis=-2)
    A = A * own
    U, s, Vt = np.linalg.svd(A, full_matrices=False)
    live = s[..., -1] > DEFAULT.singular if A.shape[-2] >= chain.n else np.zeros(s.shape[:-1], np.bool_)
    gain = np.where(live[..., None], 1.0 / np.where(s > 0.0, s, 1.0), np.nan)
    X = np.swapaxes(Vt, -1, -2) @ (gain[..., None] * np.swapaxes(U, -1, -2)) * own[:, None]
    X[..., :6] = (X[..., :6] * share) @ W
    X[~solutions.valid] = np.nan
    return np.asarray(X)


def _slopes(solver: Solver, held: list[Any]) -> Array:
    """(k, n) derivatives of joints that are redundancy parameters by the joints."""
    if any(each.kind != LOCKED_JOINT for each in held):
        raise UnsupportedArm(
            f"{solver.name}: derivatives with a swivel angle beside other redundancy parameters are not computed; hold "
            "a joint: arm.with_locked({name: value})"
        )
    names = solver.chain.joint_names
    return np.eye(solver.dof)[[names.index(each.joint) for each in held]]


def _controlled(solutions: KeptSolutions) -> Array | None:
    """(6, 6) or (..., B, 6, 6), what of a twist counts to the target; None where all of it does."""
    solver = solutions.solver
    asked = solver.asked
    if asked != POSE:
        if any(each.kind == FREE_AXIS for each in solver.parameters):
            return None
        R = _reached(solutions)[..., :3, :3]
        parts = np.zeros((*R.shape[:-2], 6, 6))
        across: Any = np.eye(3)
        if asked.axis is not None:
            a = np.broadcast_to(asked.axis, R.shape[:-1]) if asked.frame == "base" else R @ np.array(asked.axis)
            across = np.eye(3) - a[..., :, None] * a[..., None, :]
        if asked.has_place:
            parts[..., :3, :3] = np.eye(3) if asked.has_turn else across
        if asked.has_turn:
            parts[..., 3:, 3:] = across
        return parts
    if solver.task == "pose":
        if solver.free_axis is None or solver.parameters:
            return None
        return np.asarray(solver.free_axis.reduced(_reached(solutions)[..., :3, :3], np.eye(6)))
    plane = solver.control.plane
    assert plane is not None  # the task is planar
    W: Array = np.zeros((6, 6))
    W[:3, :3] = plane.axes.T @ plane.axes
    if solver.task == "planar pose":
        W[3:, 3:] = np.outer(plane.normal, plane.normal)
    return W


def _finite(solutions: KeptSolutions) -> Array:
    """The joint vectors (..., B, n), zeros where there is no solution."""
    return np.where(solutions.valid[..., None], solutions.q, 0.0)


def _reached(solutions: KeptSolutions) -> Array:
    """The tip's poses (..., B, 4, 4)."""
    return np.asarray(solutions.solver.chain.fk(_finite(solutions)))


def _target(solutions: KeptSolutions) -> Array:
    """The targets (..., 1, 4, 4), or the tip's poses (..., B, 4, 4) where a target is not a pose."""
    return solutions.poses[..., None, :, :] if solutions.solver.task == "pose" else _reached(solutions)


class DifferentiableSolutions(KeptSolutions):
    """The derivatives of :class:`IKSolutions` by the pose, the redundancy parameters and the URDF's numbers."""

    __slots__ = ()

    def dq_dT(self, axes: str = "base") -> Array:
        """The derivative of every solution by the pose: how the joints follow a small motion of the target.

        It is the inverse of the Jacobian (implicit function theorem). With seven joints, or a free axis, the redundancy
        parameters are held. With fewer than six joints it is the least-squares inverse, which gives the joint
        velocities for every twist that the arm can follow; for a task, of the part of the twist that the task fixes.

        Args:
            axes: 'base': twists of the target at its origin in base axes, as the Jacobian's rows; 'tip': at its origin
                in its own axes (body twist).

        Returns:
            (..., B, n, 6) rad or m per m (columns 0 to 2) and per rad (3 to 5); NaN where there is no solution, and at
            singular ones, where a derivative does not exist.

        Raises:
            ArgumentError: an unknown ``axes``.
            UnsupportedArm: a swivel angle beside other redundancy parameters.

        Example:
            >>> import numpy as np
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> s = arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2]))
            >>> X = s.dq_dT()
            >>> X.shape, bool(abs(X[0] @ arm.jacobian(s.q[0]) - np.eye(6)).max() < 1e-12)
            ((8, 6, 6), True)
        """
        inputs.choice(axes, "axes", AXES)
        X = inverse(self)[..., :6]
        if self.solver.free_axis is not None and self.solver.parameters:
            # The tip is where the turned target is: a rotation of the target moves it by this arm.
            X, arm = X.copy(), _reached(self)[..., :3, 3] - _target(self)[..., :3, 3]
            X[..., 3:] -= X[..., :3] @ np.cross(np.eye(3), arm[..., None, :])
        if axes == "base":
            return X
        R = _target(self)[..., :3, :3]
        return np.concatenate([X[..., :3] @ R, X[..., 3:] @ R], axis=-1)

    def dq_dredundancy(self) -> Array:
        """The derivative (..., B, n, k) of every solution by the k redundancy parameters, the pose held.

        Raises:
            UnsupportedArm: the arm has none, or a swivel angle beside others.
        """
        solver = self.solver
        if not solver.parameters:
            solver.redundant_member  # noqa: B018  says in words why there is none
        X = inverse(self)
        if solver.free_axis is None:
            return X[..., 6:]
        reached, target = _reached(self), _target(self)
        axis = reached[..., :3, :3] @ np.array(solver.free_axis.direction)
        on_axis = (target @ np.array([*solver.free_axis.at, 1.0]))[..., :3]
        twist = np.concatenate([np.cross(axis, reached[..., :3, 3] - on_axis), axis], axis=-1)
        return np.concatenate([X[..., :6] @ twist[..., None], X[..., 6:]], axis=-1)

    def dq_dgeometry(self, parameters: Any = None) -> Array:
        """The derivative of every solution by the numbers of the URDF, the pose and the redundancy parameters held.

        Args:
            parameters: tuples (joint, field, part), where the field is 'xyz', 'rpy' or 'axis' as written, or 'offset'
                (part 0), what is added to a joint's value; default: all those of the chain's joints, in the order of
                ``urdf_ik.kinematics.derivatives.written(arm.chain).parameters``.

        Returns:
            (..., B, n, p), NaN as in :meth:`dq_dT`.

        Raises:
            ArgumentError: there is no such parameter.
            UnsupportedArm: a swivel angle is held, which changes with the URDF.
        """
        no_swivel(self.solver, "derivatives by the URDF's numbers")
        return -(inverse(self)[..., :6] @ written(self.solver.chain).twists(_finite(self), parameters=parameters))


def no_swivel(solver: Solver, what: str) -> None:
    """Refuse an arm whose redundancy parameter is a swivel angle, with what to do instead."""
    if any(each.kind == SWIVEL for each in solver.parameters):
        raise UnsupportedArm(
            f"{solver.name}: {what} need a joint as the redundancy parameter, not the swivel angle: "
            f"arm.with_redundancy({solver.joint_names[0]!r})"
        )
