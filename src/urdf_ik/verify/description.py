"""Description: an arm as plain numbers and words, for comparisons and lock files."""

import hashlib
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from lxml import etree

from urdf_ik.arm import Arm
from urdf_ik.errors import UrdfIkError
from urdf_ik.model.urdf import resolve_mesh
from urdf_ik.model.xml import floats, origin_of
from urdf_ik.support.report import from_plain
from urdf_ik.typing import Array

MISSING = "missing"
"""The digest of a mesh whose file cannot be read."""

_SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "capsule": ("radius", "length"),
          "mesh": ("scale",)}  # fmt: skip

Row = tuple[float, ...]


@dataclass(frozen=True)
class Step:
    """One joint of the URDF on the way from base to tip, fixed ones included.

    Attributes:
        name: the joint's name.
        type: its type in the URDF.
        origin: 12 numbers, the upper three rows of its pose in the link before it [m].
        axis: (3,) unit direction in its own frame.
        held: value [rad or m] of a joint that is held, else 0.
        backwards: whether the way leads from the child link to the parent link.
    """

    name: str
    type: str
    origin: Row
    axis: Row
    held: float = 0.0
    backwards: bool = False


@dataclass(frozen=True)
class Shape:
    """One shape of a link.

    Attributes:
        link: the link.
        role: 'collision' or 'visual'.
        kind: 'box', 'cylinder', 'sphere', 'capsule' or 'mesh'.
        size: what the URDF says of its size [m], or a mesh's scale.
        place: 12 numbers, the upper three rows of its pose [m] in the frame of the rigid body that the link is part of:
            of the link that a movable joint carries, or of the root. Fixed joints between links do not change it.
        file: name of a mesh's file, without its folder.
        digest: SHA-256 of a mesh's file, ``MISSING`` where it cannot be read; '' for other shapes.
    """

    link: str
    role: str
    kind: str
    size: Row
    place: Row
    file: str = ""
    digest: str = ""


@dataclass(frozen=True)
class Description:
    """An arm in plain numbers and words.

    Attributes:
        robot: the robot's name.
        base: base link.
        tip: tip link.
        joint_names: joints of a joint vector, base to tip.
        joint_types: 'revolute', 'continuous' or 'prismatic', one a joint.
        limits: (n, 2) rad or m; infinite where there is none.
        moving: every axis that moves, base to tip: those of ``joint_names`` and of the joints that mimic them.
        directions: (m, 3) unit directions of these axes at q = 0, in the base.
        points: (m, 3) m, a point on each.
        sliding: (m,) whether the joint slides along it.
        home: 12 numbers, the upper three rows of the tip's pose at q = 0 [m].
        followers: (joint, joint that it follows, multiplier, offset) of those that mimic.
        steps: the URDF's joints from base to tip.
        shapes: those of every link.
        allowed: pairs of links that may touch by an SRDF, sorted.
        locked: (joint, value) of those that are held.
        redundancy: redundancy parameters, in words.
        task: what the arm controls of a pose.
        family: name of its family, '' where no solver takes it.
        reason: why it is that family.
    """

    robot: str
    base: str
    tip: str
    joint_names: tuple[str, ...]
    joint_types: tuple[str, ...]
    limits: tuple[Row, ...]
    moving: tuple[str, ...]
    directions: tuple[Row, ...]
    points: tuple[Row, ...]
    sliding: tuple[bool, ...]
    home: Row
    followers: tuple[tuple[str, str, float, float], ...]
    steps: tuple[Step, ...]
    shapes: tuple[Shape, ...]
    allowed: tuple[tuple[str, str], ...]
    locked: tuple[tuple[str, float], ...] = ()
    redundancy: tuple[str, ...] = ()
    task: str = "pose"
    family: str = ""
    reason: str = ""

    @property
    def dof(self) -> int:
        """Number of joints of a joint vector."""
        return len(self.joint_names)

    @property
    def title(self) -> str:
        """The arm in a line."""
        return f"{self.robot}, {self.base} to {self.tip}"


def described(arm: Arm, *, shapes: bool = True) -> Description:
    """The description of an arm.

    Args:
        arm: the arm.
        shapes: whether to read the shapes of its links, too: every mesh is read once.
    """
    axes = arm.chain.axes
    structure = arm.structure
    return Description(
        robot=arm.name,
        base=arm.base,
        tip=arm.tip,
        joint_names=tuple(arm.joint_names),
        joint_types=tuple(arm.chain.joint_types),
        limits=_rows(arm.limits),
        moving=_moving(arm),
        directions=_rows(axes.H),
        points=_rows(axes.points),
        sliding=tuple(map(bool, axes.prismatic)),
        home=flat(arm.fk(np.zeros(arm.dof))),
        followers=tuple((f.name, f.driver, float(f.multiplier), float(f.offset)) for f in arm.chain.followers),
        steps=_steps(arm),
        shapes=_shapes(arm) if shapes else (),
        allowed=tuple(sorted((min(pair), max(pair)) for pair in arm.cell.disabled)),
        locked=tuple((name, float(value)) for name, value in sorted(arm.chain.locked)),
        redundancy=parameters_of(arm),
        task=arm.task,
        family=structure.family or "",
        reason=structure.reason or "",
    )


def from_dict(data: Any) -> Description:
    """The description that was written as plain lists, numbers and text."""
    out: Description = from_plain(Description, data, "arm")
    for name, rows, width in (
        ("limits", out.limits, 2),
        ("directions", out.directions, 3),
        ("points", out.points, 3),
        ("home", (out.home,), 12),
        ("steps", tuple((*step.origin, *step.axis, step.held) for step in out.steps), 16),
    ):
        valid = np.isfinite if name != "limits" else lambda row: ~np.isnan(row)
        if any(len(row) != width or not valid(row).all() for row in rows):
            raise ValueError(f"arm.{name}: rows of {width} numbers are needed")
    lengths = {len(out.joint_names), len(out.joint_types), len(out.limits)}
    if len(lengths) != 1 or len({len(out.moving), len(out.directions), len(out.points), len(out.sliding)}) != 1:
        raise ValueError("the lists of the joints are not equally long")
    return out


def parameters_of(arm: Arm) -> tuple[str, ...]:
    """The arm's redundancy parameters in words, such as 'swivel of joint_3'."""
    return tuple(f"{parameter.kind} of {parameter.joint}" for parameter in arm.solver.parameters)


def flat(T: Array) -> Row:
    """The upper three rows of a pose (4, 4), 12 numbers."""
    return tuple(map(float, T[:3].reshape(-1)))


def matrix(row: Row) -> Array:
    """The pose (4, 4) of 12 numbers."""
    return np.vstack([np.array(row, dtype=np.float64).reshape(3, 4), [0.0, 0.0, 0.0, 1.0]])


def _rows(array: Array) -> tuple[Row, ...]:
    return tuple(tuple(map(float, row)) for row in np.asarray(array))


def _moving(arm: Arm) -> tuple[str, ...]:
    """Names of the joints that move between base and tip, those that mimic others included."""
    locked, path = dict(arm.chain.locked), arm.model.path_between(arm.base, arm.tip)
    return tuple(each.name for each in path if each.type != "fixed" and arm.model.driver(each)[0].name not in locked)


def _steps(arm: Arm) -> tuple[Step, ...]:
    out, link = [], arm.base
    locked = dict(arm.chain.locked)
    for joint in arm.model.path_between(arm.base, arm.tip):
        backwards = joint.child == link
        link = joint.parent if backwards else joint.child
        driver, multiplier, offset = arm.model.driver(joint)
        value = multiplier * locked[driver.name] + offset if driver.name in locked else 0.0
        axis = tuple(map(float, joint.axis))
        out.append(Step(joint.name, joint.type, flat(joint.origin), axis, float(value), backwards))
    return tuple(out)


def _shapes(arm: Arm) -> tuple[Shape, ...]:
    tree, out = etree.fromstring(arm.model.xml), []
    digest, in_body = cache(partial(_digest, arm)), cache(partial(_in_body, arm))
    for role in ("collision", "visual"):
        for body in tree.iterfind(f"link/{role}"):
            geometry = body.find("geometry")[0]
            size = tuple(x for name in _SIZES.get(geometry.tag, ()) for x in floats(geometry, name))
            name = geometry.get("filename") or ""
            file = name.replace("\\", "/").rpartition("/")[2]
            link = body.getparent().get("name")
            T, sha256 = in_body(link) @ origin_of(body), digest(name) if geometry.tag == "mesh" else ""
            out.append(Shape(link, role, geometry.tag, size, flat(T), file, sha256))
    return tuple(out)


def _in_body(arm: Arm, link: str) -> Array:
    """Pose (4, 4) of a link in the rigid body that it is part of."""
    T = np.eye(4)
    while (joint := arm.model.parent_joint(link)) is not None and joint.type == "fixed":
        T, link = joint.origin @ T, joint.parent
    return T


def _digest(arm: Arm, name: str) -> str:
    try:
        with resolve_mesh(arm.model, name).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (UrdfIkError, OSError):
        return MISSING
