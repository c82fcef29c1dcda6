"""Collision and distance of an arm's links, among themselves and with a world, through Pinocchio and coal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.cell import swept_motions
from urdf_ik.cell.coal_check import ArmShapes, CoalCheck
from urdf_ik.cell.pinocchio_reference import Reference, finite
from urdf_ik.cell.swept_motions import Motions
from urdf_ik.errors import ArgumentError, PoseError, UrdfError, printable
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import LARGEST
from urdf_ik.typing import Array

Pair = tuple[str, str]


class Nearest(NamedTuple):
    """Two links, or a link and an obstacle, and the distance between them [m]; 0 where they collide.

    Example:
        >>> import urdf_ik
        >>> links, distance = urdf_ik.load("planar_2r").cell.nearest_pair([0.0, 0.0])
        >>> links, distance > 0.0
        (('base_link', 'link_2'), True)
    """

    links: tuple[str, str]
    distance: float


class Seen(NamedTuple):
    """The check for one version of the world."""

    version: int
    check: CoalCheck


class CollisionQueries:
    """The queries of a :class:`urdf_ik.cell.CollisionModel`; the subclass decides which pairs are checked."""

    joint_names: tuple[str, ...]
    _reference: Reference
    _arm: ArmShapes
    _rank: dict[str, int]
    _error: UrdfError | None

    def _now(self) -> Seen:
        """The check for the world's present state."""
        raise NotImplementedError

    def in_collision(self, q: ArrayLike, margin: float = 0.0) -> bool | NDArray[np.bool_]:
        """Whether a checked pair touches.

        Args:
            q: (..., n) rad or m.
            margin: least distance allowed [m].

        Returns:
            A bool for one joint vector, else (...) bool.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: the last dimension is not n, or a value is not finite.
            ArgumentError: ``margin`` is negative or not finite.

        Example:
            >>> import urdf_ik
            >>> world = urdf_ik.World()
            >>> world.add("ceiling", urdf_ik.HalfSpace((0, 0, -1), -3.33))
            >>> model = urdf_ik.load("zyyzyz_6r").cell.collisions.in_world(world)
            >>> model.in_collision([0.0] * 6), model.in_collision([0.0] * 6, margin=0.05)
            (False, True)
        """
        margin = swept_motions.check_margin(margin)
        Q, places, check = self._rows(q)
        if not places.all():
            row = np.argwhere(~places)[0].tolist()
            raise ArgumentError(
                f"joint vector{row or ''} is not finite, or beyond {LARGEST:g}; what touches at it cannot be known"
            )
        out = np.zeros(len(Q), dtype=np.bool_)
        for row, touching in self._touching(check, Q, margin):
            out[row] = next(touching, None) is not None
        whole = np.zeros(places.shape, dtype=np.bool_)
        whole[places] = out
        return bool(whole) if whole.ndim == 0 else whole

    def distance(self, q: ArrayLike) -> float | Array:
        """Smallest distance of a checked pair.

        Args:
            q: (..., n) rad or m; rows that are not finite give NaN.

        Returns:
            A float for one joint vector, else (...) [m]: 0 in collision, infinite if no pair is checked.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: the last dimension is not n.

        Example:
            >>> import urdf_ik
            >>> world = urdf_ik.World()
            >>> world.add("ceiling", urdf_ik.HalfSpace((0, 0, -1), -3.33))
            >>> round(urdf_ik.load("zyyzyz_6r").cell.collisions.in_world(world).distance([0.0] * 6), 3)
            0.03
        """
        Q, places, check = self._rows(q)
        out = np.array([distance for _, distance in check.nearest_of_each(Q)])
        whole = np.full(places.shape, np.nan)
        whole[places] = out
        return float(whole) if whole.ndim == 0 else whole

    def colliding_pairs(self, q: ArrayLike) -> tuple[Pair, ...]:
        """The checked pairs that touch.

        Args:
            q: (n,) rad or m.

        Returns:
            Pairs of names, in the order of ``checked_pairs``.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: q is no (n,), or a value is not finite.

        Example:
            >>> import urdf_ik
            >>> world = urdf_ik.World()
            >>> world.add("ball", urdf_ik.Sphere(0.1), urdf_ik.pose([0.0, 0.0, 1.0]))
            >>> urdf_ik.load("zyyzyz_6r").cell.collisions.in_world(world).colliding_pairs([0.0] * 6)
            (('link_1', 'ball'),)
        """
        Q, check = self._one(q)
        (_, touching) = next(self._touching(check, Q, 0.0), (0, iter(())))
        found = {check.names(pair): check.rank(pair)[1] for pair in touching}

        def place(pair: Pair) -> tuple[int, int, int]:
            first, second = pair
            return (
                self._rank[first],
                self._rank.get(second, len(self._rank)),
                0 if second in self._rank else found[pair],
            )

        return tuple(sorted(found, key=place))

    def nearest_pair(self, q: ArrayLike) -> Nearest | None:
        """The checked pair with the smallest distance.

        Args:
            q: (n,) rad or m.

        Returns:
            The pair and its distance; one of them if several collide. None if no pair is checked.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: q is no (n,), or a value is not finite.

        Example:
            >>> import urdf_ik
            >>> world = urdf_ik.World()
            >>> world.add("ceiling", urdf_ik.HalfSpace((0, 0, -1), -3.33))
            >>> pair = urdf_ik.load("zyyzyz_6r").cell.collisions.in_world(world).nearest_pair([0.0] * 6)
            >>> pair.links, round(pair.distance, 3)
            (('link_6', 'ceiling'), 0.03)
        """
        Q, check = self._one(q)
        for pair, distance in check.nearest_of_each(Q):
            if pair is not None:
                return Nearest(check.names(pair), distance)
        return None

    def motions_free(self, q0: ArrayLike, q1: ArrayLike, margin: float = 0.0) -> Motions:
        """Which straight motions in joint space are free from end to end, proven; see :func:`swept_motions.motions`.

        Args:
            q0: (k, n) rad or m, where the motions begin.
            q1: (k, n) rad or m, where they end; every joint moves linearly from one value to the other, full turns
                included.
            margin: least distance allowed [m].

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            ArgumentError: the arrays do not fit the arm or each other, are not finite or beyond 1e15, or a joint
                goes farther than ``swept_motions.LONGEST``.
            ArgumentError: ``margin`` is negative or not finite.

        Example:
            >>> import urdf_ik
            >>> model = urdf_ik.load("zyyzyz_6r").cell.collisions
            >>> model.motions_free([[0.0] * 6], [[0.3, 0.2, 0.1, 0.0, 0.0, 0.0]]).free.tolist()
            [True]
        """
        margin = swept_motions.check_margin(margin)
        self._require_geometry()
        start, end = (self._reference.vectors(q) for q in (q0, q1))
        if start.ndim != 2 or start.shape != end.shape:
            raise ArgumentError(
                f"motions from {start.shape} to {end.shape} given; both must be (k, {len(self.joint_names)})"
            )
        for name, array in (("q0", start), ("q1", end)):
            if (bad := inputs.first_bad(array)) is not None:
                raise ArgumentError(f"{name}{list(bad)} is {array[bad]:g}; {inputs.why_bad(array[bad])}")
        swept_motions.check_length(start, end, self.joint_names)
        return swept_motions.motions(self._now().check, start, end, margin)

    def in_collision_with(self, link_poses: Mapping[str, ArrayLike]) -> bool | NDArray[np.bool_]:
        """:meth:`in_collision` with the links at given poses instead of Pinocchio's.

        Args:
            link_poses: link name to (..., 4, 4) [m], all in one frame.

        Returns:
            A bool for one set of poses, else (...) bool.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            PoseError: a link that has a shape has no pose, or a pose is no (..., 4, 4), or not finite.

        Example:
            >>> import urdf_ik
            >>> arm = urdf_ik.load("zyyzyz_6r")
            >>> arm.cell.collisions.in_collision_with(arm.link_poses([0.0] * 6))
            False
        """
        hits: bool | NDArray[np.bool_] = self._each_placing(link_poses, False)
        return hits

    def distance_with(self, link_poses: Mapping[str, ArrayLike]) -> float | Array:
        """:meth:`distance` with the links at given poses instead of Pinocchio's.

        Args:
            link_poses: link name to (..., 4, 4) [m], all in one frame; a set with a pose that is not finite gives
                NaN.

        Returns:
            A float for one set of poses, else (...) [m].

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            PoseError: a link that has a shape has no pose, or a pose is no (..., 4, 4).

        Example:
            >>> import urdf_ik
            >>> arm, q = urdf_ik.load("zyyzyz_6r"), [0.3, -0.5, 0.8, 0.4, 0.7, -0.2]
            >>> model = arm.cell.collisions
            >>> round(model.distance_with(arm.link_poses(q)) - model.distance(q), 6) + 0.0
            0.0
        """
        distances: float | Array = self._each_placing(link_poses, np.nan)
        return distances

    def _require_geometry(self) -> None:
        if self._error is not None:
            raise self._error.with_traceback(None)

    def _rows(self, q: ArrayLike) -> tuple[Array, NDArray[np.bool_], CoalCheck]:
        """The finite joint vectors (k, n), a mask (...) of their places in ``q``, and the check."""
        self._require_geometry()
        Q = self._reference.vectors(q)
        places = np.asarray((np.abs(Q) <= LARGEST).all(axis=-1))
        rows = np.ascontiguousarray(Q[places]).reshape(int(places.sum()), Q.shape[-1])  # there may be no joints
        return rows, places, self._now().check

    def _one(self, q: ArrayLike) -> tuple[Array, CoalCheck]:
        """A joint vector as (1, n), and the check."""
        self._require_geometry()
        Q = self._reference.vectors(q)
        if Q.ndim != 1:
            raise ArgumentError(f"one joint vector ({len(self.joint_names)},) is needed, not shape {Q.shape}")
        if inputs.first_bad(Q) is not None:
            raise ArgumentError(f"the joint vector {quoted(Q)} is not finite; what is near at it cannot be known")
        return Q[None], self._now().check

    def _touching(self, check: CoalCheck, Q: Array, margin: float) -> Iterator[tuple[int, Iterator[int]]]:
        """Rows of Q (k, n) in which a pair may touch, each with the pairs that do."""
        for part, placed in check.bounds.chunks(Q):
            for i, pairs in check.bounds.near_in_rows(placed, margin):
                placing = check.links.place(Q[part.start + i])
                yield part.start + i, (pair for pair in pairs if check.touches(placing, pair, margin))

    def _each_placing(self, link_poses: Mapping[str, ArrayLike], otherwise: Any) -> Any:
        """Whether each set of link poses collides if ``otherwise`` is False; else the distances, or NaN."""
        self._require_geometry()
        check = self._now().check
        needed = dict.fromkeys([*self._arm.links, *([self._reference.base] if check.index.count else [])])
        if not isinstance(link_poses, Mapping):
            raise PoseError(f"{quoted(link_poses)} given; poses by the names of their links are needed, {{name: T}}")
        if absent := sorted(set(needed) - set(link_poses)):
            raise PoseError(f"links with collision shapes have no pose: {', '.join(map(printable, absent))}")
        poses = [as_pose_array(link_poses[link]) for link in needed]
        try:
            batch = np.broadcast_shapes(*(pose.shape[:-2] for pose in poses))
        except ValueError:
            raise PoseError("the link poses are stacks whose shapes do not broadcast") from None
        for link, T in zip(needed, poses, strict=True):
            if otherwise is False and (bad := inputs.first_bad(T)) is not None:
                raise PoseError(f"the pose of link {quoted(link)} is not finite: {T[bad]}", bad[:-2] or None)
        stack = np.stack([np.broadcast_to(pose, (*batch, 4, 4)) for pose in poses], axis=-3)
        out = np.full(batch, otherwise)
        for index in finite(stack.reshape(*batch, -1)):
            pairs, least, placing = check.pairs_at(dict(zip(needed, stack[index], strict=True)), otherwise is False)
            if otherwise is False:
                out[index] = any(check.touches(placing, pair) for pair in pairs)
            else:
                out[index] = check.nearest(placing, pairs, least)[1]
        return out.item() if out.ndim == 0 else out
