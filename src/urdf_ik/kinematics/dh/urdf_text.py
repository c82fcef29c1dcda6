"""Readable URDF text of a Denavit-Hartenberg table, with links made of cylinders and boxes.

A link is a hub about its own joint's axis and a leg to the next joint. What collides is less than what is seen, so that
contacts mean something: a leg ends short of the next joint's hub, and of hubs that overlap (where axes meet) only the
last one collides.
"""

from typing import Any, NamedTuple

import numpy as np
from lxml import etree

from urdf_ik.kinematics.dh import files
from urdf_ik.kinematics.dh.files import table_error
from urdf_ik.kinematics.dh.frames import slide_z
from urdf_ik.model.poses import pose, to_rpy
from urdf_ik.support.text import quoted
from urdf_ik.typing import Array

_HUB = 0.045
"""Radius of a hub as a share of the arm's reach."""
_LEG = 0.6
"""Radius of a leg as a share of a hub's."""
_HALF_HUB = 1.3
"""Half the length of a hub as a share of its radius."""
_CLEAR = 1.15
"""Distance from a joint's origin at which the previous link's collision shapes end, as a share of the hub's extent."""
_COLOURS = {"graphite": "0.18 0.19 0.21", "silver": "0.78 0.80 0.83", "orange": "0.95 0.48 0.10"}
_VELOCITY = {"revolute": "3", "continuous": "3", "prismatic": "1"}


class _Body(NamedTuple):
    """A cylinder (radius, length) about its z axis, or a box (x, y, z) [m], at a pose (4, 4) in a link's frame."""

    size: tuple[float, ...]
    pose: Array
    material: str
    uses: tuple[str, ...] = ("visual", "collision")


def _bodies(table: Any) -> list[list[_Body]]:
    """Shapes of the base link and of each joint's link."""
    ends = table.origins()[:, :3, 3]
    steps = np.linalg.norm(ends, axis=1)
    travel = np.ptp(table.limits[table.prismatic], axis=1).sum()
    radius = _HUB * (float(steps.sum() + travel) or 1.0)
    extent = radius * float(np.hypot(1.0, _HALF_HUB))
    plate = _Body((1.6 * radius, 0.5 * radius), slide_z(-0.25 * radius), "graphite")
    links = [[plate, *_leg(np.zeros(3), ends[0], radius, extent)]]
    for i, (slides, (lower, upper)) in enumerate(zip(table.prismatic, table.limits, strict=True)):
        last = i == table.n - 1
        alone = last or bool(steps[i + 1] > 2.0 * extent)
        size = (1.6 * radius, 1.6 * radius, 2.0 * radius) if slides else (radius, 2.0 * _HALF_HUB * radius)
        hub = _Body(size, np.eye(4), "orange", ("visual", "collision") if alone else ("visual",))
        links.append([hub, *_leg(np.zeros(3), ends[i + 1], radius, 0.0 if last else extent)])
        if slides:  # from where the joint is at the farthest to where it is at the nearest, seen from the sliding link
            far, near = np.array([0.0, 0.0, min(-upper, 0.0)]), np.array([0.0, 0.0, max(-lower, 0.0)])
            links[-1] += _leg(far, near, radius, 0.0 if alone else extent)
    return links


def _leg(start: Array, end: Array, radius: float, extent: float) -> list[_Body]:
    """A cylinder from start to end: seen in full, colliding up to the clearance of the next joint's hub."""
    length = float(np.linalg.norm(end - start))
    if length < 0.1 * radius:
        return []
    along = (end - start) / length
    x, y, z = along
    turn = (0.0, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x))
    free = length - _CLEAR * extent
    parts = [(length, "visual"), (free, "collision")] if free > 0.1 * radius else [(length, "visual")]
    return [_Body((_LEG * radius, to), pose(start + 0.5 * to * along, rpy=turn), "silver", (use,)) for to, use in parts]


def write(table: Any, base_link: str, tip_link: str) -> str:
    """URDF text with the links ``base_link``, ``link_1`` ... ``link_n`` and ``tip_link``."""
    links = [base_link, *(f"link_{i + 1}" for i in range(table.n)), tip_link]
    if not all(isinstance(name, str) and name.strip() for name in links) or len(set(links)) < len(links):
        raise table_error(f"the links {', '.join(map(quoted, links))} must have different names")
    if "tool_joint" in table.joint_names:
        raise table_error("'tool_joint' is the name of the fixed joint of the tool", column="name")
    robot = etree.Element("robot", name=table.name)
    step = "Rz(theta) Tz(d) Tx(a) Rx(alpha)" if table.convention == "standard" else "Rx(alpha) Tx(a) Rz(theta) Tz(d)"
    about = f"{files.as_text(table, degrees=True)}\nT(i-1, i) = {step}. Every joint's axis is the z axis of its frame."
    # Two hyphens would end the remark.
    robot.append(etree.Comment("\n" + about.replace("--", "- -").replace("--", "- -") + "\n"))
    for name, rgb in _COLOURS.items():
        etree.SubElement(etree.SubElement(robot, "material", name=name), "color", rgba=f"{rgb} 1")
    joints = [*zip(table.joint_names, table.joint_types, table.limits, strict=True), ("tool_joint", "fixed", ())]
    for name, shapes in zip(links, [*_bodies(table), []], strict=True):
        _add_link(robot, name, shapes)
    for (name, kind, limits), parent, child, T in zip(joints, links[:-1], links[1:], table.origins(), strict=True):
        joint = etree.SubElement(robot, "joint", name=name, type=kind)
        etree.SubElement(joint, "parent", link=parent)
        etree.SubElement(joint, "child", link=child)
        etree.SubElement(joint, "origin", **_origin(T))
        if kind != "fixed":
            etree.SubElement(joint, "axis", xyz="0 0 1")
            bounds = {} if kind == "continuous" else dict(zip(("lower", "upper"), map(_number, limits), strict=True))
            etree.SubElement(joint, "limit", **bounds, effort="100", velocity=_VELOCITY[kind])
    etree.indent(robot)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + str(etree.tostring(robot, encoding="unicode")) + "\n"


def _add_link(robot: Any, name: str, shapes: list[_Body]) -> None:
    link = etree.SubElement(robot, "link", name=name)
    for use, body in ((use, body) for use in ("visual", "collision") for body in shapes if use in body.uses):
        element = etree.SubElement(link, use)
        etree.SubElement(element, "origin", **_origin(body.pose.round(6)))
        # Sizes need no more digits than a workshop does.
        size = [f"{value:.4g}" for value in body.size]
        sizes = {"size": " ".join(size)} if len(size) == 3 else {"radius": size[0], "length": size[1]}
        etree.SubElement(etree.SubElement(element, "geometry"), "box" if len(size) == 3 else "cylinder", **sizes)
        if use == "visual":
            etree.SubElement(element, "material", name=body.material)


def _origin(T: Array) -> dict[str, str]:
    return {"xyz": " ".join(map(_number, T[:3, 3])), "rpy": " ".join(map(_number, to_rpy(T)))}


def _number(value: float) -> str:
    """Text of a number without the digit that is rounding; no sign at zero."""
    return f"{0.0 if abs(value) < 1e-16 else float(value):.15g}"
