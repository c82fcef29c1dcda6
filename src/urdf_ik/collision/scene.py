"""The shapes of an arm and of a world as coal holds them, at one moment, and the questions to coal about a pair."""

from __future__ import annotations

import threading
import warnings
from typing import TYPE_CHECKING, Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin

from urdf_ik.collision import geometry
from urdf_ik.collision.bodies import Bodies
from urdf_ik.collision.shapes import HalfSpace
from urdf_ik.reference import Reference

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.collision.bodies import Placed
    from urdf_ik.collision.world import Obstacle

    Array = NDArray[np.float64]
    Pair = tuple[str, str]

CHUNK = 128
"""Joint vectors whose bounds are computed at once: few enough to stay in the processor's cache."""


class ShapePair(NamedTuple):
    """Two shapes that must not touch: their owners' names, and their places among the scene's shapes."""

    names: Pair
    first: int
    second: int


class ArmShapes:
    """The collision shapes of a URDF, which no world changes.

    Attributes:
        reference: Pinocchio's model.
        geometry: Pinocchio's geometry model, without pairs.
        links: link of each shape.
        offsets: from the link to its shape.
        bodies: how the shapes move with the joint vector.
    """

    def __init__(self, reference: Reference, chain: Chain, shapes: Any) -> None:
        self.reference, self.geometry = reference, shapes
        frames, objects = reference.pin_model.frames, shapes.geometryObjects
        self.links = [frames[each.parentFrame].name for each in objects]
        # Pinocchio keeps a shape's place from the movable joint that carries the link.
        self.offsets = [frames[each.parentFrame].placement.actInv(each.placement) for each in objects]
        balls = [geometry.covering_balls(each.geometry) for each in objects]
        placed = [[offset.act(c) for c in centres] for offset, (centres, _) in zip(self.offsets, balls, strict=True)]
        self.bodies = Bodies(chain, self.links, np.array(placed), np.array([radii for _, radii in balls]))


class _Work(threading.local):
    """Scratch memory, one a thread."""

    def __init__(self, model: Any, shapes: Any) -> None:
        self.data = model.createData()
        self.geometry = shapes.createData()
        self.request = coal.CollisionRequest()
        with warnings.catch_warnings():
            # coal starts each query from the end of the last one, unless this deprecated attribute is false: answers
            # would depend, in the seventh digit, on what was asked before.
            warnings.simplefilter("ignore", DeprecationWarning)
            self.request.enable_cached_gjk_guess = False
            for request in (*self.geometry.collisionRequests, *self.geometry.distanceRequests):
                request.enable_cached_gjk_guess = False


class Scene:
    """Shapes of an arm, obstacles at fixed places in its base link, and the pairs of them that must not touch.

    Nothing of it changes once it is made; it may be asked from any number of threads.

    Attributes:
        pairs: what is checked, those among links first.
        places: ``pinocchio.SE3`` of each obstacle in the base link.
    """

    def __init__(
        self, arm: ArmShapes, obstacles: Sequence[tuple[Obstacle, Any]] = (), pairs: Sequence[ShapePair] = ()
    ) -> None:
        """Put the obstacles beside the arm.

        Args:
            arm: the arm's shapes.
            obstacles: each with coal's geometry of its shape.
            pairs: what to check; ``second`` counts the obstacles on from the arm's last shape.
        """
        self.arm, self.pairs = arm, tuple(pairs)
        self._shapes = arm.geometry.copy()
        self._shapes.removeAllCollisionPairs()
        base = arm.reference.pin_model.frames[arm.reference.base_frame]
        self.places = [pin.SE3(each.pose) for each, _ in obstacles]
        for (each, solid), place in zip(obstacles, self.places, strict=True):
            # Names of Pinocchio's must differ from those of the arm's shapes.
            shape = pin.GeometryObject(f"world/{each.name}", base.parentJoint, base.placement * place, solid)
            self._shapes.addGeometryObject(shape)
        for pair in self.pairs:
            self._shapes.addCollisionPair(pin.CollisionPair(pair.first, pair.second))
        self._first = np.array([pair.first for pair in self.pairs], dtype=np.intp)
        self._second = np.array([pair.second for pair in self.pairs], dtype=np.intp)
        count = len(arm.links)
        self._among_links = int(np.count_nonzero(self._second < count))
        grown = np.array([0.0] * count + [each.shape.inflation for each, _ in obstacles])
        self._grown: list[float] = grown[self._second].tolist()
        self._work = _Work(arm.reference.pin_model, self._shapes)
        self._place_boxes(obstacles)
        self._choose_joints()

    def _place_boxes(self, obstacles: Sequence[tuple[Obstacle, Any]]) -> None:
        """What holds each obstacle, in the base link: planes of half-spaces, rounded boxes of the others."""
        planes = [
            (i, each.pose, each.shape) for i, (each, _) in enumerate(obstacles) if isinstance(each.shape, HalfSpace)
        ]
        flat = [i for i, _, _ in planes]
        boxed = [i for i in range(len(obstacles)) if i not in flat]
        boxes = [geometry.rounded_box(obstacles[i][0].shape, obstacles[i][1]) for i in boxed]
        poses = np.array([obstacles[i][0].pose for i in boxed]).reshape(-1, 4, 4)
        self._flat, self._boxed = flat, boxed
        centres = np.array([box.centre for box in boxes]).reshape(-1, 3)
        self._into = np.ascontiguousarray(poses[:, :3, :3].transpose(0, 2, 1))
        origin = np.einsum("oij,oj->oi", poses[:, :3, :3], centres) + poses[:, :3, 3]
        self._from = np.einsum("oij,oj->oi", self._into, origin)
        self._half = np.array([box.half for box in boxes]).reshape(-1, 3)
        self._round = np.array([box.radius for box in boxes])
        normals = [pose[:3, :3] @ np.array(shape.normal) for _, pose, shape in planes]
        self._normals = np.array(normals).reshape(-1, 3)
        heights = [shape.offset + n @ pose[:3, 3] for n, (_, pose, shape) in zip(normals, planes, strict=True)]
        self._heights = np.array(heights, dtype=np.float64)

    def _choose_joints(self) -> None:
        """The joints (P, J) that move a pair's first shape against its second, and its second against its first."""
        path, among = self.arm.bodies.path, self._among_links
        ones, others = path[self._first], np.zeros((len(self.pairs), path.shape[1]), dtype=np.bool_)
        others[:among] = path[self._second[:among]]
        self._moves_first = (ones & ~others).astype(np.float64)
        self._moves_second = (others & ~ones).astype(np.float64)[:among]

    # ------------------------------------------------------------ bounds, many joint vectors at a time

    def chunks(self, q: Array) -> Iterator[tuple[slice, Placed]]:
        """The joint vectors (k, n) a chunk at a time, with the bodies placed."""
        for start in range(0, len(q), CHUNK):
            part = slice(start, start + CHUNK)
            yield part, self.arm.bodies.place(q[part])

    def least(self, placed: Placed) -> Array:
        """(k, P) m that the pairs are apart at least, by what holds their shapes; may be negative."""
        k, S, m = placed.centres.shape[:3]
        out = np.empty((k, len(self.pairs)))
        radii, among = self.arm.bodies.radii, self._among_links
        if among:
            first, second = self._first[:among], self._second[:among]
            between = placed.centres[:, first, :, None] - placed.centres[:, second, None]
            gaps = np.sqrt(np.einsum("kpabi,kpabi->kpab", between, between))
            gaps -= radii[first, :, None] + radii[second, None]
            out[:, :among] = gaps.reshape(k, among, -1).min(axis=-1)
        if among < len(self.pairs):
            to_all = np.empty((k, S, len(self._flat) + len(self._boxed)))
            points = placed.centres.reshape(k, S * m, 3)
            if self._boxed:
                inside = np.abs(np.einsum("oij,kpj->kpoi", self._into, points) - self._from)
                outside = np.maximum(inside - self._half, 0.0)
                gaps = np.sqrt(np.einsum("kpoi,kpoi->kpo", outside, outside)) - self._round
                to_all[..., self._boxed] = (gaps.reshape(k, S, m, -1) - radii[..., None]).min(axis=2)
            if self._flat:
                gaps = points @ self._normals.T - self._heights
                to_all[..., self._flat] = (gaps.reshape(k, S, m, -1) - radii[..., None]).min(axis=2)
            out[:, among:] = to_all[:, self._first[among:], self._second[among:] - S]
        return out

    def approach(self, placed: Placed, travel: Array) -> Array:
        """(k, P) m by which pairs can come closer at most on the way from ``placed`` to either end; see `reaches`."""
        reaches = self.arm.bodies.reaches(placed, travel)
        among = self._among_links
        out: Array = np.einsum("kpj,pj->kp", reaches[:, self._first], self._moves_first)
        out[:, :among] += np.einsum("kpj,pj->kp", reaches[:, self._second[:among]], self._moves_second)
        return out

    # ------------------------------------------------------------ coal, one joint vector at a time

    def place(self, q: Array) -> Any:
        """The calling thread's geometry data with every shape where Pinocchio puts it at ``q`` (n,)."""
        work, reference = self._work, self.arm.reference
        configuration = reference.configuration(q)
        pin.updateGeometryPlacements(reference.pin_model, work.data, self._shapes, work.geometry, configuration)
        return work.geometry

    def place_at(self, link_poses: Mapping[str, Array]) -> Any:
        """The same, with every link at the pose (4, 4) that is given, the base link's too where there are obstacles."""
        shapes = self._work.geometry
        se3 = {link: pin.SE3(pose[:3, :3], pose[:3, 3]) for link, pose in link_poses.items()}
        for i, (link, offset) in enumerate(zip(self.arm.links, self.arm.offsets, strict=True)):
            shapes.oMg[i] = se3[link] * offset
        for i, pose in enumerate(self.places, len(self.arm.links)):
            shapes.oMg[i] = se3[self.arm.reference.base] * pose
        return shapes

    def touches(self, shapes: Any, k: int, margin: float = 0.0) -> bool:
        """Whether pair k comes within a margin [m]."""
        request = self._work.request
        request.security_margin = margin + self._grown[k]
        return bool(pin.computeCollision(self._shapes, shapes, k, request))

    def distance(self, shapes: Any, k: int) -> float:
        """How far pair k is apart [m], zero in collision."""
        found = float(pin.computeDistance(self._shapes, shapes, k).min_distance)
        return max(found - self._grown[k], 0.0)
