"""Regions of the plane that are bounded by arcs of circles: their exact boundary and area."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from urdf_ik.support import inputs
from urdf_ik.support.angles import TURN

Array = NDArray[np.float64]
Inside = Callable[[Array], NDArray[np.bool_]]

NUDGE = 1e-6
"""Greatest distance [share of the size] from a circle at which each of its sides is tested."""
ROUNDING = 1e-13
"""Least distance [share of the size] at which a side can be tested: nearer points round to the circle itself."""
PROBES = 7
"""Points of a piece of a circle that are candidates for the test of its sides."""
MOST_POINTS = 100_000
"""Greatest number of points of an arc."""
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

    @property
    def length(self) -> float:
        """Length [m]."""
        return self.radius * abs(self.sweep)

    def points(self, n: int = 64) -> Array:
        """(n, 2) m, points from its start to its end, evenly spaced.

        Raises:
            ArgumentError: ``n`` is no whole number from 2 to ``MOST_POINTS``.

        Example:
            >>> (Arc(np.zeros(2), radius=1.0, start=0.0, sweep=np.pi).points(3).round(6) + 0.0).tolist()
            [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]
        """
        count = inputs.whole(n, "n", low=2, high=MOST_POINTS)
        angles = self.start + np.linspace(0.0, self.sweep, count)
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

        Raises:
            ArgumentError: ``n`` is no whole number from 2 to ``MOST_POINTS``.

        Example:
            >>> import urdf_ik
            >>> region = urdf_ik.maps.workspaces.planar(urdf_ik.load("planar_2r")).boundary
            >>> [loop.shape[1] for loop in region.loops()]
            [2]
        """
        inputs.whole(n, "n", low=2, high=MOST_POINTS)
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
class Circle:
    """A circle on which the boundary may lie, and angles [rad] at which it may begin or end there."""

    centre: Array
    radius: float
    breaks: tuple[float, ...]
    name: str


def region(inside: Inside, circles: Iterable[Circle], size: float) -> Region:
    """The region in which ``inside`` holds, whose boundary lies on some of the circles.

    Every circle is cut where it meets another one. A piece belongs to the boundary when one of its sides is inside and
    the other is not. The sides are tested where the piece is farthest from every other circle, and nearer to it than
    to them, so that a sliver between two circles is never stepped over.

    Args:
        inside: points (k, 2) m to (k,) bool.
        circles: all on which a boundary may lie.
        size: m, what tolerances are relative to.
    """
    merged = _merged(circles, size)
    arcs: list[Arc] = []
    for circle in merged:
        others = [other for other in merged if other is not circle]
        cuts = [*circle.breaks, *(angle for other in others for angle in _crossings(circle, other, size))]
        arcs += _kept(circle, _distinct(cuts), inside, others, size)
    return Region(tuple(arcs))


def _merged(circles: Iterable[Circle], size: float) -> list[Circle]:
    """Each circle once, with all its breaks, without circles of radius zero."""
    merged: list[Circle] = []
    for circle in circles:
        if circle.radius < SAME * size:
            continue
        for k, other in enumerate(merged):
            off = max(abs(circle.radius - other.radius), float(np.linalg.norm(circle.centre - other.centre)))
            if off < SAME * size:
                names = other.name if circle.name in other.name else f"{other.name}, {circle.name}"
                merged[k] = Circle(other.centre, other.radius, other.breaks + circle.breaks, names)
                break
        else:
            merged.append(circle)
    return merged


def _crossings(circle: Circle, other: Circle, size: float) -> list[float]:
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


def _kept(circle: Circle, cuts: Array, inside: Inside, others: list[Circle], size: float) -> list[Arc]:
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
