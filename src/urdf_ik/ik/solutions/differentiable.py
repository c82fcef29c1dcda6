"""Solutions with their derivatives."""

from __future__ import annotations

from typing import Any

from numpy.typing import ArrayLike

from urdf_ik.ik.solutions import derivatives
from urdf_ik.ik.solutions.solution import KeptSolutions
from urdf_ik.typing import Array


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
        return derivatives.by_pose(self, axes)

    def dq_dT_error(self) -> Array:
        """A bound (..., B) on the error of :meth:`dq_dT`, as the Frobenius norm, lengths as shares of the chain's size.

        It follows from the distance between the tip and its target, from rounding, and from the inverse itself: near a
        singularity all three grow. Infinite where it says nothing: at a swivel angle, with joints that mimic others.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> bool((arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])).dq_dT_error() < 1e-6).all())
            True
        """
        return derivatives.error_by_pose(self)

    def dq_dredundancy(self) -> Array:
        """The derivative (..., B, n, k) of every solution by the k redundancy parameters, the pose held.

        Raises:
            UnsupportedArm: the arm has none, or a swivel angle beside others.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("srs_7r")
            >>> slope = arm.ik(arm.fk([0.3, 0.5, -0.4, 0.9, 0.2, -0.6, 0.1]), redundancy=0.4).dq_dredundancy()
            >>> slope.shape
            (8, 7, 1)
        """
        return derivatives.by_redundancy(self)

    def dq_dgeometry(self, parameters: Any = None) -> Array:
        """The derivative of every solution by the numbers of the URDF, the pose and the redundancy parameters held.

        A swivel angle is held as the changed arm measures it: shoulder and wrist are the points nearest to their three
        axes where all joints are zero, which follow the numbers also where the axes meet no more.

        Args:
            parameters: tuples (joint, field, part), where the field is 'xyz', 'rpy' or 'axis' as written, or 'offset'
                (part 0), what is added to a joint's value; default: all those of the chain's joints, in the order of
                ``urdf_ik.kinematics.derivatives.written(arm.chain).parameters``.

        Returns:
            (..., B, n, p), NaN as in :meth:`dq_dT`.

        Raises:
            ArgumentError: there is no such parameter.
            UnsupportedArm: a swivel angle beside other redundancy parameters.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> s = arm.ik(arm.fk([0.3, 0.5, 0.1, 0.2]))
            >>> (s.dq_dgeometry([("joint_2", "offset", 0)])[..., 0].round(6) + 0.0).tolist()
            [[0.0, -1.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0]]
        """
        return derivatives.by_geometry(self, parameters)

    def d2q_dT2(self, V: ArrayLike, W: ArrayLike | None = None) -> Array:
        """Second directional derivative: the rate of ``dq_dT() @ V`` when the target moves with the twist ``W``.

        Args:
            V: (6,) or (..., 6) a twist, constant in base axes.
            W: the same; default: ``V``, which gives the joints' accelerations along a motion with a constant twist.

        Returns:
            (..., B, n), NaN as in :meth:`dq_dT`.

        Raises:
            ArgumentError: a twist does not fit.
            UnsupportedArm: the arm is solved for the task 'position and axis', or a swivel angle stands beside other
                redundancy parameters.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> arm.ik(arm.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])).d2q_dT2([0.1, 0, 0, 0, 0, 0]).shape
            (8, 6)
        """
        return derivatives.second_by_pose(self, V, W)
