"""Arms with one to five joints, turning or sliding, by the position of a point that the last turns leave in place.

Of a pose the place of every point of the tip is known. A point on the last axis (where axes 4 and 5 of five joints
meet) is placed by three joints, see _kernels/slide_position.py; the turns behind follow from the rotation. Arms with
fewer joints get slides before the base, or a turn behind the tip, that have to stay at zero. Of the ways to do so,
from base to tip and from tip to base, the one with the best conditioned position step is taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from urdf_ik._kernels import few_joints as kernels
from urdf_ik._kernels import layout
from urdf_ik._kernels import slide_position as step
from urdf_ik.families.nearest import off_by
from urdf_ik.families.plan import Plan
from urdf_ik.structure import closest_points
from urdf_ik.tolerances import DEFAULT

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from urdf_ik.chain import Chain
    from urdf_ik.structure import Structure

    Array = NDArray[np.float64]

# A position step worth having: its smallest singular value at the middle one of sampled joint vectors.
_CONDITION = 3e-3
_SAMPLES = 60
# Most solutions of a pose, by the number of joints; of a position.
_COLUMNS = {1: 1, 2: 2, 3: 4, 4: 4, 5: 8}


@dataclass(frozen=True)
class _Joint:
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
    joints: list[_Joint]
    X: Array


def kinds_of(chain: Chain) -> str:
    """The joints in letters, base to tip: '4R' or 'RRPR'."""
    letters = "".join("P" if slides else "R" for slides in chain.prismatic)
    return letters if "P" in letters else f"{chain.n}R"


def prepare(structure: Structure, chain: Chain) -> Plan | None:
    """The plan for poses; None where no position step serves, or a joint never moves the tip on its own."""
    if not 1 <= chain.n <= 5 or is_redundant(chain):
        return None
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
    return Plan(
        family=kinds_of(chain) + (" 1x2" if best.is_reversed and turns == 2 else " 4x5" if turns == 2 else ""),
        method="Closed form: "
        + (
            f"a point on {last} is placed by three joints, the turns behind follow"
            if not best.is_reversed
            else "from tip to base, three joints place a point on the first axis, the turns behind follow"
        )
        + (f", with {added} joint{'s' * (added > 1)} added that must stay at zero" if added else "")
        + "; verified and polished on the URDF as written",
        branches=columns(_COLUMNS[chain.n]),
        imperfection=(0.0, 0.0),
        error=0.0,
        arm=_pack(chain, kernels.POSE, chosen),
        solve=kernels.solve,
        explain=lambda rotation, point: off_by(chain, pack_chain(chain, kernels.POSE), rotation, point),
    )


def prepare_position(chain: Chain) -> Plan:
    """The plan of an arm with three joints for the tip's position."""
    way = _Way(chain, chain.size, False, _joints(chain, chain.size), _tip(chain, chain.size))
    return _task_plan(chain, kernels.POSITION, "position", [way], None, None)


def prepare_planar(chain: Chain, normal: Array, heading: Array | None) -> Plan | None:
    """The plan of an arm of two or three joints in a plane: the tip's position there, or with ``heading`` its pose.

    A slide across the plane is added, which takes up what the arm is off the plane.

    Args:
        chain: the arm.
        normal: (3,) of the plane, in the base.
        heading: (3,) axis of the tip whose direction in the plane counts; None: the position alone.
    """
    if heading is None:
        joints = [_Joint(normal, np.zeros(3), True, -1), *_joints(chain, chain.size)]
        way = _Way(chain, chain.size, False, joints, _tip(chain, chain.size))
        return _task_plan(chain, kernels.PLANAR_POSITION, "planar position", [way], normal, None)
    for is_reversed in (False, True):
        seen = chain.reversed() if is_reversed else chain
        across = chain.R_tip.T @ normal if is_reversed else normal
        full = [_Joint(across, np.zeros(3), True, -1), *_joints(seen, chain.size, is_reversed)]
        if not full[-1].slides:
            way = _Way(seen, chain.size, is_reversed, full, next(_points(full)))
            return _task_plan(chain, kernels.PLANAR_POSE, "planar pose", [way], normal, heading)
    return None


def _task_plan(
    chain: Chain, kind: int, task: str, ways: list[_Way], normal: Array | None, heading: Array | None
) -> Plan:
    arm = _pack(chain, kind, ways)
    if normal is not None:
        arm[kernels.NORMAL : kernels.NORMAL + 3] = normal
    if heading is not None:
        arm[kernels.AIMED : kernels.AIMED + 3] = heading
    return Plan(
        family=f"{kinds_of(chain)} {task}",
        method="Closed form: two equations without the first joint, one of them without the second; verified and "
        "polished on the URDF as written",
        branches=columns(4 if kind == kernels.POSITION else 2),
        imperfection=(0.0, 0.0),
        error=0.0,
        arm=arm,
        solve=kernels.solve,
        explain=lambda rotation, point: off_by(chain, arm, rotation, point),
    )


def _tip(chain: Chain, size: float) -> Array:
    tip: Array = chain.P.sum(axis=0) / size
    return tip


def columns(count: int) -> tuple[str, ...]:
    """Names of the columns where geometry gives none."""
    return tuple(f"solution {k}" for k in range(1, count + 1))


def is_redundant(chain: Chain) -> bool:
    """Whether the Jacobian loses rank everywhere."""
    return float(np.median(least_stretches(chain, chain.jacobian(sampled(chain))))) < 1e-9


def sampled(chain: Chain) -> Array:
    """Joint vectors (k, n) all over."""
    q = np.random.default_rng(0).uniform(-math.pi, math.pi, (_SAMPLES, chain.n))
    return np.where(chain.prismatic, q * chain.size / math.pi, q)


def least_stretches(chain: Chain, J: Array) -> Array:
    """Smallest singular values (k,) of Jacobians (k, rows, n), lengths as shares of the arm's size."""
    scaled = J / chain.size
    scaled[:, 3:] = J[:, 3:]
    scaled[:, :, chain.prismatic] *= chain.size
    return np.asarray(np.linalg.svd(scaled, compute_uv=False)[:, -1], dtype=np.float64)


def pack_chain(chain: Chain, kind: int, aimed: Array | None = None) -> Array:
    """The numbers of the arm as written that every kernel for few joints needs."""
    n = chain.n
    arm = np.zeros(kernels.FIRST_VARIANT)
    # The target as it stands: these kernels need no frames of their own.
    arm[layout.BASE_ROTATION : layout.BASE_ROTATION + 9 : 4] = 1.0
    arm[layout.TOOL_ROTATION : layout.TOOL_ROTATION + 9 : 4] = 1.0
    arm[layout.SIZE] = chain.size
    arm[layout.REACH : layout.REACH + 9] = DEFAULT.for_kernels()
    arm[layout.H : layout.H + 3 * n] = chain.H.ravel()
    arm[layout.P : layout.P + 3 * n + 3] = chain.P.ravel()
    arm[layout.R_TIP : layout.R_TIP + 9] = chain.R_tip.ravel()
    arm[kernels.JOINTS], arm[kernels.KIND] = n, kind
    arm[kernels.AIMED : kernels.AIMED + 3] = np.zeros(3) if aimed is None else aimed
    arm[kernels.SLIDING : kernels.SLIDING + n] = chain.prismatic
    return arm


def _joints(chain: Chain, size: float, is_reversed: bool = False) -> list[_Joint]:
    order = range(chain.n - 1, -1, -1) if is_reversed else range(chain.n)
    points = chain.points / size
    return [_Joint(h, p, bool(s), i) for h, p, s, i in zip(chain.H, points, chain.prismatic, order, strict=True)]


def _ways(chain: Chain) -> Iterator[tuple[float, _Way]]:
    """Ways to solve for a pose, each with its conditioning."""
    rng = np.random.default_rng(1)
    for is_reversed in (False, True):
        seen = chain.reversed() if is_reversed else chain
        joints = _joints(seen, chain.size, is_reversed)
        tip = _tip(seen, chain.size)
        for full in _filled_up(joints, tip, rng):
            if any(joint.slides for joint in full[3:]):
                continue
            for X in _points(full):
                way = _Way(seen, chain.size, is_reversed, full, X)
                yield _conditioning(way), way


def _filled_up(joints: list[_Joint], tip: Array, rng: np.random.Generator) -> Iterator[list[_Joint]]:
    """The joints, filled up to four, three of which place a point on the axis of the last one."""
    if len(joints) >= 4:
        yield joints
        return
    behind = _Joint(_direction(rng), tip + 0.3 * _direction(rng), False, -1)
    for full in [joints, [*joints, behind]]:
        for _ in range(4):
            axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            yield [_Joint(h, np.zeros(3), True, -1) for h in axes[: 4 - len(full)]] + full
            if len(full) == 4:
                break


def _points(joints: list[_Joint]) -> Iterator[Array]:
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
    rng = np.random.default_rng(2)
    return float(np.median([_smallest(way, rng) for _ in range(_SAMPLES)]))


def _smallest(way: _Way, rng: np.random.Generator) -> float:
    """Smallest singular value of the position step's Jacobian at one random joint vector."""
    values = rng.uniform(-math.pi, math.pi, 3)
    place, moves = way.X, np.empty((3, 3))
    for k in (2, 1, 0):
        joint = way.joints[k]
        if joint.slides:
            moves[k] = joint.h
            place = place + values[k] / math.pi * joint.h
            continue
        place = joint.point + step.turned(place - joint.point, joint.h, values[k])
        for later in range(k + 1, 3):
            moves[later] = step.turned(moves[later], joint.h, values[k])
        moves[k] = np.cross(joint.h, place - joint.point)
    return float(np.linalg.svd(moves, compute_uv=False)[-1])


def _pack(chain: Chain, kind: int, ways: list[_Way]) -> Array:
    arm = pack_chain(chain, kind)
    arm[kernels.VARIANTS] = len(ways)
    return np.concatenate([arm, *(_row(way) for way in ways)])


def _row(way: _Way) -> Array:
    """One variant, as _kernels/few_joints.py reads it."""
    row = np.zeros(kernels.VARIANT)
    first, second = way.joints[0], way.joints[1]
    points = [joint.point for joint in way.joints[:3]]
    if not first.slides and not second.slides:
        points[:2] = feet(first.h, first.point, second.h, second.point)
    for k, joint in enumerate(way.joints[:3]):
        row[step.SLIDES + k] = joint.slides
        row[step.DIRECTIONS + 3 * k : step.DIRECTIONS + 3 * k + 3] = joint.h
        row[step.POINTS + 3 * k : step.POINTS + 3 * k + 3] = points[k]
    row[step.POINT : step.POINT + 3] = way.X
    row[kernels.REVERSED], row[kernels.TURNS] = way.is_reversed, len(way.joints) - 3
    row[kernels.INDEX : kernels.INDEX + 5] = -1.0
    for k, joint in enumerate(way.joints):
        row[kernels.INDEX + k] = joint.index
        if k > 2:
            row[kernels.AXES + 3 * (k - 3) : kernels.AXES + 3 * (k - 3) + 3] = joint.h
    row[kernels.HOME : kernels.HOME + 9] = way.chain.R_tip.ravel()
    row[kernels.IN_TIP : kernels.IN_TIP + 3] = way.chain.R_tip.T @ (way.X - _tip(way.chain, way.size))
    return row


def feet(h: Array, p: Array, k: Array, q: Array) -> tuple[Array, Array]:
    """Feet of the common normal of axes along ``h``, ``k`` through ``p``, ``q``; if parallel, of one through ``p``."""
    if np.linalg.norm(np.cross(h, k)) < 1e-6:
        gap = q - p
        return p, p + gap - (gap @ h) * h
    return closest_points(p, h, q, k)


def _direction(rng: np.random.Generator) -> Array:
    v = rng.normal(size=3)
    out: Array = v / np.linalg.norm(v)
    return out
