"""The rigid bodies of a URDF: their poses, and bounds on how far a motion of the joints can carry their points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.kinematics.chain import Chain, TreeJoint
from urdf_ik.typing import Array


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
        self._balls = np.einsum("sij,smj->smi", frames[:, :3, :3], balls[0]) + frames[:, None, :3, 3]
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
        return np.asarray(self._balls[shapes] @ pose[:, :3, :3].transpose(0, 2, 1) + pose[:, None, :3, 3])

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
        centres = self._balls @ own[..., :3, :3].swapaxes(-1, -2) + own[..., None, :3, 3]
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
