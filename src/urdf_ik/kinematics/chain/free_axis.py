"""A free axis: a line in the tip about which the tip may turn (welding, drilling, gripping a cylinder)."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from urdf_ik.errors import ArgumentError
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.read_only import Frozen
from urdf_ik.typing import Array

_NAMED = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class FreeAxis(Frozen):
    """A line in the tip's frame.

    Attributes:
        direction: (3,) unit vector in the tip.
        at: (3,) m, a point on the line, in the tip.
        motion: (3, 3, 4) the rotation by v: the first part, plus cos v times the second, plus sin v times the third.
    """

    direction: tuple[float, float, float]
    at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    motion: Array = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "motion", turning(np.array(self.direction), np.array(self.at)))

    @classmethod
    def read(cls, axis: Any, at: ArrayLike | None = None) -> "FreeAxis":
        """From 'x', 'y', 'z' or a direction (3,), and a point (3,) or None for the tip's origin.

        Raises:
            ArgumentError: neither an axis nor a direction, or no point.
        """
        if isinstance(axis, str):
            if axis not in _NAMED:
                raise ArgumentError(f"axis={axis!r} given; 'x', 'y', 'z' or a direction of three numbers is needed")
            direction = np.array(_NAMED[axis])
        else:
            direction = inputs.array(axis, "axis", (3,))
        length = float(np.linalg.norm(direction))
        if length == 0.0:
            raise ArgumentError(f"axis={axis!r} given; a direction needs a length, such as (0, 0, 1)")
        x, y, z = (direction / length).tolist()
        px, py, pz = (0.0, 0.0, 0.0) if at is None else inputs.array(at, "at", (3,), unit="m").tolist()
        return cls((x, y, z), (px, py, pz))

    def __str__(self) -> str:
        what = f"the tip's {self.name} axis" if self.name in _NAMED else f"the axis {self.name} of the tip"
        return f"{what} through {_numbers(self.at)} m" if any(self.at) else what

    @property
    def name(self) -> str:
        """'x', 'y', 'z', or the direction's numbers."""
        found = next((name for name, direction in _NAMED.items() if direction == self.direction), None)
        return _numbers(self.direction) if found is None else found

    @property
    def seen(self) -> Array:
        """(4, 2) what counts of a pose (4, 4), multiplied from its right: the point's place, and the direction."""
        return np.array([[*self.at, 1.0], [*self.direction, 0.0]]).T

    def reduced(self, R: Array, twists: Array) -> Array:
        """Twists without what does not count: of the point instead of the tip, and no rotation about the axis.

        Args:
            R: (..., 3, 3) the tip's rotation.
            twists: (..., 6, k) of the tip, linear rows above angular ones, in base axes.

        Returns:
            (..., 6, k).
        """
        at, axis = (R @ np.array(each) for each in (self.at, self.direction))
        linear, angular = twists[..., :3, :], twists[..., 3:, :]
        linear = linear + np.cross(angular, at[..., None], axis=-2)
        angular = angular - axis[..., None] * np.einsum("...i,...ik->...k", axis, angular)[..., None, :]
        return np.concatenate([linear, angular], axis=-2)

    def rotation(self, values: ArrayLike) -> Array:
        """The tip's motion (..., 4, 4) when it is turned by angles (...) [rad] about the line."""
        v = np.asarray(values, dtype=np.float64)
        out = np.zeros((*v.shape, 4, 4))
        constant, cosine, sine = self.motion
        out[..., :3, :] = constant + np.cos(v)[..., None, None] * cosine + np.sin(v)[..., None, None] * sine
        out[..., 3, 3] = 1.0
        return out

    def angle(self, motion: Array) -> Array:
        """The angles (...) [rad] by which rotations about the line come nearest to motions (..., 4, 4) of the tip."""
        motion = as_pose_array(motion)
        R, d = motion[..., :3, :3], np.array(self.direction)
        off = np.stack([R[..., 2, 1] - R[..., 1, 2], R[..., 0, 2] - R[..., 2, 0], R[..., 1, 0] - R[..., 0, 1]], -1)
        along = np.einsum("i,...ij,j->...", d, R, d)
        return np.asarray(np.arctan2(off @ d, np.einsum("...ii", R) - along))

    def apart(self, one: Array, other: Array) -> tuple[Array, Array]:
        """Distance (...) [m] and angle (...) [rad] between poses (..., 4, 4), apart from rotations about the line."""
        one, other = as_pose_array(one), as_pose_array(other)
        off = (one - other)[..., :3, :] @ self.seen
        far, between = np.linalg.norm(off[..., 0], axis=-1), np.linalg.norm(off[..., 1], axis=-1)
        return far, 2.0 * np.arcsin(np.minimum(0.5 * between, 1.0))


def turning(h: Array, p: Array) -> Array:
    """(3, 3, 4) a rotation about the line along ``h`` (3,) through ``p`` (3,) by Rodrigues' formula, as three parts.

    Their sum, the second times cos v and the third times sin v, is the rotation by v.
    """
    motion = np.zeros((3, 3, 4))
    x, y, z = h
    along = np.outer(h, h)
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    for part, R in zip(motion, (along, np.eye(3) - along, across), strict=True):
        part[:, :3] = R
        part[:, 3] = -R @ p
    motion[0, :, 3] += p
    motion.setflags(write=False)
    return motion


def _numbers(values: tuple[float, ...]) -> str:
    return f"({', '.join(f'{value:g}' for value in values)})"
