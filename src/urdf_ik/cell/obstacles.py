"""The obstacles of a world as a check sees them: where each is, and what holds it."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from urdf_ik.cell.shapes import Shape
from urdf_ik.typing import Array

_ROUGH = 0.25
"""Greatest relative error of a distance from the nearest point of a cloud, which makes the search short."""


class Obstacle(NamedTuple):
    """One shape of a world.

    Attributes:
        name: unique in its world.
        shape: its shape.
        pose: (4, 4) of the shape in the arm's base link [m], read-only.
    """

    name: str
    shape: Shape
    pose: Array


class Obstacles:
    """The obstacles of a world, each within a rounded box and within a ball; they do not change.

    A rounded box is all points within ``radius`` of a box, which may be infinite on some sides. An obstacle is known
    by its number.

    Attributes:
        standing: the obstacles.
        bounds: their shapes as coal has them, with their rounded boxes.
        centres: (n, 3) m of the balls.
        radii: (n,) m of the balls, infinite for a half-space.
    """

    def __init__(self, standing: Iterable[Obstacle]) -> None:
        from urdf_ik.cell.coal_shapes import bounded  # only a check imports coal

        self.standing = list(standing)
        self.bounds = [bounded(each.shape) for each in self.standing]
        self._numbers = {each.name: number for number, each in enumerate(self.standing)}
        poses = np.array([each.pose for each in self.standing]).reshape(-1, 4, 4)
        poses = poses @ np.array([each.frame for each in self.bounds]).reshape(-1, 4, 4)
        self._rotation, place = poses[:, :3, :3], poses[:, :3, 3]
        self._origin = np.einsum("oij,oi->oj", self._rotation, place)
        self._low, self._high = (np.array([each.box[side] for each in self.bounds]).reshape(-1, 3) for side in (0, 1))
        self._clouds = [(number, each.cloud) for number, each in enumerate(self.bounds) if each.cloud is not None]
        self._radius = np.array([each.radius for each in self.bounds])
        half = 0.5 * (self._high - self._low)
        finite = np.isfinite(half).all(axis=1)
        middle = np.where(finite[:, None], self._low + np.where(finite[:, None], half, 0.0), 0.0)
        self.centres: Array = np.einsum("oij,oj->oi", self._rotation, middle) + place
        self.radii: Array = np.linalg.norm(half, axis=1) + self._radius

    def __len__(self) -> int:
        return len(self.standing)

    def number(self, name: str) -> int | None:
        """The number of an obstacle, None where there is no such obstacle."""
        return self._numbers.get(name)

    def gaps(self, points: Array, numbers: NDArray[np.intp]) -> Array:
        """(e, m) m that points (e, m, 3) in the base link are away from obstacles (e,) at least, 0 or less inside."""
        local = points @ self._rotation[numbers] - self._origin[numbers, None]
        beyond = np.maximum(self._low[numbers, None] - local, local - self._high[numbers, None])
        out: Array = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
        for number, tree in self._clouds:
            if (own := np.flatnonzero(numbers == number)).size:
                pose = self.standing[number].pose
                to_point, _ = tree.query((points[own] - pose[:3, 3]) @ pose[:3, :3], eps=_ROUGH)
                out[own] = np.maximum(out[own], to_point / (1.0 + _ROUGH))
        return np.asarray(out - self._radius[numbers, None])
