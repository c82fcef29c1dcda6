"""Self-collision and distance of an arm's links through coal, by Pinocchio's geometry model of the URDF."""

from __future__ import annotations

import threading
import warnings
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pinocchio as pin

from urdf_ik.collision import geometry
from urdf_ik.errors import JointVectorError, PoseError, UrdfError
from urdf_ik.reference import Reference, finite
from urdf_ik.urdf import srdf as srdf_reader

if TYPE_CHECKING:
    import os
    from collections.abc import Callable, Iterable, Mapping

    from numpy.typing import ArrayLike, NDArray

    from urdf_ik.urdf import UrdfModel

    Array = NDArray[np.float64]
    Pair = tuple[str, str]

SAMPLES = 200
"""Random joint vectors by which pairs that always collide are found."""

ALWAYS = 0.95
"""Share of the sampled joint vectors from which on a pair counts as always colliding."""

SEED = 0
"""Seed of these joint vectors: the same URDF gives the same pairs."""

RIGID, ADJACENT, SRDF, ALWAYS_COLLIDE = "rigid", "adjacent", "srdf", "always"
"""Reasons why a pair is allowed to touch: no movable joint between its links, exactly one, a line in the SRDF, or
contact in (nearly) all sampled joint vectors."""


class Nearest(NamedTuple):
    """Two links and the distance between them [m]; 0 where they collide."""

    links: tuple[str, str]
    distance: float


class _Work(threading.local):
    """Scratch memory, one a thread."""

    def __init__(self, model: Any, geometry_data: Any) -> None:
        self.data = model.createData()
        self.geometry = geometry_data.copy()


class CollisionModel:
    """The collision shapes of a URDF, and which pairs of its links must not touch.

    Joints outside the chain stay at zero; a joint that mimics another follows it. Meshes are surfaces: one that lies
    wholly inside another touches nothing. The same joint vector gives the same answer, whatever was asked before.
    One object may be used from any number of threads.

    Attributes:
        allowed_pairs: (link, link) that may touch, in the URDF's order of links, to the reason: 'rigid', 'adjacent',
            'srdf' or 'always'.
        checked_pairs: (link, link) that must not touch.
        joint_names: joints of a joint vector, base to tip.
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
        self._error: UrdfError | None = None
        self.allowed_pairs: Mapping[Pair, str] = MappingProxyType({})
        self.checked_pairs: tuple[Pair, ...] = ()
        disabled = () if srdf is None else srdf_reader.disabled_pairs(srdf, model.links)
        try:
            self._geometry = geometry.build(model, self._reference.pin_model)
        except UrdfError as error:
            self._error = error
            return
        shapes = self._geometry.geometryObjects
        frames = self._reference.pin_model.frames
        self._links = [frames[shape.parentFrame].name for shape in shapes]
        # From the link to its shape; Pinocchio keeps it from the movable joint that carries the link.
        self._offsets = [frames[shape.parentFrame].placement.actInv(shape.placement) for shape in shapes]
        self._spheres = geometry.bounding_spheres(shapes)
        self._choose_pairs(model, disabled, samples, seed)

    @property
    def has_geometry(self) -> bool:
        """Whether there is something to check; if not, every check raises, and ``missing`` says why."""
        return self._error is None

    @property
    def missing(self) -> str:
        """What is missing where ``has_geometry`` is false, else ''."""
        return "" if self._error is None else str(self._error)

    def in_collision(self, q: ArrayLike) -> bool | NDArray[np.bool_]:
        """Whether links touch that must not.

        Args:
            q: (..., n) rad or m; rows that are not finite are not checked and give False.

        Returns:
            A bool for one joint vector, else (...) bool.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            JointVectorError: the last dimension is not n.
        """
        out = self._each(q, self._collides, False)
        return bool(out) if out.ndim == 0 else out

    def distance(self, q: ArrayLike) -> float | Array:
        """Smallest distance between links that must not touch.

        Args:
            q: (..., n) rad or m; rows that are not finite give NaN.

        Returns:
            A float for one joint vector, else (...) [m]: 0 in collision, infinite where no pair is checked.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            JointVectorError: the last dimension is not n.
        """
        out = self._each(q, lambda geometry: self._nearest(geometry)[1], np.nan)
        return float(out) if out.ndim == 0 else out

    def colliding_pairs(self, q: ArrayLike) -> tuple[Pair, ...]:
        """Links that touch and must not.

        Args:
            q: (n,) rad or m.

        Returns:
            Pairs of link names, in the URDF's order of links; none where q is not finite.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            JointVectorError: q is no (n,).
        """
        Q = self._one(q)
        found = set()
        for index in finite(Q):
            geometry = self._placed(Q[index])
            pin.computeCollisions(self._geometry, geometry, False)
            found = {pair for k, pair in enumerate(self._pair_of) if geometry.collisionResults[k].isCollision()}
        return tuple(pair for pair in self.checked_pairs if pair in found)

    def nearest_pair(self, q: ArrayLike) -> Nearest | None:
        """The two links that come closest, of those that must not touch.

        Args:
            q: (n,) rad or m.

        Returns:
            The pair and its distance; where several collide, one of them. None where no pair is checked or q is not
            finite.

        Raises:
            UrdfError: there are no collision shapes, or not all of them were found.
            JointVectorError: q is no (n,).
        """
        Q = self._one(q)
        for index in finite(Q):
            k, distance = self._nearest(self._placed(Q[index]))
            if k is not None:
                return Nearest(self._pair_of[k], distance)
        return None

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
        out = self._each_placing(link_poses, self._collides, False)
        return bool(out) if out.ndim == 0 else out

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
        out = self._each_placing(link_poses, lambda geometry: self._nearest(geometry)[1], np.nan)
        return float(out) if out.ndim == 0 else out

    def _require_geometry(self) -> None:
        if self._error is not None:
            raise self._error.with_traceback(None)

    def _each(self, q: ArrayLike, ask: Callable[[Any], Any], otherwise: Any) -> NDArray[Any]:
        """``ask`` the placed shapes of every joint vector."""
        self._require_geometry()
        Q = self._reference.vectors(q)
        out = np.full(Q.shape[:-1], otherwise)
        for index in finite(Q):
            out[index] = ask(self._placed(Q[index]))
        return out

    def _one(self, q: ArrayLike) -> Array:
        self._require_geometry()
        Q = self._reference.vectors(q)
        if Q.ndim != 1:
            raise JointVectorError(f"one joint vector ({len(self.joint_names)},) is needed, not shape {Q.shape}")
        return Q

    def _each_placing(self, link_poses: Mapping[str, ArrayLike], ask: Callable[[Any], Any], otherwise: Any) -> Any:
        """``ask`` the shapes placed with every set of link poses."""
        self._require_geometry()
        if absent := sorted(set(self._links) - set(link_poses)):
            raise PoseError(f"links with collision shapes have no pose: {', '.join(absent)}")
        poses = [np.asarray(link_poses[link], dtype=np.float64) for link in self._links]
        if any(pose.shape[-2:] != (4, 4) for pose in poses):
            raise PoseError("link poses must be of shape (..., 4, 4)")
        batch = np.broadcast_shapes(*(pose.shape[:-2] for pose in poses))
        stack = np.stack([np.broadcast_to(pose, (*batch, 4, 4)) for pose in poses], axis=-3)
        out = np.full(batch, otherwise)
        geometry = self._work.geometry
        for index in finite(stack.reshape(*batch, -1)):
            for i, (pose, offset) in enumerate(zip(stack[index], self._offsets, strict=True)):
                geometry.oMg[i] = pin.SE3(pose[:3, :3], pose[:3, 3]) * offset
            out[index] = ask(geometry)
        return out

    def _placed(self, q: Array) -> Any:
        """The calling thread's geometry data with every shape where Pinocchio puts it."""
        work, reference = self._work, self._reference
        pin.updateGeometryPlacements(
            reference.pin_model, work.data, self._geometry, work.geometry, reference.configuration(q)
        )
        return work.geometry

    def _collides(self, geometry: Any) -> bool:
        return bool(pin.computeCollisions(self._geometry, geometry, True))

    def _nearest(self, geometry: Any) -> tuple[int | None, float]:
        """Index of the nearest pair of shapes and its distance; pairs with farther bounding spheres are skipped."""
        centres = np.array([M.act(c) for M, c in zip(geometry.oMg, self._spheres[0], strict=True)]).reshape(-1, 3)
        gaps = np.linalg.norm(centres[self._first] - centres[self._second], axis=1) - self._reach
        best, at = np.inf, None
        for k in np.argsort(gaps, kind="stable"):
            if gaps[k] >= best or best == 0.0:
                break
            found = pin.computeDistance(self._geometry, geometry, int(k)).min_distance
            if found < best:
                best, at = max(float(found), 0.0), int(k)
        return at, best

    def _choose_pairs(self, model: UrdfModel, disabled: Iterable[Pair], samples: int, seed: int) -> None:
        rank = {link: i for i, link in enumerate(model.links)}

        def ordered(a: str, b: str) -> Pair:
            return (a, b) if rank[a] < rank[b] else (b, a)

        excused = {ordered(*pair) for pair in disabled}
        parents, shapes = self._reference.pin_model.parents, self._geometry.geometryObjects
        allowed: dict[Pair, str] = {}
        kept: list[tuple[Pair, int, int]] = []
        for j in range(len(shapes)):
            for i in range(j):
                if self._links[i] == self._links[j]:
                    continue
                pair = ordered(self._links[i], self._links[j])
                a, b = shapes[i].parentJoint, shapes[j].parentJoint
                if a == b:
                    allowed[pair] = RIGID
                elif parents[a] == b or parents[b] == a:
                    allowed[pair] = ADJACENT
                elif pair in excused:
                    allowed[pair] = SRDF
                else:
                    kept.append((pair, i, j))
        self._use(kept)
        always = self._always(samples, seed) if samples else set()
        allowed.update(dict.fromkeys(always, ALWAYS_COLLIDE))
        self._use([each for each in kept if each[0] not in always])
        by_rank = sorted(allowed, key=lambda pair: (rank[pair[0]], rank[pair[1]]))
        self.allowed_pairs = MappingProxyType({pair: allowed[pair] for pair in by_rank})
        self.checked_pairs = tuple(
            sorted(dict.fromkeys(self._pair_of), key=lambda pair: (rank[pair[0]], rank[pair[1]]))
        )

    def _use(self, pairs: list[tuple[Pair, int, int]]) -> None:
        """Check these pairs of shapes, and no others."""
        self._geometry.removeAllCollisionPairs()
        for _, i, j in pairs:
            self._geometry.addCollisionPair(pin.CollisionPair(i, j))
        self._pair_of = [pair for pair, _, _ in pairs]
        self._first = np.array([i for _, i, _ in pairs], dtype=np.intp)
        self._second = np.array([j for _, _, j in pairs], dtype=np.intp)
        self._reach = self._spheres[1][self._first] + self._spheres[1][self._second]
        data = self._geometry.createData()
        with warnings.catch_warnings():
            # coal starts each query from the end of the last one, unless this deprecated attribute is false: answers
            # would depend, in the seventh digit, on what was asked before.
            warnings.simplefilter("ignore", DeprecationWarning)
            for request in (*data.collisionRequests, *data.distanceRequests):
                request.enable_cached_gjk_guess = False
        self._work = _Work(self._reference.pin_model, data)

    def _always(self, samples: int, seed: int) -> set[Pair]:
        """Pairs that collide in nearly all of the sampled joint vectors; a pair that cannot be one is dropped early."""
        lower, upper = self._reference.ranges.T
        rng = np.random.default_rng(seed)
        free = dict.fromkeys(self._pair_of, 0)
        tolerated = round((1.0 - ALWAYS) * samples)
        watched = list(range(len(self._pair_of)))
        for _ in range(samples):
            geometry = self._placed(rng.uniform(lower, upper))
            pin.computeCollisions(self._geometry, geometry, False)
            touching = {self._pair_of[k] for k in watched if geometry.collisionResults[k].isCollision()}
            for pair in free.keys() - touching:
                free[pair] += 1
            for k in watched:
                if free.get(self._pair_of[k], 0) > tolerated:
                    geometry.deactivateCollisionPair(k)
            watched = [k for k in watched if free[self._pair_of[k]] <= tolerated]
            if not watched:
                break
        return {self._pair_of[k] for k in watched}
