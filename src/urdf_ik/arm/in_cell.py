"""What an arm can run into: itself, and the obstacles of a world."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik.arm.kinematics import Kinematics
from urdf_ik.errors import ArgumentError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.cell import CollisionModel, Motions, Nearest, World

    Array = NDArray[np.float64]


class InCell(Kinematics):
    """An arm's links as bodies."""

    @cached_property
    def collision_model(self) -> CollisionModel:
        """Self-collision of this URDF through Pinocchio and coal, built when first asked for.

        It may be replaced, by one with another allowed-collision table: ``arm.collision_model =
        arm.collision_model.allow("forearm", "tool")``.
        """
        from urdf_ik.cell import CollisionModel

        return CollisionModel(self.model, self.base, self.tip, locked=self.locked)

    def clearance(self, q: ArrayLike, world: World | None = None) -> float | Array:
        """Least distance between links that must not touch, and between them and the obstacles of a world.

        Args:
            q: (..., n) rad or m.
            world: the obstacles; default: none, only the arm itself.

        Returns:
            A float for one joint vector, else (...) [m]: 0 in collision, infinite where nothing can collide.

        Raises:
            ArgumentError: the last dimension is not n, or a value is not finite.
            UrdfError: the URDF has no collision shapes, or not all of them were found.
            ArgumentError: an obstacle's mesh cannot be read, or it has the name of a link.

        Example:
            >>> import urdf_ik
            >>> arm, world = urdf_ik.load("zyyzyz_6r"), urdf_ik.World()
            >>> world.add("ceiling", urdf_ik.HalfSpace((0, 0, -1), -3.33))
            >>> round(float(arm.clearance([0.0] * 6, world)), 3)
            0.03
        """
        return self.collision_model.in_world(world).distance(self.chain.check(q))

    def nearest_pair(self, q: ArrayLike, world: World | None = None) -> Nearest | None:
        """What comes closest to each other at ``q`` (n,), two links or a link and an obstacle, and how close [m].

        None where nothing can collide. Raises as :meth:`clearance` does.

        Example:
            >>> import urdf_ik
            >>> arm, world = urdf_ik.load("zyyzyz_6r"), urdf_ik.World()
            >>> world.add("ceiling", urdf_ik.HalfSpace((0, 0, -1), -3.33))
            >>> pair = arm.nearest_pair([0.0] * 6, world)
            >>> pair.links, round(pair.distance, 3)
            (('link_6', 'ceiling'), 0.03)
        """
        return self.collision_model.in_world(world).nearest_pair(self.chain.check(q))

    def motion_is_free(self, q0: ArrayLike, q1: ArrayLike, world: World | None = None, margin: float = 0.0) -> Motions:
        """Whether straight motions in joint space are free of contact from end to end: proven, not sampled.

        Each joint goes from its value in ``q0`` to its value in ``q1``, in proportion to the others, turns included.
        A motion that is called free is free of contact at every instant of it. One that is not called free has a
        contact, or comes within 0.1 mm of one (``urdf_ik.cell.swept_motions.TOUCH``), where no finite number of
        distances can prove it free.

        Args:
            q0: (..., n) rad or m.
            q1: (..., n) rad or m; the leading dimensions broadcast against those of ``q0``.
            world: the obstacles; default: none, only the arm itself.
            margin: m that the bodies must stay apart.

        Returns:
            Its ``free`` (...) says which motions are; ``share`` (...) and ``pairs`` describe the first contact of
            the others. Of a single motion, the result itself is true or false.

        Raises:
            ArgumentError: the arrays do not fit the arm or each other, a value is not finite, or a joint goes
                farther than 10000 rad or m (``urdf_ik.cell.swept_motions.LONGEST``).
            ArgumentError: ``margin`` is negative or not finite.
            UrdfError: the URDF has no collision shapes, or not all of them were found.
            ArgumentError: an obstacle's mesh cannot be read, or it has the name of a link.

        Example:
            >>> import urdf_ik
            >>> arm, world = urdf_ik.load("scara_rrpr"), urdf_ik.World()
            >>> world.add("post", urdf_ik.Cylinder(0.05, 2.0), urdf_ik.pose([0.5, 0.0, 0.0]))
            >>> motion = arm.motion_is_free([-1.0, 0.0, 0.1, 0.0], [1.0, 0.0, 0.1, 0.0], world)
            >>> bool(motion), round(float(motion.share), 2), motion.pairs
            (False, 0.42, [('link_2', 'post')])
        """
        start, end = self.chain.check(q0), self.chain.check(q1)
        try:
            start, end = np.broadcast_arrays(start, end)
        except ValueError:
            raise ArgumentError(
                f"motions from {start.shape} to {end.shape} given; the shapes do not broadcast"
            ) from None
        batch, count = start.shape[:-1], math.prod(start.shape[:-1])
        flat = self.collision_model.in_world(world).motions_free(
            start.reshape(count, self.dof), end.reshape(count, self.dof), margin
        )
        return replace(flat, free=flat.free.reshape(batch), share=flat.share.reshape(batch))
