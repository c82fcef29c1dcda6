"""Arms with one to five joints, turning or sliding, by the position of a point that the last turns leave in place.

Of a pose the place of every point of the tip is known. A point on the last axis (where axes 4 and 5 of five joints
meet) is placed by three joints (slide_position.hpp of the core); the turns behind follow from the rotation.
Arms with fewer joints get slides before the base, or a turn behind the tip, that have to stay at zero. Of the ways to
do so, from base to tip and from tip to base, the one with the best conditioned position step is taken.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from urdf_ik.ik.families.parts.explanations import off_by
from urdf_ik.ik.families.parts.family import Family, FamilyMember, columns
from urdf_ik.ik.families.parts.written import PLANAR_POSE, PLANAR_POSITION, POSITION, Aim, Numbers, written
from urdf_ik.kinematics.chain import Chain, is_redundant, kinds_of
from urdf_ik.kinematics.structure import Structure, closest_points
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array

# A position step worth having: its smallest singular value at the middle one of sampled joint vectors.
_CONDITION = 3e-3
_SAMPLES = 60
# Most solutions of a pose, by the number of joints; of a position.
_COLUMNS = {1: 1, 2: 2, 3: 4, 4: 4, 5: 8}


@dataclass(frozen=True)
class Joint:
    """One joint of a position step or behind it; ``index`` in the chain, -1 for one that was added."""

    h: Array
    point: Array
    slides: bool
    index: int


@dataclass(frozen=True)
class _Way:
    """Three joints that place ``X``, and turns behind them, on the chain or the reversed one, at q = 0.

    Lengths are shares of ``size``, the chain's own also where ``chain`` is the reversed one.
    """

    chain: Chain
    size: float
    is_reversed: bool
    joints: list[Joint]
    X: Array


def _prepare(family: Family, structure: Structure, chain: Chain) -> FamilyMember | None:
    """The plan for poses; None where no three joints place a point well."""
    ways = sorted(_ways(chain), key=lambda entry: -entry[0])
    # Ways in coordinates of the chain itself, if nearly as good.
    good = [way for score, way in ways if score > max(_CONDITION, 0.5 * ways[0][0])]
    if not good:
        return None
    best = next((way for way in good if not way.is_reversed and min(j.index for j in way.joints) >= 0), good[0])
    spare = next((way for _, way in ways[:6] if way is not best), best)
    chosen = [best] if spare is best or ways[0][0] <= _CONDITION else [best, spare]
    turns = len(best.joints) - 3
    last = "axis 5, then joint 5" if turns == 2 else f"axis {chain.n}"
    added = sum(joint.index < 0 for joint in best.joints)
    return family.member(
        chain,
        _arm(chain, Aim(), chosen, _COLUMNS[chain.n]),
        name=kinds_of(chain) + (" 1x2" if best.is_reversed and turns == 2 else " 4x5" if turns == 2 else ""),
        reason=f"axes {'1 and 2' if best.is_reversed else '4 and 5'} meet, in a point that three joints place"
        if turns == 2
        else "a point of the last axis is placed by three joints at most",
        method="Closed form: "
        + (
            f"a point on {last} is placed by three joints, the turns behind follow"
            if not best.is_reversed
            else "from tip to base, three joints place a point on the first axis, the turns behind follow"
        )
        + (f", with {added} joint{'s' * (added > 1)} added that must stay at zero" if added else "")
        + "; verified and polished on the URDF as written",
        branches=columns(_COLUMNS[chain.n]),
    )


FAMILY = Family(
    name="one to five joints",
    reason="three joints at most place a point that the others leave in place",
    steps="a point is placed by three joints, the turns behind follow",
    branches=columns(8),
    matches=lambda structure, chain: 1 <= chain.n <= 5 and not is_redundant(chain),
    prepare=_prepare,
)


def prepare_position(chain: Chain) -> FamilyMember:
    """The plan of an arm with three joints for the tip's position."""
    way = _Way(chain, chain.size, False, joints_of(chain, chain.size), _tip(chain, chain.size))
    return _task_plan(chain, Aim(POSITION), "position", [way])


def prepare_planar(chain: Chain, normal: Array, heading: Array | None) -> FamilyMember | None:
    """The plan of an arm of two or three joints in a plane: the tip's position there, or with ``heading`` its pose.

    A slide across the plane is added, which takes up what the arm is off the plane.

    Args:
        chain: the arm.
        normal: (3,) of the plane, in the base.
        heading: (3,) axis of the tip whose direction in the plane counts; None: the position alone.
    """
    if heading is None:
        joints = [Joint(normal, np.zeros(3), True, -1), *joints_of(chain, chain.size)]
        way = _Way(chain, chain.size, False, joints, _tip(chain, chain.size))
        return _task_plan(chain, Aim(PLANAR_POSITION, normal=normal), "planar position", [way])
    for is_reversed in (False, True):
        seen = chain.reversed() if is_reversed else chain
        across = chain.R_tip.T @ normal if is_reversed else normal
        full = [Joint(across, np.zeros(3), True, -1), *joints_of(seen, chain.size, is_reversed)]
        if not full[-1].slides:
            way = _Way(seen, chain.size, is_reversed, full, next(_points(full)))
            return _task_plan(chain, Aim(PLANAR_POSE, heading, normal), "planar pose", [way])
    return None


def _task_plan(chain: Chain, aim: Aim, task: str, ways: list[_Way]) -> FamilyMember:
    count = 4 if aim.kind == POSITION else 2
    return FAMILY.member(
        chain,
        _arm(chain, aim, ways, count),
        name=f"{kinds_of(chain)} {task}",
        reason=f"the task {task!r} asks for no more than the joints control",
        method="Closed form: two equations without the first joint, one of them without the second; verified and "
        "polished on the URDF as written",
        branches=columns(count),
        why=partial(off_by, chain, aim=aim),
    )


def _tip(chain: Chain, size: float) -> Array:
    return np.asarray(chain.P.sum(axis=0) / size)


def joints_of(chain: Chain, size: float, is_reversed: bool = False) -> list[Joint]:
    """The joints of a chain, lengths as shares of ``size``; a reversed chain's have the numbers of the original."""
    order = range(chain.n - 1, -1, -1) if is_reversed else range(chain.n)
    points = chain.points / size
    return [Joint(h, p, bool(s), i) for h, p, s, i in zip(chain.H, points, chain.prismatic, order, strict=True)]


def _ways(chain: Chain) -> Iterator[tuple[float, _Way]]:
    """Ways to solve for a pose, each with its conditioning."""
    rng = np.random.default_rng(1)
    for is_reversed in (False, True):
        seen = chain.reversed() if is_reversed else chain
        joints = joints_of(seen, chain.size, is_reversed)
        tip = _tip(seen, chain.size)
        for full in _filled_up(joints, tip, rng):
            if any(joint.slides for joint in full[3:]):
                continue
            for X in _points(full):
                way = _Way(seen, chain.size, is_reversed, full, X)
                yield _conditioning(way), way


def _filled_up(joints: list[Joint], tip: Array, rng: np.random.Generator) -> Iterator[list[Joint]]:
    """The joints, filled up to four, three of which place a point on the axis of the last one."""
    if len(joints) >= 4:
        yield joints
        return
    behind = Joint(_direction(rng), tip + 0.3 * _direction(rng), False, -1)
    for full in [joints, [*joints, behind]]:
        for _ in range(4):
            axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            yield [Joint(h, np.zeros(3), True, -1) for h in axes[: 4 - len(full)]] + full
            if len(full) == 4:
                break


def _points(joints: list[Joint]) -> Iterator[Array]:
    """Points that the turns behind the third joint leave in place, those first that are near the joint before."""
    last = joints[3]
    if len(joints) == 5:
        after = joints[4]
        if not after.slides and np.linalg.norm(np.cross(last.h, after.h)) > DEFAULT.near_angle:
            a, b = closest_points(last.point, last.h, after.point, after.h)
            if np.linalg.norm(a - b) < DEFAULT.exact_structure:
                yield 0.5 * (a + b)
        return
    before = joints[2]
    foot = last.point
    if np.linalg.norm(np.cross(last.h, before.h)) > DEFAULT.near_angle:
        _, foot = closest_points(before.point, before.h, last.point, last.h)
    for along in (0.0, 0.3, -0.3):
        yield foot + along * last.h


def _conditioning(way: _Way) -> float:
    """Median over joint vectors of the smallest singular value of the position step's Jacobian."""
    values = np.random.default_rng(2).uniform(-math.pi, math.pi, (_SAMPLES, 3))
    place, moves = np.tile(way.X, (_SAMPLES, 1)), np.empty((_SAMPLES, 3, 3))
    for k in (2, 1, 0):
        joint, by = way.joints[k], values[:, k]
        if joint.slides:
            moves[:, k] = joint.h
            place = place + by[:, None] / math.pi * joint.h
            continue
        place = joint.point + turned(place - joint.point, joint.h, by)
        for later in range(k + 1, 3):
            moves[:, later] = turned(moves[:, later], joint.h, by)
        moves[:, k] = np.cross(joint.h, place - joint.point)
    return float(np.median(np.linalg.svd(moves, compute_uv=False)[:, -1]))


def turned(v: Array, h: Array, angles: Array) -> Array:
    """Vectors (m, 3), each turned about unit ``h`` (3,) by an angle of (m,)."""
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    return c * v + s * np.cross(h, v) + (1.0 - c) * (v @ h)[:, None] * h


def _arm(chain: Chain, aim: Aim, ways: list[_Way], count: int) -> Numbers:
    """The arm and up to two ways to solve for it."""
    return Numbers(
        kind="few joints",
        joints=chain.n,
        columns=count,
        written=written(chain, aim),
        way=_way(ways[0]),
        spare=_way(ways[1]) if len(ways) > 1 else None,
    )


def _way(way: _Way) -> Numbers:
    """``FewJointsWay`` of the core; lengths are shares of the arm's size."""
    padded = np.full(5, -1.0)
    padded[: len(way.joints)] = [joint.index for joint in way.joints]
    axes = np.zeros((2, 3))
    for k, joint in enumerate(way.joints[3:]):
        axes[k] = joint.h
    return Numbers(
        step=position_step(way.joints[:3], way.X),
        reversed=way.is_reversed,
        turns=len(way.joints) - 3,
        axes=axes,
        joints=padded,
        home=np.ascontiguousarray(way.chain.R_tip),
        in_tip=way.chain.R_tip.T @ (way.X - _tip(way.chain, way.size)),
    )


def position_step(joints: list[Joint], X: Array) -> Numbers:
    """The step of three joints that place the point ``X`` (3,), in shares of the size."""
    first, second = joints[:2]
    points = [joint.point for joint in joints]
    if not first.slides and not second.slides:
        points[:2] = feet(first.h, first.point, second.h, second.point)
    return Numbers(
        slides=np.array([joint.slides for joint in joints], dtype=np.float64),
        directions=np.array([joint.h for joint in joints]),
        points=np.array(points),
        X=np.array(X, dtype=np.float64),
    )


def feet(h: Array, p: Array, k: Array, q: Array) -> tuple[Array, Array]:
    """Feet of the common normal of axes along ``h``, ``k`` through ``p``, ``q``; if parallel, of one through ``p``."""
    if np.linalg.norm(np.cross(h, k)) < 1e-6:
        gap = q - p
        return p, p + gap - (gap @ h) * h
    return closest_points(p, h, q, k)


def _direction(rng: np.random.Generator) -> Array:
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)
