"""The rigid bodies of a URDF: where each one is, and how far a motion of the joints can carry its points."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from urdf_ik.chain import Chain, TreeJoint

    Array = NDArray[np.float64]


class Placed(NamedTuple):
    """Bodies at k joint vectors, in the base link's frame.

    Attributes:
        poses: (k, G, 4, 4) of the bodies.
        centres: (k, S, m, 3) of the balls that cover the shapes [m].
    """

    poses: Array
    centres: Array


class _Step(NamedTuple):
    """A joint of the URDF that moves with the joint vector, from the body that carries it to the one it carries."""

    parent: int
    child: int
    to_joint: Array  # (4, 4), from the parent body's frame to the joint's parent link
    joint: TreeJoint


class Bodies:
    """What moves as one, and how far.

    A body is a set of links between which no joint moves with the joint vector; body 0 holds the URDF's root. Each of
    the S shapes is covered by m balls that its body carries.

    Attributes:
        body: (S,) body of each shape.
        base: body that the base link is part of.
        path: (S, J) whether joint j is between the base and the shape.
    """

    def __init__(self, chain: Chain, links: Sequence[str], centres: Array, radii: Array) -> None:
        """Find the bodies.

        Args:
            chain: the joints from base to tip, and the whole tree that they are part of.
            links: (S) link of each shape.
            centres: (S, m, 3) m, centres of the balls that cover the shapes, in the links' frames.
            radii: (S, m) m.
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
        self.radii = radii
        frames = np.array([offset[link] for link in links]).reshape(-1, 4, 4)
        self._centres = np.einsum("sij,smj->smi", frames[:, :3, :3], centres) + frames[:, None, :3, 3]
        self._columns = np.array([step.joint.column for step in steps], dtype=np.intp)
        self._gears = np.abs(np.array([step.joint.multiplier for step in steps], dtype=np.float64))
        self._slides = np.array([step.joint.prismatic for step in steps], dtype=np.bool_)
        self._order, path = self._paths()
        self.path = path[self.body]

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
        centres = np.einsum("ksij,smj->ksmi", own[..., :3, :3], self._centres) + own[..., None, :3, 3]
        return Placed(poses, centres)

    def reaches(self, placed: Placed, travel: Array) -> Array:
        """How far each joint can carry the points of each shape, on a motion through the poses ``placed``.

        A point at distance r of a turning joint's axis goes r |dq|. The distance of a shape's points from an axis
        changes only by the joints between that axis and the shape: from its value at ``placed``, where it is measured
        to the farthest point of the balls, by at most what those joints carry them on the way to either end.

        Args:
            placed: the bodies in the middle of k motions.
            travel: (k, n) rad or m, how far each entry of the joint vector goes from there to either end, not negative.

        Returns:
            (k, S, J) m, of the way from the middle to either end, zero where joint j is not between base and shape.
        """
        k, S = placed.centres.shape[:2]
        out = np.zeros((k, S, len(self._steps)))
        going = travel[:, self._columns] * self._gears
        carried = np.zeros((k, S))
        for j in reversed(self._order):
            on = np.flatnonzero(self.path[:, j])
            if not len(on):
                continue
            if self._slides[j]:
                moved = np.broadcast_to(going[:, j, None], (k, len(on)))
            else:
                pose = placed.poses[:, self._steps[j].child]
                axis = pose[:, :3, :3] @ self._steps[j].joint.axis
                arm = placed.centres[:, on] - pose[:, None, None, :3, 3]
                along = np.einsum("ksmi,ki->ksm", arm, axis)
                square = np.einsum("ksmi,ksmi->ksm", arm, arm) - along * along
                radius = (np.sqrt(np.maximum(square, 0.0)) + self.radii[on]).max(axis=-1)
                moved = going[:, j, None] * (radius + carried[:, on])
            out[:, on, j] = moved
            carried[:, on] += moved
        return out
