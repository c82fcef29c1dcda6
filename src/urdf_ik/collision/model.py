"""Collision and distance of an arm's links, among themselves and with a world, through Pinocchio and coal."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from urdf_ik.chain import from_urdf
from urdf_ik.collision import geometry, swept, table
from urdf_ik.collision.scene import ArmShapes, Scene
from urdf_ik.errors import JointVectorError, PoseError, UrdfError, WorldError
from urdf_ik.reference import Reference, finite
from urdf_ik.urdf import srdf as srdf_reader

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.collision.swept import Motions
    from urdf_ik.collision.table import Table
    from urdf_ik.collision.world import World
    from urdf_ik.urdf import UrdfModel

    Array = NDArray[np.float64]
    Pair = tuple[str, str]

SAMPLES = 200
"""Random joint vectors by which pairs that always collide are found."""

ALWAYS = 0.95
"""Share of the sampled joint vectors from which on a pair counts as always colliding."""

SEED = 0
"""Seed of these joint vectors: the same URDF gives the same pairs."""


class Nearest(NamedTuple):
    """Two links, or a link and an obstacle, and the distance between them [m]; 0 where they collide."""

    links: tuple[str, str]
    distance: float


class _Seen(NamedTuple):
    """What a model looks at while the world's version stays the same."""

    version: int
    scene: Scene
    table: Table


class CollisionModel:
    """The collision shapes of a URDF and of a world, and which pairs of them must not touch.

    Joints outside the chain stay at zero; a joint that mimics another follows it. Meshes are surfaces: one that lies
    wholly inside another touches nothing. The same joint vector gives the same answer, whatever was asked before.
    A model does not change: :meth:`in_world`, :meth:`allow` and :meth:`check` return new ones, which share the shapes.
    The world may change, and counts as it is at the moment of a question. One model may be used from any number of
    threads.

    Attributes:
        joint_names: joints of a joint vector, base to tip.
        world: the world, or None.
    """

    def __init__(
        self,
        model: UrdfModel,
        base: str | None = None,
        tip: str | None = None,
        *,
        srdf: str | os.PathLike[str] | bytes | None = None,
        samples: int = SAMPLES,
        seed: int = SEED,
        locked: Mapping[str, float] | None = None,
    ) -> None:
        """Read the collision shapes and decide which pairs to check.

        Args:
            model: the URDF as it was read; meshes come from its ``package_dirs`` only.
            base: base link; the root where left out.
            tip: tip link; the end of the only movable chain where left out.
            srdf: path or text of an SRDF whose ``disable_collisions`` are allowed pairs.
            samples: random joint vectors by which pairs that always collide are found; 0: none are sought.
            seed: seed of these joint vectors.
            locked: joints that are no part of a joint vector but stand at these values [rad or m].

        Raises:
            UrdfError: the SRDF is broken, or names a link that the URDF does not have.
            ChainError: base or tip is unknown, or the tip is ambiguous.
            UnsupportedArm: the chain has a joint that one number does not describe.
        """
        self._reference = Reference(model, base, tip, locked=locked)
        self.joint_names = self._reference.joint_names
        self.world: World | None = None
        self._links = model.links
        self._changes: dict[Pair, bool] = {}
        self._error: UrdfError | None = None
        self._seen: _Seen | None = None
        # The model that ``in_world`` made last: the same world is asked about again and again.
        self._last: CollisionModel | None = None
        disabled = () if srdf is None else srdf_reader.disabled_pairs(srdf, model.links)
        try:
            shapes = geometry.build(model, self._reference.pin_model)
        except UrdfError as error:
            self._error = error
            return
        chain = from_urdf(model, base, tip).lock(locked or {})
        self._arm = ArmShapes(self._reference, chain, shapes)
        rank = {link: i for i, link in enumerate(model.links)}
        excused = {table.ordered(*pair, rank) for pair in disabled}
        self._allowed, self._pairs = table.among_links(self._arm, rank, excused)
        if samples:
            kept = [pair for pair in self._pairs if pair.names not in self._allowed]
            always = table.always_colliding(Scene(self._arm, (), kept), ALWAYS, samples, seed)
            self._allowed.update(dict.fromkeys(always, table.ALWAYS_COLLIDE))

    @property
    def has_geometry(self) -> bool:
        """Whether there is something to check; if not, every check raises, and ``missing`` says why."""
        return self._error is None

    @property
    def missing(self) -> str:
        """What is missing where ``has_geometry`` is false, else ''."""
        return "" if self._error is None else str(self._error)

    @property
    def allowed_pairs(self) -> Mapping[Pair, str]:
        """Pairs that may touch, in the URDF's order of links and the world's of obstacles, to the reason.

        Reasons are 'rigid', 'adjacent', 'srdf', 'always' and 'allowed'.
        """
        return MappingProxyType({}) if self._error else self._now().table.allowed

    @property
    def checked_pairs(self) -> tuple[Pair, ...]:
        """Pairs that must not touch, two links or a link and an obstacle."""
        return () if self._error else self._now().table.checked

    def table(self) -> Table:
        """The allowed-collision table, to be read and printed; :meth:`allow` and :meth:`check` change it.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
        """
        self._require_geometry()
        return self._now().table

    def in_world(self, world: World | None) -> CollisionModel:
        """This model among the obstacles of a world, which may be changed later; itself where ``world`` is None.

        Every link that the joint vector moves against the base link is checked against every obstacle. The other links
        stand on the world, and may touch it ('rigid').
        """
        if world is None or world is self.world:
            return self
        last = self._last
        if last is None or last.world is not world:
            last = self._copy()
            last.world = world
            self._last = last
        return last

    def allow(self, first: str, second: str) -> CollisionModel:
        """This model with one more pair that may touch.

        Args:
            first: a link, or an obstacle of the world.
            second: another one.

        Raises:
            WorldError: there is no such link or obstacle, or it has no shape.
            UrdfError: there are no collision shapes, or not all of them were found.

        Example:
            >>> import urdf_ik
            >>> model = urdf_ik.load("zyyzyz_6r").collision_model
            >>> pair = model.checked_pairs[0]
            >>> model.allow(*pair).allowed_pairs[pair]
            'allowed'
        """
        return self._changed(first, second, False)

    def check(self, first: str, second: str) -> CollisionModel:
        """This model with a pair that must not touch, whatever allowed it to.

        Args:
            first: a link, or an obstacle of the world.
            second: another one.

        Raises:
            WorldError: there is no such link or obstacle, or it has no shape.
            UrdfError: there are no collision shapes, or not all of them were found.
        """
        return self._changed(first, second, True)

    @property
    def is_changed(self) -> bool:
        """Whether anything but the URDF decides what is checked: an SRDF, :meth:`allow` or :meth:`check`, a world."""
        return self._error is None and bool(self._changes or self.world or table.SRDF in self._allowed.values())

    def rebuilt(
        self, model: UrdfModel, base: str | None, tip: str | None, locked: Mapping[str, float] | None
    ) -> CollisionModel:
        """The model of a URDF that has this one's links and more, with this one's SRDF, changes and world."""
        out = type(self)(model, base, tip, locked=locked)
        if out._error is None:
            out._allowed.update({pair: why for pair, why in self._allowed.items() if why == table.SRDF})
        out._changes, out.world = dict(self._changes), self.world
        return out

    def in_collision(self, q: ArrayLike, margin: float = 0.0) -> bool | NDArray[np.bool_]:
        """Whether something touches that must not.

        Args:
            q: (..., n) rad or m; rows that are not finite are not checked and give False.
            margin: m that the bodies must stay apart.

        Returns:
            A bool for one joint vector, else (...) bool.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            JointVectorError: the last dimension is not n.
            ArgumentError: ``margin`` is negative or not finite.
        """
        swept.check_margin(margin)
        Q, places, scene = self._rows(q)
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
            JointVectorError: the last dimension is not n.
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
            Pairs of names, in the order of ``checked_pairs``; none where q is not finite.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            JointVectorError: q is no (n,).
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
            The pair and its distance; where several collide, one of them. None where no pair is checked or q is not
            finite.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            JointVectorError: q is no (n,).
        """
        Q, scene, _ = self._one(q)
        for part, placed in scene.chunks(Q):
            k, distance = scene.nearest(scene.place(Q[part.start]), scene.closest(placed)[0])
            if k is not None:
                return Nearest(scene.pairs[k].names, distance)
        return None

    def motions_free(self, q0: ArrayLike, q1: ArrayLike, margin: float = 0.0) -> Motions:
        """Which straight motions in joint space are free from end to end, proven; see :func:`swept.motions`.

        Args:
            q0: (k, n) rad or m, where the motions begin.
            q1: (k, n) rad or m, where they end; every joint goes its way in a straight line, turns included.
            margin: m that the bodies must stay apart.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            JointVectorError: the arrays do not fit the arm or each other, or are not finite.
            ArgumentError: ``margin`` is negative or not finite.
        """
        swept.check_margin(margin)
        self._require_geometry()
        start, end = (self._reference.vectors(q) for q in (q0, q1))
        if start.ndim != 2 or start.shape != end.shape:
            raise JointVectorError(
                f"motions from {start.shape} to {end.shape} given; both must be (k, {len(self.joint_names)})"
            )
        for name, array in (("q0", start), ("q1", end)):
            if len(bad := np.argwhere(~np.isfinite(array))):
                raise JointVectorError(f"{name}{bad[0].tolist()} is {array[tuple(bad[0])]}; a motion's ends are finite")
        return swept.motions(self._now().scene, start, end, margin)

    def in_collision_with(self, link_poses: Mapping[str, ArrayLike]) -> bool | NDArray[np.bool_]:
        """:meth:`in_collision`, with every link where the caller says instead of where Pinocchio puts it.

        Args:
            link_poses: link name to (..., 4, 4) [m], all in one frame; a set with a pose that is not finite gives
                False.

        Returns:
            A bool for one set of poses, else (...) bool.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            PoseError: a link that has a shape has no pose, or a pose is no (..., 4, 4).
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
        """
        distances: float | Array = self._each_placing(link_poses, np.nan)
        return distances

    def _require_geometry(self) -> None:
        if self._error is not None:
            raise self._error.with_traceback(None)

    def _copy(self) -> CollisionModel:
        out = object.__new__(type(self))
        out.__dict__.update(self.__dict__)
        out._seen = out._last = None
        return out

    def _changed(self, first: str, second: str, must_not: bool) -> CollisionModel:
        self._require_geometry()
        obstacles = () if self.world is None else self.world.names
        rank = self._rank(obstacles)
        pair = table.named(first, second, rank, [*dict.fromkeys(self._arm.links), *obstacles])
        if pair[0] in obstacles:
            raise WorldError(f"{first!r} and {second!r} are both obstacles, which stand still; a pair has a link")
        out = self._copy()
        out._changes = {**self._changes, pair: must_not}
        return out

    def _rank(self, obstacles: tuple[str, ...]) -> dict[str, int]:
        rank = {name: i for i, name in enumerate((*self._links, *obstacles))}
        if len(rank) < len(self._links) + len(obstacles):
            same = next(name for name in obstacles if name in self._links)
            raise WorldError(f"the obstacle {same!r} has the name of a link of the arm; give it another")
        return rank

    def _now(self) -> _Seen:
        """The scene and the table of the world as it is."""
        seen, world = self._seen, self.world
        if seen is None or (world is not None and seen.version != world.version):
            version, obstacles = (0, ()) if world is None else world.snapshot()
            names = tuple(each.name for each, _ in obstacles)
            rank = self._rank(names)
            allowed, pairs = table.with_obstacles(self._arm, names)
            made, checked = table.made({**self._allowed, **allowed}, [*self._pairs, *pairs], self._changes, rank)
            self._seen = seen = _Seen(version, Scene(self._arm, obstacles, checked), made)
        return seen

    def _rows(self, q: ArrayLike) -> tuple[Array, NDArray[np.bool_], Scene]:
        """The finite joint vectors (k, n), the places (...) that they come from, and the scene."""
        self._require_geometry()
        Q = self._reference.vectors(q)
        places = np.asarray(np.isfinite(Q).all(axis=-1))
        return np.ascontiguousarray(Q[places]).reshape(-1, Q.shape[-1]), places, self._now().scene

    def _one(self, q: ArrayLike) -> tuple[Array, Scene, tuple[Pair, ...]]:
        """A joint vector as (1, n), or (0, n) where it is not finite, the scene and its pairs."""
        self._require_geometry()
        Q = self._reference.vectors(q)
        if Q.ndim != 1:
            raise JointVectorError(f"one joint vector ({len(self.joint_names)},) is needed, not shape {Q.shape}")
        now = self._now()
        return Q[None][np.isfinite(Q).all(keepdims=True)], now.scene, now.table.checked

    def _each_placing(self, link_poses: Mapping[str, ArrayLike], otherwise: Any) -> Any:
        """Whether each set of link poses collides, or the distances, whichever ``otherwise`` stands for."""
        self._require_geometry()
        scene = self._now().scene
        needed = dict.fromkeys([*self._arm.links, *([self._reference.base] if scene.places else [])])
        if absent := sorted(set(needed) - set(link_poses)):
            raise PoseError(f"links with collision shapes have no pose: {', '.join(absent)}")
        poses = [np.asarray(link_poses[link], dtype=np.float64) for link in needed]
        if any(pose.shape[-2:] != (4, 4) for pose in poses):
            raise PoseError("link poses must be of shape (..., 4, 4)")
        batch = np.broadcast_shapes(*(pose.shape[:-2] for pose in poses))
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
