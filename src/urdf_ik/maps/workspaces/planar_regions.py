"""The exact region that two turning joints with limits reach in their plane, for each elbow and for both.

Regions of the plane are bounded by arcs of circles.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.arm import Arm
from urdf_ik.errors import ArgumentError
from urdf_ik.ik.solutions import limits
from urdf_ik.kinematics.chain.plane import Plane
from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

Mask = NDArray[np.bool_]
Inside = Callable[[Array], Mask]

ELBOWS = ("elbow left", "elbow right")
"""Left or right of the line from the first axis to the tip, as the plane's normal sees it; the solver's branches."""
SHARP = 1e-14
"""rad: tolerance of the limits, and of the bend's cosine, where the sides of an arc are tested. The tolerance of the
contract would widen a region beyond arcs that lie closer together."""
NUDGE = 1e-6
"""Greatest distance [share of the size] from a circle at which each of its sides is tested."""
ROUNDING = 1e-13
"""Least distance [share of the size] at which a side can be tested: nearer points round to the circle itself."""
PROBES = 7
"""Points of a piece of a circle that are candidates for the test of its sides."""
SAME = 1e-7
"""Two angles [rad], or radii and centres [share of the size], closer than this are one. Tangent circles meet in one
point; rounding makes it two, the square root of double precision apart."""


@dataclass(frozen=True, eq=False)
class Arc:
    """A part of a circle; the region lies on its left.

    Attributes:
        centre: (2,) m.
        radius: m.
        start: rad, angle of its first point as seen from the centre.
        sweep: rad, positive counter-clockwise; +-2 pi for a whole circle.
        name: the limit that bounds the region there.
    """

    centre: Array
    radius: float
    start: float
    sweep: float
    name: str = ""

    def points(self, n: int = 64) -> Array:
        """(n, 2) m, points from its start to its end, evenly spaced."""
        angles = self.start + np.linspace(0.0, self.sweep, n)
        return self.centre + self.radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


@dataclass(frozen=True, eq=False)
class Region:
    """A region by its boundary; empty where there are no arcs."""

    arcs: tuple[Arc, ...]

    @property
    def area(self) -> float:
        """Area [m^2], by Green's theorem: half the integral of x dy - y dx along the boundary."""
        total = 0.0
        for arc in self.arcs:
            a, b, (x, y) = arc.start, arc.start + arc.sweep, arc.centre
            total += arc.radius * (arc.radius * arc.sweep + x * (np.sin(b) - np.sin(a)) - y * (np.cos(b) - np.cos(a)))
        return 0.5 * float(total)

    def loops(self, n: int = 64) -> list[Array]:
        """Closed outlines (k, 2) m, the arcs joined end to start; outer ones counter-clockwise, holes clockwise.

        Args:
            n: points of each arc.
        """
        left = [arc.points(n) for arc in self.arcs]
        found: list[Array] = []
        while left:
            parts = [left.pop(0)]
            while left:
                gaps = [float(np.linalg.norm(other[0] - parts[-1][-1])) for other in left]
                best = int(np.argmin(gaps))
                if np.linalg.norm(parts[0][0] - parts[-1][-1]) <= gaps[best]:
                    break
                parts.append(left.pop(best))
            found.append(np.concatenate(parts))
        return found


@dataclass(frozen=True, eq=False)
class _Circle:
    """A circle on which the boundary may lie, and angles [rad] at which it may begin or end there."""

    centre: Array
    radius: float
    breaks: tuple[float, ...]
    name: str


def _region(inside: Inside, circles: Iterable[_Circle], size: float) -> Region:
    """The region in which ``inside`` holds, whose boundary lies on some of the circles."""
    merged = _merged(circles, size)
    arcs: list[Arc] = []
    for circle in merged:
        others = [other for other in merged if other is not circle]
        cuts = [*circle.breaks, *(angle for other in others for angle in _crossings(circle, other, size))]
        arcs += _kept(circle, _distinct(cuts), inside, others, size)
    return Region(tuple(arcs))


def _merged(circles: Iterable[_Circle], size: float) -> list[_Circle]:
    """Each circle once, with all its breaks, without circles of radius zero."""
    merged: list[_Circle] = []
    for circle in circles:
        if circle.radius < SAME * size:
            continue
        for k, other in enumerate(merged):
            off = max(abs(circle.radius - other.radius), float(np.linalg.norm(circle.centre - other.centre)))
            if off < SAME * size:
                names = other.name if circle.name in other.name else f"{other.name}, {circle.name}"
                merged[k] = _Circle(other.centre, other.radius, other.breaks + circle.breaks, names)
                break
        else:
            merged.append(circle)
    return merged


def _crossings(circle: _Circle, other: _Circle, size: float) -> list[float]:
    """Angles [rad] on ``circle`` at which ``other`` meets it."""
    offset = other.centre - circle.centre
    apart = float(np.linalg.norm(offset))
    if apart < SAME * size:
        return []
    along = (apart**2 + circle.radius**2 - other.radius**2) / (2.0 * apart * circle.radius)
    if abs(along) > 1.0 + SAME**2:
        return []
    towards, half = float(np.arctan2(offset[1], offset[0])), float(np.arccos(np.clip(along, -1.0, 1.0)))
    return [towards - half, towards + half]


def _distinct(cuts: list[float]) -> Array:
    """The angles in [0, 2 pi), sorted, without duplicates; the first of several equal ones is kept."""
    kept: list[float] = []
    for cut in cuts:
        angle = float(np.mod(cut, TURN))
        if all(abs(np.mod(angle - other + np.pi, TURN) - np.pi) > SAME for other in kept):
            kept.append(angle)
    return np.array(sorted(kept) or [0.0])


def _kept(circle: _Circle, cuts: Array, inside: Inside, others: list[_Circle], size: float) -> list[Arc]:
    """The arcs of a circle that bound the region; consecutive arcs are joined."""
    sweeps = np.diff(np.append(cuts, cuts[0] + TURN))
    angles = cuts[:, None] + sweeps[:, None] * (np.arange(1, PROBES + 1) / (PROBES + 1))
    outward = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = circle.centre + circle.radius * outward
    gaps = [np.abs(np.linalg.norm(points - other.centre, axis=-1) - other.radius) for other in others]
    free = np.min([np.full(angles.shape, circle.radius), *gaps], axis=0)
    best = np.arange(len(cuts)), free.argmax(axis=1)
    step = np.clip(0.5 * free[best], ROUNDING * size, NUDGE * size)[:, None] * outward[best]
    sides = inside(points[best] - step).astype(int) - inside(points[best] + step).astype(int)
    if (sides == sides[0]).all():
        cuts, sweeps, sides = cuts[:1], np.array([TURN]), sides[:1]
    else:
        # Begin where the side changes, so that no run of pieces goes over the end.
        first = int(np.flatnonzero(sides != np.roll(sides, 1))[0])
        cuts, sweeps, sides = np.roll(cuts, -first), np.roll(sweeps, -first), np.roll(sides, -first)
        starts = np.flatnonzero(sides != np.roll(sides, 1))
        cuts, sweeps, sides = cuts[starts], np.add.reduceat(sweeps, starts), sides[starts]
    arcs = []
    for start, sweep, side in zip(cuts.tolist(), sweeps.tolist(), sides.tolist(), strict=True):
        if side > 0:
            arcs.append(Arc(circle.centre, circle.radius, start, sweep, circle.name))
        elif side < 0:
            arcs.append(Arc(circle.centre, circle.radius, start + sweep, -sweep, circle.name))
    return arcs


@dataclass(frozen=True, eq=False)
class PlanarWorkspace:
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
    """

    name: str
    plane: Plane
    centre: Array
    lengths: Array
    angles: Array
    signs: Array
    limits: Array
    regions: dict[str, Region] = field(default_factory=dict)
    boundary: Region = Region(())
    overlap: Region = Region(())

    def __repr__(self) -> str:
        links = " and ".join(f"{length:g} m" for length in self.lengths)
        return f"<PlanarWorkspace of {self.name}: links of {links}, boundary of {len(self.boundary.arcs)} arcs>"

    def joints(self, points: ArrayLike, elbow: str) -> Array:
        """Joint vectors (..., 2) rad within the limits for points (..., 2) m, NaN where a point is not reached."""
        return self._joints(_pairs(points, "points [m]"), elbow, DEFAULT.contract)

    def reaches(self, points: ArrayLike, elbow: str | None = None) -> Mask:
        """Whether points (..., 2) m are reached within the limits, with that elbow or with either."""
        names = ELBOWS if elbow is None else (elbow,)
        return np.asarray(np.any([~np.isnan(self.joints(points, name)[..., 0]) for name in names], axis=0))

    def _joints(self, points: Array, elbow: str, tolerance: float) -> Array:
        """:meth:`joints`, by the law of cosines; ``tolerance`` of the limits [rad], and of the bend's cosine."""
        inputs.choice(elbow, "elbow", ELBOWS)
        first, second = self.lengths
        offset = points - self.centre
        cosine = ((offset**2).sum(axis=-1) - first**2 - second**2) / (2.0 * first * second)
        reached = np.abs(cosine) <= 1.0 + tolerance
        # A forearm that turns clockwise from the upper arm's direction leaves the elbow on the left.
        bend = (-1.0 if elbow == ELBOWS[0] else 1.0) * np.arccos(np.clip(cosine, -1.0, 1.0))
        heading = np.arctan2(offset[..., 1], offset[..., 0])
        heading = heading - np.arctan2(second * np.sin(bend), first + second * np.cos(bend))
        q = self.signs * (np.stack([heading, bend], axis=-1) - self.angles)
        q = np.where(reached[..., None], q, np.nan)
        return limits.nearest_image(q, self.limits, np.ones(2, dtype=np.bool_), tolerance)[0]

    def elbow(self, q: ArrayLike) -> Array:
        """Position (..., 2) m of the second axis at joint vectors (..., 2) rad."""
        turned = self.angles[0] + self.signs[0] * _pairs(q, "joint vectors")[..., 0]
        return np.asarray(self.centre + self.lengths[0] * _unit(turned))

    def tip(self, q: ArrayLike) -> Array:
        """Position (..., 2) m of the tip at joint vectors (..., 2) rad."""
        turned = (self.angles + self.signs * _pairs(q, "joint vectors")).sum(axis=-1)
        return np.asarray(self.elbow(q) + self.lengths[1] * _unit(turned))


def planar(arm: Arm) -> PlanarWorkspace:
    """The workspace of an arm of two turning joints about parallel axes, bounded by arcs.

    With the bend of the elbow at a limit, or straight or folded, the tip runs on a circle about the first axis; with
    the first joint at a limit it runs on a circle about the elbow. These circles hold every boundary.

    Raises:
        ArgumentError: the arm is of another build.
    """
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
    links_only = PlanarWorkspace(arm.name, plane, points[0], lengths, angles, signs, chain.limits)
    circles, size = _circles(arm.joint_names, links_only), float(lengths.sum())

    def reaches(where: Array, name: str) -> Mask:
        return ~np.isnan(links_only._joints(where, name, SHARP)[..., 0])

    return replace(
        links_only,
        regions={name: _region(partial(reaches, name=name), circles, size) for name in ELBOWS},
        boundary=_region(lambda at: reaches(at, ELBOWS[0]) | reaches(at, ELBOWS[1]), circles, size),
        overlap=_region(lambda at: reaches(at, ELBOWS[0]) & reaches(at, ELBOWS[1]), circles, size),
    )


def _circles(names: tuple[str, ...], arms: PlanarWorkspace) -> list[_Circle]:
    """All circles that may bound the workspace, each with the angles at which the joints' limits end it."""
    centre, lengths, signs = arms.centre, arms.lengths, arms.signs
    turned = [sorted(arms.angles[i] + signs[i] * arms.limits[i]) for i in range(2)]
    whole = [bool(hi - lo >= TURN - limits.LIMIT_TOLERANCE) for lo, hi in turned]
    starts = [] if whole[0] else [(turned[0][k], _limit(names[0], signs[0], k)) for k in range(2)]
    bends = [] if whole[1] else [(turned[1][k], _limit(names[1], signs[1], k)) for k in range(2)]
    circles = []
    for bend, name in (*bends, (0.0, "arm straight"), (np.pi, "arm folded")):
        tip = lengths[0] * _unit(np.float64(0.0)) + lengths[1] * _unit(np.float64(bend))
        breaks = tuple(float(np.arctan2(tip[1], tip[0]) + start) for start, _ in starts)
        circles.append(_Circle(centre, float(np.hypot(*tip)), breaks, name))
    for start, name in starts:
        breaks = tuple(float(start + bend) for bend, _ in bends)
        circles.append(_Circle(centre + lengths[0] * _unit(np.float64(start)), float(lengths[1]), breaks, name))
    return circles


def _limit(name: str, sign: float, k: int) -> str:
    return f"{name} at its {'lower' if (k == 0) == (sign > 0) else 'upper'} limit"


def _pairs(values: ArrayLike, words: str) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.shape[-1:] != (2,) or not np.isfinite(array).all():
        raise ArgumentError(f"{words} of shape {array.shape} given; (..., 2) finite numbers are needed")
    return array


def _unit(angle: Array | np.float64) -> Array:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
