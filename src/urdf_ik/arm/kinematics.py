"""What an arm is before it is solved: its joints and links, its kinematics, and Pinocchio's view of both."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from urdf_ik.ik.solutions import limits
from urdf_ik.ik.tasks import control_of
from urdf_ik.kinematics import velocity
from urdf_ik.kinematics.chain import velocity_limits
from urdf_ik.support import files
from urdf_ik.support.tolerances import DEFAULT

if TYPE_CHECKING:
    import os

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.cell.reference import Reference
    from urdf_ik.cell.tool import Shapes
    from urdf_ik.ik.tasks import Control
    from urdf_ik.kinematics.chain import Chain
    from urdf_ik.kinematics.chain.free_axis import FreeAxis
    from urdf_ik.kinematics.chain.plane import Plane
    from urdf_ik.model.urdf import UrdfModel

    Array = NDArray[np.float64]


class Kinematics:
    """A URDF and a chain of it.

    Attributes:
        model: the URDF as it was read.
        chain: screw axes of the joints from base to tip.
    """

    def __init__(self, model: UrdfModel, chain: Chain, free_axis: FreeAxis | None = None) -> None:
        self.model = model
        self.chain = chain
        self._free_axis = free_axis

    @property
    def free_axis(self) -> FreeAxis | None:
        """The line in the tip about which it may be turned; see :meth:`urdf_ik.Arm.with_free_axis`."""
        return self._free_axis

    @property
    def name(self) -> str:
        """The robot's name in the URDF."""
        return self.model.name

    @property
    def base(self) -> str:
        """Base link; poses are expressed in it."""
        return self.chain.base

    @property
    def tip(self) -> str:
        """Tip link, whose pose is solved for."""
        return self.chain.tip

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Movable joints, base to tip."""
        return self.chain.joint_names

    @property
    def dof(self) -> int:
        """Number of movable joints."""
        return self.chain.n

    @property
    def limits(self) -> Array:
        """(n, 2) rad or m; a continuous joint has (-inf, inf)."""
        return self.chain.limits

    @cached_property
    def velocity_limits(self) -> Array:
        """(n,) rad/s or m/s, the URDF's; infinite where it gives no speed, or zero, which counts as not given."""
        return velocity_limits(self.model, self.chain)

    def limit_margin(self, q: ArrayLike) -> Array:
        """How far (..., n) rad or m are from the joint limits: (...), the least joint's share of half its range.

        1 in the middle of all ranges, 0 at a limit, negative outside; see :func:`urdf_ik.ik.solutions.limits.margin`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> middle = arm.limits.mean(axis=1)
            >>> (arm.limit_margin([middle, arm.limits[:, 1]]).round(6) + 0.0).tolist()
            [1.0, 0.0]
        """
        return limits.margin(self.chain.check(q), self.limits)

    @property
    def locked(self) -> dict[str, float]:
        """Joints that ``load`` holds still, with their values [rad or m]."""
        return dict(self.chain.locked)

    def with_tool(self, pose: Any, shapes: Shapes = (), name: str = "tool") -> Self:
        """This arm with a tool at its tip: a new arm whose tip is the tool's centre point, and whose tool collides.

        The tool is a link of the new arm's URDF, fixed to the present tip, so that Pinocchio sees it too, and
        ``write_urdf`` writes it. Tools may be stacked: the next one is mounted at the centre point of this one. Base,
        locked joints, task and changes of the allowed-collision table stay. As with any link, a tool may touch the
        links that are rigidly joined with it and those that a single joint is between, and must not touch others.

        Args:
            pose: (4, 4) of the tool's centre point in the present tip link [m], or a ``pinocchio.SE3``; see
                ``urdf_ik.pose``.
            shapes: what the tool is made of, each a shape or a pair (shape, pose), its pose in the present tip link
                [m], on which it is mounted: where a shape lies does not depend on the centre point. ``Box``,
                ``Sphere``, ``Cylinder``, ``Capsule`` and ``Mesh``.
            name: of the tool's link.

        Raises:
            PoseError: an invalid pose.
            ArgumentError: the URDF has a link of this name, something that is no shape is given, or the tip has a
                free axis.
            ArgumentError: a shape that a URDF cannot hold (``HalfSpace``, ``Points``), or a mesh that is not there.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> body = (urdf_ik.Cylinder(0.03, 0.2), urdf_ik.pose([0.0, 0.0, 0.1]))
            >>> torch = arm.with_tool(urdf_ik.pose([0.0, 0.05, 0.25], rpy=[0.5, 0.0, 0.0]), [body], name="torch")
            >>> torch.tip, len(torch.ik(torch.fk([0.3, -0.5, 0.8, 0.4, 0.7, -0.2])))
            ('torch', 8)
        """
        from urdf_ik.cell.tool import with_tool

        return with_tool(self, pose, shapes, name)

    def write_urdf(self, path: str | os.PathLike[str]) -> None:
        """Write the arm's URDF, tools included: what was read, without what kinematics and shapes do not need.

        Meshes keep the names that they have in the file that was read. ``urdf_ik.load(path, arm.base, arm.tip,
        locked=arm.locked, mesh_roots=arm.model.package_dirs)`` gives the same arm again, wherever it was written.

        Args:
            path: the file, which is replaced if it is there. The same text as bytes: ``arm.model.xml``.

        Raises:
            ArgumentError: it cannot be written.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr").with_tool(urdf_ik.pose([0.0, 0.0, 0.1]), name="gripper")
            >>> arm.write_urdf("scara_with_gripper.urdf")
            >>> urdf_ik.load("scara_with_gripper.urdf", tip=arm.tip).tip
            'gripper'
        """
        files.write(path, self.model.xml)

    @cached_property
    def control(self) -> Control:
        """What the arm can control of its tip: the task, the plane, the tip's axis that is aimed."""
        return control_of(self.chain)

    @property
    def task(self) -> str:
        """What the arm can control: 'pose', 'position', 'position and axis', 'planar position' or 'planar pose'."""
        return self.control.task

    @property
    def plane(self) -> Plane | None:
        """The plane in which a planar arm of two or three joints moves its tip, with its coordinates; else None."""
        return self.control.plane

    def fk(self, q: ArrayLike) -> Array:
        """Pose of the tip in the base: (..., n) rad or m to (..., 4, 4); see :meth:`Chain.fk`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> (arm.fk([0.0, 0.0, 0.1, 0.0])[:3, 3].round(6) + 0.0).tolist()
            [0.6, 0.0, 0.23]
        """
        return self.chain.fk(q)

    def jacobian(self, q: ArrayLike) -> Array:
        """Geometric Jacobian at the tip in base axes: (..., n) to (..., 6, n); see :meth:`Chain.jacobian`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r")
            >>> (arm.jacobian([0.0, 0.0]).round(6) + 0.0)[[0, 1, 5]].tolist()
            [[0.0, 0.0], [0.196, 0.13], [1.0, 1.0]]
        """
        return self.chain.jacobian(q)

    def manipulability(self, q: ArrayLike, part: str = "all") -> Array:
        """Yoshikawa's manipulability: (..., n) to (...); see :func:`urdf_ik.kinematics.velocity.manipulability`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r_unit")
            >>> arm.manipulability([[0.0, 0.5], [0.0, 1.5]], "translation").round(4).tolist()
            [0.4794, 0.9975]
        """
        return velocity.manipulability(self.chain, q, part)

    def condition_number(self, q: ArrayLike, part: str = "all", length: float | None = None) -> Array:
        """Condition of the Jacobian: (..., n) to (...); see :func:`urdf_ik.kinematics.velocity.condition_number`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("planar_2r_unit")
            >>> round(float(arm.condition_number([0.0, 2.0], "translation")), 3)
            1.841
        """
        return velocity.condition_number(self.chain, q, part, length)

    def singular_directions(
        self, q: ArrayLike, *, length: float | None = None, tolerance: float = DEFAULT.singular
    ) -> velocity.SingularDirections:
        """Twists lost and idle motions at ``q`` (..., n); see :func:`urdf_ik.kinematics.velocity.singular_directions`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> found = arm.singular_directions([0.3, -0.5, 0.8, 0.4, 0.0, -0.2])
            >>> len(found.lost_twists), len(found.idle_motions)
            (1, 1)
        """
        return velocity.singular_directions(self.chain, q, length=length, tolerance=tolerance)

    def joint_velocities(
        self,
        q: ArrayLike,
        twist: ArrayLike,
        *,
        part: str = "all",
        damping: float | None = None,
        weights: ArrayLike | None = None,
        limits: ArrayLike | None = None,
        length: float | None = None,
    ) -> Array:
        """Joint velocities (..., n) for a tip twist (..., 6); see :func:`urdf_ik.kinematics.velocity.joint_velocities`.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> q = [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
            >>> speeds = arm.joint_velocities(q, [0.1, 0.0, 0.0, 0.0, 0.0, 0.0])
            >>> ((arm.jacobian(q) @ speeds).round(6) + 0.0).tolist()
            [0.1, 0.0, 0.0, 0.0, 0.0, 0.0]
        """
        return velocity.joint_velocities(
            self.chain, q, twist, part=part, damping=damping, weights=weights, limits=limits, length=length
        )

    @cached_property
    def _pinocchio(self) -> Reference:
        from urdf_ik.cell.reference import Reference

        return Reference(self.model, self.base, self.tip, locked=self.locked)

    @property
    def pinocchio_model(self) -> Any:
        """The ``pinocchio.Model`` of the whole URDF, of whose configurations :meth:`to_pinocchio` speaks."""
        return self._pinocchio.pin_model

    def to_pinocchio(self, q: ArrayLike) -> Array:
        """Configurations (..., nq) of Pinocchio's model of the whole URDF: joints by name, continuous ones (cos, sin).

        Joints beside the chain stay at zero, those that mimic others follow them.

        Args:
            q: (..., n) rad or m.

        Raises:
            ArgumentError: the last dimension is not n, or a value is not finite.
            UrdfError: Pinocchio refuses the URDF.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> arm.to_pinocchio([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]).tolist()
            [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
        """
        return self._pinocchio.configurations(self.chain.check(q))

    def from_pinocchio(self, q_pin: ArrayLike) -> Array:
        """Joint vectors (..., n) rad or m of configurations (..., nq), the inverse of :meth:`to_pinocchio`.

        Angles of continuous joints come back in (-pi, pi].

        Raises:
            ArgumentError: the last dimension is not nq, or a value is not finite.
            UrdfError: Pinocchio refuses the URDF.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("scara_rrpr")
            >>> arm.from_pinocchio(arm.to_pinocchio([0.3, 0.5, 0.1, 0.2])).round(6).tolist()
            [0.3, 0.5, 0.1, 0.2]
        """
        return self._pinocchio.joint_vectors(q_pin)

    def link_poses(self, q: ArrayLike) -> dict[str, Array]:
        """Pose of every link in the base: (..., n) to (..., 4, 4) each; see :meth:`Chain.link_poses`.

        Example:
            >>> import urdf_ik
            >>> poses = urdf_ik.load("scara_rrpr").link_poses([0.0, 0.0, 0.1, 0.0])
            >>> (poses["link_2"][:3, 3].round(6) + 0.0).tolist()
            [0.325, 0.0, 0.38]
        """
        return self.chain.link_poses(q)
