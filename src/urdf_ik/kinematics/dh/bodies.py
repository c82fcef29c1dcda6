"""Links made of cylinders and boxes, for an arm of which only the joint frames are known.

A link is a hub about its own joint's axis and legs to the next joint. What collides is less than what is seen, so
that contacts mean something: a leg ends short of the next joint's hub, and of hubs that overlap (where axes meet)
only the last one collides.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from urdf_ik.kinematics.dh.fields import TableFields
from urdf_ik.kinematics.dh.frames import slide_z
from urdf_ik.model.poses import pose
from urdf_ik.typing import Array

_HUB = 0.045
"""Radius of a hub as a share of the arm's reach."""
_LEG = 0.6
"""Radius of a leg as a share of a hub's."""
_HALF_HUB = 1.3
"""Half the length of a hub as a share of its radius."""
_CLEAR = 1.15
"""Distance from a joint's origin at which the previous link's collision shapes end, as a share of the hub's extent."""


@dataclass(frozen=True)
class Body:
    """A primitive in a link's frame.

    Attributes:
        kind: 'cylinder' (about its z axis) or 'box'.
        size: (radius, length) of a cylinder, (x, y, z) of a box [m].
        pose: (4, 4) of its centre.
        material: name of its colour.
        seen: whether it is a visual.
        collides: whether it is a collision shape.
    """

    kind: str
    size: tuple[float, ...]
    pose: Array
    material: str
    seen: bool = True
    collides: bool = True


def bodies(table: TableFields) -> list[list[Body]]:
    """Primitives of the base link and of each joint's link."""
    origins = table.origins()
    ends = np.linalg.norm(origins[:, :3, 3], axis=1)
    travel = np.where(table.prismatic, np.ptp(np.where(np.isfinite(table.limits), table.limits, 0.0), axis=1), 0.0)
    reach = float(ends.sum() + travel.sum()) or 1.0
    radius = _HUB * reach
    extent = radius * float(np.hypot(1.0, _HALF_HUB))
    links = [[_plate(radius), *_legs(table, 0, origins[0], radius, extent)]]
    for i in range(table.n):
        last = i == table.n - 1
        alone = last or bool(ends[i + 1] > 2.0 * extent)
        hub = _hub(bool(table.prismatic[i]), radius, collides=alone)
        link = [hub, *_legs(table, i + 1, origins[i + 1], radius, 0.0 if last else extent)]
        if table.prismatic[i]:
            lower, upper = table.limits[i]
            # From where the joint is at the farthest to where it is at the nearest, seen from the sliding link.
            far, near = np.array([0.0, 0.0, min(-upper, 0.0)]), np.array([0.0, 0.0, max(-lower, 0.0)])
            link.extend(_leg(far, near, radius, 0.0 if alone else extent))
        links.append(link)
    return links


def _plate(radius: float) -> Body:
    return Body("cylinder", (1.6 * radius, 0.5 * radius), slide_z(-0.25 * radius), "graphite")


def _hub(slides: bool, radius: float, collides: bool) -> Body:
    if slides:
        return Body("box", (1.6 * radius, 1.6 * radius, 2.0 * radius), np.eye(4), "orange", collides=collides)
    return Body("cylinder", (radius, 2.0 * _HALF_HUB * radius), np.eye(4), "orange", collides=collides)


def _legs(table: TableFields, link: int, to: Array, radius: float, extent: float) -> list[Body]:
    """Legs from the origin of a link's frame along x and z, as the convention has it, to the next joint."""
    end = to[:3, 3]
    corner = np.array([0.0, 0.0, end[2]])
    if table.convention == "modified" and 0 < link < table.n:
        corner = np.array([table.a[link], 0.0, 0.0])
    out = []
    if np.linalg.norm(end - corner) > 0.0:
        out = _leg(corner, end, radius, extent)
        # Where the second leg lies within the next joint's hub, the first one must stop short of it, too.
    room = extent - float(np.linalg.norm(end - corner))
    return [*_leg(np.zeros(3), corner, radius, max(room, 0.0)), *out]


def _leg(start: Array, end: Array, radius: float, extent: float) -> list[Body]:
    """A cylinder from start to end: seen in full, colliding up to the clearance of the next joint's hub."""
    length = float(np.linalg.norm(end - start))
    if length < 0.1 * radius:
        return []
    along = (end - start) / length
    x, y, z = along if along[2] >= 0.0 else -along
    rpy = (0.0, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x))

    def cylinder(to: float, seen: bool, collides: bool) -> Body:
        centre = pose(start + 0.5 * to * along, rpy=rpy)
        return Body("cylinder", (_LEG * radius, to), centre, "silver", seen, collides)

    free = length - _CLEAR * extent
    if free == length:
        return [cylinder(length, seen=True, collides=True)]
    short = [cylinder(free, seen=False, collides=True)] if free > 0.1 * radius else []
    return [cylinder(length, seen=True, collides=False), *short]
