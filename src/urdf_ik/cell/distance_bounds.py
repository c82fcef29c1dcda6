"""Lower bounds on distances, many joint vectors at a time, from balls about the shapes and boxes about the obstacles.

Coal checks only the pairs that the bounds do not decide. Pairs of two links are few, and each gets a bound. Pairs of a
link and an obstacle are many: a ball about each proposes those that are near.
"""

from collections.abc import Collection, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell.obstacles import Obstacles
from urdf_ik.kinematics.chain import Chain, TreeJoint
from urdf_ik.typing import Array

Indices = NDArray[np.intp]

QUERY_ERROR = 1e-5
"""Bound on the error of coal's distances [m]: its iterations stop at 1e-6."""

CHUNK, PAIRS = 128, 2**20
"""Joint vectors per block of bounds: few enough for the processor's cache; and pairs with obstacles per block."""

SLACK = 1e-12
"""Relative error of a squared distance, far above rounding."""


class Placed(NamedTuple):
    """Bodies at k joint vectors, in the base link's frame.

    Attributes:
        poses: (k, G, 4, 4) of the bodies.
        centres: (k, S, 3) of the balls that hold the shapes, one each [m].
    """

    poses: Array
    centres: Array


class _Step(NamedTuple):
    """A joint that moves with the joint vector, its parent body and its child body."""

    parent: int
    child: int
    to_joint: Array  # (4, 4), from the parent body's frame to the joint's parent link
    joint: TreeJoint


class Bodies:
    """Rigid bodies with bounding balls: their poses, and bounds on their motion.

    A body is a set of links between which no joint moves with the joint vector; body 0 holds the URDF's root. One ball
    encloses each of the S shapes; m smaller balls together enclose it more tightly. They move with the body.

    Attributes:
        body: (S,) body of each shape.
        base: body that the base link is part of.
        ball_radii: (S,) m, of the single balls.
        radii: (S, m) m, of the others.
        local_centres: (S, m, 3) m, centres of the others in the frames of the bodies.
        path: (S, J) whether joint j is between the base and the shape.
        moves: (S,) whether the joint vector moves the shape against the base.
    """

    def __init__(
        self, chain: Chain, links: Sequence[str], ball: tuple[Array, Array], balls: tuple[Array, Array]
    ) -> None:
        """Find the bodies.

        Args:
            chain: the joints from base to tip, and the whole tree that they are part of.
            links: (S) link of each shape.
            ball: centres (S, 3) in the links' frames and radii (S,) of the single balls [m].
            balls: centres (S, m, 3) and radii (S, m) of the balls that together enclose each shape [m].
        """
        body_of, offset = {chain.root: 0}, {chain.root: np.eye(4)}
        steps: list[_Step] = []
        for joint in chain.tree:
            at = offset[joint.parent]
            if joint.column is None:
                body_of[joint.child] = body_of[joint.parent]
                offset[joint.child] = at @ joint.motion.fk(np.array([joint.offset]))
            else:
                steps.append(_Step(body_of[joint.parent], len(steps) + 1, at, joint))
                body_of[joint.child], offset[joint.child] = len(steps), np.eye(4)
        self._steps = steps
        self.base, self._base_offset = body_of[chain.base], offset[chain.base]
        self.body = np.array([body_of[link] for link in links], dtype=np.intp)
        self.ball_radii, self.radii = ball[1], balls[1]
        frames = np.array([offset[link] for link in links]).reshape(-1, 4, 4)
        self._ball = np.einsum("sij,sj->si", frames[:, :3, :3], ball[0]) + frames[:, :3, 3]
        self.local_centres = np.einsum("sij,smj->smi", frames[:, :3, :3], balls[0]) + frames[:, None, :3, 3]
        self._child = np.array([step.child for step in steps], dtype=np.intp)
        self._axes = np.array([step.joint.axis for step in steps]).reshape(-1, 3)
        self._columns = np.array([step.joint.column for step in steps], dtype=np.intp)
        self._gears = np.abs(np.array([step.joint.multiplier for step in steps], dtype=np.float64))
        self._slides = np.array([step.joint.prismatic for step in steps], dtype=np.bool_)
        self._order, path = self._paths()
        self.path = path[self.body]
        self.moves: NDArray[np.bool_] = np.asarray(self.path.any(axis=1))

    def _paths(self) -> tuple[list[int], NDArray[np.bool_]]:
        """The joints in the order in which they are met from the base on; (G, J) those from the base to each body."""
        path = np.zeros((len(self._steps) + 1, len(self._steps)), dtype=np.bool_)
        order: list[int] = []
        waiting = [self.base]
        while waiting:
            body = waiting.pop()
            for j, step in enumerate(self._steps):
                if j not in order and body in (step.parent, step.child):
                    other = step.child if body == step.parent else step.parent
                    path[other] = path[body]
                    path[other, j] = True
                    order.append(j)
                    waiting.append(other)
        return order, path

    def place(self, q: Array) -> Placed:
        """The bodies at joint vectors (k, n)."""
        k = len(q)
        poses = np.empty((k, len(self._steps) + 1, 4, 4))
        poses[:, 0] = np.eye(4)
        for step in self._steps:
            drive = step.joint.multiplier * q[:, step.joint.column] + step.joint.offset
            poses[:, step.child] = poses[:, step.parent] @ step.to_joint @ step.joint.motion.fk(drive[:, None])
        if self.base or not np.array_equal(self._base_offset, np.eye(4)):
            poses = np.linalg.inv(poses[:, self.base] @ self._base_offset)[:, None] @ poses
        own = poses[:, self.body]
        return Placed(poses, (own[..., :3, :3] @ self._ball[..., None])[..., 0] + own[..., :3, 3])

    def balls(self, placed: Placed, rows: NDArray[np.intp], shapes: NDArray[np.intp]) -> Array:
        """Centres (e, m, 3) of the m balls about these shapes (e,) in these rows (e,) [m]."""
        pose = placed.poses[rows, self.body[shapes]]
        return np.asarray(self.local_centres[shapes] @ pose[:, :3, :3].transpose(0, 2, 1) + pose[:, None, :3, 3])

    def reaches(self, placed: Placed, travel: Array) -> Array:
        """How far each joint can carry the points of each ball, on a motion through the poses ``placed``.

        A point at distance r of a turning joint's axis goes r |dq|. The distance of a ball's points from an axis
        changes only by the joints between that axis and the ball: from its value at ``placed``, where it is measured
        to the ball's farthest point, by at most what those joints carry it on the way to either end.

        Args:
            placed: the bodies in the middle of k motions.
            travel: (k, n) rad or m, how far each entry of the joint vector goes from there to either end, not negative.

        Returns:
            (k, S, m, J) m, on the way from the middle to either end, zero where joint j is not between base and shape.
        """
        going = travel[:, self._columns] * self._gears
        # Distances of the balls' centres c from the axes, lines along a through o: |c - o|^2 - (a . (c - o))^2.
        frames = placed.poses[:, self._child]
        axes, origins = (frames[..., :3, :3] @ self._axes[..., None])[..., 0], frames[..., :3, 3]
        own = placed.poses[:, self.body]
        centres = self.local_centres @ own[..., :3, :3].swapaxes(-1, -2) + own[..., None, :3, 3]
        points = centres.reshape(len(centres), -1, 3)
        along = points @ axes.swapaxes(1, 2) - np.einsum("kji,kji->kj", axes, origins)[:, None]
        square = -2.0 * (points @ origins.swapaxes(1, 2)) - along * along
        square += np.einsum("kpi,kpi->kp", points, points)[..., None]
        square += np.einsum("kji,kji->kj", origins, origins)[:, None]
        radius = np.sqrt(np.maximum(square, 0.0, out=square), out=square).reshape(*centres.shape[:3], -1)
        radius += self.radii[..., None]
        out: Array = np.zeros_like(radius)
        carried = np.zeros(centres.shape[:3])
        for j in reversed(self._order):
            on = self.path[:, j, None]
            out[..., j] = going[:, j, None, None] * on * (1.0 if self._slides[j] else radius[..., j] + carried)
            carried += out[..., j]
        return out


class Open(NamedTuple):
    """Pairs of a link's shape and an obstacle that the bounds do not decide.

    Attributes:
        row: (e,) index of the joint vector.
        pair: (e,) number of the pair.
        closer: (e,) greatest distance by which the pair comes closer [m]; zero without motion.
    """

    row: Indices
    pair: Indices
    closer: Array


class DistanceBounds:
    """Pairs that must not touch, by number, and lower bounds on their distances.

    Pairs of two links are numbered first, from 0 to ``among_links - 1``; the pair of shape i and obstacle k has the
    number ``among_links + i * len(obstacles) + k``.

    Attributes:
        among_links: number of pairs of two links.
    """

    def __init__(
        self,
        bodies: Bodies,
        links: Sequence[tuple[int, int]],
        obstacles: Obstacles,
        excepted: Collection[tuple[int, int]] = (),
        added: Collection[tuple[int, int]] = (),
    ) -> None:
        """Choose the pairs.

        Args:
            bodies: how the arm's shapes move.
            links: pairs of shapes of two links.
            obstacles: those of the world.
            excepted: (shape, obstacle) of a shape that moves, which may touch.
            added: (shape, obstacle) of a shape that does not move, which must not touch.
        """
        self._bodies, self._obstacles = bodies, obstacles
        pairs = np.array(links, dtype=np.intp).reshape(-1, 2)
        self._first, self._second = pairs[:, 0], pairs[:, 1]
        self.among_links = len(pairs)
        self._moving = np.flatnonzero(bodies.moves)
        self._excepted = np.array(sorted(self.number(*pair) for pair in excepted), dtype=np.intp)
        self._added = np.array(sorted(self.number(*pair) for pair in added), dtype=np.intp)
        ones, others = bodies.path[self._first], bodies.path[self._second]
        # Joints (A, J) that move a pair's first shape against its second, and its second against its first.
        self._moves_first = (ones & ~others).astype(np.float64)
        self._moves_second = (others & ~ones).astype(np.float64)

    @property
    def has_obstacles(self) -> bool:
        """Whether a link is checked against an obstacle."""
        return bool(len(self._obstacles) and (len(self._moving) or len(self._added)))

    def number(self, shape: Any, obstacle: Any) -> Any:
        """Number of the pair of a shape and an obstacle."""
        return self.among_links + shape * len(self._obstacles) + obstacle

    def split(self, pairs: Indices) -> tuple[Indices, Indices]:
        """Shapes (e,) and obstacles (e,) of pairs (e,) with obstacles."""
        shape, obstacle = np.divmod(pairs - self.among_links, max(len(self._obstacles), 1))
        return shape, obstacle

    def chunks(self, q: Array) -> Iterator[tuple[slice, Placed]]:
        """The joint vectors (k, n) a chunk at a time, with the bodies placed."""
        size = min(CHUNK, 1 + PAIRS // (1 + len(self._moving) * len(self._obstacles)))
        for start in range(0, len(q), size):
            part = slice(start, start + size)
            yield part, self._bodies.place(q[part])

    def near_in_rows(self, placed: Placed, margin: float) -> Iterator[tuple[int, list[int]]]:
        """Each row in which pairs may be apart by no more than a margin [m], with these pairs."""
        links, k = self.links_near(placed, margin), len(placed.centres)
        row, pair = self.near(placed.centres, np.full(placed.centres.shape[:2], margin))
        close = self.gaps(placed, row, pair).min(axis=1) <= margin
        row, pair = row[close], pair[close]
        ends = np.searchsorted(row, np.arange(k + 1)).tolist()
        for i in np.flatnonzero(links.any(axis=1) | (np.diff(ends) > 0)).tolist():
            yield i, [*np.flatnonzero(links[i]).tolist(), *pair[ends[i] : ends[i + 1]].tolist()]

    # ------------------------------------------------------------ pairs of two links

    def links_least(self, placed: Placed) -> Array:
        """(k, A) m that the links are apart at least, by one ball about each shape; may be negative."""
        points, radii = placed.centres, self._bodies.ball_radii
        between = points[:, self._first] - points[:, self._second]
        return _length(between) - (radii[self._first] + radii[self._second])

    def links_gaps(self, placed: Placed, rows: Indices, pairs: Indices) -> Array:
        """(e, m, m) m that the balls of the one shape are apart at least from those of the other: of pairs in rows."""
        first, second, radii = self._first[pairs], self._second[pairs], self._bodies.radii
        ones, others = self._bodies.balls(placed, rows, first), self._bodies.balls(placed, rows, second)
        return _length(ones[:, :, None] - others[:, None]) - (radii[first, :, None] + radii[second, None])

    def links_closest(self, placed: Placed) -> Array:
        """(k, A) m that the links are apart at least, by all balls."""
        shape = len(placed.poses), self.among_links
        rows, pairs = (index.reshape(-1) for index in np.indices(shape))
        return np.asarray(self.links_gaps(placed, rows, pairs).min(axis=(1, 2)).reshape(shape))

    def links_near(self, placed: Placed, margin: float) -> NDArray[np.bool_]:
        """(k, A) which links may be apart by no more than a margin [m]."""
        out: NDArray[np.bool_] = self.links_least(placed) <= margin
        rows, pairs = np.nonzero(out)
        out[rows, pairs] = self.links_gaps(placed, rows, pairs).min(axis=(1, 2)) <= margin
        return out

    def links_in_reach(
        self, placed: Placed, reaches: Array, margin: float, wanted: NDArray[np.bool_]
    ) -> tuple[NDArray[np.bool_], Array]:
        """Which links may come within a margin on a motion through the poses ``placed``, and how much closer at most.

        Where two balls stay apart by more than the margin, what they hold does. The bound of a pair is that of the
        balls for which this is open: a long link is fast where it is far from its axis, and often near to others
        where it is slow.

        Args:
            placed: the bodies in the middle of k motions.
            reaches: (k, S, m, J) m; see :meth:`Bodies.reaches`.
            margin: m.
            wanted: (k, A) pairs to look at.

        Returns:
            (k, A) which pairs; (k, A) m, by which the parts of them that are in question come closer at most.
        """
        most = reaches.max(axis=2)
        closer: Array = np.einsum("kpj,pj->kp", most[:, self._first], self._moves_first)
        closer += np.einsum("kpj,pj->kp", most[:, self._second], self._moves_second)
        out: NDArray[np.bool_] = (self.links_least(placed) <= margin + closer) & wanted
        rows, pairs = np.nonzero(out)
        ones = reaches[rows, self._first[pairs]] @ self._moves_first[pairs][..., None]
        others = reaches[rows, self._second[pairs]] @ self._moves_second[pairs][..., None]
        both = ones + others.swapaxes(1, 2)
        in_question = self.links_gaps(placed, rows, pairs) <= margin + both
        closer[rows, pairs] = np.where(in_question, both, 0.0).max(axis=(1, 2), initial=0.0)
        out[rows, pairs] = in_question.any(axis=(1, 2))
        return out, closer

    # ------------------------------------------------------------ pairs of a link and an obstacle

    def near(self, centres: Array, extra: Array) -> tuple[Indices, Indices]:
        """Pairs with obstacles whose distance, by one ball about each shape, may be ``extra`` or less.

        Args:
            centres: (k, S, 3) m of the balls.
            extra: (k, S) m, of any sign; infinite: all pairs.

        Returns:
            Rows (e,) and pairs (e,), by rows and numbers.
        """
        row = pair = np.zeros(0, dtype=np.intp)
        if not self.has_obstacles:
            return row, pair
        square, slack = self._squares(centres)
        reach = (self._bodies.ball_radii + extra)[:, self._moving, None] + self._obstacles.radii
        row, moving, obstacle = np.nonzero(square <= reach * reach + slack)
        row, pair = self._checked(row, self.number(self._moving[moving], obstacle), len(centres))
        close = self.least(centres, row, pair) <= extra[row, self.split(pair)[0]]
        row, pair = row[close], pair[close]
        order = np.lexsort((pair, row))
        return row[order], pair[order]

    def likely(self, centres: Array) -> tuple[Indices, Indices]:
        """Rows and pairs with obstacles, one of each row and shape, that are likely to be its nearest."""
        k, moving = len(centres), len(self._moving)
        if not self.has_obstacles:
            return np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp)
        square, radii = self._squares(centres)[0], self._obstacles.radii
        # A half-space is likely only where there is nothing else.
        obstacle = (np.sqrt(np.maximum(square, 0.0)) - np.where(np.isinf(radii), -radii, radii)).argmin(axis=2)
        return self._checked(np.repeat(np.arange(k), moving), self.number(self._moving, obstacle).reshape(-1), k)

    def _squares(self, centres: Array) -> tuple[Array, Array]:
        """Squared distances (k, M, n) [m^2] of the M shapes that move from the obstacles, by their balls' centres.

        And how far rounding may have made them greater.
        """
        points, others = centres[:, self._moving], self._obstacles.centres
        sums = (points * points).sum(axis=-1)[..., None] + (others * others).sum(axis=-1)
        return sums - 2.0 * (points @ others.T), SLACK * sums

    def _checked(self, row: Indices, pair: Indices, k: int) -> tuple[Indices, Indices]:
        """Those of the rows and pairs with obstacles that are checked, and the pairs that are added to all k rows."""
        kept = ~np.isin(pair, self._excepted)
        row = np.concatenate([row[kept], np.repeat(np.arange(k), len(self._added))])
        return row, np.concatenate([pair[kept], np.tile(self._added, k)])

    def least(self, centres: Array, rows: Indices, pairs: Indices) -> Array:
        """(e,) m that pairs with obstacles are apart at least, by one ball about each shape."""
        shapes, obstacles = self.split(pairs)
        gaps = self._obstacles.gaps(centres[rows, shapes][:, None], obstacles)[:, 0]
        return np.asarray(gaps - self._bodies.ball_radii[shapes])

    def gaps(self, placed: Placed, rows: Indices, pairs: Indices) -> Array:
        """(e, m) m that the balls of the shapes are apart at least from the obstacles: of pairs in rows."""
        shapes, obstacles = self.split(pairs)
        gaps = self._obstacles.gaps(self._bodies.balls(placed, rows, shapes), obstacles)
        return np.asarray(gaps - self._bodies.radii[shapes])

    def in_reach(
        self,
        placed: Placed,
        reaches: Array,
        margin: float,
        listed_pairs: tuple[Indices, Indices],
        listed: NDArray[np.bool_],
    ) -> Open:
        """Obstacles that links may come to within a margin on a motion; see :meth:`links_in_reach`.

        Args:
            placed: the bodies in the middle of k motions.
            reaches: (k, S, m, J) m.
            margin: m.
            listed_pairs: rows and pairs to look at, in rows that are listed.
            listed: (k,) bool: of the other rows all pairs are looked at.
        """
        both = reaches.sum(axis=3)  # (k, S, m): obstacles stand still, and only joints before the shape count
        others = np.flatnonzero(~listed)
        row, pair = self.near(placed.centres[others], margin + both[others].max(axis=2, initial=0.0))
        rows = np.concatenate([listed_pairs[0], others[row]])
        pairs = np.concatenate([listed_pairs[1], pair])
        closer = both[rows, self.split(pairs)[0]]
        in_question = self.gaps(placed, rows, pairs) <= margin + closer
        still = in_question.any(axis=1)
        closer = np.where(in_question, closer, 0.0).max(axis=1, initial=0.0)
        return Open(rows[still], pairs[still], closer[still])


def _length(vectors: Array) -> Array:
    """Euclidean length of vectors (..., 3), component by component."""
    square = vectors[..., 0] * vectors[..., 0]
    square += vectors[..., 1] * vectors[..., 1]
    square += vectors[..., 2] * vectors[..., 2]
    return np.asarray(np.sqrt(square))
