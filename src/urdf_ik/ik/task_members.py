"""How an arm is solved for a part of a pose: in closed form, with joints given or an axis free, else by search."""

from collections.abc import Callable
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from urdf_ik._core import Solver
from urdf_ik.ik.descent import Wanted, descended
from urdf_ik.ik.families import FamilyMember, axis_added, few_joints, of_six
from urdf_ik.ik.families.joint_given import PythonSolver, prepare_middle
from urdf_ik.ik.families.parts.family import Family, columns
from urdf_ik.ik.minima import searched
from urdf_ik.ik.task import Task
from urdf_ik.ik.tasks import CONTROL, controls_aim
from urdf_ik.kinematics.chain import Chain, kinds_of, sampled
from urdf_ik.kinematics.chain.free_axis import FreeAxis
from urdf_ik.model.poses import project_rotation
from urdf_ik.typing import Array

_MOST_GIVEN = 4
"""Joints that are given beside the three that place the tip; a joint more makes preparing five times as long."""
_REACHED = 2e-11
"""Share of the size, rad: what a solution that is searched may miss."""
_INCOMPLETE = np.uint8(32)
COLUMNS = 16
"""Most solutions that a search returns."""

_BY_SEARCH = Family(
    name="by search",
    reason="no closed form",
    steps="Newton's method on the URDF as written, from evenly spread starts",
    branches=columns(COLUMNS),
    matches=lambda structure, chain: False,
    prepare=lambda family, structure, chain: None,
)


def member(chain: Chain, asked: Task, whole: Callable[[], FamilyMember | None]) -> FamilyMember:
    """The arm as it is solved for a task; ``whole`` makes its member for whole poses."""
    if asked.components == "position" and 3 <= chain.n <= 3 + _MOST_GIVEN and chain.axes is chain:
        placing = _placing(chain)
        placed = placing and _placed(chain, placing, tuple(range(1, chain.n + 1)))
        if placed:
            return placed
    if asked.components == "position and axis" and asked.frame == "tip" and chain.axes is chain:
        axis = np.array(asked.axis)
        if chain.n >= 6 and (own := whole()) is not None and isinstance(own.solver, Solver):
            return axis_added.prepare_free(chain, own, FreeAxis.read(axis))
        if chain.n == 5 and not chain.prismatic.any() and controls_aim(chain, axis):
            aimed = axis_added.prepare_aimed(chain, axis, of_six)
            if aimed is not None:
                return aimed
    return _by_search(chain, asked)


def _placing(chain: Chain) -> tuple[str, ...]:
    """Three joints that place the tip well, those nearest to the base; () where none do."""
    J = chain.jacobian(sampled(chain))[:, :3] / chain.size
    J[:, :, chain.prismatic] *= chain.size

    def stretch(joints: tuple[int, ...]) -> float:
        return float(np.median(np.linalg.svd(J[:, :, joints], compute_uv=False)[:, -1]))

    every = list(combinations(range(chain.n), 3))
    best = max(map(stretch, every))
    if best < CONTROL:
        return ()
    chosen = next(joints for joints in every if stretch(joints) >= 0.5 * best)
    return tuple(chain.joint_names[k] for k in chosen)


def _placed(chain: Chain, placing: tuple[str, ...], numbers: tuple[int, ...]) -> FamilyMember | None:
    """The plan that gives all joints but those of ``placing``, the first one first."""
    k = next((k for k, name in enumerate(chain.joint_names) if name not in placing), None)
    if k is None:
        return few_joints.prepare_position(chain)
    rest = (*numbers[:k], *numbers[k + 1 :])
    return prepare_middle(chain, k, numbers[k], lambda others: _placed(others, placing, rest))


def _by_search(chain: Chain, asked: Task) -> FamilyMember:
    reason = f"no closed form of {chain.n} joints for the task {str(asked)!r}"
    solver: Any = _Search(chain, asked)
    return FamilyMember(
        family=_BY_SEARCH,
        name=f"{kinds_of(chain)}: by search",
        reason=reason,
        method=_BY_SEARCH.steps,
        branches=_BY_SEARCH.branches,
        solver=solver,
        why=partial(_nearest, chain, asked),
    )


def _nearest(chain: Chain, asked: Task, T: Array) -> str:
    q = _minima(chain, asked, T[None])[0, :1]
    off, angle = (float(each[0]) for each in asked.errors(T[None], chain.fk(q)))
    return f"the nearest posture that was found misses the {asked} by {off:.3g} m and {angle:.3g} rad"


def _minima(chain: Chain, asked: Task, T: Array, q_ref: Array | None = None) -> Array:
    seen, parts = asked.chain(chain), (float(asked.has_place), float(asked.has_turn))
    free = np.where(seen.prismatic[:, None], seen.limits, [-np.inf, np.inf])
    wanted = Wanted(seen, T[:, :3, 3], *asked.matrix(T))
    known = None
    if q_ref is not None and seen is chain:
        known = descended(wanted, np.tile(q_ref, (len(T), 1)), free, *parts, 60)[:, None]
    return searched(wanted, free, None, *parts, known)[..., : chain.n]


class _Search(PythonSolver):
    """Solves by the minima of what is missed."""

    def __init__(self, chain: Chain, asked: Task) -> None:
        self._chain, self._asked = chain, asked
        self.joints, self.branches = chain.n, COLUMNS

    def solve(self, T: Array, q_ref: Array | None, q: Array, flags: NDArray[np.uint8], *_: Any) -> int:
        """Solve poses (m, 4, 4) into q (m, B, n) and flags (m, B); -1, as all are poses."""
        stack = project_rotation(T)
        q[...] = np.nan
        for k in range(0, len(stack), 64):
            found = _minima(self._chain, self._asked, stack[k : k + 64], q_ref)[:, :COLUMNS]
            q[k : k + 64, : found.shape[1]] = found
        q[...], flags[...] = answered(self._chain, self._asked, stack, q)
        return -1


def answered(chain: Chain, asked: Task, T: Array, q: Array) -> tuple[Array, NDArray[np.uint8]]:
    """Q (m, B, n), NaN where it misses what is asked of poses (m, 4, 4), and the flags (m, B) of a search."""
    off, angle = asked.errors(T[:, None], chain.fk(q))
    reached = (off <= _REACHED * chain.size) & (angle <= _REACHED)
    flags = reached.astype(np.uint8)
    flags[:, 0] |= _INCOMPLETE
    return np.where(reached[..., None], q, np.nan), flags
