"""The nearest postures: where no joint vector does what is asked, those that miss least of it."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from urdf_ik.errors import ArgumentError
from urdf_ik.ik.closed_minima import Beside, Placed, Planar, in_closed_form, prepare
from urdf_ik.ik.descent import Wanted
from urdf_ik.ik.minima import searched
from urdf_ik.ik.pose_solving import solve
from urdf_ik.ik.solutions import IKSolutions
from urdf_ik.ik.solutions.limits import nearest_image
from urdf_ik.ik.solver import Solver
from urdf_ik.ik.task import POSE, Task
from urdf_ik.model.poses import project_rotation
from urdf_ik.support import inputs

INCOMPLETE = 32
"""Flags of the first column of a pose whose solutions were searched."""
_BLOCK = 64
"""Poses that are searched at once."""
_CLOSED_BLOCK = 1024
"""Poses that are solved in closed form at once."""


def closest(
    solver: Solver,
    T: Any,
    weights: ArrayLike | None = None,
    first: str | None = None,
    *,
    task: Any = None,
    within_limits: bool = False,
    unsolved: bool = False,
) -> IKSolutions:
    """The joint vectors that miss least of targets: every local minimum that is found, the best first.

    For targets that an arm cannot reach, or of which its joints are too few to reach all. ``IKSolutions.error`` says
    what each misses. Where three joints place the tip, or a yaw and three parallel axes across it, and the joints
    behind turn about axes through it, all minima with the position first follow in closed form: ``status`` is
    'complete'. Where a roll misses the tip a little, the minima are those of a function of its angle, which are looked
    for on a grid; else minima are searched from 48 joint vectors spread evenly over the ranges of the joints, by
    Newton's method with the exact Hessian, beside those in closed form and the solutions of a pose: ``status`` is
    'incomplete', since neither proves anything.

    Args:
        solver: of the arm.
        T: (..., 4, 4) poses, or targets of the task; see :meth:`urdf_ik.Arm.ik`.
        weights: per m and per rad; the root of the sum of squared weighted errors is least.
        first: 'position' (the default without ``weights``): the position is missed by as little as possible, by 1e-9 m
            where it can be reached, and of the joint vectors that do so the rotation is nearest; 'orientation': the
            other way round.
        task: what is asked for, see :class:`urdf_ik.Task`; default: what the arm was made for, a pose.
        within_limits: whether only joint vectors inside the joint limits count.
        unsolved: whether it is known that the targets have no solution.

    Returns:
        One column a minimum, named 'closest', 'closest 2', ...

    Raises:
        PoseError: a target is not a rigid pose.
        ArgumentError: ``weights``, ``first`` or ``task`` does not fit.

    Example:
        >>> import urdf_ik
        >>> arm = urdf_ik.load("so100")
        >>> s = arm.ik_closest(urdf_ik.pose([0.0, -0.2, 0.1], rpy=[3.0, 0.2, 0.0]))
        >>> bool(s.error.position[0] < 1e-9), float(s.error.rotation[0].round(4))
        (True, 0.028)
    """
    asked = solver.asked if task is None else Task.read(task)
    place, turn = _weights(weights, first, solver.chain.size)
    first = "position" if weights is None and first is None else first
    if not (asked.has_turn and asked.has_place):
        place, turn, first = float(asked.has_place), float(asked.has_turn), None
    target = project_rotation(asked.read_targets(T))
    seen = asked.chain(solver.chain)
    bounds = seen.limits if within_limits else np.where(seen.prismatic[:, None], seen.limits, [-np.inf, np.inf])
    stack = target.reshape(-1, 4, 4)
    wanted = Wanted(seen, stack[:, :3, 3], *asked.matrix(stack))
    closed = None if weights is not None or first != "position" else _closed(solver, asked)
    exact = closed is None and asked == solver.asked == POSE and solver.targets is None and not unsolved
    exact = exact and solver.member is not None and not solver.parameters
    parts, proven = [], np.zeros(len(stack), dtype=np.bool_)
    for block in _blocks(np.arange(len(stack)), _CLOSED_BLOCK):
        known = solve(solver, stack[block]).q if exact else np.empty((len(block), 0, seen.n))
        if closed is not None:
            known, proven[block] = in_closed_form(closed, wanted[block])
        if within_limits:
            known, proven[block] = nearest_image(known, bounds, seen.image_turns)[0], False
        parts.append((block[proven[block]], known[proven[block]][..., : solver.dof]))
        for part in _blocks(np.flatnonzero(~proven[block]), _BLOCK):
            q = searched(wanted[block[part]], bounds, first, place, turn, known[part])
            parts.append((block[part], q[..., : solver.dof]))
    count = max((each.shape[1] for _, each in parts), default=1)
    q = np.full((len(stack), count, solver.dof), np.nan)
    for at, each in parts:
        q[at, : each.shape[1]] = each
    info = (~np.isnan(q[..., 0])).astype(np.uint8)
    info[slice(None) if isinstance(closed, Beside) else ~proven, 0] |= np.uint8(INCOMPLETE)
    names = tuple("closest" if k == 1 else f"closest {k}" for k in range(1, count + 1))
    shape = target.shape[:-2]
    q, info = q.reshape(*shape, count, solver.dof), info.reshape(*shape, count)
    return IKSolutions(replace(solver, asked=asked), target, q, info, names)


def _blocks(index: NDArray[np.intp], size: int) -> Iterator[NDArray[np.intp]]:
    return (index[k : k + size] for k in range(0, len(index), size))


def _weights(weights: ArrayLike | None, first: str | None, size: float) -> tuple[float, float]:
    """The weights of the place [per share of size] and of the angle [per rad], the greater one 1."""
    if first is not None:
        inputs.choice(first, "first", ("position", "orientation"))
        if weights is not None:
            raise ArgumentError(f"weights and first={first!r} given: one part counts first, or both by their weights")
    if weights is None:
        return 1.0, 1.0
    pair = inputs.array(weights, "weights", (2,))
    if not (pair >= 0.0).all() or not pair.any():
        raise ArgumentError(f"weights={weights!r} given; two numbers are needed, per m and per rad, none negative")
    pair = pair * [size, 1.0] / max(pair[0] * size, pair[1])
    return float(pair[0]), float(pair[1])


@lru_cache(maxsize=64)
def _closed(solver: Solver, asked: Task) -> Planar | Placed | Beside | None:
    return prepare(solver.chain, asked)
