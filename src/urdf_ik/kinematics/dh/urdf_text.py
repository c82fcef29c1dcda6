"""Readable URDF text of a Denavit-Hartenberg table, with links made of cylinders and boxes.

A link is a hub about its own joint's axis and legs to the next joint. What collides is less than what is seen, so
that contacts mean something: a leg ends short of the next joint's hub, and of hubs that overlap (where axes meet)
only the last one collides.
"""

from dataclasses import dataclass, replace
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from urdf_ik.kinematics.dh import files
from urdf_ik.kinematics.dh.files import table_error
from urdf_ik.kinematics.dh.frames import slide_z
from urdf_ik.model.poses import pose, to_rpy
from urdf_ik.support.text import aligned, quoted
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


def bodies(table: Any) -> list[list[Body]]:
    """Primitives of the base link and of each joint's link."""
    origins = table.origins()
    ends = np.linalg.norm(origins[:, :3, 3], axis=1)
    travel = np.where(table.prismatic, np.ptp(np.where(np.isfinite(table.limits), table.limits, 0.0), axis=1), 0.0)
    reach = float(ends.sum() + travel.sum()) or 1.0
    radius = _HUB * reach
    extent = radius * float(np.hypot(1.0, _HALF_HUB))
    plate = Body("cylinder", (1.6 * radius, 0.5 * radius), slide_z(-0.25 * radius), "graphite")
    links = [[plate, *_legs(table, 0, origins[0], radius, extent)]]
    for i in range(table.n):
        last = i == table.n - 1
        alone = last or bool(ends[i + 1] > 2.0 * extent)
        hub = Body("cylinder", (radius, 2.0 * _HALF_HUB * radius), np.eye(4), "orange", collides=alone)
        if table.prismatic[i]:
            hub = replace(hub, kind="box", size=(1.6 * radius, 1.6 * radius, 2.0 * radius))
        link = [hub, *_legs(table, i + 1, origins[i + 1], radius, 0.0 if last else extent)]
        if table.prismatic[i]:
            lower, upper = table.limits[i]
            # From where the joint is at the farthest to where it is at the nearest, seen from the sliding link.
            far, near = np.array([0.0, 0.0, min(-upper, 0.0)]), np.array([0.0, 0.0, max(-lower, 0.0)])
            link.extend(_leg(far, near, radius, 0.0 if alone else extent))
        links.append(link)
    return links


def _legs(table: Any, link: int, to: Array, radius: float, extent: float) -> list[Body]:
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


_COLOURS = {"graphite": "0.18 0.19 0.21", "silver": "0.78 0.80 0.83", "orange": "0.95 0.48 0.10"}
_EFFORT, _VELOCITY = 100, {"revolute": 3, "continuous": 3, "prismatic": 1}


def write(table: Any, base_link: str, tip_link: str) -> str:
    """URDF text with the links ``base_link``, ``link_1`` ... ``link_n`` and ``tip_link``."""
    links = [base_link, *(f"link_{i + 1}" for i in range(table.n)), tip_link]
    if not all(isinstance(name, str) and name.strip() for name in links) or len(set(links)) < len(links):
        raise table_error(f"the links {', '.join(map(quoted, links))} must have different names")
    if "tool_joint" in table.joint_names:
        raise table_error("'tool_joint' is the name of the fixed joint of the tool", column="name")
    origins = table.origins()
    lines = ['<?xml version="1.0" encoding="utf-8"?>', *_remark(table), f"<robot name={quoteattr(table.name)}>"]
    lines += [f'  <material name="{name}"><color rgba="{rgb} 1"/></material>' for name, rgb in _COLOURS.items()]
    for i, shapes in enumerate(bodies(table)):
        if i:
            lines += ["", *_joint(table, i - 1, links[i - 1], links[i], origins[i - 1])]
        lines += ["", f"  <link name={quoteattr(links[i])}>", *_shapes(shapes), "  </link>"]
    lines += [
        "",
        '  <joint name="tool_joint" type="fixed">',
        f"    <parent link={quoteattr(links[-2])}/>",
        f"    <child link={quoteattr(tip_link)}/>",
        f"    {_origin(origins[-1])}",
        "  </joint>",
        "",
        f"  <link name={quoteattr(tip_link)}/>",
        "</robot>",
        "",
    ]
    return "\n".join(lines)


def _remark(table: Any) -> list[str]:
    step = "Rz(theta) Tz(d) Tx(a) Rx(alpha)" if table.convention == "standard" else "Rx(alpha) Tx(a) Rz(theta) Tz(d)"
    header, rows = files.cells(table, degrees=True)
    wanted = [header.index(name) for name in ("joint", "alpha [deg]", "a [m]", "d [m]", "theta [deg]")]
    lines = aligned([[row[k] for k in wanted] for row in (header, *rows)])
    text = [
        f"From a Denavit-Hartenberg table in the {table.convention} convention, T(i-1, i) = {step}:",
        "",
        *("  " + line for line in lines),
        *("  " + line for line in files.frames(table, degrees=True)),
        "",
        "Every joint's axis is the z axis of its frame. Units: m, rad.",
    ]
    # Two hyphens would end the remark.
    return ["<!--", *(f"  {escape(line)}".rstrip().replace("--", "- -") for line in text), "-->"]


def _joint(table: Any, i: int, parent: str, child: str, origin: Array) -> list[str]:
    kind = table.joint_types[i]
    lower, upper = table.limits[i]
    bounds = "" if kind == "continuous" else f'lower="{number(lower)}" upper="{number(upper)}" '
    return [
        f'  <joint name={quoteattr(table.joint_names[i])} type="{kind}">',
        f"    <parent link={quoteattr(parent)}/>",
        f"    <child link={quoteattr(child)}/>",
        f"    {_origin(origin)}",
        '    <axis xyz="0 0 1"/>',
        f'    <limit {bounds}effort="{_EFFORT}" velocity="{_VELOCITY[kind]}"/>',
        "  </joint>",
    ]


def _shapes(shapes: list[Body]) -> list[str]:
    lines: list[str] = []
    for tag in ("visual", "collision"):
        for body in shapes:
            if not (body.seen if tag == "visual" else body.collides):
                continue
            # Sizes need no more digits than a workshop does.
            size = [f"{value:.4g}" for value in body.size]
            geometry = f'<box size="{" ".join(size)}"/>'
            if body.kind == "cylinder":
                geometry = f'<cylinder radius="{size[0]}" length="{size[1]}"/>'
            lines += [f"    <{tag}>", f"      {_origin(body.pose, digits=6)}", f"      <geometry>{geometry}</geometry>"]
            lines += [f'      <material name="{body.material}"/>'] if tag == "visual" else []
            lines += [f"    </{tag}>"]
    return lines


def _origin(T: Array, digits: int | None = None) -> str:
    xyz, rpy = T[:3, 3], to_rpy(T)
    if digits is not None:
        xyz = np.round(xyz, digits)
    return f'<origin xyz="{" ".join(map(number, xyz))}" rpy="{" ".join(map(number, rpy))}"/>'


def number(value: float) -> str:
    """Text of a number as short as its rounding allows; no sign at zero."""
    value = float(value)
    short = float(f"{value:.15g}")
    if abs(short - value) <= 2.0 * np.spacing(abs(value)) or abs(value) < 1e-16:
        value = 0.0 if abs(value) < 1e-16 else short
    text = repr(value)
    return text.removesuffix(".0")
