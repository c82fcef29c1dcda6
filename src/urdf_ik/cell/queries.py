"""Collision and distance of an arm's links, among themselves and with a world, through Pinocchio and coal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf_ik.cell import swept_motions
from urdf_ik.cell.coal_scene import ArmShapes, Scene
from urdf_ik.cell.reference import Reference, finite
from urdf_ik.errors import ArgumentError, PoseError, UrdfError, printable
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import LARGEST

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.cell.allowed_collisions import Table
    from urdf_ik.cell.swept_motions import Motions

    Array = NDArray[np.float64]
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
    """What a model looks at while the world's version stays the same."""

    version: int
    scene: Scene
    table: Table


class Questions:
    """What is asked about a :class:`urdf_ik.cell.CollisionModel`, whatever decides which pairs are checked."""

    joint_names: tuple[str, ...]
    _reference: Reference
    _arm: ArmShapes
    _error: UrdfError | None

    def _now(self) -> Seen:
        """The scene and the table of the world as it is."""
        raise NotImplementedError

    def in_collision(self, q: ArrayLike, margin: float = 0.0) -> bool | NDArray[np.bool_]:
        """Whether something touches that must not.

        Args:
            q: (..., n) rad or m.
            margin: m that the bodies must stay apart.

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
        Q, places, scene = self._rows(q)
        if not places.all():
            row = np.argwhere(~places)[0].tolist()
            raise ArgumentError(
                f"joint vector{row or ''} is not finite, or beyond {LARGEST:g}; what touches at it cannot be known"
            )
        out = np.zeros(len(Q), dtype=np.bool_)
        for part, placed in scene.chunks(Q):
            near = scene.near(placed, margin)
            for i in np.flatnonzero(near.any(axis=1)):
                shapes = scene.place(Q[part.start + i])
                out[part.start + i] = any(scene.touches(shapes, int(k), margin) for k in np.flatnonzero(near[i]))
        whole = np.zeros(places.shape, dtype=np.bool_)
        whole[places] = out
        return bool(whole) if whole.ndim == 0 else whole

    def distance(self, q: ArrayLike) -> float | Array:
        """Smallest distance between what must not touch.

        Args:
            q: (..., n) rad or m; rows that are not finite give NaN.

        Returns:
            A float for one joint vector, else (...) [m]: 0 in collision, infinite where no pair is checked.

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
        Q, places, scene = self._rows(q)
        out = np.empty(len(Q))
        for part, placed in scene.chunks(Q):
            for i, least in enumerate(scene.closest(placed), part.start):
                out[i] = scene.nearest(scene.place(Q[i]), least)[1]
        whole = np.full(places.shape, np.nan)
        whole[places] = out
        return float(whole) if whole.ndim == 0 else whole

    def colliding_pairs(self, q: ArrayLike) -> tuple[Pair, ...]:
        """What touches and must not.

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
        Q, scene, checked = self._one(q)
        found = set()
        for part, placed in scene.chunks(Q):
            shapes = scene.place(Q[part.start])
            for k in np.flatnonzero(scene.near(placed, 0.0)[0]):
                if scene.touches(shapes, int(k)):
                    found.add(scene.pairs[k].names)
        return tuple(pair for pair in checked if pair in found)

    def nearest_pair(self, q: ArrayLike) -> Nearest | None:
        """What comes closest to each other, of that which must not touch.

        Args:
            q: (n,) rad or m.

        Returns:
            The pair and its distance; where several collide, one of them. None where no pair is checked.

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
        Q, scene, _ = self._one(q)
        for part, placed in scene.chunks(Q):
            k, distance = scene.nearest(scene.place(Q[part.start]), scene.closest(placed)[0])
            if k is not None:
                return Nearest(scene.pairs[k].names, distance)
        return None

    def motions_free(self, q0: ArrayLike, q1: ArrayLike, margin: float = 0.0) -> Motions:
        """Which straight motions in joint space are free from end to end, proven; see :func:`swept_motions.motions`.

        Args:
            q0: (k, n) rad or m, where the motions begin.
            q1: (k, n) rad or m, where they end; every joint goes its way in a straight line, turns included.
            margin: m that the bodies must stay apart.

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
        return swept_motions.motions(self._now().scene, start, end, margin)

    def in_collision_with(self, link_poses: Mapping[str, ArrayLike]) -> bool | NDArray[np.bool_]:
        """:meth:`in_collision`, with every link where the caller says instead of where Pinocchio puts it.

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
        """:meth:`distance`, with every link where the caller says instead of where Pinocchio puts it.

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

    def _rows(self, q: ArrayLike) -> tuple[Array, NDArray[np.bool_], Scene]:
        """The finite joint vectors (k, n), the places (...) that they come from, and the scene."""
        self._require_geometry()
        Q = self._reference.vectors(q)
        places = np.asarray((np.abs(Q) <= LARGEST).all(axis=-1))
        rows = np.ascontiguousarray(Q[places]).reshape(int(places.sum()), Q.shape[-1])  # there may be no joints
        return rows, places, self._now().scene

    def _one(self, q: ArrayLike) -> tuple[Array, Scene, tuple[Pair, ...]]:
        """A joint vector as (1, n), the scene and its pairs."""
        self._require_geometry()
        Q = self._reference.vectors(q)
        if Q.ndim != 1:
            raise ArgumentError(f"one joint vector ({len(self.joint_names)},) is needed, not shape {Q.shape}")
        if inputs.first_bad(Q) is not None:
            raise ArgumentError(f"the joint vector {quoted(Q)} is not finite; what is near at it cannot be known")
        now = self._now()
        return Q[None], now.scene, now.table.checked

    def _each_placing(self, link_poses: Mapping[str, ArrayLike], otherwise: Any) -> Any:
        """Whether each set of link poses collides, or the distances, whichever ``otherwise`` stands for."""
        self._require_geometry()
        scene = self._now().scene
        needed = dict.fromkeys([*self._arm.links, *([self._reference.base] if scene.places else [])])
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
        every = range(len(scene.pairs))
        for index in finite(stack.reshape(*batch, -1)):
            shapes = scene.place_at(dict(zip(needed, stack[index], strict=True)))
            if otherwise is False:
                out[index] = any(scene.touches(shapes, k) for k in every)
            else:
                out[index] = scene.nearest(shapes, np.full(len(every), -np.inf))[1]
        return out.item() if out.ndim == 0 else out
