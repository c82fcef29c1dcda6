"""The shapes of an arm and of a world as coal holds them, at one moment, and the questions to coal about a pair."""

from __future__ import annotations

import heapq
import threading
from typing import TYPE_CHECKING, Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin

from urdf_ik.cell import geometry
from urdf_ik.cell.bodies import Bodies
from urdf_ik.cell.reference import Reference

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from urdf_ik.cell.bodies import Placed
    from urdf_ik.cell.geometry import Solid
    from urdf_ik.cell.world import Obstacle
    from urdf_ik.kinematics.chain import Chain

    Array = NDArray[np.float64]
    Pair = tuple[str, str]

CHUNK = 128
"""Joint vectors whose bounds are computed at once: few enough to stay in the processor's cache."""

QUERY_ERROR = 1e-5
"""What a distance of coal may be too large by [m]: its iterations stop at 1e-6."""


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
        solids: the shapes with their hulls.
        bodies: how the shapes move with the joint vector.
    """

    def __init__(self, reference: Reference, chain: Chain, shapes: Any) -> None:
        self.reference, self.geometry = reference, shapes
        frames, objects = reference.pin_model.frames, shapes.geometryObjects
        self.links = [frames[each.parentFrame].name for each in objects]
        # Pinocchio keeps a shape's place from the movable joint that carries the link.
        self.offsets = [frames[each.parentFrame].placement.actInv(each.placement) for each in objects]
        self.solids = [geometry.solid(each.geometry) for each in objects]
        one = [geometry.one_ball(each.geometry) for each in objects]
        several = [geometry.covering_balls(each.geometry) for each in objects]
        centres = [offset.act(centre) for offset, (centre, _) in zip(self.offsets, one, strict=True)]
        covering = [[offset.act(c) for c in balls] for offset, (balls, _) in zip(self.offsets, several, strict=True)]
        self.bodies = Bodies(
            chain,
            self.links,
            (np.array(centres), np.array([radius for _, radius in one])),
            (np.array(covering), np.array([radii for _, radii in several])),
        )


class _Holds:
    """What holds each of O obstacles: a rounded box in a frame of its own, which may be infinite on some sides.

    Attributes:
        axes: (3, 3, O) that bring points (..., 3) of the base link into the frames.
        origin: (3, O) m, to be subtracted then.
    """

    def __init__(self, obstacles: Sequence[tuple[Obstacle, Solid]]) -> None:
        holds = [geometry.rounded_box(each.shape, solid.exact) for each, solid in obstacles]
        poses = [each.pose @ hold.frame for (each, _), hold in zip(obstacles, holds, strict=True)]
        stack = np.array(poses).reshape(-1, 4, 4)
        self.axes = np.ascontiguousarray(stack[:, :3, :3].transpose(1, 2, 0))
        self.origin = np.einsum("oij,oi->jo", stack[:, :3, :3], stack[:, :3, 3])
        self._low = np.array([hold.low for hold in holds]).reshape(-1, 3).T
        self._high = np.array([hold.high for hold in holds]).reshape(-1, 3).T
        self._radius = np.array([hold.radius for hold in holds])

    def gaps(self, local: Array) -> Array:
        """(k, S, O) m from points (k, S, 3, O) in the frames to the obstacles, not above zero inside."""
        outside = _outside(local, self._low, self._high)
        gaps: Array = _length(outside[:, :, 0], outside[:, :, 1], outside[:, :, 2]) - self._radius
        return gaps

    def gaps_of(self, local: Array, which: NDArray[np.intp]) -> Array:
        """(e, m) m from points (e, m, 3) in the frames of the obstacles ``which`` (e,)."""
        outside = _outside(local, self._low.T[which, None], self._high.T[which, None])
        gaps: Array = _length(outside[..., 0], outside[..., 1], outside[..., 2]) - self._radius[which, None]
        return gaps


class _Work(threading.local):
    """Scratch memory, one a thread."""

    def __init__(self, model: Any, shapes: Any) -> None:
        self.data = model.createData()
        self.geometry = shapes.createData()
        self.request = coal.CollisionRequest()
        # Pinocchio's own requests start each query from the end of the last one: answers would depend, in the seventh
        # digit, on what was asked before. Fresh ones do not.
        for k in range(len(self.geometry.distanceRequests)):
            self.geometry.distanceRequests[k] = coal.DistanceRequest()


class Scene:
    """Shapes of an arm, obstacles at fixed places in its base link, and the pairs of them that must not touch.

    Nothing of it changes once it is made; it may be asked from any number of threads.

    Attributes:
        pairs: what is checked, those among links first.
        places: index of each obstacle among the shapes, and ``pinocchio.SE3`` of it in the base link.
    """

    def __init__(
        self, arm: ArmShapes, obstacles: Sequence[tuple[Obstacle, Solid]] = (), pairs: Sequence[ShapePair] = ()
    ) -> None:
        """Put the obstacles beside the arm.

        Args:
            arm: the arm's shapes.
            obstacles: each with coal's geometry of its shape.
            pairs: what to check; ``second`` counts the obstacles on from the arm's last shape.
        """
        self.arm, self.pairs = arm, tuple(pairs)
        self._first = np.array([pair.first for pair in self.pairs], dtype=np.intp)
        self._second = np.array([pair.second for pair in self.pairs], dtype=np.intp)
        count = len(arm.links)
        self._among_links = int(np.count_nonzero(self._second < count))
        grown = np.array([0.0] * count + [each.shape.inflation for each, _ in obstacles])
        self._grown: list[float] = grown[self._second].tolist()
        self._holds = _Holds(obstacles)
        self._choose_joints()
        self._shapes, self._hulls = self._build(obstacles)
        self._work = _Work(arm.reference.pin_model, self._shapes)

    def _build(self, obstacles: Sequence[tuple[Obstacle, Solid]]) -> tuple[Any, list[int]]:
        """Pinocchio's geometry model: arm, obstacles, then convex hulls.

        Returns:
            The model; for each pair the index of the pair of its hulls in the model, -1 where neither shape has one.
        """
        arm = self.arm
        shapes = arm.geometry.copy()
        shapes.removeAllCollisionPairs()
        base = arm.reference.pin_model.frames[arm.reference.base_frame]
        for each, solid in obstacles:
            # Names of Pinocchio's must differ from those of the arm's shapes.
            place = base.placement * pin.SE3(each.pose)
            shapes.addGeometryObject(pin.GeometryObject(f"world/{each.name}", base.parentJoint, place, solid.exact))
        hull_of = list(range(shapes.ngeoms))
        for i, solid in enumerate([*arm.solids, *(solid for _, solid in obstacles)]):
            if solid.hull is not None:
                whole = shapes.geometryObjects[i]
                hull_of[i] = shapes.addGeometryObject(
                    pin.GeometryObject(f"hull/{whole.name}", whole.parentJoint, whole.placement, solid.hull)
                )
        for pair in self.pairs:
            shapes.addCollisionPair(pin.CollisionPair(pair.first, pair.second))
        hulls = []
        for pair in self.pairs:
            first, second = hull_of[pair.first], hull_of[pair.second]
            differs = (first, second) != (pair.first, pair.second)
            hulls.append(len(shapes.collisionPairs) if differs else -1)
            if differs:
                shapes.addCollisionPair(pin.CollisionPair(first, second))
        self.places = [(len(arm.links) + o, pin.SE3(each.pose)) for o, (each, _) in enumerate(obstacles)]
        self._hull_of = [(i, hull) for i, hull in enumerate(hull_of) if i != hull]
        return shapes, hulls

    def _choose_joints(self) -> None:
        """The joints (P, J) that move a pair's first shape against its second, and its second against its first."""
        path, among = self.arm.bodies.path, self._among_links
        ones, others = path[self._first], np.zeros((len(self.pairs), path.shape[1]), dtype=np.bool_)
        others[:among] = path[self._second[:among]]
        self._moves_first = (ones & ~others).astype(np.float64)
        self._moves_second = (others & ~ones).astype(np.float64)

    # ------------------------------------------------------------ bounds, many joint vectors at a time

    def chunks(self, q: Array) -> Iterator[tuple[slice, Placed]]:
        """The joint vectors (k, n) a chunk at a time, with the bodies placed."""
        for start in range(0, len(q), CHUNK):
            part = slice(start, start + CHUNK)
            yield part, self.arm.bodies.place(q[part])

    def least(self, placed: Placed) -> Array:
        """(k, P) m that the pairs are apart at least, by one ball about each shape; may be negative."""
        points, radii, among = placed.centres, self.arm.bodies.ball_radii, self._among_links
        k, S = points.shape[:2]
        out = np.empty((k, len(self.pairs)))
        first, second = self._first[:among], self._second[:among]
        between = points[:, first] - points[:, second]
        out[:, :among] = _length(between[..., 0], between[..., 1], between[..., 2]) - (radii[first] + radii[second])
        if among < len(self.pairs):
            local = (points.reshape(-1, 3) @ self._holds.axes.reshape(3, -1)).reshape(k, S, 3, -1) - self._holds.origin
            gaps = self._holds.gaps(local) - radii[:, None]
            out[:, among:] = gaps[:, self._first[among:], self._second[among:] - S]
        return out

    def gaps_of(self, placed: Placed, rows: NDArray[np.intp], pairs: NDArray[np.intp]) -> Array:
        """(e, m, m) m that the balls of the one shape are apart at least from those of the other: of pairs in rows.

        An obstacle has no balls: there the last dimension repeats one number.
        """
        m, radii, S = self.arm.bodies.radii.shape[1], self.arm.bodies.radii, len(self.arm.links)
        out = np.empty((len(rows), m, m))
        first, second = self._first[pairs], self._second[pairs]
        points = self.arm.bodies.balls(placed, rows, first)
        links = np.flatnonzero(second < S)
        if len(links):
            others = self.arm.bodies.balls(placed, rows[links], second[links])
            between = points[links, :, None] - others[:, None]
            gaps = _length(between[..., 0], between[..., 1], between[..., 2])
            out[links] = gaps - (radii[first[links], :, None] + radii[second[links], None])
        solids = np.flatnonzero(second >= S)
        if len(solids):
            which = second[solids] - S
            local = points[solids] @ self._holds.axes[:, :, which].transpose(2, 0, 1)
            gaps = self._holds.gaps_of(local - self._holds.origin.T[which, None], which)
            out[solids] = (gaps - radii[first[solids]])[..., None]
        return out

    def closest(self, placed: Placed) -> Array:
        """(k, P) m that the pairs are apart at least, by all balls."""
        k, P = len(placed.poses), len(self.pairs)
        rows, pairs = (index.reshape(-1) for index in np.indices((k, P)))
        return np.asarray(self.gaps_of(placed, rows, pairs).min(axis=(1, 2)).reshape(k, P))

    def near(self, placed: Placed, margin: float) -> NDArray[np.bool_]:
        """(k, P) which pairs may be apart by no more than a margin [m], by all balls."""
        out: NDArray[np.bool_] = self.least(placed) <= margin
        rows, pairs = np.nonzero(out)
        out[rows, pairs] = self.gaps_of(placed, rows, pairs).min(axis=(1, 2)) <= margin
        return out

    def within_reach(
        self, placed: Placed, travel: Array, margin: float, asked: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], Array]:
        """Which pairs may come within a margin on a motion through the poses ``placed``, and how much closer at most.

        Where two balls stay apart by more than the margin, what they hold does. The bound of a pair is that of the
        balls for which this is open: a long link is fast where it is far from its axis, and often near to others
        where it is slow.

        Args:
            placed: the bodies in the middle of k motions.
            travel: (k, n) rad or m, from there to either end; see :meth:`Bodies.reaches`.
            margin: m.
            asked: (k, P) pairs to look at.

        Returns:
            (k, P) which pairs; (k, P) m, by which the parts of them that are in question come closer at most.
        """
        reaches, among, S = self.arm.bodies.reaches(placed, travel), self._among_links, len(self.arm.links)
        most = reaches.max(axis=2)
        closer: Array = np.einsum("kpj,pj->kp", most[:, self._first], self._moves_first)
        closer[:, :among] += np.einsum("kpj,pj->kp", most[:, self._second[:among]], self._moves_second[:among])
        out: NDArray[np.bool_] = (self.least(placed) <= margin + closer) & asked
        rows, pairs = np.nonzero(out)
        first, second = self._first[pairs], np.minimum(self._second[pairs], S - 1)
        ones = reaches[rows, first] @ self._moves_first[pairs][..., None]
        others = reaches[rows, second] @ self._moves_second[pairs][..., None]
        both = ones + others.swapaxes(1, 2)
        in_question = self.gaps_of(placed, rows, pairs) <= margin + both
        closer[rows, pairs] = np.where(in_question, both, 0.0).max(axis=(1, 2), initial=0.0)
        out[rows, pairs] = in_question.any(axis=(1, 2))
        return out, closer

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
        for i, pose in self.places:
            shapes.oMg[i] = se3[self.arm.reference.base] * pose
        for i, hull in self._hull_of:
            shapes.oMg[hull] = shapes.oMg[i]
        return shapes

    def touches(self, shapes: Any, k: int, margin: float = 0.0) -> bool:
        """Whether pair k comes within a margin [m]; its hulls are asked first."""
        request = self._work.request
        request.security_margin = margin + self._grown[k]
        hulls = self._hulls[k]
        if hulls >= 0 and not pin.computeCollision(self._shapes, shapes, hulls, request):
            return False
        return bool(pin.computeCollision(self._shapes, shapes, k, request))

    def distance(self, shapes: Any, k: int) -> float:
        """How far pair k is apart [m], zero in collision."""
        found = float(pin.computeDistance(self._shapes, shapes, k).min_distance)
        return max(found - self._grown[k], 0.0)

    def nearest(self, shapes: Any, least: Array) -> tuple[int | None, float]:
        """Index of the nearest pair and its distance [m]; ``least`` (P,) m bounds the distances from below."""
        best, at = np.inf, None
        # Bound, whether it is that of the hulls, pair.
        waiting = [(float(bound), False, k) for k, bound in enumerate(least)]
        heapq.heapify(waiting)
        while waiting and best > 0.0:
            bound, of_hulls, k = heapq.heappop(waiting)
            if bound >= best:
                break
            hulls = self._hulls[k]
            if hulls >= 0 and not of_hulls:
                found = float(pin.computeDistance(self._shapes, shapes, hulls).min_distance) - self._grown[k]
                heapq.heappush(waiting, (max(bound, found - QUERY_ERROR), True, k))
            elif (found := self.distance(shapes, k)) < best:
                best, at = found, k
        return at, best


def _length(x: Array, y: Array, z: Array) -> Array:
    """Euclidean length of vectors, component by component."""
    square = x * x
    square += y * y
    square += z * z
    return np.sqrt(square, out=square)


def _outside(local: Array, low: Array, high: Array) -> Array:
    """How far coordinates are below ``low`` or above ``high``, zero between."""
    below = low - local
    np.maximum(below, local - high, out=below)
    return np.maximum(below, 0.0, out=below)
