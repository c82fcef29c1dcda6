"""The exact region that two turning joints with limits reach in their plane, for each elbow and for both."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions import limits
from urdf_ik.kinematics.chain.plane import Plane
from urdf_ik.maps.workspaces.arcs import Circle, Region, region
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN
from urdf_ik.support.read_only import Frozen
from urdf_ik.support.text import quoted
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]

ELBOWS = ("elbow left", "elbow right")
"""Left or right of the line from the first axis to the tip, as the plane's normal sees it; the solver's branches."""
SHARP = 1e-14
"""rad: tolerance of the limits, and of the bend's cosine, where the sides of an arc are tested. The tolerance of the
contract would widen a region beyond arcs that lie closer together."""


@dataclass(frozen=True, eq=False)
class PlanarWorkspace(Frozen):
    """Where the tip of two turning joints can be, in the coordinates of ``arm.solver.control.plane``.

    Attributes:
        name: the robot's name.
        plane: the plane, with its axes.
        centre: (2,) m, the first joint's axis.
        lengths: (2,) m, first axis to second, second axis to tip.
        angles: (2,) rad, direction of the first link, and the bend at the elbow, at q = 0.
        signs: (2,) +1 or -1: a joint that turns counter-clockwise, or clockwise.
        limits: (2, 2) rad, of the joints.
        regions: what each of ``ELBOWS`` reaches within the limits.
        boundary: what the arm reaches, with either elbow.
        overlap: what it reaches with both, in two ways.

    Example:
        >>> import urdf_ik
        >>> region = urdf_ik.maps.workspaces.planar(urdf_ik.load("planar_2r"))
        >>> region.lengths.round(6).tolist(), len(region.boundary.arcs) > 0
        ([0.066, 0.13], True)
    """

    name: str
    plane: Plane
    centre: Array
    lengths: Array
    angles: Array
    signs: Array
    limits: Array
    regions: dict[str, Region]
    boundary: Region
    overlap: Region

    def __repr__(self) -> str:
        links = " and ".join(f"{length:g} m" for length in self.lengths)
        return f"<PlanarWorkspace of {self.name}: links of {links}, boundary of {len(self.boundary.arcs)} arcs>"

    def joints(self, points: ArrayLike, elbow: str) -> Array:
        """Joint vectors (..., 2) rad within the limits for points (..., 2) m, NaN where a point is not reached.

        Example:
            >>> import urdf_ik
            >>> region = urdf_ik.maps.workspaces.planar(urdf_ik.load("planar_2r"))
            >>> q = region.joints([0.12, 0.1], "elbow left")
            >>> region.tip(q).round(6).tolist()
            [0.12, 0.1]
        """
        return _joints(self.centre, self.lengths, self.angles, self.signs, self.limits, _points(points), elbow)

    def reaches(self, points: ArrayLike, elbow: str | None = None) -> Mask:
        """Whether points (..., 2) m are reached within the limits, with that elbow or with either.

        Example:
            >>> import urdf_ik
            >>> region = urdf_ik.maps.workspaces.planar(urdf_ik.load("planar_2r"))
            >>> region.reaches([[0.12, 0.1], [0.3, 0.0]]).tolist()
            [True, False]
        """
        names = ELBOWS if elbow is None else (elbow,)
        return np.asarray(np.any([~np.isnan(self.joints(points, name)[..., 0]) for name in names], axis=0))

    def elbow(self, q: ArrayLike) -> Array:
        """Position (..., 2) m of the second axis at joint vectors (..., 2) rad.

        Example:
            >>> import urdf_ik
            >>> (urdf_ik.maps.workspaces.planar(urdf_ik.load("planar_2r")).elbow([0.0, 0.5]).round(6) + 0.0).tolist()
            [0.066, 0.0]
        """
        turned = self.angles[0] + self.signs[0] * _vectors(q)[..., 0]
        return np.asarray(self.centre + self.lengths[0] * _unit(turned))

    def tip(self, q: ArrayLike) -> Array:
        """Position (..., 2) m of the tip at joint vectors (..., 2) rad.

        Example:
            >>> import urdf_ik
            >>> (urdf_ik.maps.workspaces.planar(urdf_ik.load("planar_2r")).tip([0.0, 0.0]).round(6) + 0.0).tolist()
            [0.196, 0.0]
        """
        turned = (self.angles + self.signs * _vectors(q)).sum(axis=-1)
        return np.asarray(self.elbow(q) + self.lengths[1] * _unit(turned))


def planar(arm: Arm) -> PlanarWorkspace:
    """The workspace of an arm of two turning joints about parallel axes, bounded by arcs.

    With the bend of the elbow at a limit, or straight or folded, the tip runs on a circle about the first axis; with
    the first joint at a limit it runs on a circle about the elbow. These circles hold every boundary.

    Raises:
        ArgumentError: the arm is of another build.

    Example:
        >>> import urdf_ik
        >>> region = planar(urdf_ik.load("planar_2r"))
        >>> region.lengths.round(6).tolist(), sorted(region.regions)
        ([0.066, 0.13], ['elbow left', 'elbow right'])
    """
    inputs.arm(arm)
    chain, plane = arm.chain, arm.solver.control.plane
    if plane is None or chain.n != 2 or chain.prismatic.any():
        kinds = ", ".join(chain.joint_types)
        raise ArgumentError(
            f"{arm.name}: joints {kinds}; an exact boundary is that of two joints that turn about parallel axes. "
            "Other arms have a map: urdf_ik.maps.workspace(arm)"
        )
    tilted = float(np.linalg.norm(np.cross(chain.H, plane.normal), axis=1).max())
    if tilted > DEFAULT.contract:
        raise ArgumentError(
            f"{arm.name}: its axes are {tilted:.2g} rad off parallel, so that the tip's paths are no circles in the "
            "plane; urdf_ik.maps.workspace(arm) makes a map"
        )
    points = np.cumsum(chain.P, axis=0) @ plane.axes.T
    links = np.diff(points, axis=0)
    lengths = np.linalg.norm(links, axis=1)
    if lengths.min() < DEFAULT.near_distance * chain.size:
        raise ArgumentError(f"{arm.name}: a link of {lengths.min():.2g} m; both must have a length")
    headings = np.arctan2(links[:, 1], links[:, 0])
    angles = np.array([headings[0], headings[1] - headings[0]])
    signs = np.sign(chain.H @ plane.normal)
    centre, bounds = points[0], chain.limits

    def reaches(where: Array, name: str) -> Mask:
        return ~np.isnan(_joints(centre, lengths, angles, signs, bounds, where, name, SHARP)[..., 0])

    circles = list(_circles(arm.joint_names, centre, lengths, angles, signs, bounds))
    size = float(lengths.sum())
    return PlanarWorkspace(
        name=arm.name,
        plane=plane,
        centre=centre,
        lengths=lengths,
        angles=angles,
        signs=signs,
        limits=bounds,
        regions={name: region(partial(reaches, name=name), circles, size) for name in ELBOWS},
        boundary=region(lambda at: reaches(at, ELBOWS[0]) | reaches(at, ELBOWS[1]), circles, size),
        overlap=region(lambda at: reaches(at, ELBOWS[0]) & reaches(at, ELBOWS[1]), circles, size),
    )


def _circles(
    names: tuple[str, ...], centre: Array, lengths: Array, angles: Array, signs: Array, bounds: Array
) -> list[Circle]:
    """All circles that may bound the workspace, each with the angles at which the joints' limits end it."""
    turned = [sorted(angles[i] + signs[i] * bounds[i]) for i in range(2)]
    whole = [bool(hi - lo >= TURN - limits.LIMIT_TOLERANCE) for lo, hi in turned]
    starts = [] if whole[0] else [(turned[0][k], _limit(names[0], signs[0], k)) for k in range(2)]
    bends = [] if whole[1] else [(turned[1][k], _limit(names[1], signs[1], k)) for k in range(2)]
    circles = []
    for bend, name in (*bends, (0.0, "arm straight"), (np.pi, "arm folded")):
        tip = lengths[0] * _unit(np.float64(0.0)) + lengths[1] * _unit(np.float64(bend))
        breaks = tuple(float(np.arctan2(tip[1], tip[0]) + start) for start, _ in starts)
        circles.append(Circle(centre, float(np.hypot(*tip)), breaks, name))
    for start, name in starts:
        breaks = tuple(float(start + bend) for bend, _ in bends)
        circles.append(Circle(centre + lengths[0] * _unit(np.float64(start)), float(lengths[1]), breaks, name))
    return circles


def _limit(name: str, sign: float, k: int) -> str:
    return f"{name} at its {'lower' if (k == 0) == (sign > 0) else 'upper'} limit"


def _joints(
    centre: Array,
    lengths: Array,
    angles: Array,
    signs: Array,
    bounds: Array,
    points: Array,
    elbow: str,
    tolerance: float = DEFAULT.contract,
) -> Array:
    """Joint vectors (..., 2) within the limits by the law of cosines, NaN where a point is not reached."""
    inputs.choice(elbow, "elbow", ELBOWS)
    first, second = lengths
    offset = points - centre
    cosine = ((offset**2).sum(axis=-1) - first**2 - second**2) / (2.0 * first * second)
    reached = np.abs(cosine) <= 1.0 + tolerance
    # A forearm that turns clockwise from the upper arm's direction leaves the elbow on the left.
    bend = (-1.0 if elbow == ELBOWS[0] else 1.0) * np.arccos(np.clip(cosine, -1.0, 1.0))
    heading = np.arctan2(offset[..., 1], offset[..., 0])
    heading = heading - np.arctan2(second * np.sin(bend), first + second * np.cos(bend))
    q = signs * (np.stack([heading, bend], axis=-1) - angles)
    q = np.where(reached[..., None], q, np.nan)
    return limits.nearest_image(q, bounds, np.ones(2, dtype=np.bool_), tolerance)[0]


def _points(points: ArrayLike) -> Array:
    array = inputs.real(points, "points", "an array of numbers (..., 2), m in the arm's plane")
    if array.shape[-1:] != (2,):
        raise ArgumentError(f"points of shape {array.shape} given; (..., 2) m in the arm's plane are needed")
    if (bad := inputs.first_bad(array)) is not None:
        raise ArgumentError(f"point {array[bad[:-1]].tolist()} given; {inputs.why_bad(array[bad])}")
    return array


def _vectors(q: ArrayLike) -> Array:
    array = inputs.real(q, "a joint vector", "an array of numbers (..., 2)")
    if array.shape[-1:] != (2,) or inputs.first_bad(array) is not None:
        raise ArgumentError(f"joint vectors {quoted(q)} given; (..., 2) finite numbers [rad] are needed")
    return array


def _unit(angle: Array | np.float64) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
