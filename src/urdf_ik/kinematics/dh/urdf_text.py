"""Readable URDF text of a Denavit-Hartenberg table."""

from __future__ import annotations

from xml.sax.saxutils import escape, quoteattr

import numpy as np

from urdf_ik.kinematics.dh import files
from urdf_ik.kinematics.dh.bodies import Body, bodies
from urdf_ik.kinematics.dh.fields import TableFields, table_error
from urdf_ik.model.poses import to_rpy
from urdf_ik.support.text import aligned, quoted
from urdf_ik.typing import Array

_COLOURS = {"graphite": "0.18 0.19 0.21", "silver": "0.78 0.80 0.83", "orange": "0.95 0.48 0.10"}
_EFFORT, _VELOCITY = 100, {"revolute": 3, "continuous": 3, "prismatic": 1}


def write(table: TableFields, base_link: str, tip_link: str) -> str:
    """URDF text with the links ``base_link``, ``link_1`` ... ``link_n`` and ``tip_link``.

    Raises:
        UrdfError: base and tip have the same name, or that of another link.
    """
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


def _remark(table: TableFields) -> list[str]:
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


def _joint(table: TableFields, i: int, parent: str, child: str, origin: Array) -> list[str]:
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
