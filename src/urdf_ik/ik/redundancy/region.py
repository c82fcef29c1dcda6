"""``Region``: how far the tip may be from a target, in the target's frame."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError, PoseError
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support import inputs
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

Range = tuple[float, float]


@dataclass(frozen=True, init=False)
class Region:
    """The poses allowed around a target: a box for the position, a cone for an axis, a range of rotations.

    A part that is not given is exact: ``Region()`` is the target alone.

    Attributes:
        box: three pairs (low, high) m, along the target's x, y and z.
        cone: rad, how far the axis may be tilted from the target's, in any direction.
        rotation: rad, how far the tip may be turned about the axis, in both directions; pi: any rotation.
        axis: the axis in the tip, through the point that the box bounds.

    Example:
        >>> import numpy as np
        >>> import urdf_ik
        >>> region = urdf_ik.Region(box=[0.0, 0.0, 0.005], cone=0.2, rotation=np.pi)
        >>> bool(region.contains(np.eye(4), urdf_ik.pose([0.0, 0.0, 0.004], rpy=[0.1, 0.0, 2.0])))
        True
    """

    box: tuple[Range, Range, Range]
    cone: float
    rotation: float
    axis: FreeAxis

    def __init__(
        self,
        box: ArrayLike = 0.0,
        cone: float = 0.0,
        rotation: float = 0.0,
        *,
        axis: Any = "z",
        at: ArrayLike | None = None,
    ) -> None:
        """Describe a region.

        Args:
            box: m, half the width along the target's x, y and z: one number, three, or three pairs (low, high).
            cone: rad, half the angle of the cone about the axis, below pi.
            rotation: rad about the axis, in both directions; pi or more: any.
            axis: 'x', 'y', 'z' or a direction (3,) of the tip.
            at: (3,) m, the point of the tip that the box bounds; default: the tip's origin.

        Raises:
            ArgumentError: a width, an angle or an axis is invalid.
        """
        needed = "a half width [m], three, or three pairs (low, high)"
        given = inputs.real(box, "box", needed)
        half = given if given.shape in ((), (1,), (3,)) else np.array(np.nan)
        ranges = given if given.shape == (3, 2) else np.broadcast_to(half, (3,))[:, None] * [-1.0, 1.0]
        if inputs.first_bad(ranges) is not None or (ranges[:, 0] > ranges[:, 1]).any():
            raise ArgumentError(f"box={quoted(box)} given; {needed} is needed")
        for name, angle, most in (("cone", cone, np.pi), ("rotation", rotation, np.inf)):
            if not (inputs.is_real(angle) and 0.0 <= angle < most):
                raise ArgumentError(f"{name}={quoted(angle)} given; zero or a positive angle [rad] is needed")
        x, y, z = ((float(low) + 0.0, float(high)) for low, high in ranges)
        for name, value in (
            ("box", (x, y, z)),
            ("cone", float(cone)),
            ("rotation", float(min(rotation, np.pi))),
            ("axis", axis if isinstance(axis, FreeAxis) else FreeAxis.read(axis, at)),
        ):
            object.__setattr__(self, name, value)

    def measured(self, T: Array, reached: Array) -> tuple[Array, Array, Array]:
        """Poses (..., 4, 4) relative to targets: position (..., 3) m, the axis' direction (..., 3), rotation (...) rad.

        The rotation is the one that remains after the shortest rotation that undoes the tilt.

        Example:
            >>> import numpy as np
            >>> import urdf_ik
            >>> place, _, turn = Region().measured(np.eye(4), urdf_ik.pose([0.1, 0.0, 0.0], rpy=[0.0, 0.0, 0.5]))
            >>> place.tolist(), round(float(turn), 6)
            ([0.1, 0.0, 0.0], 0.5)
        """
        T, reached = as_pose_array(T), as_pose_array(reached)
        try:
            batch = np.broadcast_shapes(T.shape[:-2], reached.shape[:-2])
        except ValueError:
            raise PoseError(
                f"targets of shape {T.shape} and poses of shape {reached.shape} given; they do not fit"
            ) from None
        off = (reached - T)[..., :3, :] @ self.axis.seen[:, 0]
        inverse = np.swapaxes(T[..., :3, :3], -1, -2)
        motion = np.zeros((*batch, 4, 4))
        motion[..., :3, :3] = inverse @ reached[..., :3, :3]
        direction = motion[..., :3, :3] @ np.array(self.axis.direction)
        return np.einsum("...ij,...j->...i", inverse, off), direction, self.axis.angle(motion)

    def contains(self, T: Array, reached: Array, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """Whether poses (..., 4, 4) are in the region around targets (..., 4, 4), to a tolerance [m, rad].

        Example:
            >>> import numpy as np
            >>> bool(Region().contains(np.eye(4), np.eye(4)))
            True
        """
        tolerance = inputs.number(tolerance, "tolerance", low=0.0)
        place, direction, turn = self.measured(T, reached)
        low, high = np.array(self.box).T
        inside = ((place >= low - tolerance) & (place <= high + tolerance)).all(axis=-1)
        tilt = 2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(direction - self.axis.direction, axis=-1), 1.0))
        return np.asarray(inside & (tilt <= self.cone + tolerance) & (np.abs(turn) <= self.rotation + tolerance))

    def clipped(self, T: Array, reached: Array) -> Array:
        """The pose (4, 4) in the region around a target with a pose's place, tilt and rotation as far as allowed.

        Example:
            >>> import numpy as np
            >>> import urdf_ik
            >>> Region(box=0.01).clipped(np.eye(4), urdf_ik.pose([0.1, 0.0, 0.0]))[:3, 3].round(6).tolist()
            [0.01, 0.0, 0.0]
        """
        place, direction, turn = self.measured(T, reached)
        low, high = np.array(self.box).T
        aside, along = self.across @ direction, direction @ np.array(self.axis.direction)
        tilt = np.minimum(np.arctan2(np.linalg.norm(aside), along), self.cone)
        heading = np.arctan2(aside[1], aside[0])
        place, turn = place.clip(low, high), turn.clip(-self.rotation, self.rotation)
        return self._pose(as_pose_array(T), place, tilt, heading, turn)

    def _pose(self, T: Array, place: Array, tilt: Array, heading: Array, turn: Array) -> Array:
        """Poses (..., 4, 4) with the point at ``place`` (..., 3), the axis tilted towards ``heading``, and turned."""
        a, (e, f) = np.array(self.axis.direction), self.across
        towards = np.cos(heading)[..., None] * e + np.sin(heading)[..., None] * f
        # The tilt turns a to the direction of ``towards``: a rotation in the plane of the two.
        sine, cosine = np.sin(tilt)[..., None, None], np.cos(tilt)[..., None, None]
        both = towards[..., :, None] * a - a[:, None] * towards[..., None, :]
        plane = towards[..., :, None] * towards[..., None, :] + np.outer(a, a)
        swing = np.eye(3) + sine * both + (cosine - 1.0) * plane
        out: Array = np.zeros((*np.shape(tilt), 4, 4))
        out[..., :3, :3] = T[:3, :3] @ swing @ FreeAxis(self.axis.direction).rotation(turn)[..., :3, :3]
        at = np.array(self.axis.at)
        out[..., :3, 3] = T[:3, 3] + (at + place) @ T[:3, :3].T - out[..., :3, :3] @ at
        out[..., 3, 3] = 1.0
        return out

    @cached_property
    def across(self) -> Array:
        """(2, 3) directions at right angles to the axis and to each other."""
        a = np.array(self.axis.direction)
        e = np.cross(a, np.eye(3)[int(np.argmin(np.abs(a)))])
        e /= np.linalg.norm(e)
        return np.stack([e, np.cross(a, e)])

    def sampled(self, T: Array, shares: Array) -> Array:
        """Poses (m, 4, 4) spread over the region around a target, from shares (m, 6) of a unit cube.

        Raises:
            PoseError: the target is no pose.
            ArgumentError: the shares are not such numbers.

        Example:
            >>> import numpy as np
            >>> region = Region(box=0.01, cone=0.1)
            >>> poses = region.sampled(np.eye(4), np.random.default_rng(0).uniform(size=(5, 6)))
            >>> bool(region.contains(np.eye(4), poses).all())
            True
        """
        shares, low, high = inputs.real(shares, "shares", "(m, 6) shares of 1"), *np.array(self.box).T
        if shares.ndim != 2 or shares.shape[1] != 6:
            raise ArgumentError(f"shares of shape {shares.shape} given; (m, 6) is needed")
        tilt, turn = self.cone * np.sqrt(shares[:, 3]), self.rotation * (2.0 * shares[:, 5] - 1.0)
        return self._pose(as_pose_array(T), low + shares[:, :3] * (high - low), tilt, 2.0 * np.pi * shares[:, 4], turn)

    @property
    def widths(self) -> Array:
        """(6,) m and rad: how wide the region is in each of the directions that ``sampled`` spreads over."""
        low, high = np.array(self.box).T
        return np.array([*(high - low), self.cone, self.cone, self.rotation])
