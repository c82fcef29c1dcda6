"""The nearest arm that has its family's structure exactly, and the closed form of six turning joints by it."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from urdf_ik._core import Solver
from urdf_ik.ik.families.parts.explanations import seen_in_frame_1
from urdf_ik.ik.families.parts.family import Family, FamilyMember
from urdf_ik.ik.families.parts.written import Numbers, ends, written
from urdf_ik.kinematics.chain import Chain
from urdf_ik.kinematics.dh.frames import DHFrames, denavit_hartenberg
from urdf_ik.kinematics.structure import Structure
from urdf_ik.support.tolerances import DEFAULT
from urdf_ik.typing import Array


def eight(pattern: str, first: tuple[str, str] = ("front", "back")) -> tuple[str, ...]:
    """Names of the eight branches of three square roots, in the order of ``SIGNS``."""
    return tuple(pattern.format(*each) for each in itertools.product(first, ("up", "down"), ("noflip", "flip")))


# The signs of the roots of shoulder, elbow and wrist (3, 8), and the names of the branches in the same order.
SIGNS = np.array(list(itertools.product((1.0, -1.0), repeat=3))).T.copy()
NAMES = eight("shoulder {}, elbow {}, wrist {}")
POSITIONS = tuple(
    f"position {root}, elbow {up}" for first in (1, 3) for up in ("up", "down") for root in (first, first + 1)
)
"""Names of the branches of a quartic's roots, each with an elbow."""

# Rounding of one step's numbers here, about sixteen operations with an error of 2^-53 each.
_STEP_ROUNDING = 2e-15


def _displacement(frames: DHFrames, chain: Chain) -> Numbers:
    """Bounds on the motion between the tips of two arms at the same joint vector: ``Displacement`` of the core.

    An arm is a chain of seven constant steps with a turn between two of them: A0 turn A1 turn ... A6 for the ideal arm,
    B0 ... B6 for the arm as written, whose frames are slid along its axes and turned about them so that they are near
    the ideal ones. Replacing one step after the other by its counterpart turns the tip by the angle t_i between A_i
    and B_i, and shifts it by |a_i - b_i| + t_i times the distance from there to the tip, which is at most the sum of
    the later steps' lengths. The triangle inequality adds these up, whatever the turns are. Entry k is for steps k to
    6: entry 0 for the whole arm, entry k for what joint k moves.

    Args:
        frames: of the ideal arm.
        chain: six turning joints, which the ideal arm replaces.

    Returns:
        turn (7,) rad, sum of t_i; shift (7,) m, sum of |a_i - b_i| + t_i (|b_i+1| + ... + |b_6|); length (7,) m, sum of
        |b_i|.
    """
    ideal = frames.steps()
    written = [np.vstack([step, [0.0, 0.0, 0.0, 1.0]]) for step in np.array(chain.motion.steps)]
    # Both arms' frames at q = 0, from frame 1's base to the solved point.
    at, other = np.eye(4), np.linalg.inv(frames.base)
    joints = [np.eye(4)]
    for k in range(6):
        at, other = at @ ideal[k], other @ written[k]
        joints.append(_beside(other, at))
    joints.append(other @ written[6] @ np.linalg.inv(frames.tool))
    steps = [np.linalg.inv(a) @ b for a, b in zip(joints, joints[1:], strict=False)]
    apart = [np.linalg.norm(a[:3, :3] - b[:3, :3]) for a, b in zip(ideal, steps, strict=True)]
    turns = 2.0 * np.arcsin(np.minimum(np.array(apart) / np.sqrt(8.0), 1.0)) + _STEP_ROUNDING
    lengths = np.array([np.linalg.norm(b[:3, 3]) for b in steps])
    offs = np.array([np.linalg.norm(a[:3, 3] - b[:3, 3]) for a, b in zip(ideal, steps, strict=True)])
    offs += _STEP_ROUNDING * (chain.size + np.abs(frames.base[:3, 3]).max())
    left = _sums(lengths)
    return Numbers(turn=_sums(turns), shift=_sums(offs + turns * (left - lengths)), length=left)


def _sums(values: Array) -> Array:
    """Each entry with all that follow it."""
    return np.ascontiguousarray(np.cumsum(values[::-1])[::-1])


def _beside(frame: Array, ideal: Array) -> Array:
    """A joint's frame, slid along its z axis and turned about it so that it is nearest to the ideal frame."""
    near, z = frame.copy(), frame[:3, 2]
    near[:3, 3] += (ideal[:3, 3] - frame[:3, 3]) @ z * z
    x = ideal[:3, 0] - (ideal[:3, 0] @ z) * z
    near[:3, 0] = x / np.linalg.norm(x)
    near[:3, 1] = np.cross(z, near[:3, 0])
    return near


LITTLE = 3e-3
"""Share of the arm's size: a distance up to here may be what a calibration has added, and names no branch."""

# Below this a cosine or sine of a twist is rounding of zero: eight units in the last place of 1.
_ROUNDING = 2e-15


def _ideal_frames(
    chain: Chain, directions: Array, points: Array, parallel: Sequence[bool], meet: Sequence[bool]
) -> tuple[DHFrames, float]:
    """DH frames of the ideal arm, and how far its poses are from those of the arm as written [rad, share of size]."""
    # Measured from the first axis: how far from its base the arm is mounted has no part in its structure.
    mount = chain.P[0]
    local = replace(chain, P=np.vstack([np.zeros(3), chain.P[1:]]))
    home = np.eye(4)
    home[:3, :3], home[:3, 3] = local.R_tip, local.P.sum(axis=0)
    frames = denavit_hartenberg(directions, points - mount, home, parallel, meet, LITTLE * chain.size)
    Q = np.random.default_rng(0).uniform(-np.pi, np.pi, (12, chain.n))
    apart = frames.fk(Q) - local.fk(Q)
    apart[:, :3, 3] /= chain.size
    frames.base[:3, 3] += mount
    return frames, float(np.abs(apart).max())


def _ideal_arm(frames: DHFrames, error: float, chain: Chain) -> Numbers:
    """The ideal arm by Craig's Denavit-Hartenberg parameters: ``IdealFrames`` of the core.

    T = base Rz(t1) Tx(a1) Rx(alpha1) Tz(d2) Rz(t2) ... Rz(t6) tool, with t = q + offset.
    """
    base, tool = frames.base, frames.tool
    exact = error <= DEFAULT.exact_structure
    return Numbers(
        **vars(ends(base[:3, :3].T, base[:3, 3], tool[:3, :3].T, -tool[:3, :3].T @ tool[:3, 3])),
        cos_alpha=snapped(np.cos(frames.alpha)),
        sin_alpha=snapped(np.sin(frames.alpha)),
        a=np.array(frames.a, dtype=np.float64),
        d=np.array(frames.d[:4], dtype=np.float64),
        offset=np.array(frames.offset, dtype=np.float64),
        steps=np.ascontiguousarray(np.array(frames.steps())[:, :3]),
        size=chain.size,
        imperfection=0.0 if exact else error,
        signs=SIGNS,
        displacement=_displacement(frames, chain),
    )


def snapped(values: Array) -> Array:
    """Values with the rounding of 0 and +-1 taken away."""
    nearest = np.round(values)
    return np.where(np.abs(values - nearest) < _ROUNDING, nearest, values)


class Variant(NamedTuple):
    """What one family of a file has beside the others.

    Attributes:
        variant: its name in the core.
        name: the end of the family's name.
        reason: the end of the reason.
        steps: how it is solved.
        holds: whether an arm, given its structure, has this family's relation.
        branches: names of the columns.
        by_quadratics: see ``Family``.
    """

    variant: str
    name: str
    reason: str
    steps: str
    holds: Callable[[Structure, Chain], bool]
    branches: tuple[str, ...] = NAMES
    by_quadratics: bool = True


def families(
    name: str,
    reason: str,
    matches: Callable[[Structure], bool],
    prepare: Callable[[Family, Structure, Chain], FamilyMember | None],
    variants: Sequence[Variant],
) -> tuple[Family, ...]:
    """The families of a file, which share the beginnings of name and reason, and a relation of their axes."""

    def family(own: Variant) -> Family:
        return Family(
            name=name + own.name,
            reason=reason + own.reason,
            steps=own.steps,
            branches=own.branches,
            by_quadratics=own.by_quadratics,
            matches=lambda structure, chain: matches(structure) and own.holds(structure, chain),
            prepare=prepare,
            variant=own.variant,
        )

    return tuple(map(family, variants))


def closed_form(
    family: Family,
    structure: Structure,
    chain: Chain,
    kind: str,
    triple: tuple[int, str],
    meet: Sequence[int],
    numbers: Callable[[Numbers], dict[str, Any] | None],
    explain: Callable[[Numbers, Solver, Array, Array], str] | None = None,
) -> FamilyMember | None:
    """The member of a family of six turning joints that is solved in closed form.

    Its ideal arm has the structure's parallel neighbours exactly parallel, and the triple and ``meet`` exactly meeting.

    Args:
        family: of the arm.
        structure: of the arm.
        chain: the arm as written.
        kind: of the solver.
        triple: first axis, from 1, and relation of the three axes that the family rests on.
        meet: first axes of pairs that meet too.
        numbers: the ideal arm -> what its solver takes beside it; None where the arm has no such solution.
        explain: (arm, solver, rotation (3, 3) and solved point (3,) in the ideal frame 1) -> which length does not fit;
            None: the nearest pose explains.
    """
    first, relation = triple
    three = structure.triple(first, relation)
    assert three is not None
    parallel = [structure.is_parallel(i) for i in range(1, 6)]
    together = {*meet, first, first + 1} if relation == "meet" else set(meet)
    points = chain.points.copy()
    if three.point is not None:
        points[first - 1 : first + 2] = three.point
    frames, error = _ideal_frames(
        chain, straightened(chain.H, parallel), points, parallel, [i in together for i in range(1, 6)]
    )
    ideal = _ideal_arm(frames, error, chain)
    more = numbers(ideal)
    if more is None:
        return None
    arm = Numbers(kind=kind, variant=family.variant, ideal=ideal, written=written(chain), **more)
    inside = (first, first + 1) if relation == "parallel" else ()
    angles = [pair.off_angle for pair in structure.pairs if parallel[pair.first - 1] and pair.first not in inside]
    distances = [structure.pairs[i - 1].off_distance for i in meet]
    (distances if relation == "meet" else angles).append(three.imperfection)
    imperfection = max(angles, default=0.0), max(distances, default=0.0)
    member = family.member(chain, arm, error, imperfection=imperfection)
    if explain is None:
        return member
    why = seen_in_frame_1(chain, ideal, lambda rotation, point: explain(arm, member.solver, rotation, point))
    return replace(member, why=why)


def straightened(directions: Array, parallel: Sequence[bool]) -> Array:
    """Directions (n, 3) with the neighbours that are to be parallel (n - 1,) made exactly so, with their signs."""
    straight = directions.copy()
    start = 0
    for end in range(1, len(directions) + 1):
        if end < len(directions) and parallel[end - 1]:
            continue
        row = directions[start:end]
        if len(row) > 1:
            signs = np.where(row @ row[0] < 0.0, -1.0, 1.0)
            mean = (signs[:, None] * row).sum(axis=0)
            straight[start:end] = signs[:, None] * (mean / np.linalg.norm(mean))
        start = end
    return straight


_SAMPLES = 8
"""Number of random poses whose solutions show what the signs of the roots mean on an arm."""
_BESIDE = 0.02
"""Share of the arm's size: a wrist that is nearer to the shoulder's axis is neither in front nor behind."""


def forward(chain: Chain, wrist: Array) -> tuple[Array, Array]:
    """Up, along axis 1, and the forward side of link 1, square to axes 1 and 2 at q = 0: unit vectors (3,).

    Forward is where the shoulder's offset puts axis 2; without an offset, where the wrist (3,) is at q = 0; if that is
    above the shoulder, along the base's x or y.
    """
    up = chain.H[0] * (1.0 if chain.H[0][2] > -0.1 else -1.0)
    across = np.cross(chain.H[1], up)
    across /= np.linalg.norm(across)
    offset, reach = ((point - chain.points[0]) @ across / chain.size for point in (chain.points[1], wrist))
    sides = (offset, reach, 0.01 * across[0], 0.01 * across[1])
    return up, across * next((np.sign(side) for side in sides if abs(side) > LITTLE), 1.0)


def geometric(branches: tuple[str, ...], solver: Any, chain: Chain, wrist: tuple[int, int]) -> tuple[str, ...]:
    """The names of an arm's columns by geometry; ``branches`` where a column has no clear side.

    *Front*: the wrist is on the forward side of axis 1. *Up*: the elbow (axis 3) is above the line from the shoulder
    (axis 2) to the wrist, as long as the wrist is on the side of the shoulder that its name says. Above is along axis
    1, upwards in the base. *Flip*: the hand bends up, not down, once joint 4 is turned so that axis 5 is parallel to
    axes 2 and 3, from its zero by less than a right angle; of a wrist (4, 5): once axis 5 leads forward.

    Args:
        branches: the names by the signs of the roots, the first eight ``NAMES``.
        solver: the compiled solver.
        chain: six turning joints, axes 2 and 3 parallel.
        wrist: the two axes, counted from 0, that meet in the point that joint 1 puts in place: (3, 4), or
            (4, 5) where axis 4 is parallel to axes 2 and 3.
    """
    home = _axes(chain, np.zeros(6))
    up, ahead = forward(chain, _meeting(*home, *wrist))
    side = np.sign(np.cross(chain.H[1], up) @ ahead)
    T = chain.fk(np.random.default_rng(0).uniform(-np.pi, np.pi, (_SAMPLES, 6)))
    q = np.full((_SAMPLES, len(branches), 6), np.nan)
    solver.solve(T, None, q, np.zeros(q.shape[:2], np.uint8), None, 1)
    H, points = _axes(chain, q[:, :8])
    ahead = side * np.cross(H[..., 1, :], up)
    far = ((_meeting(H, points, *wrist) - points[..., 0, :]) * ahead).sum(-1)
    end = points[..., 3, :] if wrist == (4, 5) else _meeting(H, points, *wrist)
    to_wrist, to_elbow = end - points[..., 1, :], points[..., 2, :] - points[..., 1, :]
    x = (to_wrist * ahead).sum(-1)
    above = x * (x * (to_elbow @ up) - (to_wrist @ up) * (to_elbow * ahead).sum(-1))
    above[~((np.abs(x) > _BESIDE * chain.size) & (x * far > 0.0))] = 0.0
    left = side * H[..., 1, :]
    if wrist == (4, 5):
        fore, hinge = left, -_outward(_meeting(*home, 5, 4), *home, 4, chain.size) * H[..., 4, :]
        straight = side * (home[0][1] @ home[0][5])
    else:
        outward = _outward(_meeting(*home, *wrist), *home, 3, chain.size)
        fore, straight = outward * H[..., 3, :], outward * (home[0][3] @ home[0][5])
        hinge = (-1.0 if side * (home[0][1] @ home[0][4]) < -LITTLE else 1.0) * H[..., 4, :]
    # Joint 6's origin, not the tip: a tool renames no branch.
    out = _outward(chain.points[5], *home, 5, chain.size, straight) * H[..., 5, :]
    down = (np.cross(fore, out) * hinge).sum(-1)
    # 0 where the first of two words is the name, as in NAMES.
    rows = [np.nansum(np.sign(each), axis=0) <= 0.0 for each in (far, above, down)]
    named = tuple(NAMES[k] for k in np.array([4, 2, 1]) @ rows)
    return (*named, *branches[8:]) if sorted(named) == sorted(NAMES) else branches


def _axes(chain: Chain, q: Array) -> tuple[Array, Array]:
    """Directions (..., 6, 3) of the axes at joint vectors (..., 6), and their points (..., 6, 3) next to the tip."""
    J = np.moveaxis(chain.jacobian(q), -1, -2)
    H = J[..., 3:]
    return H, chain.fk(q)[..., None, :3, 3] + np.cross(H, J[..., :3])


def _outward(far: Array, H: Array, points: Array, k: int, size: float, straight: float = 0.0) -> float:
    """1 or -1: axis k's sign that leads from axis k - 1 to the point; where it leads neither way, that of straight."""
    along = (far - _meeting(H, points, k, k - 1)) @ H[k]
    return -1.0 if (along / size if abs(along) > LITTLE * size else straight) < -LITTLE else 1.0


def _meeting(H: Array, points: Array, i: int, j: int) -> Array:
    """The point (..., 3) of axis i that is nearest to axis j."""
    normal = np.cross(H[..., j, :], np.cross(H[..., i, :], H[..., j, :]))
    along = ((points[..., j, :] - points[..., i, :]) * normal).sum(-1) / (H[..., i, :] * normal).sum(-1)
    return np.asarray(points[..., i, :] + H[..., i, :] * along[..., None])
