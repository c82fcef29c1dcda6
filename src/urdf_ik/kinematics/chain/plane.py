"""The plane in which a planar arm moves its tip, with its coordinates."""

from dataclasses import dataclass

import numpy as np

from urdf_ik.kinematics.chain.serial import Chain
from urdf_ik.model.poses import as_pose_array
from urdf_ik.support.read_only import Frozen
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

# A direction with less than this across another one is no direction to measure from.
_CLEAR = 0.3
_ALIGNED = 1e-9


@dataclass(frozen=True, eq=False)
class Plane(Frozen):
    """Coordinates (x, y) of the tip in the plane of a planar arm, and the angle of one of the tip's axes there.

    A plane along two axes of the base, in the order x, y, z, has these as its own: (x, y), (x, z) or (y, z). Any other
    plane has the base's x axis, as it lies in the plane, for its first one (the base's y axis where x is near the
    normal), and the second one a quarter turn on about the first joint's axis. Both are measured from the base's
    origin; angles go from the first axis to the second.

    Attributes:
        axes: (2, 3) unit directions in the base.
        normal: (3,) first axis times second, in the base.
        origin: (3,) m, the base's origin moved along the normal to where the tip is at q = 0.
        heading: (3,) the tip's axis whose angle is meant, in the tip: x; where x stands out of the plane, y.
    """

    axes: Array
    normal: Array
    origin: Array
    heading: Array

    def __post_init__(self) -> None:
        for array in (self.axes, self.normal, self.origin, self.heading):
            array.setflags(write=False)

    def coordinates(self, T: Array) -> Array:
        """Planar pose (..., 3), x [m], y [m], angle [rad], of tip poses ``T`` (..., 4, 4)."""
        T = as_pose_array(T)
        position = T[..., :3, 3] @ self.axes.T
        ahead = (T[..., :3, :3] @ self.heading) @ self.axes.T
        return np.concatenate([position, np.arctan2(ahead[..., 1:], ahead[..., :1])], axis=-1)


def plane_of(chain: Chain) -> Plane | None:
    """The plane in which two or three joints move the tip; None for an arm that is not planar."""
    if chain.n not in (2, 3):
        return None
    turning = np.flatnonzero(~chain.prismatic)
    slides = chain.H[chain.prismatic]
    normal = chain.H[turning[0]] if len(turning) else np.cross(*slides[:2])
    if np.linalg.norm(normal) < _CLEAR:
        return None
    normal = normal / np.linalg.norm(normal)
    off = np.linalg.norm(np.cross(chain.H[turning], normal), axis=1).max(initial=0.0)
    if max(off, np.abs(slides @ normal).max(initial=0.0)) > DEFAULT.near_angle:
        return None
    axes = axes_across(normal)
    normal = np.cross(*axes)
    tip_axes = chain.R_tip
    across = np.linalg.norm(np.cross(tip_axes.T, normal), axis=1)
    heading = np.eye(3)[0 if across[0] > _CLEAR else 1]
    return Plane(axes, normal, (chain.P.sum(axis=0) @ normal) * normal, heading)


def axes_across(normal: Array) -> Array:
    """Directions (2, 3) to measure along in the plane across unit ``normal`` (3,); see :class:`Plane`."""
    base = np.eye(3)
    k = int(np.argmax(np.abs(normal)))
    if np.abs(np.delete(normal, k)).max() < _ALIGNED:
        return np.delete(base, k, axis=0)
    for start in base[:2]:
        first = start - (start @ normal) * normal
        if np.linalg.norm(first) > _CLEAR:
            break
    first = first / np.linalg.norm(first)
    return np.array([first, np.cross(normal, first)])
