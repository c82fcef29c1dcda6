"""The obstacles of a world by place: which of them are near given points.

A world's obstacles are sorted into a tree of axis-aligned boxes. A change of the world makes a new index, which shares
the tree with the last one: obstacles that were moved or added since the tree was built are in a short list that every
query scans, and those that were moved or removed no longer count in the tree. When the list becomes too long, the next
index builds a new tree. Large clouds of points have a grid of lower bounds on the distance as well.
"""

import math
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell.shapes import Box, Capsule, Cylinder, Points, Shape, Sphere
from urdf_ik.cell.spatial_search import SLACK, BoxTree, DistanceField, Found
from urdf_ik.typing import Array

Indices = NDArray[np.intp]

FEW = 64
"""A world with at most so many pieces of obstacles has no tree: a scan of all pieces is as fast."""

HOLD = np.dtype(
    [
        ("rotation", np.float64, (3, 3)),
        ("origin", np.float64, (3,)),
        ("low", np.float64, (3,)),
        ("high", np.float64, (3,)),
        ("radius", np.float64),
        ("box_low", np.float64, (3,)),
        ("box_high", np.float64, (3,)),
        ("serial", np.int64),
        ("piece", np.int64),
        ("entry", np.int64),
    ]
)
"""Bound of one piece of an obstacle: all points within ``radius`` of a box, which may be infinite on some sides.

``rotation`` brings points of the base link into the box's frame (``point @ rotation``), ``origin`` is subtracted then;
``box_low`` and ``box_high`` are the corners of an axis-aligned box about it in the base link. ``serial`` is the
obstacle's place in the order of addition, ``piece`` the number of the piece of its shape, ``entry`` its index among the
obstacles of its part of the index.
"""


class Standing(NamedTuple):
    """An obstacle in its present place.

    Attributes:
        name: unique in its world.
        shape: what it is.
        pose: (4, 4) of the shape in the arm's base link [m], read-only.
        serial: its place in the order of addition.
    """

    name: str
    shape: Shape
    pose: Array
    serial: int


class _Part(NamedTuple):
    """Some obstacles and what holds their pieces.

    Attributes:
        entries: the obstacles.
        holds: (n,) of ``HOLD``.
        slots: name of an obstacle to its first piece and the one behind its last.
        clouds: those of the obstacles that are clouds of points.
    """

    entries: list[Standing]
    holds: NDArray[np.void]
    slots: dict[str, tuple[int, int]]
    clouds: list[Standing]


class ObstacleIndex:
    """The pieces of a world's obstacles. A simple shape is one piece, a large cloud or mesh has many.

    A piece is known by its slot: those in the tree first, then those in the list. An index does not change, and may be
    used from any number of threads.

    Attributes:
        count: slots, those of pieces that are no longer present among them.
    """

    def __init__(self, tree: BoxTree | None, fixed: _Part, present: NDArray[np.bool_], loose: _Part) -> None:
        """Take the parts as they are; see :func:`index_of`."""
        self._tree, self._fixed, self._present, self._loose = tree, fixed, present, loose
        self.count = len(fixed.holds) + len(loose.holds)
        self._low = np.ascontiguousarray(loose.holds["box_low"].T)
        self._high = np.ascontiguousarray(loose.holds["box_high"].T)
        self._solids: dict[int, Any] = {}  # of the slots that were asked for

    @property
    def has_tree(self) -> bool:
        """Whether there are so many pieces that there is a tree of them."""
        return self._tree is not None

    def __len__(self) -> int:
        """Number of obstacles."""
        return len(self._loose.entries) + sum(bool(self._present[first]) for first, _ in self._fixed.slots.values())

    def changed(self, names: Mapping[str, Standing | None], every: Iterable[Standing]) -> "ObstacleIndex":
        """The index after some obstacles were moved, added or removed.

        Args:
            names: each of these obstacles as it is now; None: it was removed.
            every: all obstacles as they are now, looked at where a new tree is due.
        """
        now = [obstacle for obstacle in names.values() if obstacle is not None]
        stay = [obstacle for obstacle in self._loose.entries if obstacle.name not in names]
        most = max(FEW, 4 * math.isqrt(len(self._fixed.holds)))
        gone = [self._fixed.slots[name] for name in names if name in self._fixed.slots]
        absent = int(np.count_nonzero(~self._present)) + sum(end - first for first, end in gone)
        if self._loose.holds.size + len(now) > most or absent > most:
            return index_of(every)
        present = self._present
        if any(self._present[first] for first, _ in gone):
            present = self._present.copy()
            for first, end in gone:
                present[first:end] = False
        if not stay:
            return ObstacleIndex(self._tree, self._fixed, present, _part(now))
        loose = self._loose.holds
        kept = loose[[self._loose.entries[e].name not in names for e in loose["entry"].tolist()]]
        old = _numbered(stay, kept)
        new = _part(now)
        return ObstacleIndex(self._tree, self._fixed, present, _joined(old, new))

    def holds(self, slots: Indices) -> NDArray[np.void]:
        """(e,) of ``HOLD``: what holds the pieces in these slots (e,)."""
        fixed = len(self._fixed.holds)
        if not fixed:
            return self._loose.holds.take(slots)
        # Records are taken six times as fast by `take` as by their indices.
        out = self._fixed.holds.take(slots, mode="clip")
        loose = slots >= fixed
        if loose.any():
            out[loose] = self._loose.holds.take(slots[loose] - fixed)
        return out

    def standing(self, slot: int) -> Standing:
        """The obstacle that the piece in a slot is part of."""
        part, at = self._at(slot)
        return part.entries[int(part.holds["entry"][at])]

    def solid(self, slot: int) -> Any:
        """Coal's geometry of the piece in a slot."""
        solid = self._solids.get(slot)
        if solid is None:
            from urdf_ik.cell.coal_shapes import pieces_of

            part, at = self._at(slot)
            solid = self._solids[slot] = pieces_of(self.standing(slot).shape).solid(int(part.holds["piece"][at]))
        return solid

    @cached_property
    def clouds(self) -> list[tuple[Standing, range, DistanceField]]:
        """Clouds of points that have a distance field, as they stand now, with the slots of their pieces."""
        from urdf_ik.cell.coal_shapes import pieces_of

        # One that was moved is in the list, and still in the tree where it stood.
        there = [obstacle for obstacle in self._fixed.clouds if self._present[self._fixed.slots[obstacle.name][0]]]
        clouds = [
            (obstacle, self.slots_of(obstacle.name), pieces_of(obstacle.shape).field)
            for obstacle in (*there, *self._loose.clouds)
        ]
        return [(obstacle, slots, field) for obstacle, slots, field in clouds if field is not None]

    def slots_of(self, name: str) -> range:
        """The slots of an obstacle's pieces, empty where there is no such obstacle."""
        if name in self._loose.slots:
            fixed = len(self._fixed.holds)
            first, end = self._loose.slots[name]
            return range(fixed + first, fixed + end)
        first, end = self._fixed.slots.get(name, (0, 0))
        return range(first, end) if end and self._present[first] else range(0)

    def names(self) -> list[str]:
        """Names of all obstacles, in the order of their addition."""
        there = [self._fixed.entries[e] for e in np.unique(self._fixed.holds["entry"][self._present])]
        return [
            obstacle.name for obstacle in sorted([*there, *self._loose.entries], key=lambda obstacle: obstacle.serial)
        ]

    def near(self, points: Array, radii: Array, row: Indices, most: Indices | None = None) -> Found:
        """Slots of the pieces whose axis-aligned boxes lie within ``radii`` (p,) m of points (p, 3).

        Args:
            points: (p, 3) m in the base link.
            radii: (p,) m, not negative.
            row: (p,) row that each point is part of; see :meth:`BoxTree.within`.
            most: (r,) how much of the tree is looked at for a row; None: all that is near.
        """
        fixed = len(self._fixed.holds)
        crowded = np.zeros(0 if most is None else len(most), dtype=np.bool_)
        point = slot = np.zeros(0, dtype=np.intp)
        if self._tree is not None:
            near_boxes = self._tree.within(points, radii, row, most)
            there = self._present[near_boxes.box]
            point, slot, crowded = near_boxes.point[there], near_boxes.box[there], near_boxes.crowded
        if len(self._loose.holds):
            gaps = self._loose_gaps(points)
            near = radii + SLACK * (1.0 + radii + np.abs(points).max(axis=1, initial=0.0))
            close, at = np.nonzero(gaps <= (near * near)[:, None])
            point, slot = np.concatenate([point, close]), np.concatenate([slot, at + fixed])
        return Found(point, slot, crowded)

    def nearby(self, points: Array) -> tuple[Indices, Indices]:
        """Pairs of a point and a slot near it, mostly the nearest: at most two for each of the points (p, 3)."""
        rows = np.arange(len(points))
        point = slot = np.zeros(0, dtype=np.intp)
        if self._tree is not None:
            slot = self._tree.nearby(points, self._present)
            point, slot = rows[slot >= 0], slot[slot >= 0]
        if len(self._loose.holds):
            point = np.concatenate([point, rows])
            slot = np.concatenate([slot, self._loose_gaps(points).argmin(axis=1) + len(self._fixed.holds)])
        return point, slot

    def _loose_gaps(self, points: Array) -> Array:
        """(p, M) m^2 from points to the boxes about the pieces in the list."""
        total = 0.0
        for axis in range(3):
            at = points[:, axis, None]
            gap = np.maximum(self._low[axis] - at, at - self._high[axis])
            np.maximum(gap, 0.0, out=gap)
            gap *= gap
            total = total + gap
        return np.asarray(total)

    def _at(self, slot: int) -> tuple[_Part, int]:
        fixed = len(self._fixed.holds)
        return (self._fixed, slot) if slot < fixed else (self._loose, slot - fixed)


def index_of(every: Iterable[Standing]) -> ObstacleIndex:
    """An index of obstacles, with a tree where they are many."""
    whole = _part(list(every))
    none = _part([])
    if len(whole.holds) <= FEW:
        return ObstacleIndex(None, none, np.zeros(0, dtype=np.bool_), whole)
    finite = np.isfinite(whole.holds["box_low"]).all(axis=1) & np.isfinite(whole.holds["box_high"]).all(axis=1)
    if not finite.all():
        infinite = set(whole.holds["entry"][~finite].tolist())
        rest = [obstacle for e, obstacle in enumerate(whole.entries) if e not in infinite]
        none = _part([whole.entries[e] for e in sorted(infinite)])
        whole = _numbered(rest, whole.holds[finite])
        if not len(whole.holds):
            return ObstacleIndex(None, whole, np.zeros(0, dtype=np.bool_), none)
    tree = BoxTree(whole.holds["box_low"], whole.holds["box_high"])
    return ObstacleIndex(tree, whole, np.ones(len(whole.holds), dtype=np.bool_), none)


def _part(entries: list[Standing]) -> _Part:
    """Obstacles with what holds their pieces."""
    from urdf_ik.cell.coal_shapes import pieces_of

    out = np.empty(len(entries), dtype=HOLD)
    if entries:
        out["serial"] = [obstacle.serial for obstacle in entries]
    out["entry"], out["piece"] = np.arange(len(entries)), 0
    shapes = [obstacle.shape for obstacle in entries]
    own: dict[int, Any] = {}
    half = np.zeros((len(entries), 3))
    radius = np.zeros(len(entries))
    for i, shape in enumerate(shapes):
        match shape:
            case Box(size):
                half[i] = size
            case Sphere(r):
                radius[i] = r
            case Capsule(r, length):
                half[i, 2], radius[i] = length, r
            case Cylinder(r, length):
                half[i] = 2.0 * r, 2.0 * r, length
            case _:
                own[i] = pieces_of(shape)
    half *= 0.5
    out["low"], out["high"], out["radius"] = -half, half, radius
    poses = np.array([obstacle.pose for obstacle in entries]).reshape(-1, 4, 4)
    if own:
        counts = np.ones(len(entries), dtype=np.intp)
        counts[list(own)] = [pieces.count for pieces in own.values()]
        out, poses = np.repeat(out, counts), np.repeat(poses, counts, axis=0)
        ends = np.cumsum(counts)
        for i, pieces in own.items():
            piece = slice(ends[i] - counts[i], ends[i])
            out["piece"][piece] = np.arange(counts[i])
            out["low"][piece], out["high"][piece], out["radius"][piece] = pieces.low, pieces.high, pieces.radius
            poses[piece] = poses[piece] @ pieces.frame
    _place(out, poses)
    if not own:
        return _Part(entries, out, {obstacle.name: (i, i + 1) for i, obstacle in enumerate(entries)}, [])
    return _numbered(entries, out)


def _place(holds: NDArray[np.void], poses: Array) -> None:
    """Write where the boxes with these poses (n, 4, 4) in the base link are, and the axis-aligned boxes about them."""
    rotation, at = poses[:, :3, :3], poses[:, :3, 3]
    holds["rotation"], holds["origin"] = rotation, np.einsum("oij,oi->oj", rotation, at)
    low, high, radius = holds["low"], holds["high"], holds["radius"][:, None]
    finite = (np.isfinite(low) & np.isfinite(high)).all(axis=1)[:, None]
    low, high = np.where(finite, low, 0.0), np.where(finite, high, 0.0)
    middle = np.einsum("oij,oj->oi", rotation, 0.5 * (low + high)) + at
    reach = np.einsum("oij,oj->oi", np.abs(rotation), 0.5 * (high - low)) + radius
    holds["box_low"] = np.where(finite, middle - reach, -np.inf)
    holds["box_high"] = np.where(finite, middle + reach, np.inf)


def _numbered(entries: list[Standing], holds: NDArray[np.void]) -> _Part:
    """A part of obstacles and holds whose ``entry`` numbers may have gaps, but are in order."""
    if not entries:
        return _Part([], np.empty(0, dtype=HOLD), {}, [])
    _, number = np.unique(holds["entry"], return_inverse=True)
    holds["entry"] = number
    first = np.searchsorted(number, np.arange(len(entries) + 1)).tolist()
    names = [obstacle.name for obstacle in entries]
    slots = dict(zip(names, zip(first[:-1], first[1:], strict=True), strict=True))
    return _Part(entries, holds, slots, [obstacle for obstacle in entries if isinstance(obstacle.shape, Points)])


def _joined(one: _Part, other: _Part) -> _Part:
    """Two parts as one."""
    holds = np.concatenate([one.holds, other.holds])
    holds["entry"][len(one.holds) :] += len(one.entries)
    return _numbered([*one.entries, *other.entries], holds)
