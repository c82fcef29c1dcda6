"""Alignment: base frame, tip frame, joint zeros and signs with which one arm moves like another.

Each step is closed. The zero of a turning joint comes from the angle about its axis between the common normals to its
neighbours, the joint angle of Denavit and Hartenberg (1955). The rotations of base and tip are least-squares fits by
singular values (Kabsch 1976), their positions and the zeros of slides are linear least squares. Every combination of
signs is tried. The first and the last joint have no zeros: a turn about their axes is one of base or tip.
"""

from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
from lxml import etree

from urdf_ik.arm import Arm, load
from urdf_ik.errors import ArgumentError
from urdf_ik.model.poses import nearest_rotation
from urdf_ik.model.xml import numbers_text, origin_attributes
from urdf_ik.support.angles import shortest
from urdf_ik.typing import Array
from urdf_ik.verify.description import Row, Step, flat, matrix
from urdf_ik.verify.differences import pose_of

_PARALLEL = 0.02  # rad: closer to each other, two axes have as their normal the step from the one to the other
_SAMPLES = 40
_AS_GOOD = 1.05, 1e-7  # a factor, and a share of the arm's size: fits of other signs that are as good as the best


@dataclass(frozen=True)
class Alignment:
    """B's conventions in A's: at q, A's tip is where base * B's pose at (signs * q + zeros) * tip is.

    Attributes:
        base: 12 numbers, the upper three rows of the pose [m] of B's base in A's base.
        tip: 12 numbers, likewise of A's tip in B's tip.
        signs: (n,) -1 for a joint that moves the other way in B, else 1.
        zeros: (n,) rad or m, joint values of B where those of A are zero.
    """

    base: Row
    tip: Row
    signs: Row
    zeros: Row


def aligned(a: Arm, b: Arm) -> tuple[Arm, Alignment]:
    """B with A's frames of base and tip, zeros and signs. Joints are paired from base to tip."""
    if a.joint_names != b.joint_names and set(a.joint_names) == set(b.joint_names):
        raise ArgumentError("arms with the same joint names in another order cannot be aligned")
    slides = a.chain.prismatic
    if list(slides) != list(b.chain.prismatic) or a.chain.followers or b.chain.followers:
        raise ArgumentError("only arms with the same kinds of joints, none of which mimics another, can be aligned")
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (_SAMPLES, a.dof))
    poses, size = a.fk(q), a.cell.reference.size
    fits = []
    # Fewest turned joints first.
    for signs in sorted(map(np.array, product((1.0, -1.0), repeat=a.dof)), key=lambda each: -float(each.sum())):
        zeros, rotation = _angles(a, b, signs)
        fits.append((signs, *_ends(poses, b, signs * q + zeros, zeros, rotation, size)))
    enough = _AS_GOOD[0] * min(off for *_, off in fits) + _AS_GOOD[1] * size
    as_good = (fit for fit in fits if fit[-1] <= enough)
    signs, zeros, base, tip, _ = min(as_good, key=lambda fit: round(_limits_apart(a, b, fit[0], fit[1]), 3))
    found = Alignment(flat(base), flat(tip), tuple(map(float, signs)), tuple(map(float, zeros)))
    return _rewritten(b, found), found


def _angles(a: Arm, b: Arm, signs: Array) -> tuple[Array, Array]:
    """Zeros (n,) of the joints of B that turn, and the rotation (3, 3) of its base in A's by the first normal."""
    n, slides = a.dof, a.chain.prismatic
    axes, points = (signs[:, None] * a.chain.H, b.chain.H), (a.chain.points, b.chain.points)
    normals: dict[tuple[int, int], list[Array]] = {}
    for i, k in combinations(range(n), 2):
        crossed = [np.cross(u[i], u[k]) for u in axes]
        if min(map(np.linalg.norm, crossed)) < _PARALLEL:
            if slides[i] or slides[k]:  # a slide has no place, and the next axis has the normal
                continue
            steps = [p[k] - p[i] for p in points]
            crossed = [step - (step @ u[i]) * u[i] for step, u in zip(steps, axes, strict=True)]
        if min(map(np.linalg.norm, crossed)) > 1e-9:
            normals[i, k] = crossed
    zeros = np.zeros(n)
    first = next(iter(normals), None)
    for k in np.flatnonzero(~np.asarray(slides)).tolist():
        before = next((normals[i, k] for i in range(k - 1, -1, -1) if (i, k) in normals), None)
        after = next((normals[k, i] for i in range(k + 1, n) if (k, i) in normals), None)
        if before is not None and after is not None:
            normal = zip(axes, before, after, strict=True)
            ours, theirs = (np.arctan2(u[k] @ np.cross(x, y), x @ y) for u, x, y in normal)
            zeros[k] = shortest(np.array(ours - theirs))
    if first is None:
        return zeros, np.eye(3)
    frames = [_frame(u[first[0]], x) for u, x in zip(axes, normals[first], strict=True)]
    return zeros, frames[0] @ frames[1].T


def _limits_apart(a: Arm, b: Arm, signs: Array, zeros: Array) -> float:
    """Sum of the differences of the limits [rad, m], those of B in A's joint values."""
    theirs = np.sort(signs[:, None] * (b.limits - zeros[:, None]), axis=1)
    finite = np.isfinite(a.limits) & np.isfinite(theirs)
    return float(np.abs(np.where(finite, a.limits - theirs, 0.0)).sum())


def _frame(z: Array, x: Array) -> Array:
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _ends(
    poses: Array, b: Arm, q: Array, zeros: Array, rotation: Array, size: float
) -> tuple[Array, Array, Array, float]:
    """Zeros, base and tip with which B at q (m, n) fits poses (m, 4, 4) best, and the root mean square [m] of it."""
    there = b.fk(q)
    R, S = poses[:, :3, :3], there[:, :3, :3]
    for _ in range(5):
        tip = nearest_rotation(np.einsum("mji,kj,mkl->il", S, rotation, R))
        rotation = nearest_rotation(np.einsum("mij,kj,mlk->il", R, tip, S))
    columns = [np.broadcast_to(np.eye(3), R.shape), rotation @ S]
    slides = np.flatnonzero(b.chain.prismatic)
    moves = [(rotation @ (b.fk(q + np.eye(b.dof)[k]) - there)[:, :3, 3, None]) for k in slides]
    wanted = poses[:, :3, 3] - there[:, :3, 3] @ rotation.T
    system = np.concatenate([*columns, *moves], axis=2).reshape(3 * len(q), -1)
    x, *_ = np.linalg.lstsq(system, wanted.reshape(-1), rcond=1e-9)
    missed = (wanted.reshape(-1) - system @ x).reshape(-1, 3)
    turned = R - rotation @ S @ tip
    base_pose, tip_pose = np.eye(4), np.eye(4)
    base_pose[:3, :3], base_pose[:3, 3] = rotation, x[:3]
    tip_pose[:3, :3], tip_pose[:3, 3] = tip, x[3:6]
    zeros = zeros.copy()
    zeros[slides] = x[6:]
    off = float(np.sqrt((missed**2).sum(axis=1).mean() + size**2 * (turned**2).sum(axis=(1, 2)).mean()))
    return zeros, base_pose, tip_pose, off


def _rewritten(b: Arm, found: Alignment) -> Arm:
    """B with joints of A's zeros and signs, and links for A's base and tip."""
    robot = etree.fromstring(b.model.xml)
    elements = {each.get("name"): each for each in robot.iterfind("joint")}
    joints = {each.name: each for each in b.model.joints}
    for name, sign, zero in zip(b.joint_names, found.signs, found.zeros, strict=True):
        joint, element = joints[name], elements[name]
        for each in element.xpath("origin | axis"):
            element.remove(each)
        at_zero = Step(name, joint.type, flat(joint.origin), tuple(joint.axis), zero)
        etree.SubElement(element, "origin", origin_attributes(pose_of([at_zero])))
        etree.SubElement(element, "axis", xyz=numbers_text(sign * joint.axis))
        limit = element.find("limit")
        if np.isfinite((joint.lower, joint.upper)).all():
            lower, upper = sorted((sign * (joint.lower - zero), sign * (joint.upper - zero)))
            limit.attrib.update({"lower": repr(float(lower)), "upper": repr(float(upper))})
    ends = [f"base of A in {b.base}", f"tip of A in {b.tip}"]
    base = np.asarray(np.linalg.inv(matrix(found.base)), dtype=np.float64)
    for end, link, pose in ((ends[0], b.base, base), (ends[1], b.tip, matrix(found.tip))):
        etree.SubElement(robot, "link", name=end)
        fixed = etree.SubElement(robot, "joint", name=end, type="fixed")
        etree.SubElement(fixed, "origin", origin_attributes(pose))
        etree.SubElement(fixed, "parent", link=link)
        etree.SubElement(fixed, "child", link=end)
    text = etree.tostring(robot, encoding="utf-8")
    return load(text, *ends, locked=dict(b.chain.locked), mesh_roots=b.model.package_dirs)
