"""Cell: an arm's links as bodies, and Pinocchio's model of its URDF; both are built at first use."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.cell import missing_pinocchio as without_pinocchio
from urdf_ik.errors import ArgumentError
from urdf_ik.kinematics.chain import Chain
from urdf_ik.model.urdf import UrdfModel
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

if TYPE_CHECKING:
    from urdf_ik.cell.collision_model import CollisionModel, Nearest
    from urdf_ik.cell.pinocchio_reference import Reference
    from urdf_ik.cell.swept_motions import Motions
    from urdf_ik.cell.world import World


@dataclass(frozen=True, eq=False)
class Cell:
    """The bodies of an arm, and the reference that its kinematics are compared with.

    Attributes:
        model: the URDF.
        chain: the joints from base to tip, and the locked joints.
        changed: a collision model with a changed allowed-collision table; None: the URDF's own.
        disabled: pairs of links that an SRDF allows to touch.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("zyyzyz_6r")
        >>> arm.cell.nearest_pair([0.0] * 6).links
        ('link_4', 'link_6')
    """

    model: UrdfModel
    chain: Chain
    changed: CollisionModel | None = None
    disabled: tuple[tuple[str, str], ...] = ()

    @cached_property
    def collisions(self) -> CollisionModel:
        """Collision and distance of the links through Pinocchio and coal; where these are not installed, none."""
        if self.changed is not None:
            return self.changed
        if not without_pinocchio.installed():
            return cast("CollisionModel", without_pinocchio.unchecked())
        from urdf_ik.cell.collision_model import CollisionModel

        model, chain = self.model, self.chain
        return CollisionModel(model, chain.base, chain.tip, disabled=self.disabled, locked=dict(chain.locked))

    @cached_property
    def reference(self) -> Reference:
        """Pinocchio's model of the whole URDF, built from the file itself.

        Raises:
            MissingPackage: Pinocchio is not installed.
        """
        if not without_pinocchio.installed():
            raise without_pinocchio.needed("comparisons with the reference")
        from urdf_ik.cell.pinocchio_reference import Reference

        return Reference(self.model, self.chain.base, self.chain.tip, locked=dict(self.chain.locked))

    def in_world(self, world: World | None) -> CollisionModel:
        """The links among the obstacles of a world; None: the links alone."""
        return self.collisions.in_world(world)

    def to_check(self, collisions: bool | str, world: World | None = None) -> tuple[CollisionModel | None, str]:
        """What to check for contacts, or None and why nothing is checked.

        Args:
            collisions: True: check where the shapes can be read; where meshes are missing, warn. 'require': fail where
                they cannot be read. False: do not check.
            world: the obstacles; where some are given, the shapes are required.

        Returns:
            The links among the obstacles and '', or None and the reason, such as '6 meshes missing'.

        Raises:
            UrdfError: the shapes are required, and not all of them can be read.
            ArgumentError: ``collisions`` is none of these, or False where a world is given.
        """
        require = isinstance(collisions, str) and collisions == "require"
        if not require and not isinstance(collisions, bool | np.bool_):
            raise ArgumentError(f"collisions={quoted(collisions)} given; True, False or 'require' is needed")
        if not collisions:
            if world is not None:
                raise ArgumentError("collisions=False given with a world; leave one of the two out")
            return None, "not asked for"
        model = self.in_world(world)
        if model.has_geometry or world is not None:
            return model, ""
        if require:
            model.table()  # raises the error that says what is missing
        if "missing" in model.unchecked:
            warnings.warn(f"{self.model.name}: contacts not checked: {model.unchecked}", UserWarning, stacklevel=4)
        return None, model.unchecked

    def clearance(self, q: ArrayLike, world: World | None = None) -> float | Array:
        """Smallest distance between links that must not touch, and between links and the obstacles of a world.

        Args:
            q: (..., n) rad or m.
            world: the obstacles; default: none, only the arm itself.

        Returns:
            A float for one joint vector, else (...) [m]: 0 in collision, infinite if no pair is checked.

        Raises:
            ArgumentError: ``q`` does not fit; an obstacle's mesh cannot be read, or it has the name of a link.
            UrdfError: the URDF has no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> arm, world = urdf_ik.load("zyyzyz_6r"), urdf_ik.World()
            >>> world.add("ceiling", urdf_ik.HalfSpace((0, 0, -1), -3.33))
            >>> round(float(arm.clearance([0.0] * 6, world)), 3)
            0.03
        """
        return self.in_world(world).distance(self.chain.check(q, padded=True))

    def nearest_pair(self, q: ArrayLike, world: World | None = None) -> Nearest | None:
        """The nearest checked pair at ``q`` (n,), two links or a link and an obstacle; None if no pair is checked.

        Raises the errors of :meth:`urdf_ik.Arm.clearance`.
        """
        return self.in_world(world).nearest_pair(self.chain.check(q))

    def motion_is_free(self, q0: ArrayLike, q1: ArrayLike, world: World | None = None, margin: float = 0.0) -> Motions:
        """Whether straight motions in joint space are free of contact from end to end: proven, not sampled.

        Each joint moves linearly from its value in ``q0`` to its value in ``q1``, full turns included. A motion that is
        reported as not free has a contact, or comes within 0.1 mm of one (``urdf_ik.cell.swept_motions.TOUCH``): that
        close, no finite number of distances can prove it free.

        Args:
            q0: (..., n) rad or m. A motion from or to a row of NaN, as solutions are padded with, is not free; its
                ``share`` is NaN.
            q1: (..., n) rad or m; the leading dimensions broadcast against those of ``q0``.
            world: the obstacles; default: none, only the arm itself.
            margin: least distance allowed [m].

        Returns:
            ``free`` (...) is true for each free motion; ``share`` (...) and ``pairs`` describe the first contact of
            the others. The result for a single motion is itself true or false.

        Raises:
            ArgumentError: the arrays do not fit the arm or each other, a joint goes farther than 10000 rad or m, or
                ``margin`` or an obstacle is invalid.
            UrdfError: the URDF has no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> arm, world = urdf_ik.load("scara_rrpr"), urdf_ik.World()
            >>> world.add("post", urdf_ik.Cylinder(0.05, 2.0), urdf_ik.pose([0.5, 0.0, 0.0]))
            >>> motion = arm.motion_is_free([-1.0, 0.0, 0.1, 0.0], [1.0, 0.0, 0.1, 0.0], world)
            >>> bool(motion), round(float(motion.share), 2), motion.pairs
            (False, 0.42, [('link_2', 'post')])
        """
        start, end = self.chain.check(q0, padded=True), self.chain.check(q1, padded=True)
        try:
            start, end = np.broadcast_arrays(start, end)
        except ValueError:
            raise ArgumentError(
                f"motions from {start.shape} to {end.shape} given; the shapes do not broadcast"
            ) from None
        batch, count = start.shape[:-1], math.prod(start.shape[:-1])
        start, end = start.reshape(count, self.chain.n), end.reshape(count, self.chain.n)
        there = np.asarray((np.isfinite(start) & np.isfinite(end)).all(axis=1))
        flat = self.in_world(world).motions_free(start[there], end[there], margin)
        if not there.all():
            flat = flat.spread(there)
        return replace(flat, free=flat.free.reshape(batch), share=flat.share.reshape(batch))

    def allow(self, first: str, second: str) -> Cell:
        """This cell, two links being allowed to touch; see :meth:`urdf_ik.cell.CollisionModel.allow`."""
        return replace(self, changed=self.collisions.allow(first, second))

    def moved_to(self, model: UrdfModel, chain: Chain) -> Cell:
        """The cell of another URDF, with the changes that a user made to the allowed-collision table of this one."""
        own = self.__dict__.get("collisions", self.changed)
        if own is None or not own.is_changed:
            return Cell(model, chain, None, self.disabled)
        changed = own.rebuilt(model, chain.base, chain.tip, dict(chain.locked))
        return Cell(model, chain, changed, self.disabled)

    def __reduce__(self) -> tuple[Callable[..., Cell], tuple[Any, ...]]:
        # The collision model is built when it is needed; only the changes of a user must not be lost.
        own = self.__dict__.get("collisions", self.changed)
        return Cell, (self.model, self.chain, own if own is not None and own.is_changed else None, self.disabled)
